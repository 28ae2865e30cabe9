//! From the tables of a scenario to what the core simulates. What the core does not check is
//! checked here, at the door.

mod checks;
mod materials;
mod motion;
mod parts;
mod probes;
mod surface_part;

use crate::scenario::{
    BodyTable, Document, FieldTable, FormulationName, Integrator, KeyPath, LoadedScenario, ModeName,
    Scenario, ScenarioError, SolverTable, TimeStepValue, TimeTable, UnitsName, remedy_at,
};
use crate::shape_of::{FoundShape, shape_of};
use checks::{positive, zero_or_more};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Formulation, Initial, Integration, Mechanics, Pieces, Scheme, Setup, Solver, TimeStep, Units,
};
use rsph_core::shape::BoxShape;
use rsph_core::tensor::Vec3;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// More frames than this would fill a disk before anyone looks at them.
const MAX_FRAMES: f64 = 100_000.0;
/// Without `output.every`, a run is cut into this many intervals.
const DEFAULT_INTERVALS: f64 = 50.0;
/// Wall time between checkpoints: storing one takes less than a thousandth of that.
const DEFAULT_MINUTES: f64 = 5.0;

/// Motion or equilibria.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The motion in time.
    Dynamic,
    /// Equilibria at so many moments.
    Static {
        /// How many.
        steps: usize,
    },
}

/// How often a run is stored so that it can be resumed; whichever comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cadence {
    /// Wall time between two checkpoints.
    pub every: Option<Duration>,
    /// Frames between them.
    pub frames: Option<u64>,
}

/// A scenario made ready to run.
#[derive(Clone, Debug)]
pub struct Job {
    /// What the core simulates.
    pub setup: Setup,
    /// What is computed.
    pub mode: Mode,
    /// End of the simulation (time unit of the scenario).
    pub until: f64,
    /// Time between frames.
    pub frame_interval: f64,
    /// How often it is stored.
    pub checkpoint: Cadence,
    /// Things the user should know (one sentence each).
    pub notes: Vec<String>,
}

impl LoadedScenario {
    /// Turns the tables into what the core simulates; reads the body's mesh if it has one.
    ///
    /// # Errors
    /// The first value that can not be simulated, with its place.
    pub fn lower(&self) -> Result<Job, ScenarioError> {
        self.lower_on(Some(self.base_dir()), || {
            shape_of(self.document(), &self.tables().body, self.base_dir())
        })
    }

    /// Whether [`LoadedScenario::lower`] would find anything wrong with the tables, without a look at the body's
    /// shape: reading a mesh or an image takes its time.
    ///
    /// # Errors
    /// The first value that can not be simulated, with its place.
    pub fn check(&self) -> Result<(), ScenarioError> {
        let any = BoxShape::new(Vec3::repeat(1.0), Vec3::zeros());
        let any = any.map_err(|e| self.document().invalid_input(&e))?;
        self.lower_on(None, || Ok((Arc::new(any), Vec::new()))).map(drop)
    }

    /// The job of the body that `shape` finds, with files of its materials read from `folder`, or not read.
    fn lower_on(
        &self,
        folder: Option<&Path>,
        shape: impl FnOnce() -> Result<FoundShape, ScenarioError>,
    ) -> Result<Job, ScenarioError> {
        let (doc, tables) = (self.document(), self.tables());
        let until = tables.until();
        let time_step = time_step(doc, tables)?;
        let frame_interval = frame_interval(doc, tables)?;
        let checkpoint = cadence(doc, tables)?;
        let mechanics = motion::mechanics(doc, tables, folder)?;
        let resolution = resolution(doc, &tables.body)?;
        let remesh = motion::remesh(doc, tables, &mechanics)?;
        let solver = solver(doc, &tables.solver, &mechanics)?;
        let initial = |key: &str, table: &Option<FieldTable>| {
            parts::field(doc, &KeyPath::from("initial").key(key), table.as_ref())
        };
        let initial = Initial {
            displacement: initial("displacement", &tables.initial.displacement)?,
            velocity: initial("velocity", &tables.initial.velocity)?,
        };
        let mode = mode(doc, tables)?;
        let gauges = probes::gauges(doc, &tables.gauge)?;
        let probes = probes::probes(doc, &tables.probe, (&mechanics, &gauges), remesh.trigger)?;
        let fields = probes::measures(doc, &tables.output.fields)?;
        // Last, as reading a mesh takes longest.
        let (shape, notes) = shape()?;
        let setup = Setup {
            units: match tables.units {
                UnitsName::Si => Units::Si,
                UnitsName::Normalised => Units::Normalised,
            },
            shape,
            resolution,
            initial,
            mechanics,
            remesh,
            solver,
            time_step,
            integration: integration(doc, &tables.time)?,
            allow_unstable: tables.time.allow_unstable,
            probes,
            gauges,
            fields,
            pieces: if matches!(mode, Mode::Static { .. }) { Pieces::Held } else { Pieces::All },
        };
        Ok(Job { setup, mode, until, frame_interval, checkpoint, notes })
    }
}

fn resolution(doc: &Document, body: &BodyTable) -> Result<Resolution, ScenarioError> {
    let path = KeyPath::from("body");
    match (body.spacing, body.particles) {
        (Some(dx), None) => {
            positive(doc, &path.key("spacing"), dx, "the distance between particles")?;
            Ok(Resolution::Spacing(dx))
        }
        (None, Some(0)) => Err(doc.error(
            &path.key("particles"),
            "a body needs at least one particle",
            "1000 particles make a quick run",
        )),
        (None, Some(n)) => Ok(Resolution::Particles(n)),
        (Some(_), Some(_)) => Err(doc.error(
            &path.key("particles"),
            "`spacing` and `particles` exclude each other: each says how fine the body is",
            "remove one of the two",
        )),
        (None, None) => Err(doc.error(
            &path.key("spacing"),
            "missing in `body`: how fine the body is, as `spacing` or as `particles`",
            "for example `particles = 1000`",
        )),
    }
}

