//! Free bodies that swing in their slowest mode: a bar along its axis against c / (2 L), a beam that bends
//! against finite elements; a damped bar against the decay of a Kelvin-Voigt solid.

use super::Row;
use super::case::{OSCILLATING_BAR, OSCILLATING_BEAM, simulation};
use super::figure::{Curve, Figure};
use rsph_core::particles::{Column, Field};
use std::f64::consts::TAU;
use std::path::Path;

/// c / (2 L) of the bar: c = sqrt(E / rho) = 10, L = 1, nu = 0.
const BAR: f64 = 5.0;
/// First bending frequency of the beam by quadratic hexahedra (validation/oscillation/README.md).
const BEAM: f64 = 0.99343;
/// Relaxation time of the damped bar.
const RELAXATION: f64 = 0.002;

/// A body that swings in the mode it was started in.
struct Swing {
    time: Vec<f64>,
    /// Share of the initial velocity in the present one, by mass.
    share: Vec<f64>,
    /// Largest relative change of motion's and strain's energy.
    energy_drift: f64,
}

impl Swing {
    fn run(scenario: (&str, &str), sets: &[String]) -> Result<Self, String> {
        let (mut sim, until) = simulation(scenario, sets)?;
        let mode = sim.particles().column(Field::Velocity).clone();
        let mass = sim.particles().column(Field::Mass).clone();
        let onto = |v: &Column| -> f64 {
            (0..mode.len()).map(|a| mass.values()[a] * v.vector(a).dot(&mode.vector(a))).sum()
        };
        let norm = onto(&mode);
        let energy = |c: rsph_core::simulation::Conservation| c.kinetic_energy + c.elastic_energy;
        let start = energy(sim.conservation());
        let mut swing = Self { time: vec![0.0], share: vec![1.0], energy_drift: 0.0 };
        while sim.time() < until {
            sim.step().map_err(|e| e.to_string())?;
            swing.time.push(sim.time());
            swing.share.push(onto(sim.particles().column(Field::Velocity)) / norm);
            if sim.step_count() % 20 == 0 {
                let drift = (energy(sim.conservation()) / start - 1.0).abs();
                swing.energy_drift = swing.energy_drift.max(drift);
            }
        }
        Ok(swing)
    }

    /// Times at which the mode changes its sign, between steps by a straight line.
    fn crossings(&self) -> Vec<f64> {
        let pairs = self.share.windows(2).zip(self.time.windows(2));
        pairs
            .filter(|(q, _)| q[0] * q[1] < 0.0)
            .map(|(q, t)| t[0] - q[0] * (t[1] - t[0]) / (q[1] - q[0]))
            .collect()
    }

    fn frequency(&self) -> f64 {
        let crossings = self.crossings();
        let [first, .., last] = crossings[..] else { return f64::NAN };
        (crossings.len() - 1) as f64 / (2.0 * (last - first))
    }

    /// Rate r of the decay exp(-r t), from the largest values between changes of sign.
    fn decay(&self) -> f64 {
        let crossings = self.crossings();
        let peak = |from: f64, to: f64| {
            let inside = (0..self.time.len()).filter(|&i| self.time[i] > from && self.time[i] < to);
            inside.map(|i| self.share[i].abs()).fold(0.0, f64::max)
        };
        let peaks: Vec<f64> = crossings.windows(2).map(|t| peak(t[0], t[1])).collect();
        let [first, .., last] = peaks[..] else { return f64::NAN };
        let between = crossings[peaks.len() - 1] - crossings[0];
        (first / last).ln() / between
    }

    /// The curve over periods of `frequency`.
    fn curve(&self, frequency: f64) -> (Vec<f64>, &[f64]) {
        (self.time.iter().map(|t| t * frequency).collect(), &self.share)
    }
}

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let mut figure =
        Figure::new("Free bodies in their slowest mode", "time in exact periods", "velocity of the mode");
    let bar = order(
        "bar",
        OSCILLATING_BAR,
        BAR,
        if quick { &[(20, 0.5), (40, 0.15)] } else { &[(20, 0.5), (40, 0.15), (80, 0.04)] },
        &mut rows,
    )?;
    let beam = order(
        "beam",
        OSCILLATING_BEAM,
        BEAM,
        if quick { &[(50, 1.0)] } else { &[(50, 1.0), (100, 0.3)] },
        &mut rows,
    )?;

    let omega = TAU * BAR;
    let ratio = 0.5 * RELAXATION * omega;
    let damped = Swing::run(
        OSCILLATING_BAR,
        &[format!("material.relaxation_time={RELAXATION}"), "body.spacing=0.025".into()],
    )?;
    let (decay, frequency) = (ratio * omega, BAR * (1.0 - ratio * ratio).sqrt());
    rows.push(Row::within("oscillation: damped bar, dx = 1/40, decay", damped.decay(), decay, 1.0, "1/time"));
    rows.push(Row::within(
        "oscillation: damped bar, dx = 1/40, frequency",
        damped.frequency(),
        frequency,
        0.15,
        "1/time",
    ));

    let exact: Vec<f64> = (0..=500).map(|i| f64::from(i) / 100.0).collect();
    let cosine: Vec<f64> = exact.iter().map(|t| (TAU * t).cos()).collect();
    let (t, q) = bar.curve(BAR);
    figure.add(Curve::solid("bar", &t, q));
    let (t, q) = beam.curve(BEAM);
    figure.add(Curve::marked("beam", &t, q));
    let (t, q) = damped.curve(BAR);
    figure.add(Curve::dashed("bar, damped", &t, q));
    figure.add(Curve::dotted("exact", &exact, &cosine));
    let envelope: Vec<f64> = exact.iter().map(|t| (-decay * t / BAR).exp()).collect();
    figure.add(Curve::dotted("", &exact, &envelope));
    figure.limit(-1.15, 1.15);
    figure.save(folder, "oscillation")?;
    Ok(rows)
}

/// Frequencies of a scenario at so many particles along its length, each with its bound in %, and the order
/// in which their error falls; returns the coarsest.
fn order(
    what: &str,
    scenario: (&str, &str),
    exact: f64,
    levels: &[(u32, f64)],
    rows: &mut Vec<Row>,
) -> Result<Swing, String> {
    let mut errors = Vec::new();
    let mut coarsest = None;
    for &(n, bound) in levels {
        let swing = Swing::run(scenario, &[format!("body.spacing={}", 1.0 / f64::from(n))])?;
        let frequency = swing.frequency();
        let name = |of: &str| format!("oscillation: {what}, dx = 1/{n}, {of}");
        rows.push(Row::within(name("frequency"), frequency, exact, bound, "1/time"));
        rows.push(Row::at_most(name("change of the energy"), swing.energy_drift, 2e-4, "of the energy"));
        errors.push((frequency / exact - 1.0).abs());
        coarsest.get_or_insert(swing);
    }
    for (pair, n) in errors.windows(2).zip(levels) {
        let name = format!("oscillation: {what}, order from dx = 1/{} to half of it", n.0);
        rows.push(Row::at_least(name, (pair[0] / pair[1]).log2(), 1.6, "1"));
    }
    coarsest.ok_or_else(|| "no level".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decaying_cosine_is_measured() {
        let time: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.0013).collect();
        let share = time.iter().map(|t| (-0.3 * t).exp() * (TAU * 1.7 * t).cos()).collect();
        let swing = Swing { time, share, energy_drift: 0.0 };
        assert!((swing.frequency() / 1.7 - 1.0).abs() < 1e-5, "{}", swing.frequency());
        assert!((swing.decay() / 0.3 - 1.0).abs() < 1e-3, "{}", swing.decay());
    }
}
