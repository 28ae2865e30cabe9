//! Time integration. Particles move with the material, so that the material derivative D/Dt of
//! Eq. (3) is the plain time derivative of what they carry.

pub mod chebyshev;
pub mod implicit;

use crate::dynamics::{Dynamics, ForceSums};
use crate::error::{FailureKind, InvalidInput};
use crate::particles::{Column, Field, Particles};
use crate::state::State;
use crate::tensor::Vec3;
use dyn_clone::DynClone;
use rayon::prelude::*;

/// Values that one task works on.
const VALUES_PER_TASK: usize = 4096;

/// The classical Runge-Kutta scheme of fourth order, section 5.2 of the paper, with its work space.
#[derive(Clone, Debug, Default)]
pub struct RungeKutta4 {
    start: Vec<Column>,
    end: Vec<Column>,
    rates: Vec<Column>,
}

/// What a step did to the body, integrated over the step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepSums {
    /// Impulse of loads.
    pub load: Vec3,
    /// Impulse of clamps and moved parts, prescribed velocities included.
    pub reaction: Vec3,
    /// Work of loads and moved parts.
    pub work: f64,
    /// Energy that viscosity took, where the dynamics sums it up by itself.
    pub dissipated: f64,
}

/// What a step came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// What it did to the body.
    pub sums: StepSums,
    /// The forces at its start (explicit schemes) or end (implicit ones).
    pub forces: ForceSums,
    /// Right-hand sides evaluated and operators applied.
    pub evaluations: u64,
    /// Length of the next step, from schemes that choose it.
    pub next: Option<f64>,
    /// Whether it was taken; if not the particles are as before, and the next step must be shorter.
    pub taken: bool,
}

/// A scheme of integration in time with its work space for one set of particles.
pub trait Integrator: DynClone + std::fmt::Debug + Send + Sync {
    /// The forces at time `t`, without advancing.
    fn evaluate(&mut self, dynamics: &mut dyn Dynamics, particles: &Particles, t: f64) -> ForceSums;

    /// Advances `particles` from `t` to `t + dt`.
    ///
    /// # Errors
    /// What went wrong; the particles are then of no use.
    fn step(
        &mut self,
        dynamics: &mut dyn Dynamics,
        particles: &mut Particles,
        t: f64,
        dt: f64,
    ) -> Result<Step, (FailureKind, String)>;

    /// Frees the work space that the next step makes anew.
    fn rest(&mut self) {}

    /// Puts what it remembers from step to step into `state`.
    fn save(&self, state: &mut State) {
        let _ = state;
    }

    /// Takes it back.
    ///
    /// # Errors
    /// What is missing or has another length.
    fn restore(&mut self, state: &State) -> Result<(), InvalidInput> {
        let _ = state;
        Ok(())
    }
}

dyn_clone::clone_trait_object!(Integrator);

impl RungeKutta4 {
    /// Right-hand sides a step.
    pub const EVALUATIONS: u64 = 4;

    /// Makes the columns of the rates, if they are not there.
    fn prepare_rates(&mut self, dynamics: &dyn Dynamics, particles: &Particles) {
        if self.rates.is_empty() {
            self.rates = columns(dynamics, particles, |f| !is_velocity(dynamics, f));
        }
    }

    /// Makes all of the work space, if it is not there.
    fn prepare(&mut self, dynamics: &dyn Dynamics, particles: &Particles) {
        self.prepare_rates(dynamics, particles);
        if self.start.is_empty() {
            self.start = columns(dynamics, particles, |_| true);
            self.end = columns(dynamics, particles, |_| true);
        }
    }
}

/// Whether the rate of change of a field is the velocity, and needs no place of its own.
fn is_velocity(dynamics: &dyn Dynamics, field: Field) -> bool {
    field == Field::Displacement && dynamics.moves_with_velocity()
}

/// Zeros for the integrated columns that are wanted, nothing for the others.
fn columns(dynamics: &dyn Dynamics, particles: &Particles, wanted: impl Fn(Field) -> bool) -> Vec<Column> {
    let zeros = |&f: &Field| {
        if wanted(f) { Column::zeros(f.spec().components, particles.len()) } else { Column::zeros(0, 0) }
    };
    dynamics.integrated().iter().map(zeros).collect()
}

impl Integrator for RungeKutta4 {
    fn evaluate(&mut self, dynamics: &mut dyn Dynamics, particles: &Particles, t: f64) -> ForceSums {
        self.prepare_rates(dynamics, particles);
        dynamics.rates(t, particles, &mut self.rates)
    }

    fn rest(&mut self) {
        *self = Self::default();
    }

    fn step(
        &mut self,
        dynamics: &mut dyn Dynamics,
        particles: &mut Particles,
        t: f64,
        dt: f64,
    ) -> Result<Step, (FailureKind, String)> {
        // (time of the stage, weight of its rates, distance of the next stage), in steps.
        const STAGES: [(f64, f64, f64); 4] =
            [(0.0, 1.0 / 6.0, 0.5), (0.5, 1.0 / 3.0, 0.5), (0.5, 1.0 / 3.0, 1.0), (1.0, 1.0 / 6.0, 0.0)];
        self.prepare(dynamics, particles);
        let fields = dynamics.integrated();
        for (start, field) in self.start.iter_mut().zip(fields) {
            start.values_mut().copy_from_slice(particles.column(*field).values());
        }
        let mut integral = ForceSums::default();
        let mut at_start = ForceSums::default();
        for (stage, (c, weight, next)) in STAGES.into_iter().enumerate() {
            if stage > 0 {
                dynamics.impose(t + c * dt, particles);
            }
            let sums = dynamics.rates(t + c * dt, particles, &mut self.rates);
            integral = integral.add_scaled(weight * dt, &sums);
            if stage == 0 {
                at_start = sums;
            }
            for (i, field) in fields.iter().enumerate() {
                // Displacements advance before the velocity of this stage does, and held ones are imposed.
                let velocity =
                    is_velocity(dynamics, *field).then(|| particles.column(Field::Velocity).share());
                advance(
                    particles.column_mut(*field).values_mut(),
                    self.end[i].values_mut(),
                    self.start[i].values(),
                    velocity.as_ref().map_or(self.rates[i].values(), |v| v.as_slice()), // Eq. (4)
                    weight * dt,
                    next * dt,
                    stage,
                );
            }
        }
        let imposed = dynamics.impose(t + dt, particles);
        let sums = StepSums {
            load: integral.load,
            reaction: integral.reaction + imposed.momentum,
            work: integral.power + imposed.energy,
            dissipated: integral.dissipation,
        };
        Ok(Step { sums, forces: at_start, evaluations: Self::EVALUATIONS, next: None, taken: true })
    }
}

/// One stage of one column: `end` collects the result, `value` becomes the next stage, or the result
/// after the last one.
fn advance(
    value: &mut [f64],
    end: &mut [f64],
    start: &[f64],
    rate: &[f64],
    weight: f64,
    next: f64,
    stage: usize,
) {
    let n = VALUES_PER_TASK;
    (value.par_chunks_mut(n), end.par_chunks_mut(n), start.par_chunks(n), rate.par_chunks(n))
        .into_par_iter()
        .for_each(|(value, end, start, rate)| {
            for (((value, end), start), rate) in value.iter_mut().zip(end).zip(start).zip(rate) {
                *end = if stage == 0 { *start } else { *end } + weight * rate;
                *value = if stage == 3 { *end } else { start + next * rate };
            }
        });
}
