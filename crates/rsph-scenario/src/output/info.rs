//! Description of a run for its writers.

use super::units;
use rsph_core::region::Axis;
use rsph_core::setup::{Probe, Quantity, Units};
use rsph_core::shape::Repair;
use rsph_core::simulation::Description;
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// One row of a table of parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// What, in words: `Young's modulus`.
    pub name: String,
    /// How much or which.
    pub value: String,
    /// SI unit; empty for words, `1` for pure numbers.
    pub unit: String,
}

impl Parameter {
    /// A new row.
    pub fn new(name: impl Into<String>, value: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), value: value.into(), unit: unit.into() }
    }

    /// A new row with a number.
    pub fn number(name: &str, value: f64, unit: &str) -> Self {
        Self::new(name, units::number(value), unit)
    }
}

/// How a load or a motion changes in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// What, in words: `load 1: pressure 2000 Pa`.
    pub name: String,
    /// Times and factors, up to the end of the run.
    pub points: Vec<[f64; 2]>,
}

/// One column of `probes.csv`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProbeColumn {
    /// Header.
    pub name: String,
    /// What it reads, such as `displacement.z`.
    pub quantity: String,
    /// SI unit.
    pub unit: String,
}

impl ProbeColumn {
    /// The columns of the probes, in order: `<name>` or `<name>_x`, `<name>_y`, ...
    pub fn of(probes: &[Probe]) -> Vec<Self> {
        let mut columns = Vec::new();
        for p in probes {
            let Quantity { field, component } = p.quantity;
            let spec = field.spec();
            let suffixes = spec.suffixes;
            let column = |name: String, suffix: Option<&&str>| Self {
                name,
                quantity: suffix.map_or_else(|| spec.name.to_owned(), |s| format!("{}.{s}", spec.name)),
                unit: spec.unit.to_owned(),
            };
            match component {
                Some(c) => columns.push(column(p.name.clone(), suffixes.get(c))),
                None if suffixes.is_empty() => columns.push(column(p.name.clone(), None)),
                None => columns.extend(suffixes.iter().map(|s| column(format!("{}_{s}", p.name), Some(s)))),
            }
        }
        columns
    }
}

/// Description of a run for its writers: everything besides its numbers.
#[derive(Clone, Debug)]
pub struct RunInfo {
    /// Title of the scenario.
    pub title: String,
    /// Its unit system.
    pub units: Units,
    /// The scenario as run, after `--set`, as TOML that runs from any folder.
    pub scenario: String,
    /// What was known before the first step; its notes go into summary and report.
    pub description: Description,
    /// How the surface of the body was made whole, if it had to be.
    pub repair: Option<Repair>,
    /// The material in words.
    pub material: Vec<Parameter>,
    /// Anything else worth a row in the report's table: shape, loads, integrator.
    pub parameters: Vec<Parameter>,
    /// Loads and motions that change in time.
    pub courses: Vec<Course>,
    /// The columns of `probes.csv`.
    pub probes: Vec<ProbeColumn>,
    /// Which axis points up in the report's view: y for organs.
    pub up: Axis,
}

impl RunInfo {
    /// SHA-256 of the scenario as run, in hexadecimal.
    pub fn scenario_sha256(&self) -> String {
        Sha256::digest(self.scenario.as_bytes()).iter().fold(String::new(), |mut s, byte| {
            let _ = write!(s, "{byte:02x}");
            s
        })
    }
}
