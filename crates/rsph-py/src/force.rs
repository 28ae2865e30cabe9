//! Forces from a Python function, called once a step.

use crate::arrays::{point_by_point, positions, vectors};
use crate::errors::{input_error, invalid_input, plain};
use numpy::{PyArrayLike2, PyUntypedArrayMethods, TypeMustMatch};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsph_core::boundary::surface_load::SurfacePoint;
use rsph_core::boundary::surface_quadrature::SurfaceQuadrature;
use rsph_core::particles::{Column, Field};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// A Python function `f(time, columns)` that returns the forces (P, 3) on points of the surface or on the
/// particles.
pub struct PythonForce {
    function: Py<PyAny>,
    on_surface: bool,
    /// The reference positions of the particles that what follows was made for.
    prepared: Option<Arc<Vec<f64>>>,
    surface: Option<(SurfaceQuadrature, Vec<SurfacePoint>)>,
    /// Columns that stay as they are: reference positions, and normals and areas, or masses and volumes.
    constant: Vec<(&'static str, Py<PyAny>)>,
    /// The step and the time that the present forces are for.
    evaluated: Option<(u64, f64)>,
}

impl PythonForce {
    pub fn new(function: Py<PyAny>, on_surface: bool) -> Self {
        Self { function, on_surface, prepared: None, surface: None, constant: Vec::new(), evaluated: None }
    }

    pub fn clone_ref(&self, py: Python<'_>) -> Self {
        Self {
            function: self.function.clone_ref(py),
            on_surface: self.on_surface,
            prepared: self.prepared.clone(),
            surface: self.surface.clone(),
            constant: self.constant.iter().map(|(name, array)| (*name, array.clone_ref(py))).collect(),
            evaluated: self.evaluated,
        }
    }

    /// Puts the forces of the time `t` on the particles, if that was not done for the step to come.
    pub fn apply(&mut self, py: Python<'_>, simulation: &mut Simulation, t: f64) -> PyResult<()> {
        if self.evaluated == Some((simulation.step_count(), t)) {
            return Ok(());
        }
        let reference = simulation.particles().column(Field::Reference).share();
        if !self.prepared.as_ref().is_some_and(|prepared| Arc::ptr_eq(prepared, &reference)) {
            self.prepare(py, simulation)?;
            self.prepared = Some(reference);
        }
        let columns = PyDict::new(py);
        for (name, array) in &self.constant {
            columns.set_item(name, array)?;
        }
        let particles = simulation.particles();
        let here = |field: Field| -> Vec<f64> {
            let column = particles.column(field);
            self.surface
                .as_ref()
                .map_or_else(|| by_point(column), |(surface, points)| surface.interpolate(points, column))
        };
        columns.set_item("displacement", point_by_point(py, here(Field::Displacement), 3)?)?;
        columns.set_item("velocity", point_by_point(py, here(Field::Velocity), 3)?)?;
        let returned = self.function.bind(py).call1((t, columns))?;
        let points = self.surface.as_ref().map_or(particles.len(), |(_, points)| points.len());
        let forces = checked(py, &returned, points)?;
        let n = particles.len();
        let force = match &self.surface {
            Some((surface, points)) => surface.carry(n, points, &forces),
            None => (0..3 * n).map(|k| forces[k % n][k / n]).collect(),
        };
        simulation.set_forces(&force).map_err(|e| invalid_input(&e))?;
        self.evaluated = Some((simulation.step_count(), t));
        Ok(())
    }

    /// Finds the points for the present particles.
    fn prepare(&mut self, py: Python<'_>, simulation: &Simulation) -> PyResult<()> {
        let read_only = |array: Bound<'_, PyAny>| -> PyResult<Py<PyAny>> {
            array.call_method1("setflags", (false,))?;
            Ok(array.unbind())
        };
        self.constant.clear();
        if self.on_surface {
            let surface = simulation
                .surface_quadrature()
                .ok_or_else(|| plain("this kind of body takes no forces on its surface"))?;
            let points = surface.points();
            let list = |of: fn(&SurfacePoint) -> Vec3| positions(py, points.iter().map(|p| of(p).into()));
            self.constant.push(("reference", read_only(list(|p| p.x))?));
            self.constant.push(("normals", read_only(list(|p| p.normal))?));
            let areas = points.iter().map(|p| p.area).collect();
            self.constant.push(("areas", read_only(point_by_point(py, areas, 1)?)?));
            self.surface = Some((surface, points));
        } else {
            let particles = simulation.particles();
            for (name, field) in
                [("reference", Field::Reference), ("mass", Field::Mass), ("volume", Field::Volume)]
            {
                let column = particles.column(field);
                let array = point_by_point(py, by_point(column), column.components())?;
                self.constant.push((name, read_only(array)?));
            }
        }
        Ok(())
    }
}

/// The values of a column particle by particle.
fn by_point(column: &Column) -> Vec<f64> {
    let (n, c) = (column.len(), column.components());
    (0..n * c).map(|k| column.component(k % c)[k / c]).collect()
}

/// The forces that a Python function returned for that many points.
fn checked(py: Python<'_>, returned: &Bound<'_, PyAny>, points: usize) -> PyResult<Vec<Vec3>> {
    let wrong = |value: &str, problem: &str| {
        input_error(
            &format!("the forces of a load returned by your function are {value}: {problem}"),
            "load",
            Some(value),
            "return one force (N) for each row of the positions",
        )
    };
    let numbers = py.import("numpy")?.call_method1("asarray", (returned, "float64"))?;
    let shape = || numbers.getattr("shape").map_or_else(|_| "?".into(), |s| s.to_string());
    let needed = format!("({points}, 3) is needed");
    let array: PyArrayLike2<'_, f64, TypeMustMatch> =
        numbers.extract().map_err(|_| wrong(&format!("an array of shape {}", shape()), &needed))?;
    if array.shape() != [points, 3] {
        return Err(wrong(&format!("an array of shape {}", shape()), &needed));
    }
    let forces = vectors(&array, "load")?;
    if forces.iter().any(|f| !f.iter().all(|c| c.is_finite())) {
        return Err(wrong("not finite", "NaN and infinity are no forces"));
    }
    Ok(forces)
}
