//! The run loop: from frame to frame, with everything that is seen on the way handed to a sink.

mod folder;
mod memory;
mod store;
mod writer_thread;

pub use folder::{FolderError, OutputFolder};
pub use memory::{Remembered, run_in_memory};

use crate::lower::{Job, Mode};
use crate::scenario::{KeyPath, LoadedScenario, ScenarioError};
use crate::sink::{Outcome, RunSink, SinkError, Status};
use rsph_core::simulation::{Description, Simulation};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A run records its probes at least this often, or at every step if it has fewer.
const MIN_SAMPLES: u64 = 1000;
/// More steps than this take years.
const MAX_STEPS: f64 = 1e12;
/// Shortest wall time between two reports of progress.
const REPORT_INTERVAL: Duration = Duration::from_millis(100);

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
    /// Results could not be stored.
    #[error(transparent)]
    Sink(#[from] SinkError),
}

impl From<ScenarioError> for RunError {
    fn from(error: ScenarioError) -> Self {
        Self::Scenario(Box::new(error))
    }
}

/// What a sink needs to know when a run begins.
#[derive(Debug)]
pub struct RunStart<'a> {
    /// The scenario.
    pub scenario: &'a LoadedScenario,
    /// The simulation at time 0.
    pub simulation: &'a Simulation,
    /// The folder, which exists and can be written.
    pub folder: &'a Path,
    /// Notes of the scenario and the simulation.
    pub notes: &'a [String],
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
    force: bool,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<Outcome, RunError> {
    run_with(scenario, folder, force, &mut store::open, observer, stop)
}

/// Runs `scenario` and hands its results to the sink that `make_sink` makes for `folder`. A folder with results is refused unless `force`. Nothing is written before it is known that the
/// scenario can be simulated.
///
/// # Errors
/// Wrong input, an unusable folder, or results that can not be stored. A simulation that fails is
/// an [`Outcome`], not an error.
pub fn run_with(
    scenario: &LoadedScenario,
    folder: &Path,
    force: bool,
    make_sink: &mut MakeSink<'_>,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<Outcome, RunError> {
    let output = OutputFolder::new(folder, force)?;
    if let Some(file) = scenario.file() {
        output.spare(file)?;
    }
    let ready = Ready::new(scenario)?;
    let mut sink = make_sink(&ready.start(scenario, output.claim()?))?;
    Ok(ready.run(sink.as_mut(), observer, stop)?)
}

/// A run that can begin.
struct Ready {
    simulation: Simulation,
    mode: Mode,
    until: f64,
    interval: f64,
    notes: Vec<String>,
}

impl Ready {
    fn new(scenario: &LoadedScenario) -> Result<Self, ScenarioError> {
        let Job { setup, mode, until, frame_interval, mut notes } = scenario.lower()?;
        let simulation = Simulation::new(setup).map_err(|e| scenario.document().invalid_input(&e))?;
        if mode == Mode::Dynamic {
            check_steps(scenario, until, simulation.description().dt)?;
        }
        notes.extend(simulation.description().notes.iter().cloned());
        Ok(Self { simulation, mode, until, interval: frame_interval, notes })
    }

