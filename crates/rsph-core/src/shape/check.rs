//! Checks that the constructors of shapes share.

use crate::error::InvalidInput;
use crate::tensor::Vec3;

/// A length that must be positive and finite.
pub(super) fn positive(key: &str, value: f64) -> Result<(), InvalidInput> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(InvalidInput::new(
        key,
        value,
        "a length must be a positive, finite number (length unit of the scenario, m in SI)",
        "give a length above zero",
    ))
}

/// Edge lengths that must be positive and finite.
pub(super) fn positive_vector(key: &str, value: &Vec3) -> Result<(), InvalidInput> {
    (0..3).try_for_each(|i| positive(&format!("{key}[{i}]"), value[i]))
}

/// A position that must be finite.
pub(super) fn finite(key: &str, value: &Vec3) -> Result<(), InvalidInput> {
    match (0..3).find(|&i| !value[i].is_finite()) {
        None => Ok(()),
        Some(i) => Err(InvalidInput::new(
            format!("{key}[{i}]"),
            value[i],
            "a coordinate must be a finite number (length unit of the scenario, m in SI)",
            "give three finite coordinates",
        )),
    }
}
