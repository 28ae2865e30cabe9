//! The Runge-Kutta-Chebyshev scheme of second order (Sommeijer, Shampine and Verwer 1997): explicit, with
//! so many stages that the negative real axis is stable as far as viscosity reaches.

use super::{Integrator, Step, StepSums};
use crate::dynamics::{Dynamics, ForceSums};
use crate::error::FailureKind;
use crate::particles::{Column, Particles};
use rayon::prelude::*;

/// Damping of the stability polynomial.
const DAMPING: f64 = 2.0 / 13.0;
/// Stages s reach 0.65 s^2 along the axis.
const REACH: f64 = 1.54;

/// The scheme with its work space.
#[derive(Clone, Debug)]
pub struct RungeKuttaChebyshev {
    /// Largest rate of decay (1/s).
    fastest: f64,
    start: Vec<Column>,
    start_rates: Vec<Column>,
    before: Vec<Column>,
    rates: Vec<Column>,
}

impl RungeKuttaChebyshev {
    /// For `dynamics` on `particles`, whose fastest decay has the rate `fastest`.
    pub fn new(dynamics: &dyn Dynamics, particles: &Particles, fastest: f64) -> Self {
        let zeros = |f: &crate::particles::Field| Column::zeros(f.spec().components, particles.len());
        let columns: Vec<Column> = dynamics.integrated().iter().map(zeros).collect();
        Self {
            fastest,
            start: columns.clone(),
            start_rates: columns.clone(),
            before: columns.clone(),
            rates: columns,
        }
    }

    /// Stages of a step of length `dt`.
    pub fn stages(&self, dt: f64) -> usize {
        ((1.0 + REACH * dt * self.fastest).sqrt().ceil() as usize).max(2)
    }
}

impl Integrator for RungeKuttaChebyshev {
    fn evaluate(&mut self, dynamics: &mut dyn Dynamics, particles: &Particles, t: f64) -> ForceSums {
        dynamics.rates(t, particles, &mut self.rates)
    }

    fn step(
        &mut self,
        dynamics: &mut dyn Dynamics,
        particles: &mut Particles,
        t: f64,
        dt: f64,
    ) -> Result<Step, (FailureKind, String)> {
        let s = self.stages(dt);
        let w0 = 1.0 + DAMPING / (s * s) as f64;
        // Chebyshev polynomials at w0 with their first two derivatives.
        let mut p = vec![(1.0, 0.0, 0.0), (w0, 1.0, 0.0)];
        for j in 2..=s {
            let ((a, da, dda), (b, db, ddb)) = (p[j - 1], p[j - 2]);
            p.push((2.0 * w0 * a - b, 2.0 * a + 2.0 * w0 * da - db, 4.0 * da + 2.0 * w0 * dda - ddb));
        }
        let w1 = p[s].1 / p[s].2;
        let b = |j: usize| p[j.max(2)].2 / p[j.max(2)].1.powi(2);
        // Times of the stages, in steps, and sums over the step by the trapezoidal rule.
        let time = |j: usize| if j < 2 { b(1) * w1 * j as f64 } else { w1 * p[j].2 / p[j].1 };

        let fields = dynamics.integrated();
        for (start, field) in self.start.iter_mut().zip(fields) {
            start.values_mut().copy_from_slice(particles.column(*field).values());
        }
        let at_start = dynamics.rates(t, particles, &mut self.start_rates);
        for (i, field) in fields.iter().enumerate() {
            self.before[i].values_mut().copy_from_slice(self.start[i].values());
            let value = particles.column_mut(*field).values_mut();
            crate::solve::sums::combine(b(1) * w1 * dt, self.start_rates[i].values(), 1.0, value);
        }
        let mut integral = at_start.add_scaled(-1.0, &at_start);
        let (mut last, mut last_time) = (at_start, 0.0);
        for j in 2..=s {
            let now = time(j - 1);
            dynamics.impose(t + now * dt, particles);
            let sums = dynamics.rates(t + now * dt, particles, &mut self.rates);
            let half = 0.5 * (now - last_time) * dt;
            integral = integral.add_scaled(half, &last).add_scaled(half, &sums);
            (last, last_time) = (sums, now);
            let mu = 2.0 * b(j) * w0 / b(j - 1);
            let nu = -b(j) / b(j - 2);
            let step = 2.0 * b(j) * w1 / b(j - 1) * dt;
            let of_start = -(1.0 - b(j - 1) * p[j - 1].0) * step;
            for (i, field) in fields.iter().enumerate() {
                let value = particles.column_mut(*field).values_mut();
                (value, self.before[i].values_mut(), self.start[i].values(), self.rates[i].values())
                    .into_par_iter()
                    .zip(self.start_rates[i].values())
                    .for_each(|((y, before, start, rate), start_rate)| {
                        let next = (1.0 - mu - nu) * start
                            + mu * *y
                            + nu * *before
                            + step * rate
                            + of_start * start_rate;
                        *before = *y;
                        *y = next;
                    });
            }
        }
        let imposed = dynamics.impose(t + dt, particles);
        let forces = dynamics.rates(t + dt, particles, &mut self.rates);
        let half = 0.5 * (1.0 - last_time) * dt;
        integral = integral.add_scaled(half, &last).add_scaled(half, &forces);
        let sums = StepSums {
            load: integral.load,
            reaction: integral.reaction + imposed.momentum,
            work: integral.power + imposed.energy,
            // A solid's is what its energy lacks.
            dissipated: 0.0,
        };
        Ok(Step { sums, forces, evaluations: s as u64 + 1, next: None, taken: true })
    }
}