fn time_step(doc: &Document, tables: &Scenario) -> Result<TimeStep, ScenarioError> {
    let (path, time) = (KeyPath::from("time"), &tables.time);
    let is_static = tables.solver.mode == ModeName::Static;
    let end = path.key("until");
    if time.until.is_none() && !is_static {
        return Err(doc.error(&end, "missing in `time`: when the motion ends", remedy_at(&end)));
    }
    positive(doc, &end, tables.until(), "the end of the simulation")?;
    match time.dt {
        // An equilibrium is found without steps in time.
        TimeStepValue::Seconds(dt) if dt > 0.0 && is_static => Ok(TimeStep::Auto),
        TimeStepValue::Auto => Ok(TimeStep::Auto),
        TimeStepValue::Seconds(dt) if dt > 0.0 => Ok(TimeStep::Fixed(dt)),
        TimeStepValue::Seconds(_) => Err(doc.error(
            &path.key("dt"),
            "the time step must be positive, or \"auto\"",
            "`dt = \"auto\"` takes 0.9 of the stability limit",
        )),
    }
}

fn mode(doc: &Document, tables: &Scenario) -> Result<Mode, ScenarioError> {
    let SolverTable { mode, steps, .. } = tables.solver;
    let path = KeyPath::from("solver.steps");
    match mode {
        ModeName::Static if steps == 0 || steps as f64 > MAX_FRAMES => Err(doc.error(
            &path,
            format!("the number of equilibria must lie between 1 and {MAX_FRAMES}"),
            "1 goes straight to the end, 10 shows how the loads grow",
        )),
        ModeName::Static => Ok(Mode::Static { steps }),
        ModeName::Dynamic if steps != 1 => Err(doc.error(
            &path,
            "is for `mode = \"static\"`",
            "set `solver.mode = \"static\"`, or remove it; `time.dt` is the time step of a motion",
        )),
        ModeName::Dynamic => Ok(Mode::Dynamic),
    }
}

fn integration(doc: &Document, time: &TimeTable) -> Result<Integration, ScenarioError> {
    let scheme = match time.integrator {
        Integrator::Auto => Scheme::Auto,
        Integrator::Rk4 => Scheme::Rk4,
        Integrator::Sdirk2 => Scheme::Sdirk2,
        Integrator::BackwardEuler => Scheme::BackwardEuler,
        Integrator::Rkc2 => Scheme::Rkc2,
    };
    let default = Integration::default().tolerance;
    match time.tolerance {
        Some(t) if !(1e-8..=0.5).contains(&t) => Err(doc.error(
            &KeyPath::from("time.tolerance"),
            "the error of a step must lie between 1e-8 and 0.5 of the displacement",
            format!("{default} is the default; 0.001 gives three digits"),
        )),
        given => Ok(Integration { scheme, tolerance: given.unwrap_or(default) }),
    }
}

fn frame_interval(doc: &Document, tables: &Scenario) -> Result<f64, ScenarioError> {
    let Some(every) = tables.output.every else {
        return Ok(tables.until() / DEFAULT_INTERVALS);
    };
    let path = KeyPath::from("output.every");
    positive(doc, &path, every, "the time between frames")?;
    let frames = tables.until() / every;
    if frames > MAX_FRAMES {
        return Err(doc.error(
            &path,
            format!("would write {frames:.3e} frames until the end; {MAX_FRAMES} are allowed"),
            format!("write every {:.3e} or more", tables.until() / MAX_FRAMES),
        ));
    }
    Ok(every)
}

fn cadence(doc: &Document, tables: &Scenario) -> Result<Cadence, ScenarioError> {
    let path = KeyPath::from("output.checkpoint");
    let table = tables.output.checkpoint;
    if let Some(minutes) = table.minutes {
        positive(doc, &path.key("minutes"), minutes, "the wall time between checkpoints")?;
    }
    if table.frames == Some(0) {
        return Err(doc.error(
            &path.key("frames"),
            "the number of frames between checkpoints must be at least 1",
            "remove it: a run is stored every 5 minutes",
        ));
    }
    let minutes = table.minutes.or(if table.frames.is_none() { Some(DEFAULT_MINUTES) } else { None });
    // More than fits is never.
    let every = minutes.and_then(|m| Duration::try_from_secs_f64(60.0 * m).ok());
    Ok(Cadence { every, frames: table.frames })
}

fn solver(doc: &Document, table: &SolverTable, mechanics: &Mechanics) -> Result<Solver, ScenarioError> {
    let path = KeyPath::from("solver");
    let formulation = match table.formulation {
        FormulationName::Adjoint => Formulation::Adjoint,
        FormulationName::Paper => Formulation::Paper,
    };
    let on_lattice = formulation == Formulation::Adjoint && matches!(mechanics, Mechanics::Solid(_));
    let usual = if on_lattice { Solver::ACCURATE } else { Solver::default() };
    let smoothing = table.smoothing.unwrap_or(usual.smoothing);
    let hourglass = table.hourglass.unwrap_or(usual.hourglass);
    positive(doc, &path.key("smoothing"), smoothing, "the smoothing length in spacings")?;
    zero_or_more(doc, &path.key("hourglass"), hourglass, "the multiple of the hourglass term")?;
    Ok(Solver { formulation, smoothing, hourglass })
}
