//! The reproductions and benchmarks of `validation/`, as rows of a table and a figure each.

mod case;
mod column;
mod creep;
mod deformation;
mod equilibrium;
mod figure;
mod fsi_1d;
mod kelvin_voigt_bar;
mod large_strain;
mod literal;
mod modal;
mod patch;
mod remeshed;
mod series;
mod tensile;

use serde::Serialize;
use std::path::Path;

/// One measured quantity beside what it should be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the check.
    pub name: String,
    /// What was measured.
    pub measured: f64,
    /// What the literature or a finer method says; `None`: nothing to compare with.
    pub reference: Option<f64>,
    /// The bound that decides, in words: "within 2 %", ">= 1.5".
    pub bound: String,
    /// Unit of the measured value.
    pub unit: String,
    /// Whether the bound is kept.
    pub pass: bool,
}

impl Row {
    /// A value that must agree with `reference` to `percent`.
    fn within(name: impl Into<String>, measured: f64, reference: f64, percent: f64, unit: &str) -> Self {
        Self {
            name: name.into(),
            measured,
            reference: Some(reference),
            bound: format!("within {percent} %"),
            unit: unit.into(),
            pass: (measured / reference - 1.0).abs() <= percent / 100.0,
        }
    }

    /// A value that must agree with `reference` to `distance`.
    fn near(name: impl Into<String>, measured: f64, reference: f64, distance: f64, unit: &str) -> Self {
        Self {
            name: name.into(),
            measured,
            reference: Some(reference),
            bound: format!("within {distance}"),
            unit: unit.into(),
            pass: (measured - reference).abs() <= distance,
        }
    }

    /// A value that must not exceed `limit`.
    fn at_most(name: impl Into<String>, measured: f64, limit: f64, unit: &str) -> Self {
        Self {
            name: name.into(),
            measured,
            reference: None,
            bound: format!("<= {}", plain(limit)),
            unit: unit.into(),
            pass: measured <= limit,
        }
    }

    /// A value that must reach `limit`.
    fn at_least(name: impl Into<String>, measured: f64, limit: f64, unit: &str) -> Self {
        Self {
            name: name.into(),
            measured,
            reference: None,
            bound: format!(">= {limit}"),
            unit: unit.into(),
            pass: measured >= limit,
        }
    }
}

/// What went wrong in a validation: a bug of the program, not of its user.
#[derive(Debug, thiserror::Error)]
#[error("validation {name}: {problem}")]
pub struct ValidationError {
    /// Which one.
    pub name: &'static str,
    /// What went wrong.
    pub problem: String,
}

/// A validation: shortened or in full, with its figures and curves in a folder.
type Case = fn(quick: bool, folder: &Path) -> Result<Vec<Row>, String>;

/// All validations by name.
const CASES: &[(&str, Case)] = &[
    ("patch", patch::run),
    ("column", column::run),
    ("series", series::run),
    ("tensile", tensile::run),
    ("equilibrium", equilibrium::run),
    ("creep", creep::run),
    ("literal", literal::run),
    ("remeshed", remeshed::run),
    ("deformation", deformation::run),
    ("fsi_1d", fsi_1d::run),
    ("large_strain", large_strain::run),
];

/// Names that [`run`] knows.
pub fn names() -> impl Iterator<Item = &'static str> {
    CASES.iter().map(|(name, _)| *name)
}

/// Runs the checks of these names (all of them if the list is empty); `quick` shortens them. Each
/// leaves its figures (SVG) and curves (CSV) in `folder`. `progress` is told the name of each as it
/// starts.
///
/// # Errors
/// A validation that could not be carried out, or a folder that can not be written.
pub fn run(
    names: &[String],
    quick: bool,
    folder: &Path,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<Row>, ValidationError> {
    let mut rows = Vec::new();
    for (name, case) in CASES {
        if names.is_empty() || names.iter().any(|n| n == name) {
            progress(name);
            let failed = |problem| ValidationError { name, problem };
            std::fs::create_dir_all(folder)
                .map_err(|e| failed(format!("cannot make the folder {}: {e}", folder.display())))?;
            rows.extend(case(quick, folder).map_err(failed)?);
        }
    }
    Ok(rows)
}

/// A bound as one writes it: small ones as powers of ten.
fn plain(limit: f64) -> String {
    if limit != 0.0 && limit.abs() < 1e-3 { format!("{limit:e}") } else { format!("{limit}") }
}
