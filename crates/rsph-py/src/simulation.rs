//! A running simulation.

use crate::errors;
use crate::field::{Trouble, python_field, python_modulus};
use crate::force::PythonForce;
use crate::history::History;
use crate::interrupt::{SOON, interruptible};
use crate::pool::{compute, detach};
use crate::scenario::Source;
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
use rsph_scenario::scenario::{LoadedScenario, ScenarioError};
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
    load: Option<PythonForce>,
}

impl Simulation {
    fn new_at_start(simulation: CoreSimulation, until: Option<f64>, mut notes: Vec<String>) -> Self {
        notes.extend(simulation.description().notes.iter().cloned());
        let state = State { simulation, history: History::default(), load: None };
        Self { state: Mutex::new(state), until, notes }
    }

    /// The simulation of a scenario, one from a file (`named`) or one that Python made.
    fn of(py: Python<'_>, scenario: LoadedScenario, named: bool) -> PyResult<Self> {
        let build = move || {
            let job = scenario.lower()?;
            let simulation =
                CoreSimulation::new(job.setup).map_err(|e| scenario.document().invalid_input(&e))?;
            Ok(Self::new_at_start(simulation, Some(job.until), job.notes))
        };
        interruptible(py, SOON, || (), build)?.map_err(|e: ScenarioError| errors::scenario(&e, named))
    }

    fn state(&self) -> PyResult<MutexGuard<'_, State>> {
        self.state.try_lock().map_err(|_| {
            errors::plain(
                "this simulation is computing in another thread; wait for it, or use the `callback` of \
                 `run` to look at it on its way",
            )
        })
    }

    /// Calls `compute` without the interpreter lock. What it is given is to be called after every step
    /// and says whether to go on; the user's Ctrl-C and an error of `report` or of a Python load end the work
    /// at a whole step.
    fn compute(
        py: Python<'_>,
        state: &mut State,
        report: Option<&Py<PyAny>>,
        compute: impl FnOnce(&mut State, &mut Listener<'_>) -> Result<(), Failure> + Send,
    ) -> PyResult<()> {
        let mut listener = Listener { report, last: Instant::now(), stopped: None };
        let done = detach(py, || compute(state, &mut listener));
        listener.stopped.map_or(Ok(()), Err)?;
        done.map_err(|e| errors::failure(&e))
    }
}

/// Looks up from the computation now and then.
struct Listener<'a> {
    report: Option<&'a Py<PyAny>>,
    last: Instant,
    stopped: Option<PyErr>,
}

impl Listener<'_> {
    /// Whether to go on at this time of the simulation.
    fn go_on(&mut self, time: f64) -> bool {
        if self.last.elapsed() < SLICE {
            return true;
        }
        self.last = Instant::now();
        let report = self.report;
        self.attempt(|py| {
            py.check_signals()?;
            report.map_or(Ok(()), |r| r.call1(py, (time,)).map(drop))
        })
    }

    /// Does something in Python; false if it went wrong.
    fn attempt(&mut self, what: impl FnOnce(Python<'_>) -> PyResult<()>) -> bool {
        Python::attach(what).map_err(|e| self.stopped = Some(e)).is_ok()
    }

    /// Brings the forces of a Python load up to date for the step to come.
    fn reload(&mut self, load: Option<&mut PythonForce>, simulation: &mut CoreSimulation, t: f64) -> bool {
        load.is_none_or(|load| self.attempt(|py| load.apply(py, simulation, t)))
    }
}

#[pymethods]
impl Simulation {
    /// From the TOML text of a scenario, the shape of the body, and Python functions for the initial
    /// values that the text does not give and for the moduli and fibres of materials, by their numbers.
    #[new]
    #[pyo3(signature = (scenario, shape, displacement=None, velocity=None, moduli=vec![], fibres=vec![]))]
    fn new(
        py: Python<'_>,
        scenario: String,
        shape: &Shape,
        displacement: Option<Py<PyAny>>,
        velocity: Option<Py<PyAny>>,
        moduli: Vec<(usize, Py<PyAny>)>,
        fibres: Vec<(usize, Py<PyAny>)>,
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
        for (k, f) in moduli {
            if let Some((modulus, _)) = setup.solid_mut().and_then(|solid| solid.fields_mut(k)) {
                *modulus = Some(python_modulus(f, trouble.clone()));
            }
        }
        for (k, f) in fibres {
            if let Some((_, fibres)) = setup.solid_mut().and_then(|solid| solid.fields_mut(k)) {
                *fibres = Some(field("fibres", f));
            }
        }
        let simulation = interruptible(py, SOON, || (), move || CoreSimulation::new(setup));
        trouble.check()?;
        let simulation = simulation?;
        Ok(Self::new_at_start(simulation.map_err(|e| errors::invalid_input(&e))?, None, Vec::new()))
    }

    /// From a scenario file and edits `key.path=value`.
    #[staticmethod]
    fn from_toml(py: Python<'_>, path: PathBuf, sets: Vec<String>) -> PyResult<Self> {
        let scenario = LoadedScenario::from_file(&path, &sets).map_err(|e| errors::scenario_file(&e))?;
        Self::of(py, scenario, true)
    }

    /// From a scenario.
    #[staticmethod]
    fn from_scenario(py: Python<'_>, source: Source) -> PyResult<Self> {
        let named = !source.0.is_empty();
        Self::of(py, scenario::loaded(source)?, named)
    }

