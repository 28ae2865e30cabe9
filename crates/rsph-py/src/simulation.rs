//! A running simulation.

use crate::errors;
use crate::field::{Trouble, python_field};
use crate::history::History;
use crate::shape::Shape;
use crate::snapshot::Snapshot;
use crate::{arrays, scenario};
use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsph_core::error::{Failure, InvalidInput};
use rsph_core::setup::{Integration, Scheme, TimeStep};
use rsph_core::simulation::Simulation as CoreSimulation;
use rsph_core::tensor::Vec3;
use rsph_scenario::scenario::LoadedScenario;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// How often a run looks whether the user pressed Ctrl-C, and reports how far it is.
const SLICE: Duration = Duration::from_millis(50);

/// A running simulation. It computes without the interpreter lock; another thread that uses it
/// meanwhile gets an error.
#[pyclass(frozen, module = "rsph._rsph")]
pub struct Simulation {
    state: Mutex<State>,
    until: Option<f64>,
    notes: Vec<String>,
}

struct State {
    simulation: CoreSimulation,
    history: History,
}

impl Simulation {
    fn new_at_start(simulation: CoreSimulation, until: Option<f64>, mut notes: Vec<String>) -> Self {
        notes.extend(simulation.description().notes.iter().cloned());
        Self { state: Mutex::new(State { simulation, history: History::default() }), until, notes }
    }

    fn state(&self) -> PyResult<MutexGuard<'_, State>> {
        self.state.try_lock().map_err(|_| {
            errors::plain(
                "this simulation is computing in another thread; wait for it, or use the `callback` of \
                 `run` to look at it on its way",
            )
        })
    }

    /// Calls `compute` without the interpreter lock. What it is given is to be called after every
    /// step and says whether to go on; the user's Ctrl-C and an error of `report` end the work at a
    /// whole step.
    fn compute(
        py: Python<'_>,
        state: &mut State,
        report: Option<&Py<PyAny>>,
        compute: impl FnOnce(&mut State, &mut dyn FnMut(f64) -> bool) -> Result<(), Failure> + Send,
    ) -> PyResult<()> {
        let mut stopped = None;
        let stop = &mut stopped;
        let done = py.detach(move || {
            let mut last = Instant::now();
            compute(state, &mut |time| {
                if last.elapsed() < SLICE {
                    return true;
                }
                let heard = Python::attach(|py| {
                    py.check_signals()?;
                    report.map_or(Ok(()), |r| r.call1(py, (time,)).map(drop))
                });
                last = Instant::now();
                heard.map_err(|e| *stop = Some(e)).is_ok()
            })
        });
        stopped.map_or(Ok(()), Err)?;
        done.map_err(|e| errors::failure(&e))
    }
}

#[pymethods]
impl Simulation {
    /// From the TOML text of a scenario, the shape of the body, and Python functions for the initial
    /// values that the text does not give.
    #[new]
    #[pyo3(signature = (scenario, shape, displacement=None, velocity=None))]
    fn new(
        py: Python<'_>,
        scenario: String,
        shape: &Shape,
        displacement: Option<Py<PyAny>>,
        velocity: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let mut setup = scenario::setup(scenario, shape)?;
        let trouble = Trouble::default();
        let field = |key, f| python_field(key, f, trouble.clone());
        if let Some(f) = displacement {
            setup.initial.displacement = field("initial_displacement", f);
        }
        if let Some(f) = velocity {
            setup.initial.velocity = field("initial_velocity", f);
        }
        let simulation = py.detach(|| CoreSimulation::new(setup));
        trouble.check()?;
        Ok(Self::new_at_start(simulation.map_err(|e| errors::invalid_input(&e))?, None, Vec::new()))
    }

