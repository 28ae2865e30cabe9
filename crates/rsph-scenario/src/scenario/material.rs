//! The material table: a model of the core's registry and its parameters, so that a new material
//! in the core needs no change here.

use super::document::Document;
use super::error::ScenarioError;
use super::explain::suggestion;
use super::keypath::KeyPath;
use rsph_core::material::{Material, Model, Parameter, REGISTRY, model};
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
            values.push(match self.0.get(p.key) {
                Some(toml::Value::Float(x)) => *x,
                Some(toml::Value::Integer(i)) => *i as f64,
                Some(other) => {
                    let problem = format!("is a {}, and a number is allowed: {what}", other.type_str());
                    return Err(document.error(&path, problem, "write a number without quotes or brackets"));
                }
                None => p.default.ok_or_else(|| {
                    let problem = format!("missing in [material]: {what}, which model {} needs", model.name);
                    document.error(&path, problem, format!("add a line `{} = <number>` to [material]", p.key))
                })?,
            });
        }
        (model.build)(&values).map_err(|e| document.invalid_input(&e))
    }

    /// Name of the model, if it is there.
    pub fn model_name(&self) -> Option<&str> {
        self.0.get("model")?.as_str()
    }

    /// The model's parameters with their values, defaults included; absent ones are left out.
    pub fn values(&self) -> Vec<(&'static Parameter, f64)> {
        let parameters = self.model_name().and_then(model).map_or(&[][..], |m| m.parameters);
        parameters.iter().filter_map(|p| Some((p, self.value(p.key).or(p.default)?))).collect()
    }

    fn value(&self, key: &str) -> Option<f64> {
        let value = self.0.get(key)?;
        value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
    }

    fn model(&self, document: &Document) -> Result<&'static Model, ScenarioError> {
        let path = KeyPath::from("material.model");
        let names: Vec<&str> = REGISTRY.iter().map(|m| m.name).collect();
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

impl JsonSchema for MaterialTable {
    fn schema_name() -> Cow<'static, str> {
        "MaterialTable".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let models: Vec<_> = REGISTRY.iter().map(model_schema).collect();
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
        let mut entry =
            serde_json::json!({"type": "number", "description": format!("{} ({})", p.doc, p.unit)});
        if let Some(default) = p.default {
            entry["default"] = default.into();
        } else {
            required.push(p.key);
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
