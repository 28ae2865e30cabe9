//! The curves of the page: probes and conserved sums against time.

use super::packed::six_digits;
use super::thinned::Thinned;
use rsph_core::error::InvalidInput;
use rsph_core::simulation::{Conservation, Reading};
use rsph_core::state::State;
use serde::Serialize;

/// Most points of a curve.
const MAX_POINTS: usize = 2000;

/// Conserved sums of a sample.
const SUMS: usize = 6;

#[derive(Debug)]
struct Sample {
    time: f64,
    readings: Vec<f64>,
    sums: [f64; SUMS],
}

/// Collects samples while a run goes on.
#[derive(Debug, Default)]
pub struct History {
    samples: Thinned<Sample>,
}

/// The curves as they stand in the page; a number that is not finite is `null`.
#[derive(Debug, Serialize)]
pub struct Curves {
    time: Vec<f64>,
    probes: Vec<Vec<f64>>,
    kinetic: Vec<f64>,
    elastic: Vec<f64>,
    external_work: Vec<f64>,
    dissipated: Vec<f64>,
    momentum_error: Vec<f64>,
    mass_error: Vec<f64>,
}

impl History {
    /// Takes the values of time `time`.
    pub fn push(&mut self, time: f64, readings: &[Reading], c: &Conservation) {
        let sample = Sample {
            time,
            readings: readings.iter().map(|r| r.value).collect(),
            sums: [
                c.kinetic_energy,
                c.elastic_energy,
                c.external_work,
                c.dissipated,
                c.momentum_error,
                c.mass_error,
            ],
        };
        self.samples.push(sample, |s| s.len() <= MAX_POINTS);
    }

    /// The readings of the last sample; nothing if there was none.
    pub fn last_readings(&self) -> &[f64] {
        self.samples.entries().last().map_or(&[], |sample| &sample.readings)
    }

    /// Puts the samples into `state`.
    pub fn save(&self, state: &mut State) {
        let rows = self.samples.entries().into_iter().flat_map(|s| {
            std::iter::once(s.time).chain(s.sums).chain(s.readings.iter().copied()).collect::<Vec<_>>()
        });
        let (numbers, stride, seen, last) = self.samples.layout();
        state.put("history/rows", rows.collect::<Vec<_>>());
        state.put_counts("history/numbers", &numbers);
        state.put_counts("history/counts", &[stride, seen, u64::from(last), numbers.len() as u64]);
    }

    /// Takes back samples of `probes` probe columns.
    ///
    /// # Errors
    /// When they are not there or do not belong together.
    pub fn restore(&mut self, state: &State, probes: usize) -> Result<(), InvalidInput> {
        let [stride, seen, last, kept] = state.counts("history/counts")?;
        let numbers = state.whole_of("history/numbers", kept as usize)?.iter().map(|n| *n as u64).collect();
        let (last, width) = (last == 1, SUMS + 1 + probes);
        let count = kept as usize + usize::from(last);
        let rows = state.real_of("history/rows", count.saturating_mul(width))?;
        let sample = |row: &[f64]| Sample {
            time: row[0],
            sums: std::array::from_fn(|i| row[1 + i]),
            readings: row[1 + SUMS..].to_vec(),
        };
        let entries = rows.chunks(width).map(sample).collect();
        if let Some(samples) = Thinned::from_layout((numbers, stride, seen, last), entries) {
            self.samples = samples;
        }
        Ok(())
    }

    /// The curves of `probes` probe columns.
    pub fn curves(&self, probes: usize) -> Curves {
        let samples = self.samples.entries();
        let curve = |of: &dyn Fn(&Sample) -> f64| samples.iter().map(|s| six_digits(of(s))).collect();
        let sum = |i: usize| curve(&move |s: &Sample| s.sums[i]);
        Curves {
            time: curve(&|s| s.time),
            probes: (0..probes)
                .map(|i| curve(&move |s: &Sample| s.readings.get(i).copied().unwrap_or(f64::NAN)))
                .collect(),
            kinetic: sum(0),
            elastic: sum(1),
            external_work: sum(2),
            dissipated: sum(3),
            momentum_error: sum(4),
            mass_error: sum(5),
        }
    }
}
