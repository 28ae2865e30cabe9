//! From the tables of a scenario to what the core simulates. What the core does not check is
//! checked here, at the door.

mod checks;
mod motion;
mod parts;
mod probes;

use crate::scenario::{
    BodyTable, Document, FormulationName, KeyPath, LoadedScenario, Scenario, ScenarioError, SolverTable,
    TimeStepValue, TimeTable, UnitsName,
};
use crate::shape_of::shape_of;
use checks::{positive, zero_or_more};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Formulation, Initial, Setup, Solver, TimeStep, Units};

/// More frames than this would fill a disk before anyone looks at them.
const MAX_FRAMES: f64 = 100_000.0;
/// Without `output.every`, a run is cut into this many intervals.
const DEFAULT_INTERVALS: f64 = 50.0;

/// A scenario made ready to run.
#[derive(Clone, Debug)]
pub struct Job {
    /// What the core simulates.
    pub setup: Setup,
    /// End of the simulation (time unit of the scenario).
    pub until: f64,
    /// Time between frames.
    pub frame_interval: f64,
    /// Things the user should know (one sentence each).
    pub notes: Vec<String>,
}

impl LoadedScenario {
    /// Turns the tables into what the core simulates; reads the body's mesh if it has one.
    ///
    /// # Errors
    /// The first value that can not be simulated, with its place.
    pub fn lower(&self) -> Result<Job, ScenarioError> {
        let (doc, tables) = (self.document(), self.tables());
        let until = tables.time.until;
        let time_step = time_step(doc, &tables.time)?;
        let frame_interval = frame_interval(doc, tables)?;
        let mechanics = motion::mechanics(doc, tables)?;
        let remesh = motion::remesh(doc, tables, &mechanics)?;
        let solver = solver(doc, &tables.solver)?;
        let resolution = resolution(doc, &tables.body)?;
        let material = motion::material(doc, tables, &mechanics)?;
        let initial = Initial {
            displacement: parts::field(tables.initial.displacement.as_ref()),
            velocity: parts::field(tables.initial.velocity.as_ref()),
        };
        let boundaries = parts::boundaries(doc, &tables.boundary)?;
        let loads = parts::loads(doc, &tables.load)?;
        let probes = probes::probes(doc, &tables.probe)?;
        // Last, as reading a mesh takes longest.
        let (shape, notes) = shape_of(doc, &tables.body, self.base_dir())?;
        let setup = Setup {
            units: match tables.units {
                UnitsName::Si => Units::Si,
                UnitsName::Normalised => Units::Normalised,
            },
            shape,
            resolution,
            material,
            initial,
            boundaries,
            loads,
            mechanics,
            remesh,
            solver,
            time_step,
            allow_unstable: tables.time.allow_unstable,
            probes,
        };
        Ok(Job { setup, until, frame_interval, notes })
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

fn time_step(doc: &Document, time: &TimeTable) -> Result<TimeStep, ScenarioError> {
    let path = KeyPath::from("time");
    positive(doc, &path.key("until"), time.until, "the end of the simulation")?;
    match time.dt {
        TimeStepValue::Auto => Ok(TimeStep::Auto),
        TimeStepValue::Seconds(dt) if dt > 0.0 => Ok(TimeStep::Fixed(dt)),
        TimeStepValue::Seconds(_) => Err(doc.error(
            &path.key("dt"),
            "the time step must be positive, or \"auto\"",
            "`dt = \"auto\"` takes 0.9 of the stability limit",
        )),
    }
}

fn frame_interval(doc: &Document, tables: &Scenario) -> Result<f64, ScenarioError> {
    let Some(every) = tables.output.every else {
        return Ok(tables.time.until / DEFAULT_INTERVALS);
    };
    let path = KeyPath::from("output.every");
    positive(doc, &path, every, "the time between frames")?;
    let frames = tables.time.until / every;
    if frames > MAX_FRAMES {
        return Err(doc.error(
            &path,
            format!("would write {frames:.3e} frames until the end; {MAX_FRAMES} are allowed"),
            format!("write every {:.3e} or more", tables.time.until / MAX_FRAMES),
        ));
    }
    Ok(every)
}

fn solver(doc: &Document, table: &SolverTable) -> Result<Solver, ScenarioError> {
    let path = KeyPath::from("solver");
    positive(doc, &path.key("smoothing"), table.smoothing, "the smoothing length in spacings")?;
    zero_or_more(doc, &path.key("hourglass"), table.hourglass, "the weight of the hourglass term")?;
    let formulation = match table.formulation {
        FormulationName::Adjoint => Formulation::Adjoint,
        FormulationName::Paper => Formulation::Paper,
    };
    Ok(Solver { formulation, smoothing: table.smoothing, hourglass: table.hourglass })
}