    /// Another simulation in the same state.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let state = &*self.state()?;
        let load = state.load.as_ref().map(|l| l.clone_ref(py));
        let (simulation, history) = detach(py, || (state.simulation.clone(), state.history.clone()));
        let state = State { simulation, history, load };
        Ok(Self { state: Mutex::new(state), until: self.until, notes: self.notes.clone() })
    }

    /// Puts the forces of a Python function `f(time, columns)` on the body in every step to come, or none.
    #[pyo3(signature = (function, on_surface))]
    fn set_load(&self, function: Option<Py<PyAny>>, on_surface: bool) -> PyResult<()> {
        let state = &mut *self.state()?;
        compute(|| state.simulation.set_forces(&[])).map_err(|e| errors::invalid_input(&e))?;
        state.load = function.map(|f| PythonForce::new(f, on_surface));
        Ok(())
    }

    /// Adds the first probe of the scenario `text`.
    fn add_probe(&self, text: String) -> PyResult<()> {
        let probe = scenario::probe(text)?;
        let state = &mut *self.state()?;
        compute(|| state.simulation.add_probe(probe)).map_err(|e| errors::invalid_input(&e))
    }

    /// Takes `n` steps of length `dt`.
    fn step(&self, py: Python<'_>, n: u64) -> PyResult<()> {
        Self::compute(py, &mut *self.state()?, None, |state, listener| {
            let State { simulation, load, .. } = state;
            for _ in 0..n {
                let t = simulation.time();
                if !listener.reload(load.as_mut(), simulation, t) {
                    break;
                }
                simulation.step()?;
                if !listener.go_on(simulation.time()) {
                    break;
                }
            }
            Ok(())
        })
    }

    /// Advances to the time `until` exactly, recording the probes every `stride` steps and at both
    /// ends; `report(time)` is called now and then, `observe(snapshot)` after every step.
    #[pyo3(signature = (until, stride, report=None, observe=None))]
    fn advance(
        &self,
        py: Python<'_>,
        until: f64,
        stride: u64,
        report: Option<Py<PyAny>>,
        observe: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        Self::compute(py, &mut *self.state()?, report.as_ref(), |state, listener| {
            let State { simulation, history, load } = state;
            history.record(simulation);
            let t = simulation.time();
            if !listener.reload(load.as_mut(), simulation, t) {
                return Ok(());
            }
            let result = simulation.advance_to(until, &mut |s| {
                if s.step_count() % stride.max(1) == 0 {
                    history.record(s);
                }
                let seen = observe.as_ref().is_none_or(|observe| {
                    let snapshot = Snapshot::new(s.snapshot());
                    listener.attempt(|py| observe.call1(py, (snapshot,)).map(drop))
                });
                let t = s.time();
                seen && listener.reload(load.as_mut(), s, t) && listener.go_on(t)
            });
            history.record(simulation);
            result
        })
    }

    /// Goes straight to equilibrium under the loads and holds of the time `t`.
    fn solve_static<'py>(&self, py: Python<'py>, t: f64) -> PyResult<Bound<'py, PyDict>> {
        let mut found = None;
        Self::compute(py, &mut *self.state()?, None, |state, listener| {
            let State { simulation, load, .. } = state;
            if !listener.reload(load.as_mut(), simulation, t) {
                return Ok(());
            }
            let result = simulation.solve_static(t, &mut |_, _| listener.go_on(t));
            result.map(|e| found = Some(e))
        })?;
        let e = found.unwrap_or_default();
        let dict = PyDict::new(py);
        dict.set_item("iterations", e.iterations)?;
        dict.set_item("newton_steps", e.steps)?;
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
        detach(py, || state.simulation.set_integration(Integration { scheme, tolerance }, step))
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
        let force = detach(py, || state.simulation.stiffness(&columns)).ok_or_else(|| {
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

    /// Goes on with another material, of the scenario text `material`, in the place of that of this name or of the only one.
    #[pyo3(signature = (material, name=None))]
    fn set_material(&self, material: String, name: Option<String>) -> PyResult<()> {
        let material = scenario::material(material)?;
        let mut state = self.state()?;
        let names: Vec<String> = state
            .simulation
            .setup()
            .solid()
            .map_or(Vec::new(), |solid| solid.material_names().map(str::to_owned).collect());
        let k = match &name {
            None => Some(0),
            Some(name) => names.iter().position(|n| n == name),
        };
        let Some(k) = k else {
            let name = name.unwrap_or_default();
            let message = format!("`name` = {name:?}: there is no material of that name");
            return Err(errors::input_error(&message, "name", Some(&name), &format!("there are {names:?}")));
        };
        let simulation = &mut state.simulation;
        compute(|| simulation.set_material(k, &material)).map_err(|e| errors::invalid_input(&e))
    }

    /// What to know where this moment is beyond what the law is for.
    fn beyond_the_law(&self) -> PyResult<Option<String>> {
        let state = &mut *self.state()?;
        let simulation = &mut state.simulation;
        Ok(compute(|| simulation.extremes().and_then(|extremes| simulation.beyond_the_law(&extremes))))
    }

    /// What is known before the first step, by name.
    fn description<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = self.state()?;
        let (d, setup) = (state.simulation.description(), state.simulation.setup());
        let dict = PyDict::new(py);
        dict.set_item("shape", setup.shape.name())?;
        dict.set_item("material", setup.solid().map(|solid| solid.material.name()))?;
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
        Ok(Snapshot::new(detach(py, || state.simulation.snapshot())))
    }

    /// The surface of this moment: vertices (V, 3), triangles (T, 3) and fields by name.
    fn surface<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyDict>)> {
        let state = &mut *self.state()?;
        let surface = detach(py, || {
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
        let readings = detach(py, || state.simulation.readings());
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
        let c = detach(py, || state.simulation.conservation());
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
