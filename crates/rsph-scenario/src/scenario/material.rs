//! Material tables: a model of the core's registry and its parameters, so that a new material in the core needs no change here, and
//! which part of the body is of it.

use super::document::Document;
use super::error::ScenarioError;
use super::explain::{explain, suggestion};
use super::keypath::KeyPath;
use super::label_map::AxesName;
use super::region::RegionTable;
use super::tables::{FieldTable, ShapeTable};
use rsph_core::material::{Kind, MAX_TERMS, Material, Model, Parameter, model, models};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Keys that every material can have beside those of its model.
const BESIDE: [&str; 5] = ["name", "region", "shape", "modulus", "fibres"];

/// What a body is made of: `[material]`, or several `[[material]]`.
#[derive(Clone, Debug)]
pub struct MaterialTables {
    tables: Vec<MaterialTable>,
    listed: bool,
}

impl MaterialTables {
    /// The tables with their places.
    pub fn iter(&self) -> impl Iterator<Item = (KeyPath, &MaterialTable)> {
        let path = KeyPath::from("material");
        let place = move |i| if self.listed { path.index(i) } else { path.clone() };
        self.tables.iter().enumerate().map(move |(i, table)| (place(i), table))
    }
}

impl<'de> Deserialize<'de> for MaterialTables {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let table = |value: toml::Value| match value {
            toml::Value::Table(table) => Ok(MaterialTable(table.into_iter().collect())),
            other => Err(D::Error::custom(format!("a material is a table, not a {}", other.type_str()))),
        };
        match toml::Value::deserialize(d)? {
            toml::Value::Array(list) if !list.is_empty() => {
                let tables = list.into_iter().map(table).collect::<Result<_, _>>()?;
                Ok(Self { tables, listed: true })
            }
            value => Ok(Self { tables: vec![table(value)?], listed: false }),
        }
    }
}

impl JsonSchema for MaterialTables {
    fn schema_name() -> Cow<'static, str> {
        "MaterialTables".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let table = generator.subschema_for::<MaterialTable>();
        json_schema!({"anyOf": [table.clone(), {"type": "array", "items": table, "minItems": 1}]})
    }
}

/// Young's modulus at small strain as a map, to which the law is scaled: an image.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModulusTable {
    /// NIfTI or NRRD file (.nii, .nii.gz, .nrrd) of the organ; a relative path starts at the scenario file.
    pub path: String,
    /// What its values are multiplied by to be Young's modulus (Pa): 1000 for kPa, 3000 for a shear modulus in kPa. Default: 1.
    #[serde(default = "one")]
    pub factor: f64,
    /// Factor from the units of the image's coordinates to those of the scenario. Default: to metres, as its header says.
    pub scale: Option<f64>,
    /// Axes of the body. Default: "image".
    #[serde(default)]
    pub axes: AxesName,
}

fn one() -> f64 {
    1.0
}

/// A material: `model` and the parameters of that model, and which part of the body is of it.
#[derive(Clone, Debug)]
pub struct MaterialTable(BTreeMap<String, toml::Value>);

impl MaterialTable {
    /// Name of the part.
    ///
    /// # Errors
    /// One that is no text.
    pub fn name(&self, document: &Document, table: &KeyPath) -> Result<Option<String>, ScenarioError> {
        self.beside(document, table, "name")
    }

    /// The region that is of it.
    ///
    /// # Errors
    /// One that is none.
    pub fn region(&self, document: &Document, table: &KeyPath) -> Result<Option<RegionTable>, ScenarioError> {
        self.beside(document, table, "region")
    }

    /// The shape that is of it.
    ///
    /// # Errors
    /// One that is none.
    pub fn shape(&self, document: &Document, table: &KeyPath) -> Result<Option<ShapeTable>, ScenarioError> {
        self.beside(document, table, "shape")
    }

    /// The map of its modulus.
    ///
    /// # Errors
    /// One that is none.
    pub fn modulus(
        &self,
        document: &Document,
        table: &KeyPath,
    ) -> Result<Option<ModulusTable>, ScenarioError> {
        self.beside(document, table, "modulus")
    }

    /// The direction of its fibres from place to place.
    ///
    /// # Errors
    /// One that is no field.
    pub fn fibres(&self, document: &Document, table: &KeyPath) -> Result<Option<FieldTable>, ScenarioError> {
        self.beside(document, table, "fibres")
    }