    /// From a scenario file and edits `key.path=value`.
    #[staticmethod]
    fn from_toml(py: Python<'_>, path: PathBuf, sets: Vec<String>) -> PyResult<Self> {
        py.detach(|| {
            let loaded = LoadedScenario::from_file(&path, &sets).map_err(|e| errors::scenario_file(&e))?;
            let job = loaded.lower().map_err(|e| errors::scenario_file(&e))?;
            let simulation = CoreSimulation::new(job.setup)
                .map_err(|e| errors::scenario_file(&loaded.document().invalid_input(&e)))?;
            Ok(Self::new_at_start(simulation, Some(job.until), job.notes))
        })
    }

    /// Takes `n` steps of length `dt`.
    fn step(&self, py: Python<'_>, n: u64) -> PyResult<()> {
        Self::compute(py, &mut *self.state()?, None, |state, go_on| {
            for _ in 0..n {
                state.simulation.step()?;
                if !go_on(state.simulation.time()) {
                    break;
                }
            }
            Ok(())
        })
    }

    /// Advances to the time `until` exactly, recording the probes every `stride` steps and at both
    /// ends; `report(time)` is called now and then.
    #[pyo3(signature = (until, stride, report=None))]
    fn advance(&self, py: Python<'_>, until: f64, stride: u64, report: Option<Py<PyAny>>) -> PyResult<()> {
        Self::compute(py, &mut *self.state()?, report.as_ref(), |state, go_on| {
            let State { simulation, history } = state;
            history.record(simulation);
            let result = simulation.advance_to(until, &mut |s| {
                if s.step_count() % stride.max(1) == 0 {
                    history.record(s);
                }
                go_on(s.time())
            });
            history.record(simulation);
            result
        })
    }

