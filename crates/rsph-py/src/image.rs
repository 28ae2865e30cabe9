//! Fields on the voxels of an image.

use crate::errors;
use crate::pool::detach;
use pyo3::prelude::*;
use rsph_core::error::InvalidInput;
use rsph_scenario::label_map::{Axes, read_grid};
use rsph_scenario::output::polydata::PolyData;
use rsph_scenario::output::voxels::{Registration, on_voxels, registration};
use rsph_scenario::output::{nifti, vtkhdf};
use std::path::{Path, PathBuf};

/// The axes of that name.
pub fn axes(name: &str) -> PyResult<Axes> {
    match name {
        "image" => Ok(Axes::Image),
        "organ" => Ok(Axes::Organ),
        other => Err(errors::invalid_input(&InvalidInput::new(
            "axes",
            other,
            "is no set of axes",
            "take \"image\" or \"organ\"",
        ))),
    }
}

/// Writes a field of `particles` on the voxels of the image `like` to `path`.
pub fn write(
    path: &Path,
    particles: &PolyData,
    field: &str,
    like: &Path,
    registration: Registration,
    outside: f32,
) -> PyResult<()> {
    if registration.scale.is_some_and(|s| !(s.is_finite() && s > 0.0)) {
        return Err(errors::invalid_input(&InvalidInput::new(
            "scale",
            registration.scale.unwrap_or_default(),
            "must be greater than 0",
            "0.001 makes metres of mm",
        )));
    }
    let grid = read_grid(like).map_err(|e| errors::label_map(&e))?;
    let shown = on_voxels(particles, field, &grid, registration).map_err(|e| errors::invalid_input(&e))?;
    nifti::write(path, &grid, &shown, outside).map_err(|e| errors::plain(&e.to_string()))
}

/// Writes a field of one step of the particles in the folder of a run on the voxels of the image `like`, with the label map's scale and
/// axes.
#[pyfunction]
pub fn frame_to_nifti(
    py: Python<'_>,
    folder: PathBuf,
    step: usize,
    path: PathBuf,
    field: String,
    like: PathBuf,
    outside: f32,
) -> PyResult<()> {
    detach(py, || {
        let particles = vtkhdf::read_step(&folder.join("particles.vtkhdf"), Some(step))
            .map_err(|e| errors::results(&e))?;
        let registration = registration(&folder).map_err(|e| errors::scenario_file(&e))?;
        write(&path, &particles, &field, &like, registration, outside)
    })
}