    /// The value of a key beside those of the model.
    fn beside<T: serde::de::DeserializeOwned>(
        &self,
        document: &Document,
        table: &KeyPath,
        key: &str,
    ) -> Result<Option<T>, ScenarioError> {
        let Some(value) = self.0.get(key) else { return Ok(None) };
        value
            .clone()
            .try_into()
            .map(Some)
            .map_err(|e: toml::de::Error| explain(document, &table.key(key), e.message()))
    }

    /// Builds the material written at `table`; `document` gives messages their places.
    ///
    /// # Errors
    /// An unknown model or parameter, a missing one, one that is no number or out of range.
    pub fn build(&self, document: &Document, table: &KeyPath) -> Result<Arc<dyn Material>, ScenarioError> {
        let model = self.model(document, table)?;
        let known: Vec<&str> =
            std::iter::once("model").chain(model.all_parameters().map(|p| p.key)).chain(BESIDE).collect();
        if let Some(stranger) = self.0.keys().find(|k| !known.contains(&k.as_str())) {
            return Err(document.unknown_key(&table.key(stranger), &known));
        }
        let mut values = Vec::with_capacity(model.parameters.len() + 1);
        for p in model.all_parameters() {
            let path = table.key(p.key);
            let what = format!("{} ({})", p.doc, p.unit);
            let numbers = match self.0.get(p.key) {
                Some(value) => numbers(value, p.kind)
                    .map_err(|problem| document.error(&path, format!("{problem}: {what}"), remedy(p.kind)))?,
                None => p.default().ok_or_else(|| {
                    let problem =
                        format!("missing in {}: {what}, which model {} needs", header(table), model.name);
                    document.error(
                        &path,
                        problem,
                        format!("add a line `{} = {}` to {}", p.key, wanted(p.kind), header(table)),
                    )
                })?,
            };
            values.push((p.key, numbers));
        }
        let given = |key: &str| values.iter().find(|(k, _)| *k == key).map(|(_, numbers)| numbers.clone());
        model.make(given).map_err(|mut e| {
            // The core knows one material; this may be one of several.
            if let Some(key) = e.key.strip_prefix("material.") {
                e.key = table.key(key).to_string();
            }
            document.invalid_input(&e)
        })
    }

    /// The text at a key, if there is one.
    pub fn text(&self, key: &str) -> Option<&str> {
        self.0.get(key)?.as_str()
    }

    /// The model's parameters with their values, defaults included; absent ones are left out.
    pub fn values(&self) -> Vec<(&'static Parameter, Vec<f64>)> {
        let parameters = self.text("model").and_then(model).into_iter().flat_map(Model::all_parameters);
        let value = |p: &Parameter| match self.0.get(p.key) {
            Some(value) => numbers(value, p.kind).ok(),
            None => p.default().filter(|numbers| !numbers.is_empty()),
        };
        parameters.filter_map(|p| Some((p, value(p)?))).collect()
    }

    fn model(&self, document: &Document, table: &KeyPath) -> Result<&'static Model, ScenarioError> {
        let path = table.key("model");
        let names: Vec<&str> = models().iter().map(|m| m.name).collect();
        let known = names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
        let example = format!("model = \"{}\"", names.first().copied().unwrap_or_default());
        match self.0.get("model") {
            None => Err(document.error(
                &path,
                format!("missing in {}; known models: {known}", header(table)),
                format!("add a line such as `{example}`"),
            )),
            Some(toml::Value::String(name)) => model(name).ok_or_else(|| {
                let hint = suggestion(name, &names)
                    .map_or_else(|| format!("for example `{example}`"), |s| format!("did you mean \"{s}\"?"));
                document.error(&path, format!("unknown model; known models: {known}"), hint)
            }),
            Some(_) => Err(document.error(&path, format!("must be the name of a model: {known}"), example)),
        }
    }
}

/// How a table is written in a file.
fn header(table: &KeyPath) -> &'static str {
    if *table == KeyPath::from("material") { "[material]" } else { "[[material]]" }
}

