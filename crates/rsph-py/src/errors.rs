//! Errors of the libraries as those of `rsph.errors`, with the texts of the command line.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsph_core::error::{Failure, InvalidInput};
use rsph_scenario::label_map::LabelMapError;
use rsph_scenario::mesh_io::MeshError;
use rsph_scenario::output::vtkhdf::VtkHdfError;
use rsph_scenario::run::RunError;
use rsph_scenario::scenario::ScenarioError;

/// Wrong input: an `rsph.InputError`.
pub fn input_error(message: &str, key: &str, value: Option<&str>, remedy: &str) -> PyErr {
    Python::attach(|py| {
        let details = PyDict::new(py);
        let filled = details
            .set_item("key", key)
            .and_then(|()| details.set_item("value", value))
            .and_then(|()| details.set_item("remedy", remedy));
        filled.map_or_else(|e| e, |()| raised(py, "InputError", message, &details))
    })
}

/// The core refused an input.
pub fn invalid_input(error: &InvalidInput) -> PyErr {
    input_error(&error.to_string(), &error.key, Some(&error.value), &error.remedy)
}

/// A scenario file was refused; the message says where in the file.
pub fn scenario_file(error: &ScenarioError) -> PyErr {
    input_error(&error.to_string(), &error.key, error.value.as_deref(), &error.remedy)
}

/// A scenario written by the Python half was refused; it has no place that the user could look up.
pub fn scenario_text(error: &ScenarioError) -> PyErr {
    let message = match (error.key.as_str(), &error.value) {
        ("", _) => error.problem.clone(),
        (key, Some(value)) => format!("`{key}` = {value}: {}", error.problem),
        (key, None) => format!("`{key}`: {}", error.problem),
    };
    input_error(&message, &error.key, error.value.as_deref(), &error.remedy)
}

/// A scenario was refused: one from a file (`named`) or one that Python made.
pub fn scenario(error: &ScenarioError, named: bool) -> PyErr {
    if named { scenario_file(error) } else { scenario_text(error) }
}

/// A run did not come to an outcome; `named` says whether its scenario was read from a file.
pub fn run(error: &RunError, named: bool) -> PyErr {
    match error {
        RunError::Scenario(e) => scenario(e, named),
        RunError::Folder(e) => input_error(&e.to_string(), "output", None, e.remedy()),
        RunError::Checkpoint(e) => input_error(&e.to_string(), "output", None, &e.remedy),
        RunError::Memory(e) => input_error(&e.to_string(), "body.particles", None, &e.remedy()),
        RunError::Sink(e) => Python::attach(|py| {
            let details = PyDict::new(py);
            let filled = details.set_item("path", e.path.display().to_string());
            filled.map_or_else(|e| e, |()| raised(py, "StorageError", &e.to_string(), &details))
        }),
    }
}

/// A mesh file could not be read.
pub fn mesh(error: &MeshError) -> PyErr {
    let path = error.path().display().to_string();
    let message = format!("{path}: {}", error.problem());
    input_error(&message, "body.shape.mesh.path", Some(&path), error.remedy())
}

/// A segmentation could not be read.
pub fn label_map(error: &LabelMapError) -> PyErr {
    let path = error.path.display().to_string();
    let message = format!("{path}: {}", error.problem);
    input_error(&message, "body.labelmap.path", Some(&path), &error.remedy)
}

/// A results file could not be read.
pub fn results(error: &VtkHdfError) -> PyErr {
    let path = error.path.display().to_string();
    input_error(&error.to_string(), "path", Some(&path), &error.remedy)
}

/// The simulation failed: an `rsph.SimulationError`.
pub fn failure(failure: &Failure) -> PyErr {
    Python::attach(|py| {
        let place = failure.place.map(|p| (p.x, p.y, p.z));
        let shown = place.map_or_else(String::new, |(x, y, z)| format!(", at X = ({x:.4}, {y:.4}, {z:.4})"));
        let details = PyDict::new(py);
        let filled = details
            .set_item("time", failure.time)
            .and_then(|()| details.set_item("step", failure.step))
            .and_then(|()| details.set_item("place", place))
            .and_then(|()| details.set_item("remedy", &failure.remedy));
        let message = format!("{failure}{shown}");
        filled.map_or_else(|e| e, |()| raised(py, "SimulationError", &message, &details))
    })
}

/// An `rsph.Error` without further details.
pub fn plain(message: &str) -> PyErr {
    Python::attach(|py| raised(py, "Error", message, &PyDict::new(py)))
}

/// An exception of the module `rsph.errors`.
fn raised(py: Python<'_>, class: &str, message: &str, details: &Bound<'_, PyDict>) -> PyErr {
    let error = py
        .import("rsph.errors")
        .and_then(|m| m.getattr(class))
        .and_then(|c| c.call((message,), Some(details)));
    error.map_or_else(|e| e, PyErr::from_value)
}
