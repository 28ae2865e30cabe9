//! Results files.

use crate::pool::detach;
use crate::{arrays, errors};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsph_scenario::output::polydata::Cells;
use rsph_scenario::output::vtkhdf;
use std::path::PathBuf;

/// What a results file holds: `times`, `points` of each step, `polygons` of each step, and `fields`
/// by name with their numbers of components.
#[pyfunction]
pub fn describe_results(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let info = detach(py, || vtkhdf::describe(&path)).map_err(|e| errors::results(&e))?;
    let fields = PyDict::new(py);
    for field in info.fields {
        fields.set_item(field.name, field.components)?;
    }
    let dict = PyDict::new(py);
    dict.set_item("times", info.times)?;
    dict.set_item("points", info.points)?;
    dict.set_item("polygons", info.polygons)?;
    dict.set_item("fields", fields)?;
    Ok(dict)
}

/// One field of one step of a results file: an array (N,) or (N, components).
#[pyfunction]
pub fn read_field<'py>(
    py: Python<'py>,
    path: PathBuf,
    step: usize,
    field: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let read = detach(py, || vtkhdf::read_field(&path, step, field)).map_err(|e| errors::results(&e))?;
    arrays::point_by_point(py, read.values, read.components)
}

/// One step of a results file: `time`, `points` (N, 3), `triangles` (T, 3) or None for particles,
/// and `fields` by name.
#[pyfunction]
pub fn read_frame(py: Python<'_>, path: PathBuf, step: usize) -> PyResult<Bound<'_, PyDict>> {
    let frame = detach(py, || vtkhdf::read_step(&path, Some(step))).map_err(|e| errors::results(&e))?;
    let fields = PyDict::new(py);
    for field in frame.fields {
        fields.set_item(field.name, arrays::point_by_point(py, field.values, field.components)?)?;
    }
    let dict = PyDict::new(py);
    dict.set_item("time", frame.time)?;
    dict.set_item("points", arrays::positions(py, frame.points.into_iter()))?;
    dict.set_item(
        "triangles",
        match &frame.cells {
            Cells::Vertices => None,
            Cells::Triangles(triangles) => Some(arrays::triangles(py, triangles)),
        },
    )?;
    dict.set_item("fields", fields)?;
    Ok(dict)
}
