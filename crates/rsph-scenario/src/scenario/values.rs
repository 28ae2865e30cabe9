//! Values that are a number or a word.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;

/// A time step: a number (s) or "auto".
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum TimeStepValue {
    /// 0.9 of the stability limit.
    #[default]
    Auto,
    /// This many seconds.
    Seconds(f64),
}

/// Steps between remeshings: a whole number or "auto".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EveryValue {
    /// When the strain asks for it.
    Auto,
    /// Every so many steps; 0: never.
    Steps(u64),
}

impl Default for EveryValue {
    fn default() -> Self {
        Self::Steps(0)
    }
}

/// The centre of a patch: a point (m) or "upper-right".
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CentreValue {
    /// A point on or near the surface.
    At([f64; 3]),
    /// The upper right part of an organ.
    UpperRight,
}

struct TimeStepVisitor;

impl Visitor<'_> for TimeStepVisitor {
    type Value = TimeStepValue;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number (s) or \"auto\"")
    }

    fn visit_f64<E: Error>(self, v: f64) -> Result<Self::Value, E> {
        Ok(TimeStepValue::Seconds(v))
    }

    fn visit_i64<E: Error>(self, v: i64) -> Result<Self::Value, E> {
        Ok(TimeStepValue::Seconds(v as f64))
    }

    fn visit_str<E: Error>(self, v: &str) -> Result<Self::Value, E> {
        match v {
            "auto" => Ok(TimeStepValue::Auto),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(v), &self)),
        }
    }
}

struct EveryVisitor;

impl Visitor<'_> for EveryVisitor {
    type Value = EveryValue;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a whole number of steps, 0 for never, or \"auto\"")
    }

    fn visit_i64<E: Error>(self, v: i64) -> Result<Self::Value, E> {
        u64::try_from(v)
            .map(EveryValue::Steps)
            .map_err(|_| E::invalid_value(serde::de::Unexpected::Signed(v), &self))
    }

    fn visit_u64<E: Error>(self, v: u64) -> Result<Self::Value, E> {
        Ok(EveryValue::Steps(v))
    }

    fn visit_str<E: Error>(self, v: &str) -> Result<Self::Value, E> {
        match v {
            "auto" => Ok(EveryValue::Auto),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(v), &self)),
        }
    }
}

struct CentreVisitor;

impl<'de> Visitor<'de> for CentreVisitor {
    type Value = CentreValue;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("three coordinates [x, y, z] (m) or \"upper-right\"")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut point = [0.0; 3];
        for (i, x) in point.iter_mut().enumerate() {
            *x = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
        }
        if seq.next_element::<serde::de::IgnoredAny>()?.is_some() {
            return Err(A::Error::invalid_length(4, &self));
        }
        Ok(CentreValue::At(point))
    }

    fn visit_str<E: Error>(self, v: &str) -> Result<Self::Value, E> {
        match v {
            "upper-right" => Ok(CentreValue::UpperRight),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(v), &self)),
        }
    }
}

impl<'de> Deserialize<'de> for TimeStepValue {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(TimeStepVisitor)
    }
}

impl<'de> Deserialize<'de> for EveryValue {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(EveryVisitor)
    }
}

impl<'de> Deserialize<'de> for CentreValue {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(CentreVisitor)
    }
}

macro_rules! inline_schema {
    ($type:ty, $name:literal, $schema:tt) => {
        impl JsonSchema for $type {
            fn schema_name() -> Cow<'static, str> {
                $name.into()
            }

            fn inline_schema() -> bool {
                true
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!($schema)
            }
        }
    };
}

inline_schema!(TimeStepValue, "TimeStep", {
    "anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"const": "auto"}]
});
inline_schema!(EveryValue, "RemeshEvery", {
    "anyOf": [{"type": "integer", "minimum": 0}, {"const": "auto"}]
});
inline_schema!(CentreValue, "PatchCentre", {
    "anyOf": [
        {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
        {"const": "upper-right"}
    ]
});
