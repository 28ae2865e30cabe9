//! The run loop: from frame to frame, with everything that is seen on the way handed to a sink, and checkpoints.

use super::Observer;
use super::accounting::Accounting;
use crate::lower::Cadence;
use crate::sink::{Event, Largest, Outcome, RunSink, SinkError, Status};
use rsph_core::simulation::Simulation;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Shortest wall time between two reports of progress.
const REPORT_INTERVAL: Duration = Duration::from_millis(100);

/// A simulation on its way to `until`.
pub(super) struct Run<'a> {
    pub simulation: &'a mut Simulation,
    pub until: f64,
    pub accounting: Accounting,
    pub cadence: Cadence,
    pub sink: &'a mut dyn RunSink,
    pub observer: &'a mut dyn Observer,
    pub stop: &'a AtomicBool,
}

impl Run<'_> {
    /// Advances with a frame every `interval`, the first and the last moment included, until `stop` is set.
    ///
    /// # Errors
    /// When the sink can not store a result.
    pub fn advance(&mut self, interval: f64) -> Result<Outcome, SinkError> {
        let mut clock = self.start()?;
        let count = frame_count(self.accounting.origin, self.until, interval);
        while self.accounting.done < count {
            let t = frame_time(self.accounting.origin, self.until, interval, self.accounting.done + 1, count);
            let Self { accounting, sink, observer, until, stop, cadence, .. } = self;
            let mut trouble = None;
            let mut on_the_way = |s: &mut Simulation| -> Result<(), SinkError> {
                // The moment of a frame is sampled with the frame.
                if s.step_count().is_multiple_of(accounting.stride) {
                    sample(*sink, accounting, s)?;
                }
                if clock.is_time_to_report() {
                    observer.progressed(&accounting.progress(s, *until));
                    sink.take(Event::Tick)?;
                }
                if clock.is_due(cadence) {
                    checkpoint(*sink, accounting, s)?;
                    clock.stored();
                }
                Ok(())
            };
            let advanced = self.simulation.advance_to(t, &mut |s| {
                if s.time() >= t {
                    return true;
                }
                trouble = on_the_way(s).err();
                trouble.is_none() && !stop.load(Ordering::Relaxed)
            });
            if let Some(error) = trouble {
                return Err(error);
            }
            if let Err(failure) = advanced {
                return self.failed(failure);
            }
            if self.simulation.time() < t {
                return self.interrupted();
            }
            frame(self.sink, &mut self.accounting, self.simulation)?;
            self.accounting.done += 1;
            clock.frame();
            if self.stop.load(Ordering::Relaxed) && self.accounting.done < count {
                return self.interrupted();
            }
            if clock.is_due(&self.cadence) {
                checkpoint(self.sink, &self.accounting, self.simulation)?;
                clock.stored();
            }
        }
        self.finished()
    }

    /// Brings the simulation to rest at `steps` moments, each with a frame, the undeformed body first, until
    /// `stop` is set.
    ///
    /// # Errors
    /// When the sink can not store a result.
    pub fn run_static(&mut self, steps: usize) -> Result<Outcome, SinkError> {
        let mut clock = self.start()?;
        while self.accounting.done < steps as u64 {
            let k = self.accounting.done + 1;
            let last = k == steps as u64;
            let t = if last { self.until } else { self.until * (k as f64 / steps as f64) };
            let Self { observer, stop, .. } = self;
            let solved = self.simulation.solve_static(t, &mut |iteration, residual| {
                if clock.is_time_to_report() {
                    observer.solving(iteration, residual);
                }
                !stop.load(Ordering::Relaxed)
            });
            match solved {
                Ok(_) => frame(self.sink, &mut self.accounting, self.simulation)?,
                Err(_) if self.stop.load(Ordering::Relaxed) => return self.interrupted(),
                Err(failure) => return self.failed(failure),
            }
            self.accounting.done = k;
            clock.frame();
            self.sink.take(Event::Tick)?;
            if clock.is_due(&self.cadence) {
                checkpoint(self.sink, &self.accounting, self.simulation)?;
                clock.stored();
            }
        }
        self.finished()
    }

    /// The first frame and the first checkpoint, unless the run goes on from one.
    fn start(&mut self) -> Result<Clock, SinkError> {
        if self.accounting.last_frame.is_none() {
            frame(self.sink, &mut self.accounting, self.simulation)?;
            checkpoint(self.sink, &self.accounting, self.simulation)?;
        }
        Ok(Clock { reported: Instant::now(), stored: Instant::now(), frames: 0 })
    }

    fn finished(&mut self) -> Result<Outcome, SinkError> {
        checkpoint(self.sink, &self.accounting, self.simulation)?;
        self.close(Status::Finished)
    }

    /// The checkpoint comes before the frame of the moment of the stop, which an uninterrupted run would not have.
    fn interrupted(&mut self) -> Result<Outcome, SinkError> {
        checkpoint(self.sink, &self.accounting, self.simulation)?;
        frame(self.sink, &mut self.accounting, self.simulation)?;
        self.close(Status::Interrupted)
    }

    fn failed(&mut self, failure: rsph_core::error::Failure) -> Result<Outcome, SinkError> {
        frame(self.sink, &mut self.accounting, self.simulation)?;
        if let Some(snapshot) = self.simulation.failed_state() {
            self.sink.take(Event::PostMortem(snapshot.clone()))?;
        }
        self.close(Status::Failed(failure))
    }

    fn close(&mut self, status: Status) -> Result<Outcome, SinkError> {
        let largest = Largest::of(&self.simulation.snapshot());
        let s = &*self.simulation;
        self.observer.progressed(&self.accounting.progress(s, self.until));
        let outcome = Outcome {
            status,
            wall_seconds: self.accounting.wall_seconds(),
            steps: s.step_count(),
            rhs_evaluations: s.rhs_evaluations(),
            time: s.time(),
            threads: rayon::current_num_threads(),
            remesh: s.remesh_log(),
            equilibrium: s.equilibrium(),
            largest,
            notes: s.beyond_the_law(&self.accounting.extremes).into_iter().collect(),
        };
        self.sink.take(Event::Finish(Box::new(outcome.clone())))?;
        self.observer.finished(&outcome);
        Ok(outcome)
    }
}

