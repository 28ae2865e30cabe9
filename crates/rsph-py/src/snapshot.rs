//! One moment of a simulation.

use crate::pool::detach;
use crate::{arrays, image};
use pyo3::prelude::*;
use rsph_core::particles::Field;
use rsph_core::snapshot::Snapshot as CoreSnapshot;
use rsph_scenario::output::polydata::PolyData;
use rsph_scenario::output::voxels::Registration;
use std::path::PathBuf;

/// One moment of a simulation; columns are shared with it, not copied.
#[pyclass(frozen, module = "rsph._rsph")]
pub struct Snapshot {
    snapshot: CoreSnapshot,
}

impl Snapshot {
    pub(crate) fn new(snapshot: CoreSnapshot) -> Self {
        Self { snapshot }
    }
}

#[pymethods]
impl Snapshot {
    /// Simulated time.
    #[getter]
    fn time(&self) -> f64 {
        self.snapshot.time
    }

    /// Number of steps taken.
    #[getter]
    fn step(&self) -> u64 {
        self.snapshot.step
    }

    /// Names of the columns that are there.
    fn names(&self) -> Vec<&'static str> {
        self.snapshot.columns().map(|(spec, _)| spec.name).collect()
    }

    /// The column of that name, read-only and without a copy; None if there is none.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        match Field::from_name(name).filter(|f| self.snapshot.particles.has(*f)) {
            None => Ok(None),
            Some(field) => arrays::column_view(py, self.snapshot.column(field)).map(Some),
        }
    }

    /// Current positions (N, 3), a new array.
    fn positions<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        arrays::positions(py, self.snapshot.positions().into_iter())
    }

    /// Writes a field on the voxels of the image `like`.
    #[pyo3(signature = (path, field, like, scale, axes, outside))]
    #[allow(clippy::too_many_arguments, reason = "so many has the method in Python")]
    fn to_nifti(
        &self,
        py: Python<'_>,
        path: PathBuf,
        field: String,
        like: PathBuf,
        scale: Option<f64>,
        axes: &str,
        outside: f32,
    ) -> PyResult<()> {
        let registration = Registration { scale, axes: image::axes(axes)? };
        detach(py, || {
            let particles = PolyData::from_snapshot(&self.snapshot);
            image::write(&path, &particles, &field, &like, registration, outside)
        })
    }

    fn __len__(&self) -> usize {
        self.snapshot.len()
    }
}
