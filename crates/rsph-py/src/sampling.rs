//! Particles of a shape, without a simulation.

use crate::arrays::{point_by_point, positions};
use crate::errors::invalid_input;
use crate::interrupt::{SOON, interruptible};
use crate::shape::Shape;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsph_core::sample::{Resolution, sample as fill};
use std::sync::Arc;

/// Fills a shape with particles: `positions` (N, 3), `volume` (N,), `level_set` (N,) and `spacing`.
#[pyfunction]
#[pyo3(signature = (shape, spacing=None, particles=None))]
pub fn sample<'py>(
    py: Python<'py>,
    shape: &Shape,
    spacing: Option<f64>,
    particles: Option<usize>,
) -> PyResult<Bound<'py, PyDict>> {
    let resolution =
        spacing.map_or_else(|| Resolution::Particles(particles.unwrap_or_default()), Resolution::Spacing);
    let shape = Arc::clone(&shape.shape);
    let body = interruptible(py, SOON, || (), move || fill(&*shape, resolution, &[]))?
        .map_err(|e| invalid_input(&e))?;
    let dx = body.grid.spacing;
    let centres = body.cells.iter().map(|c| body.grid.centre(*c).into());
    let dict = PyDict::new(py);
    dict.set_item("positions", positions(py, centres))?;
    dict.set_item("volume", point_by_point(py, body.volume, 1)?)?;
    dict.set_item("level_set", point_by_point(py, body.level_set, 1)?)?;
    dict.set_item("spacing", dx)?;
    Ok(dict)
}
