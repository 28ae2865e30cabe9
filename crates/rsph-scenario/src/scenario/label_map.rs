//! A label map as the source of the body: the path of an image, or a table with more.

use crate::label_map::Axes;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

/// A label of a segmented image.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LabelMapTable {
    /// NIfTI or NRRD file (.nii, .nii.gz, .nrrd); a relative path starts at the scenario file.
    pub path: String,
    /// Number of the organ in the image. Default: 1.
    #[schemars(range(min = 1))]
    pub label: Option<u32>,
    /// Instead of one number: numbers with names, all of which make one body, such as `{ 6 = "parenchyma", 7 = "tumour" }`.
    /// Each is of the material of that name.
    pub labels: Option<BTreeMap<String, String>>,
    /// Factor from the units of the image to those of the scenario. Default: to metres, as its header says.
    pub scale: Option<f64>,
    /// Axes of the body. Default: "image".
    #[serde(default)]
    pub axes: AxesName,
}

/// Axes of a body from an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AxesName {
    /// Axes of the image.
    #[default]
    Image,
    /// Axes of organs: from a patient's (x to the right, y to the front, z up) to x from the right side of the
    /// body to its left, y up, z to the front.
    Organ,
}

impl AxesName {
    /// The axes.
    pub fn axes(self) -> Axes {
        match self {
            Self::Image => Axes::Image,
            Self::Organ => Axes::Organ,
        }
    }
}

/// A path or a table.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelMapValue(pub LabelMapTable);

struct LabelMapVisitor;

impl<'de> Visitor<'de> for LabelMapVisitor {
    type Value = LabelMapValue;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("the path of an image in quotes, or a table { path = ..., label = ... }")
    }

    fn visit_str<E: Error>(self, path: &str) -> Result<Self::Value, E> {
        Ok(LabelMapValue(LabelMapTable {
            path: path.into(),
            label: None,
            labels: None,
            scale: None,
            axes: AxesName::Image,
        }))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        LabelMapTable::deserialize(MapAccessDeserializer::new(map)).map(LabelMapValue)
    }
}

impl<'de> Deserialize<'de> for LabelMapValue {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(LabelMapVisitor)
    }
}

impl JsonSchema for LabelMapValue {
    fn schema_name() -> Cow<'static, str> {
        "LabelMap".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let table = generator.subschema_for::<LabelMapTable>();
        json_schema!({"anyOf": [{"type": "string"}, table]})
    }
}
