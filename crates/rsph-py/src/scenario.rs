//! Scenarios written by the Python half, and what it needs to know to write them.

use crate::errors;
use crate::pool::compute;
use crate::shape::Shape;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsph_core::material::{Material, models};
use rsph_core::setup::{Probe, Setup};
use rsph_scenario::scenario::LoadedScenario;
use std::path::PathBuf;
use std::sync::Arc;

/// A scenario as Python hands it over: its name in messages (empty if it was not read from a file), its text,
/// the folder where its paths begin, and edits `key.path=value`.
pub type Source = (String, String, PathBuf, Vec<String>);

/// The scenario of a source.
pub fn loaded((name, text, base_dir, sets): Source) -> PyResult<LoadedScenario> {
    LoadedScenario::from_text(&name, text, base_dir, &sets)
        .map_err(|e| errors::scenario(&e, !name.is_empty()))
}

/// The text of a scenario file. Raises `rsph.InputError` if it can not be read or is none.
#[pyfunction]
pub fn read_scenario(path: PathBuf) -> PyResult<String> {
    let scenario = LoadedScenario::from_file(&path, &[]).map_err(|e| errors::scenario_file(&e))?;
    Ok(scenario.as_run().to_owned())
}

/// The text of a scenario with its edits in it, in a form that runs from any folder. Raises `rsph.InputError`
/// if it is none.
#[pyfunction]
pub fn scenario_text(source: Source) -> PyResult<String> {
    let named = !source.0.is_empty();
    let scenario = loaded(source)?;
    compute(|| scenario.check()).map_err(|e| errors::scenario(&e, named))?;
    Ok(scenario.as_run_anywhere())
}

/// The first probe of the scenario `text`.
pub fn probe(text: String) -> PyResult<Probe> {
    let first = understood(text)?.probes.into_iter().next();
    first.ok_or_else(|| errors::plain("there is no probe"))
}

/// The material of the scenario `text`.
pub fn material(text: String) -> PyResult<Arc<dyn Material>> {
    let setup = understood(text)?;
    let material = setup.solid().map(|solid| Arc::clone(&solid.material));
    material.ok_or_else(|| errors::plain("there is no material"))
}

fn understood(text: String) -> PyResult<Setup> {
    let loaded = LoadedScenario::from_text("", text, PathBuf::new(), &[]);
    let job = compute(|| loaded.and_then(|s| s.lower())).map_err(|e| errors::scenario_text(&e))?;
    Ok(job.setup)
}

/// What the core simulates from the TOML text `text`; its shape is replaced by `shape`, since a
/// shape made in Python may have no words in TOML.
pub fn setup(text: String, shape: &Shape) -> PyResult<Setup> {
    Ok(Setup { shape: Arc::clone(&shape.shape), ..understood(text)? })
}

/// Raises `rsph.InputError` if the scenario `text` can not be understood.
#[pyfunction]
pub fn check(text: String) -> PyResult<()> {
    understood(text).map(drop)
}

/// All material models: name, description and parameters (key, unit, description, default).
#[pyfunction]
pub fn material_models(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    models()
        .into_iter()
        .map(|model| {
            let parameters: Vec<_> = model
                .all_parameters()
                .map(|p| {
                    (
                        p.key,
                        p.unit,
                        p.doc,
                        p.default().filter(|d| !d.is_empty()).map(|d| d[0]),
                        p.kind.count(),
                    )
                })
                .collect();
            let row = PyDict::new(py);
            row.set_item("name", model.name)?;
            row.set_item("doc", model.doc)?;
            row.set_item("parameters", parameters)?;
            Ok(row)
        })
        .collect()
}