    /// Goes straight to equilibrium under the loads and holds of the time `t`.
    fn solve_static<'py>(&self, py: Python<'py>, t: f64) -> PyResult<Bound<'py, PyDict>> {
        let mut found = None;
        Self::compute(py, &mut *self.state()?, None, |state, go_on| {
            let result = state.simulation.solve_static(t, &mut |_, _| go_on(t));
            result.map(|e| found = Some(e))
        })?;
        let e = found.unwrap_or_default();
        let dict = PyDict::new(py);
        dict.set_item("iterations", e.iterations)?;
        dict.set_item("residual", e.residual)?;
        dict.set_item("compliance", e.compliance)?;
        dict.set_item("load", vector(py, &e.load))?;
        dict.set_item("reaction", vector(py, &e.reaction))?;
        Ok(dict)
    }

    /// Goes on with another scheme; `dt` absent: the scheme's own.
    #[pyo3(signature = (integrator, dt=None, tolerance=None))]
    fn set_integration(
        &self,
        py: Python<'_>,
        integrator: &str,
        dt: Option<f64>,
        tolerance: Option<f64>,
    ) -> PyResult<()> {
        let scheme = Scheme::ALL.into_iter().find(|s| s.name() == integrator).ok_or_else(|| {
            errors::invalid_input(&InvalidInput::new(
                "integrator",
                integrator,
                "is no scheme of integration",
                "take \"auto\", \"rk4\", \"sdirk2\", \"backward-euler\" or \"rkc2\"",
            ))
        })?;
        let state = &mut *self.state()?;
        let tolerance = tolerance.unwrap_or(state.simulation.setup().integration.tolerance);
        let step = dt.map_or(TimeStep::Auto, TimeStep::Fixed);
        py.detach(|| state.simulation.set_integration(Integration { scheme, tolerance }, step))
            .map_err(|e| errors::invalid_input(&e))
    }

    /// K u of displacements (N, 3), as an array of that shape.
    fn stiffness<'py>(&self, py: Python<'py>, u: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyAny>> {
        let state = &mut *self.state()?;
        let (u, n) = (u.as_array(), state.simulation.particles().len());
        if u.shape() != [n, 3] {
            return Err(errors::invalid_input(&InvalidInput::new(
                "u",
                format!("{:?}", u.shape()),
                format!("must have the shape ({n}, 3): a displacement for each particle"),
                "as `snapshot().displacement` has",
            )));
        }
        let columns: Vec<f64> = (0..3).flat_map(|i| u.column(i).to_vec()).collect();
        let force = py.detach(|| state.simulation.stiffness(&columns)).ok_or_else(|| {
            errors::plain("this body has no stiffness: it needs the adjoint formulation of a solid")
        })?;
        arrays::point_by_point(py, (0..3 * n).map(|k| force[k % 3 * n + k / 3]).collect(), 3)
    }

    /// Simulated time.
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.state()?.simulation.time())
    }

    /// Number of steps taken.
    #[getter]
    fn steps(&self) -> PyResult<u64> {
        Ok(self.state()?.simulation.step_count())
    }

    /// The end of the simulation that the scenario file names.
    #[getter]
    fn until(&self) -> Option<f64> {
        self.until
    }

    /// Things the user should know, one sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// What is known before the first step, by name.
    fn description<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = self.state()?;
        let (d, setup) = (state.simulation.description(), state.simulation.setup());
        let dict = PyDict::new(py);
        dict.set_item("shape", setup.shape.name())?;
        dict.set_item("material", setup.material.name())?;
        dict.set_item("particles", d.particles)?;
        dict.set_item("spacing", d.spacing)?;
        dict.set_item("smoothing_length", d.smoothing_length)?;
        dict.set_item("neighbours", d.neighbours)?;
        dict.set_item("integrator", d.scheme.name())?;
        dict.set_item("dt", d.dt)?;
        dict.set_item("dt_limit", d.dt_limit)?;
        dict.set_item("limited_by_viscosity", d.limited_by_viscosity)?;
        dict.set_item("volume", d.volume)?;
        dict.set_item("shape_volume", d.shape_volume)?;
        dict.set_item("load", vector(py, &d.load))?;
        Ok(dict)
    }

    /// A picture of this moment.
    fn snapshot(&self, py: Python<'_>) -> PyResult<Snapshot> {
        let state = &mut *self.state()?;
        Ok(Snapshot::new(py.detach(|| state.simulation.snapshot())))
    }

    /// The surface of this moment: vertices (V, 3), triangles (T, 3) and fields by name.
    fn surface<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyDict>)> {
        let state = &mut *self.state()?;
        let surface = py.detach(|| {
            let snapshot = state.simulation.snapshot();
            state.simulation.surface(&snapshot)
        });
        let fields = PyDict::new(py);
        for field in surface.fields {
            fields.set_item(field.name, arrays::point_by_point(py, field.values, field.components)?)?;
        }
        let vertices = arrays::positions(py, surface.mesh.vertices.iter().map(|v| (*v).into()));
        Ok((vertices, arrays::triangles(py, &surface.mesh.triangles), fields))
    }

    /// The probes' readings of this moment, by name.
    fn probes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = &mut *self.state()?;
        let readings = py.detach(|| state.simulation.readings());
        let dict = PyDict::new(py);
        for reading in readings {
            dict.set_item(reading.name, reading.value)?;
        }
        Ok(dict)
    }

    /// The readings that `advance` recorded: arrays (S,) by name, `time` first.
    fn history<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.state()?.history.to_dict(py)
    }

    /// The conserved sums of this moment, by name.
    fn conservation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = &mut *self.state()?;
        let c = py.detach(|| state.simulation.conservation());
        let dict = PyDict::new(py);
        dict.set_item("mass", c.mass)?;
        dict.set_item("momentum", vector(py, &c.momentum))?;
        dict.set_item("kinetic_energy", c.kinetic_energy)?;
        dict.set_item("elastic_energy", c.elastic_energy)?;
        dict.set_item("external_work", c.external_work)?;
        dict.set_item("dissipated", c.dissipated)?;
        if let Some(error) = c.energy_error {
            dict.set_item("energy_error", error)?;
        }
        dict.set_item("load", vector(py, &c.load))?;
        dict.set_item("reaction", vector(py, &c.reaction))?;
        dict.set_item("momentum_error", c.momentum_error)?;
        dict.set_item("mass_error", c.mass_error)?;
        Ok(dict)
    }
}

fn vector<'py>(py: Python<'py>, v: &Vec3) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, v.as_slice())
}
