//! Named parts of a mesh as a region: a name, several names, or a table with more.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;

/// Named parts of a mesh file.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartTable {
    /// Name of the part, or names of several, as `rsph info` lists them.
    pub name: Names,
    /// Mesh file with the part, of nearly the same surface as the body; a relative path starts at the scenario file. Default: the
    /// mesh of the body.
    pub path: Option<String>,
    /// Factor from the units of that file to those of the scenario. Default: that of the body's mesh, or 1.
    pub scale: Option<f64>,
}

/// One name or several.
#[derive(Clone, Debug, PartialEq)]
pub struct Names(pub Vec<String>);

/// Names or a table.
#[derive(Clone, Debug, PartialEq)]
pub struct PartValue(pub PartTable);

struct NamesVisitor;

impl<'de> Visitor<'de> for NamesVisitor {
    type Value = Names;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("the name of a part in quotes, or a list of names")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Self::Value, E> {
        Ok(Names(vec![name.into()]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Self::Value, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(list)).map(Names)
    }
}

impl<'de> Deserialize<'de> for Names {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(NamesVisitor)
    }
}

struct PartVisitor;

impl<'de> Visitor<'de> for PartVisitor {
    type Value = PartValue;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("the name of a part in quotes, a list of names, or a table { name = ..., path = ... }")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Self::Value, E> {
        NamesVisitor.visit_str(name).map(of_the_body)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Self::Value, A::Error> {
        NamesVisitor.visit_seq(list).map(of_the_body)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        PartTable::deserialize(MapAccessDeserializer::new(map)).map(PartValue)
    }
}

fn of_the_body(name: Names) -> PartValue {
    PartValue(PartTable { name, path: None, scale: None })
}

impl<'de> Deserialize<'de> for PartValue {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(PartVisitor)
    }
}

impl JsonSchema for Names {
    fn schema_name() -> Cow<'static, str> {
        "Names".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1}]})
    }
}

impl JsonSchema for PartValue {
    fn schema_name() -> Cow<'static, str> {
        "Part".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let names = generator.subschema_for::<Names>();
        let table = generator.subschema_for::<PartTable>();
        json_schema!({"anyOf": [names, table]})
    }
}