    /// What a sink needs to know.
    fn start<'a>(&'a self, scenario: &'a LoadedScenario, folder: &'a Path) -> RunStart<'a> {
        RunStart { scenario, simulation: &self.simulation, folder, notes: &self.notes }
    }

    fn run(
        mut self,
        sink: &mut dyn RunSink,
        observer: &mut dyn Observer,
        stop: &AtomicBool,
    ) -> Result<Outcome, SinkError> {
        observer.started(self.simulation.description(), &self.notes);
        let simulation = &mut self.simulation;
        match self.mode {
            Mode::Dynamic => advance(simulation, self.until, self.interval, sink, observer, stop),
            Mode::Static { steps } => settle(simulation, self.until, steps, sink, observer, stop),
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

/// Advances `simulation` to `until`, with a frame every `interval`, the first and the last moment
/// included, until `stop` is set.
///
/// # Errors
/// When the sink can not store a result.
pub fn advance(
    simulation: &mut Simulation,
    until: f64,
    interval: f64,
    sink: &mut dyn RunSink,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<Outcome, SinkError> {
    let start = Start::new(simulation);
    let stride = sample_stride(until - simulation.time(), simulation.description().dt);
    let mut last_report = Instant::now();
    let mut recorder = Recorder { sink, last_sample: None, last_frame: None };
    recorder.frame(simulation)?;
    let mut status = Status::Finished;
    for t in frame_times(simulation.time(), until, interval) {
        let mut trouble = None;
        let advanced = simulation.advance_to(t, &mut |s| {
            // The moment of a frame is sampled with the frame.
            if s.step_count() % stride == 0 && s.time() < t {
                trouble = recorder.sample(s).err();
            }
            if last_report.elapsed() >= REPORT_INTERVAL {
                last_report = Instant::now();
                observer.progressed(&start.progress(s, until));
            }
            trouble.is_none() && !stop.load(Ordering::Relaxed)
        });
        if let Some(error) = trouble {
            return Err(error);
        }
        recorder.frame(simulation)?;
        if let Err(failure) = advanced {
            status = Status::Failed(failure);
            break;
        }
        if stop.load(Ordering::Relaxed) && simulation.time() < until {
            status = Status::Interrupted;
            break;
        }
    }
    finish(simulation, &start, until, status, recorder.sink, observer)
}

/// Brings `simulation` to rest at `steps` moments up to `until`, each with a frame, the undeformed body
/// first, until `stop` is set.
///
/// # Errors
/// When the sink can not store a result.
pub fn settle(
    simulation: &mut Simulation,
    until: f64,
    steps: usize,
    sink: &mut dyn RunSink,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<Outcome, SinkError> {
    let start = Start::new(simulation);
    let mut recorder = Recorder { sink, last_sample: None, last_frame: None };
    recorder.frame(simulation)?;
    let mut status = Status::Finished;
    for k in 1..=steps {
        let t = if k == steps { until } else { until * (k as f64 / steps as f64) };
        let mut last_report = Instant::now();
        let solved = simulation.solve_static(t, &mut |iteration, residual| {
            if last_report.elapsed() >= REPORT_INTERVAL {
                last_report = Instant::now();
                observer.solving(iteration, residual);
            }
            !stop.load(Ordering::Relaxed)
        });
        match solved {
            Ok(_) => recorder.frame(simulation)?,
            Err(_) if stop.load(Ordering::Relaxed) => {
                status = Status::Interrupted;
                break;
            }
            Err(failure) => {
                status = Status::Failed(failure);
                break;
            }
        }
    }
    finish(simulation, &start, until, status, recorder.sink, observer)
}

/// Closes a run.
fn finish(
    simulation: &Simulation,
    start: &Start,
    until: f64,
    status: Status,
    sink: &mut dyn RunSink,
    observer: &mut dyn Observer,
) -> Result<Outcome, SinkError> {
    observer.progressed(&start.progress(simulation, until));
    let outcome = Outcome {
        status,
        wall_seconds: start.wall.elapsed().as_secs_f64(),
        steps: simulation.step_count() - start.step,
        rhs_evaluations: simulation.rhs_evaluations() - start.rhs,
        time: simulation.time(),
        threads: rayon::current_num_threads(),
        remesh: simulation.remesh_log(),
        equilibrium: simulation.equilibrium(),
    };
    sink.finish(&outcome)?;
    observer.finished(&outcome);
    Ok(outcome)
}

struct Start {
    wall: Instant,
    step: u64,
    rhs: u64,
}

impl Start {
    fn new(s: &Simulation) -> Self {
        Self { wall: Instant::now(), step: s.step_count(), rhs: s.rhs_evaluations() }
    }

    fn progress(&self, s: &Simulation, until: f64) -> Progress {
        let seconds = self.wall.elapsed().as_secs_f64().max(1e-9);
        let updates = (s.rhs_evaluations() - self.rhs) as f64 * s.description().particles as f64;
        Progress {
            time: s.time(),
            until,
            step: s.step_count(),
            steps_per_second: (s.step_count() - self.step) as f64 / seconds,
            updates_per_second: updates / seconds,
        }
    }
}

/// Hands moments to the sink, none of them twice.
struct Recorder<'a> {
    sink: &'a mut dyn RunSink,
    last_sample: Option<u64>,
    last_frame: Option<u64>,
}

impl Recorder<'_> {
    fn sample(&mut self, s: &mut Simulation) -> Result<(), SinkError> {
        // A run that failed goes back to its last good state, which is behind the last sample.
        if self.last_sample.is_some_and(|last| s.step_count() <= last) {
            return Ok(());
        }
        self.last_sample = Some(s.step_count());
        self.sink.sample(s.time(), &s.readings(), &s.conservation())
    }

    /// A frame, and a sample with it.
    fn frame(&mut self, s: &mut Simulation) -> Result<(), SinkError> {
        self.sample(s)?;
        if self.last_frame.replace(s.step_count()) == Some(s.step_count()) {
            return Ok(());
        }
        let snapshot = s.snapshot();
        self.sink.frame(&snapshot, &s.surface(&snapshot), &s.conservation())
    }
}

/// Steps between two samples.
fn sample_stride(duration: f64, dt: f64) -> u64 {
    let steps = (duration / dt).ceil();
    if steps.is_finite() { (steps as u64 / MIN_SAMPLES).max(1) } else { 1 }
}

/// The moments of the frames after the first: multiples of `interval`, and `until`.
fn frame_times(from: f64, until: f64, interval: f64) -> impl Iterator<Item = f64> {
    // A remainder of rounding is no frame of its own.
    let count = ((until - from) / interval - 1e-9).ceil().max(if until > from { 1.0 } else { 0.0 }) as u64;
    (1..=count).map(move |k| if k == count { until } else { from + k as f64 * interval })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_long_run_still_has_a_thousand_samples() {
        assert_eq!(sample_stride(3.0, 0.001), 3);
        assert_eq!(sample_stride(0.5, 0.001), 1);
        assert_eq!(sample_stride(3.0, 0.0), 1);
    }

    proptest! {
        #[test]
        fn frames_end_at_the_end_and_never_stand_still(until in 1e-3..1e3f64, cut in 1e-3..2.0f64) {
            let interval = until * cut;
            let times: Vec<f64> = frame_times(0.0, until, interval).collect();
            prop_assert_eq!(times.last().copied(), Some(until));
            prop_assert!(times.windows(2).all(|w| w[1] - w[0] > 1e-10 * until));
            prop_assert!(times.len() <= (1.0 / cut).ceil() as usize);
        }
    }
}
