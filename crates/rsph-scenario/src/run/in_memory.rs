//! A run that leaves nothing on disk: its summary and its probes, for sweeps over many scenarios.

use super::prepared::Prepared;
use super::{Observer, RunError, store};
use crate::output::RunInfo;
use crate::output::summary::Summary;
use crate::scenario::LoadedScenario;
use crate::sink::{Event, Outcome, RunSink, SinkError};
use rsph_core::simulation::{Conservation, Reading};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Summary and last probe readings of a run.
#[derive(Clone, Debug)]
pub struct Remembered {
    /// What `summary.json` would say.
    pub summary: Summary,
    /// Columns of `probes.csv`, without `time`.
    pub columns: Vec<String>,
    /// Last row of `probes.csv`; empty if there was no sample.
    pub last: Vec<f64>,
}

/// Runs `scenario` and remembers its end.
///
/// # Errors
/// As [`super::run_with`]. A simulation that fails is told by the summary.
pub fn run_in_memory(
    scenario: &LoadedScenario,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<(Remembered, Outcome), RunError> {
    let mut prepared = Prepared::new(scenario)?;
    let info = store::info(&prepared.start(scenario, Path::new(""), None));
    observer.started(prepared.simulation.description(), &prepared.notes);
    let mut memory = Memory::default();
    let outcome = prepared.run(&mut memory, observer, stop)?;
    Ok((memory.remembered(&info, &outcome), outcome))
}

/// Keeps the last of everything.
#[derive(Debug, Default)]
struct Memory {
    readings: Vec<Reading>,
    conservation: Conservation,
    particles: usize,
    frames: usize,
}

impl Memory {
    fn remembered(self, info: &RunInfo, outcome: &Outcome) -> Remembered {
        let last: Vec<f64> = self.readings.iter().map(|r| r.value).collect();
        let at_the_end = (&self.conservation, &last[..]);
        Remembered {
            summary: Summary::new(info, outcome, at_the_end, self.particles, self.frames),
            columns: info.probes.iter().map(|c| c.name.clone()).collect(),
            last,
        }
    }
}

impl RunSink for Memory {
    fn take(&mut self, event: Event) -> Result<(), SinkError> {
        match event {
            Event::Frame(frame) => {
                (self.particles, self.conservation) = (frame.0.len(), frame.2);
                self.frames += 1;
            }
            Event::Sample(_, readings, now) => (self.readings, self.conservation) = (readings, now),
            Event::Tick | Event::Checkpoint(_) | Event::PostMortem(_) | Event::Finish(_) => {}
        }
        Ok(())
    }
}
