//! A scenario that is found good and made a simulation, ready to run.

use super::accounting::Accounting;
use super::frames::{Run, frames_until};
use super::{Observer, RunError, RunStart, memory_estimate};
use crate::lower::{Cadence, Mode};
use crate::output::checkpoint::Checkpoint;
use crate::scenario::{KeyPath, LoadedScenario, ScenarioError};
use crate::sink::{Outcome, RunSink, SinkError};
use rsph_core::simulation::{Description, Simulation};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// More steps than this take years.
const MAX_STEPS: f64 = 1e12;

/// A simulation with what its scenario says of the run.
pub(super) struct Prepared {
    pub simulation: Simulation,
    /// Notes of the scenario and the simulation.
    pub notes: Vec<String>,
    pub accounting: Accounting,
    /// What is known of the simulation before the first step.
    description: Description,
    mode: Mode,
    pub until: f64,
    interval: f64,
    cadence: Cadence,
}

impl Prepared {
    /// Makes the simulation of `scenario`.
    ///
    /// # Errors
    /// Wrong input, or too little memory.
    pub fn new(scenario: &LoadedScenario) -> Result<Self, RunError> {
        let job = scenario.lower()?;
        memory_estimate::check(&job.setup)?;
        let simulation = Simulation::new(job.setup).map_err(|e| scenario.document().invalid_input(&e))?;
        if job.mode == Mode::Dynamic {
            check_steps(scenario, job.until, simulation.description().dt)?;
        }
        let description = simulation.description().clone();
        let mut notes = job.notes;
        notes.extend(description.notes.iter().cloned());
        Ok(Self {
            notes,
            accounting: Accounting::begin(&simulation, job.until),
            simulation,
            description,
            mode: job.mode,
            until: job.until,
            interval: job.frame_interval,
            cadence: job.checkpoint,
        })
    }

    /// What a sink needs to know of it.
    pub fn start<'a>(
        &'a mut self,
        scenario: &'a LoadedScenario,
        folder: &'a Path,
        checkpoint: Option<&'a Checkpoint>,
    ) -> RunStart<'a> {
        let conservation = self.simulation.conservation();
        RunStart {
            scenario,
            simulation: &self.simulation,
            description: &self.description,
            conservation,
            folder,
            notes: &self.notes,
            checkpoint,
        }
    }

    /// Counts the frames of a motion that are done, by its time: a run that goes on may have others than before.
    pub fn count_frames(&mut self) {
        if matches!(self.mode, Mode::Dynamic) {
            let Accounting { origin, done, .. } = &mut self.accounting;
            *done = frames_until(*origin, self.until, self.interval, self.simulation.time());
        }
    }

    /// Runs it to its end, or until `stop` is set.
    ///
    /// # Errors
    /// When `sink` can not store a result.
    pub fn run(
        self,
        sink: &mut dyn RunSink,
        observer: &mut dyn Observer,
        stop: &AtomicBool,
    ) -> Result<Outcome, SinkError> {
        let Self { mut simulation, accounting, mode, until, interval, cadence, .. } = self;
        let mut run = Run { simulation: &mut simulation, until, accounting, cadence, sink, observer, stop };
        match mode {
            Mode::Dynamic => run.advance(interval),
            Mode::Static { steps } => run.run_static(steps),
        }
    }
}

/// Refuses a run that nobody will see the end of.
fn check_steps(scenario: &LoadedScenario, until: f64, dt: f64) -> Result<(), ScenarioError> {
    let steps = until / dt;
    if steps <= MAX_STEPS {
        return Ok(());
    }
    Err(scenario.document().error(
        &KeyPath::from("time.until"),
        format!("a time step of {dt:.3e} makes this {steps:.1e} steps; {MAX_STEPS:.0e} are allowed"),
        format!("end at {:.3e} or before, or take larger steps", MAX_STEPS * dt),
    ))
}
