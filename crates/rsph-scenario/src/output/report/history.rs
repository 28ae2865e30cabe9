//! The curves of the page: probes and conserved sums against time.

use super::packed::six_digits;
use super::thinned::Thinned;
use rsph_core::simulation::{Conservation, Reading};
use serde::Serialize;

/// Most points of a curve.
const MAX_POINTS: usize = 2000;

#[derive(Debug)]
struct Sample {
    time: f64,
    readings: Vec<f64>,
    sums: [f64; 6],
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
