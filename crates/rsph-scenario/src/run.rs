//! A run: from a scenario and a folder to its outcome.

mod accounting;
mod folder;
mod frames;
mod in_memory;
mod memory_estimate;
mod prepared;
mod resume;
mod store;
mod writer_thread;

pub use folder::{FolderError, OutputFolder};
pub use in_memory::{Remembered, run_in_memory};
pub use memory_estimate::MemoryError;

use crate::output::checkpoint::{Checkpoint, CheckpointError};
use crate::scenario::{LoadedScenario, ScenarioError};
use crate::sink::{Outcome, RunSink, SinkError};
use prepared::Prepared;
use rsph_core::simulation::{Conservation, Description, Simulation};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// How a run begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begin {
    /// In a folder without results.
    Fresh,
    /// In place of the results that are there.
    Overwriting,
    /// Where the checkpoint of the folder stands.
    Resumed,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Simulated time.
    pub time: f64,
    /// Where it ends.
    pub until: f64,
    /// Steps taken.
    pub step: u64,
    /// Time steps a second of wall time since the start.
    pub steps_per_second: f64,
    /// Particle updates (particles x right-hand sides) a second since the start.
    pub updates_per_second: f64,
}

/// Is told how a run goes. Every method may be left as it is.
pub trait Observer {
    /// The simulation is built and starts; `notes` are things the user should know.
    fn started(&mut self, description: &Description, notes: &[String]) {
        let _ = (description, notes);
    }

    /// The run goes on from a checkpoint at the time `time`, behind that many frames after the first.
    fn resumed(&mut self, time: f64, frames: u64) {
        let _ = (time, frames);
    }

    /// Some steps were taken (called a few times a second).
    fn progressed(&mut self, progress: &Progress) {
        let _ = progress;
    }

    /// An equilibrium is being solved for: so many iterations, and what is out of balance as a share of the
    /// load (called a few times a second).
    fn solving(&mut self, iteration: usize, residual: f64) {
        let _ = (iteration, residual);
    }

    /// The run ended, well or badly; all results are stored.
    fn finished(&mut self, outcome: &Outcome) {
        let _ = outcome;
    }
}

/// Observes nothing.
impl Observer for () {}

/// Why a run did not come to an outcome.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The scenario can not be simulated; nothing was written.
    #[error(transparent)]
    Scenario(#[from] Box<ScenarioError>),
    /// The output folder can not be used; nothing was written.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The run can not go on from its checkpoint; nothing was written.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The machine has too little memory; nothing was written.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// Results could not be stored.
    #[error(transparent)]
    Sink(#[from] SinkError),
}

impl From<ScenarioError> for RunError {
    fn from(error: ScenarioError) -> Self {
        Self::Scenario(Box::new(error))
    }
}

/// Everything that a sink needs to know when a run begins.
#[derive(Debug)]
pub struct RunStart<'a> {
    /// The scenario.
    pub scenario: &'a LoadedScenario,
    /// The simulation at time 0, or where the run goes on.
    pub simulation: &'a Simulation,
    /// What was known of it before the first step.
    pub description: &'a Description,
    /// Its conserved sums.
    pub conservation: Conservation,
    /// The folder, which exists, can be written and is this run's alone.
    pub folder: &'a Path,
    /// Notes of the scenario and the simulation.
    pub notes: &'a [String],
    /// What the run goes on from, if it does.
    pub checkpoint: Option<&'a Checkpoint>,
}

/// Makes the sink of a run, once it is known that the run can begin.
pub type MakeSink<'a> = dyn FnMut(&RunStart<'_>) -> Result<Box<dyn RunSink>, SinkError> + 'a;

/// Runs `scenario` and stores its results in `folder`: the files of a run's folder.
///
/// # Errors
/// As [`run_with`].
pub fn run(
    scenario: &LoadedScenario,
    folder: &Path,
    begin: Begin,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<Outcome, RunError> {
    if begin == Begin::Resumed {
        resume::check_results(folder)?;
    }
    run_with(scenario, folder, begin, &mut store::open, observer, stop)
}

/// Runs `scenario` and hands its results to the sink that `make_sink` makes for `folder`, until the end or until
/// `stop` is set. Nothing is written before it is known that the scenario can be simulated.
///
/// # Errors
/// Wrong input, an unusable folder or checkpoint, too little memory, or results that can not be stored. A
/// simulation that fails is an [`Outcome`], not an error.
pub fn run_with(
    scenario: &LoadedScenario,
    folder: &Path,
    begin: Begin,
    make_sink: &mut MakeSink<'_>,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<Outcome, RunError> {
    let mut output = OutputFolder::new(folder, begin)?;
    // A run that goes on leaves the scenario in its folder alone.
    if let Some(file) = scenario.file().filter(|_| begin != Begin::Resumed) {
        output.spare(file)?;
    }
    let mut checkpoint = None;
    if begin == Begin::Resumed {
        let folder = output.claim()?;
        let found = Checkpoint::read(folder)?;
        resume::check_scenario(folder, scenario, &found)?;
        checkpoint = Some(found);
    }
    let mut prepared = Prepared::new(scenario)?;
    if let Some(checkpoint) = &checkpoint {
        prepared.notes.extend(resume::note(checkpoint));
        resume::restore(folder, checkpoint, &mut prepared)?;
    } else {
        output.claim()?;
    }
    let mut sink = make_sink(&prepared.start(scenario, folder, checkpoint.as_ref()))?;
    observer.started(prepared.simulation.description(), &prepared.notes);
    if checkpoint.is_some() {
        observer.resumed(prepared.simulation.time(), prepared.accounting.done);
    }
    Ok(prepared.run(sink.as_mut(), observer, stop)?)
}
