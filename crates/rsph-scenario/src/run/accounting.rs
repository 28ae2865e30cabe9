//! The accounting of a run besides its simulation: where it began, how often it samples, how long it took.

use super::Progress;
use rsph_core::error::InvalidInput;
use rsph_core::simulation::{Extremes, Simulation};
use rsph_core::state::State;
use std::time::Instant;

/// A run records its probes at least this often, or at every step if it has fewer.
const MIN_SAMPLES: u64 = 1000;

/// Start, sampling, progress and wall time of a run.
#[derive(Clone, Debug)]
pub(super) struct Accounting {
    /// Time at which it began; frames are counted from there.
    pub origin: f64,
    /// Steps between two samples.
    pub stride: u64,
    /// Frames after the first one, or equilibria, that are done.
    pub done: u64,
    /// Steps at the last sample.
    pub last_sample: Option<u64>,
    /// Steps at the last frame.
    pub last_frame: Option<u64>,
    /// Largest strain, turn and displacement in the frames.
    pub extremes: Extremes,
    /// Wall time before this program took over (s).
    wall_before: f64,
    wall: Instant,
    /// Steps and right-hand sides before this program took over.
    before: [u64; 2],
}

impl Accounting {
    /// Begins the accounting of a run of `s` up to `until`.
    pub fn begin(s: &Simulation, until: f64) -> Self {
        Self {
            origin: s.time(),
            stride: sample_stride(until - s.time(), s.description().dt),
            done: 0,
            last_sample: None,
            last_frame: None,
            extremes: Extremes::default(),
            wall_before: 0.0,
            wall: Instant::now(),
            before: [0, 0],
        }
    }

    /// Wall time of the run so far (s).
    pub fn wall_seconds(&self) -> f64 {
        self.wall_before + self.wall.elapsed().as_secs_f64()
    }

    /// Stores everything in `state`.
    pub fn save(&self, state: &mut State) {
        state.put("run/times", [self.origin, self.wall_seconds()]);
        let step = |last: Option<u64>| last.map_or(-1, |step| step as i64);
        let counts = [self.stride as i64, self.done as i64, step(self.last_sample), step(self.last_frame)];
        state.put_whole("run/counts", counts);
        state.put("run/extremes", self.extremes.to_numbers());
    }

    /// Takes everything back from `state`; that of `s` is already restored.
    ///
    /// # Errors
    /// What is missing or damaged.
    pub fn restore(&mut self, state: &State, s: &Simulation) -> Result<(), InvalidInput> {
        [self.origin, self.wall_before] = state.numbers("run/times")?;
        let counts = state.whole_of("run/counts", 4)?;
        let step = |last: i64| u64::try_from(last).ok();
        self.stride = step(counts[0]).unwrap_or(1).max(1);
        self.done = step(counts[1]).unwrap_or(0);
        (self.last_sample, self.last_frame) = (step(counts[2]), step(counts[3]));
        if state.has("run/extremes") {
            self.extremes = Extremes::from_numbers(&state.numbers("run/extremes")?);
        }
        self.before = [s.step_count(), s.rhs_evaluations()];
        self.wall = Instant::now();
        Ok(())
    }

    /// How far the run up to `until` is; rates are those since this program took over.
    pub fn progress(&self, s: &Simulation, until: f64) -> Progress {
        let seconds = self.wall.elapsed().as_secs_f64().max(1e-9);
        let [steps, updates] = self.before;
        Progress {
            time: s.time(),
            until,
            step: s.step_count(),
            steps_per_second: (s.step_count() - steps) as f64 / seconds,
            updates_per_second: (s.rhs_evaluations() - updates) as f64 * s.description().particles as f64
                / seconds,
        }
    }
}

/// Steps between two samples.
fn sample_stride(duration: f64, dt: f64) -> u64 {
    let steps = (duration / dt).ceil();
    if steps.is_finite() { (steps as u64 / MIN_SAMPLES).max(1) } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_still_has_a_thousand_samples() {
        assert_eq!(sample_stride(3.0, 0.001), 3);
        assert_eq!(sample_stride(0.5, 0.001), 1);
        assert_eq!(sample_stride(3.0, 0.0), 1);
    }
}