/// When something was last done.
struct Clock {
    reported: Instant,
    stored: Instant,
    /// Frames since the last checkpoint.
    frames: u64,
}

impl Clock {
    fn is_time_to_report(&mut self) -> bool {
        let now = Instant::now();
        let due = now - self.reported >= REPORT_INTERVAL;
        if due {
            self.reported = now;
        }
        due
    }

    fn is_due(&self, cadence: &Cadence) -> bool {
        cadence.every.is_some_and(|every| self.stored.elapsed() >= every)
            || cadence.frames.is_some_and(|frames| self.frames >= frames)
    }

    fn frame(&mut self) {
        self.frames += 1;
    }

    fn stored(&mut self) {
        (self.stored, self.frames) = (Instant::now(), 0);
    }
}

fn checkpoint(sink: &mut dyn RunSink, accounting: &Accounting, s: &Simulation) -> Result<(), SinkError> {
    let mut state = s.state();
    accounting.save(&mut state);
    sink.take(Event::Checkpoint(state))
}

/// A sample, none of them twice.
fn sample(sink: &mut dyn RunSink, accounting: &mut Accounting, s: &mut Simulation) -> Result<(), SinkError> {
    // A run that failed goes back to its last good state, which is behind the last sample.
    if accounting.last_sample.is_some_and(|last| s.step_count() <= last) {
        return Ok(());
    }
    accounting.last_sample = Some(s.step_count());
    sink.take(Event::Sample(s.time(), s.readings(), s.conservation()))
}

/// A frame, none of them twice, and a sample with it.
fn frame(sink: &mut dyn RunSink, accounting: &mut Accounting, s: &mut Simulation) -> Result<(), SinkError> {
    sample(sink, accounting, s)?;
    if accounting.last_frame.replace(s.step_count()) == Some(s.step_count()) {
        return Ok(());
    }
    s.rest();
    if let Some(extremes) = s.extremes() {
        accounting.extremes = accounting.extremes.with(&extremes);
    }
    let snapshot = s.snapshot();
    let surface = s.surface(&snapshot);
    sink.take(Event::Frame(Box::new((snapshot, surface, s.conservation()))))
}

/// Number of frames after the first.
fn frame_count(from: f64, until: f64, interval: f64) -> u64 {
    // A remainder of rounding is no frame of its own.
    ((until - from) / interval - 1e-9).ceil().max(if until > from { 1.0 } else { 0.0 }) as u64
}

/// Number of frames after the first up to time `t`.
pub(super) fn frames_until(from: f64, until: f64, interval: f64, t: f64) -> u64 {
    let count = frame_count(from, until, interval);
    if t >= until { count } else { (((t - from) / interval + 1e-9).floor() as u64).min(count) }
}

/// The moment of frame `k` of `count` after the first: multiples of `interval`, and `until`.
fn frame_time(from: f64, until: f64, interval: f64, k: u64, count: u64) -> f64 {
    if k == count { until } else { from + k as f64 * interval }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn frames_end_at_the_end_and_never_stand_still(until in 1e-3..1e3f64, cut in 1e-3..2.0f64) {
            let interval = until * cut;
            let count = frame_count(0.0, until, interval);
            let times: Vec<f64> = (1..=count).map(|k| frame_time(0.0, until, interval, k, count)).collect();
            prop_assert_eq!(times.last().copied(), Some(until));
            prop_assert!(times.windows(2).all(|w| w[1] - w[0] > 1e-10 * until));
            prop_assert!(times.len() <= (1.0 / cut).ceil() as usize);
        }
    }
}
