//! Ranges of numbers, with messages that point at them.

use crate::scenario::{Document, KeyPath, ScenarioError};
use rsph_core::tensor::Vec3;

/// `value`, which is `what`, must be greater than zero.
pub fn positive(doc: &Document, path: &KeyPath, value: f64, what: &str) -> Result<f64, ScenarioError> {
    if value > 0.0 {
        return Ok(value);
    }
    Err(doc.error(path, format!("{what} must be greater than 0"), "write a positive number"))
}

/// `value`, which is `what`, must not be negative.
pub fn zero_or_more(doc: &Document, path: &KeyPath, value: f64, what: &str) -> Result<f64, ScenarioError> {
    if value >= 0.0 {
        return Ok(value);
    }
    Err(doc.error(path, format!("{what} must be 0 or greater"), "write 0 or a positive number"))
}

/// `value`, which is `what`, must point somewhere.
pub fn direction(doc: &Document, path: &KeyPath, value: [f64; 3], what: &str) -> Result<Vec3, ScenarioError> {
    let v = Vec3::from(value);
    if v.norm() > 0.0 && v.norm().is_finite() {
        return Ok(v);
    }
    Err(doc.error(path, format!("{what} must not be the zero vector"), "for example [0.0, 0.0, 1.0]"))
}
