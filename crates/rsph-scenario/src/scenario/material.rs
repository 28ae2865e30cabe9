//! The material table: a model of the core's registry and its parameters, so that a new material
//! in the core needs no change here.

use super::document::Document;
use super::error::ScenarioError;
use super::explain::suggestion;
use super::keypath::KeyPath;
use rsph_core::material::{Kind, Material, Model, Parameter, model, models};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Material of the body: `model` and the parameters of that model.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub struct MaterialTable(BTreeMap<String, toml::Value>);

impl MaterialTable {
    /// Builds the material; `document` gives messages their places.
    ///
    /// # Errors
    /// An unknown model or parameter, a missing one, one that is no number or out of range.
    pub fn build(&self, document: &Document) -> Result<Arc<dyn Material>, ScenarioError> {
        let model = self.model(document)?;
        let table = KeyPath::from("material");
        let known: Vec<&str> =
            std::iter::once("model").chain(model.parameters.iter().map(|p| p.key)).collect();
        if let Some(stranger) = self.0.keys().find(|k| !known.contains(&k.as_str())) {
            return Err(document.unknown_key(&table.key(stranger), &known));
        }
        let mut values = Vec::with_capacity(model.parameters.len());
        for p in model.parameters {
            let path = table.key(p.key);
            let what = format!("{} ({})", p.doc, p.unit);
            let numbers = match self.0.get(p.key) {
                Some(value) => numbers(value, p.kind)
                    .map_err(|problem| document.error(&path, format!("{problem}: {what}"), remedy(p.kind)))?,
                None => p.default().ok_or_else(|| {
                    let problem = format!("missing in [material]: {what}, which model {} needs", model.name);
                    document.error(
                        &path,
                        problem,
                        format!("add a line `{} = {}` to [material]", p.key, wanted(p.kind)),
                    )
                })?,
            };
            values.push((p.key, numbers));
        }
        let given = |key: &str| values.iter().find(|(k, _)| *k == key).map(|(_, numbers)| numbers.clone());
        model.make(given).map_err(|e| document.invalid_input(&e))
    }

    /// Name of the model, if it is there.
    pub fn model_name(&self) -> Option<&str> {
        self.0.get("model")?.as_str()
    }

    /// The model's parameters with their values, defaults included; absent ones are left out.
    pub fn values(&self) -> Vec<(&'static Parameter, Vec<f64>)> {
        let parameters = self.model_name().and_then(model).map_or(&[][..], |m| m.parameters);
        let value = |p: &Parameter| match self.0.get(p.key) {
            Some(value) => numbers(value, p.kind).ok(),
            None => p.default().filter(|numbers| !numbers.is_empty()),
        };
        parameters.iter().filter_map(|p| Some((p, value(p)?))).collect()
    }

    fn model(&self, document: &Document) -> Result<&'static Model, ScenarioError> {
        let path = KeyPath::from("material.model");
        let names: Vec<&str> = models().iter().map(|m| m.name).collect();
        let known = names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
        let example = format!("model = \"{}\"", names.first().copied().unwrap_or_default());
        match self.0.get("model") {
            None => Err(document.error(
                &path,
                format!("missing in [material]; known models: {known}"),
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
    let found: Option<Vec<f64>> = match value {
        toml::Value::Array(values) if !kind.is_number() => values.iter().map(number).collect(),
        value if kind.is_number() || kind == Kind::List => number(value).map(|x| vec![x]),
        _ => None,
    };
    let (_, most) = kind.count();
    let fewest = if kind == Kind::List { 1 } else { most };
    match found {
        None if kind.is_number() => Err(format!("is a {}, and a number is allowed", value.type_str())),
        None => Err(format!("is a {}, and {} is allowed", value.type_str(), wanted(kind))),
        Some(found) if (fewest..=most).contains(&found.len()) => Ok(found),
        Some(found) => Err(format!("has {} numbers, and {} is allowed", found.len(), wanted(kind))),
    }
}

/// How to write it.
fn remedy(kind: Kind) -> &'static str {
    if kind.is_number() {
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
    }
}

impl JsonSchema for MaterialTable {
    fn schema_name() -> Cow<'static, str> {
        "MaterialTable".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let models: Vec<_> = models().into_iter().map(model_schema).collect();
        json_schema!({
            "description": "What the body is made of: a model and its parameters.",
            "oneOf": models
        })
    }
}

fn model_schema(m: &Model) -> serde_json::Value {
    let mut properties = serde_json::Map::new();
    properties.insert("model".into(), serde_json::json!({"const": m.name, "description": m.doc}));
    let mut required = vec!["model"];
    for p in m.parameters {
        let mut entry = serde_json::json!({"description": format!("{} ({})", p.doc, p.unit)});
        if p.kind.is_number() {
            entry["type"] = "number".into();
        } else {
            let (_, most) = p.kind.count();
            let fewest = if p.kind == Kind::List { 1 } else { most };
            entry["type"] = "array".into();
            entry["items"] = serde_json::json!({"type": "number"});
            (entry["minItems"], entry["maxItems"]) = (fewest.into(), most.into());
        }
        match p.kind {
            Kind::Default(default) => entry["default"] = default.into(),
            Kind::OptionalNumber | Kind::OptionalVector => {}
            Kind::Number | Kind::Vector | Kind::List => required.push(p.key),
        }
        properties.insert(p.key.into(), entry);
    }
    serde_json::json!({
        "type": "object",
        "description": m.doc,
        "properties": properties,
        "required": required,
        "additionalProperties": false
    })
}