/// The numbers of a value.
///
/// # Errors
/// What is wrong about it.
fn numbers(value: &toml::Value, kind: Kind) -> Result<Vec<f64>, String> {
    let number = |value: &toml::Value| match value {
        toml::Value::Float(x) => Some(*x),
        toml::Value::Integer(i) => Some(*i as f64),
        _ => None,
    };
    let pair = |value: &toml::Value| match value.as_array().map(Vec::as_slice) {
        Some([first, second]) => Some([number(first)?, number(second)?]),
        _ => None,
    };
    let found: Option<Vec<f64>> = match value {
        toml::Value::Array(pairs) if kind == Kind::Pairs => {
            pairs.iter().map(pair).collect::<Option<Vec<_>>>().map(|pairs| pairs.concat())
        }
        toml::Value::Array(values) if !kind.is_number() => values.iter().map(number).collect(),
        value if kind.is_number() || kind == Kind::List => number(value).map(|x| vec![x]),
        _ => None,
    };
    let (_, most) = kind.count();
    let fewest = if kind == Kind::List { 1 } else { most };
    match found {
        Some(found) if kind == Kind::Pairs && (2..=most).contains(&found.len()) => Ok(found),
        _ if kind == Kind::Pairs => Err(format!("must be a list of {}", wanted(kind))),
        None if kind.is_number() => Err(format!("is a {}, and a number is allowed", value.type_str())),
        None => Err(format!("is a {}, and {} is allowed", value.type_str(), wanted(kind))),
        Some(found) if (fewest..=most).contains(&found.len()) => Ok(found),
        Some(found) => Err(format!("has {} numbers, and {} is allowed", found.len(), wanted(kind))),
    }
}

/// How to write it.
fn remedy(kind: Kind) -> &'static str {
    if kind == Kind::Pairs {
        "for example [[0.5, 1.5]]"
    } else if kind.is_number() {
        "write a number without quotes or brackets"
    } else {
        "write numbers without quotes, in brackets"
    }
}

/// What a parameter takes, in words.
fn wanted(kind: Kind) -> &'static str {
    match kind {
        Kind::Number | Kind::Default(_) | Kind::OptionalNumber => "<number>",
        Kind::Vector | Kind::OptionalVector => "[<x>, <y>, <z>]",
        Kind::List => "[<one to six numbers>]",
        Kind::Pairs => "one to six pairs",
    }
}

impl JsonSchema for MaterialTable {
    fn schema_name() -> Cow<'static, str> {
        "MaterialTable".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let beside = serde_json::json!({
            "name": {"type": "string", "description": "Name in results and messages; that of a label of the label map makes it the \
                material of these voxels."},
            "region": generator.subschema_for::<RegionTable>(),
            "shape": generator.subschema_for::<ShapeTable>(),
            "modulus": generator.subschema_for::<ModulusTable>(),
            "fibres": generator.subschema_for::<FieldTable>(),
        });
        let models: Vec<_> = models().into_iter().map(|model| model_schema(model, &beside)).collect();
        json_schema!({
            "description": "What the body is made of: a model and its parameters.",
            "oneOf": models
        })
    }
}

fn model_schema(m: &Model, beside: &serde_json::Value) -> serde_json::Value {
    let mut properties = serde_json::Map::new();
    properties.insert("model".into(), serde_json::json!({"const": m.name, "description": m.doc}));
    let mut required = vec!["model"];
    for p in m.all_parameters() {
        let mut entry = serde_json::json!({"description": format!("{} ({})", p.doc, p.unit)});
        if p.kind.is_number() {
            entry["type"] = "number".into();
        } else if p.kind == Kind::Pairs {
            let number = serde_json::json!({"type": "number", "exclusiveMinimum": 0});
            entry["type"] = "array".into();
            entry["items"] =
                serde_json::json!({"type": "array", "items": number, "minItems": 2, "maxItems": 2});
            (entry["minItems"], entry["maxItems"]) = (1.into(), MAX_TERMS.into());
        } else {
            let (_, most) = p.kind.count();
            let fewest = if p.kind == Kind::List { 1 } else { most };
            entry["type"] = "array".into();
            entry["items"] = serde_json::json!({"type": "number"});
            (entry["minItems"], entry["maxItems"]) = (fewest.into(), most.into());
        }
        match p.kind {
            Kind::Default(default) => entry["default"] = default.into(),
            Kind::OptionalNumber | Kind::OptionalVector | Kind::Pairs => {}
            Kind::Number | Kind::Vector | Kind::List => required.push(p.key),
        }
        properties.insert(p.key.into(), entry);
    }
    properties.extend(beside.as_object().cloned().unwrap_or_default());
    serde_json::json!({
        "type": "object",
        "description": m.doc,
        "properties": properties,
        "required": required,
        "additionalProperties": false
    })
}
