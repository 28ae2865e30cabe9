//! Where a run's results go: the trait between the run loop and whoever writes or keeps them.

use rsph_core::error::Failure;
use rsph_core::particles::Field;
use rsph_core::simulation::{Conservation, Equilibrium, Reading, RemeshLog};
use rsph_core::snapshot::Snapshot;
use rsph_core::state::State;
use rsph_core::surface::Surface;
use std::io;
use std::path::{Path, PathBuf};

/// A result that could not be stored.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {message}", path.display())]
pub struct SinkError {
    /// The file or folder that was being written.
    pub path: PathBuf,
    /// What went wrong, in words.
    pub message: String,
    /// The system's error, if there was one.
    #[source]
    pub source: Option<io::Error>,
}

impl SinkError {
    /// An error in words.
    #[allow(clippy::needless_pass_by_value)] // an error is handed over
    pub fn new(path: impl Into<PathBuf>, message: impl ToString) -> Self {
        Self { path: path.into(), message: message.to_string(), source: None }
    }

    /// An error of the system while writing `path`.
    pub fn io(path: &Path, source: io::Error) -> Self {
        Self { path: path.into(), message: source.to_string(), source: Some(source) }
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Status {
    /// It reached `time.until`.
    Finished,
    /// The user stopped it; the last frame is complete.
    Interrupted,
    /// It stopped by itself; the frames up to there are complete.
    Failed(Failure),
}

/// Status, length and cost of a run that has ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// How it ended.
    pub status: Status,
    /// Wall time of the run loop (s).
    pub wall_seconds: f64,
    /// Time steps taken.
    pub steps: u64,
    /// Right-hand sides evaluated.
    pub rhs_evaluations: u64,
    /// Simulated time reached (time unit of the scenario).
    pub time: f64,
    /// Threads used.
    pub threads: usize,
    /// What remeshing did; `None` if remeshing is off.
    pub remesh: Option<RemeshLog>,
    /// How the last equilibrium was found; `None` if none was asked for.
    pub equilibrium: Option<Equilibrium>,
    /// Largest values at its end; `None` where nothing is strained.
    pub largest: Option<Largest>,
    /// Things the user should know about its results (one sentence each).
    pub notes: Vec<String>,
}

/// Largest values over the particles of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Largest {
    /// Length of the displacement (m).
    pub displacement: f64,
    /// Principal strain, either way.
    pub strain: f64,
    /// Von Mises' equivalent stress (Pa).
    pub von_mises: f64,
}

impl Largest {
    /// Of one moment; `None` for what is no solid.
    pub fn of(snapshot: &Snapshot) -> Option<Self> {
        let [displacement, strain, von_mises] =
            [Field::Displacement, Field::Strain, Field::VonMises].map(|field| snapshot.column(field));
        if strain.is_empty() {
            return None;
        }
        let most = |value: &dyn Fn(usize) -> f64| (0..snapshot.len()).map(value).fold(0.0, f64::max);
        Some(Self {
            displacement: most(&|a| displacement.vector(a).norm()),
            strain: most(&|a| strain.tensor(a).to_matrix().symmetric_eigenvalues().amax()),
            von_mises: most(&|a| von_mises.values()[a]),
        })
    }
}

/// A result that a run hands on; they come in the order of time.
#[derive(Clone, Debug)]
pub enum Event {
    /// A frame: the first and the last moment, and one every `output.every`.
    Frame(Box<(Snapshot, Surface, Conservation)>),
    /// The probes' readings at one time.
    Sample(f64, Vec<Reading>, Conservation),
    /// A few times a second: what has waited long enough is to be stored.
    Tick,
    /// A moment from which the run can go on, with what to store for that; all results so far belong to it.
    Checkpoint(State),
    /// The particles as a failure left them; the frame of the last good state comes before.
    PostMortem(Snapshot),
    /// The end of the run, good or bad: everything is to be closed.
    Finish(Box<Outcome>),
}

/// Receives the results of a run.
pub trait RunSink: Send {
    /// Takes what comes next.
    ///
    /// # Errors
    /// When it can not be stored.
    fn take(&mut self, event: Event) -> Result<(), SinkError>;
}
