//! The step: the one file that sees all.

use crate::error::{Failure, InvalidInput};
use crate::sample::Body;
use crate::setup::Setup;
use crate::snapshot::Snapshot;
use crate::surface::Surface;
use crate::tensor::Vec3;

/// Sums that the equations conserve, and what changes them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Conservation {
    /// Total mass.
    pub mass: f64,
    /// Total linear momentum.
    pub momentum: Vec3,
    /// Kinetic energy.
    pub kinetic_energy: f64,
    /// Elastic energy, hourglass energy included.
    pub elastic_energy: f64,
    /// Work done by loads and moving boundaries since the start.
    pub external_work: f64,
    /// Energy taken by the viscosity since the start.
    pub dissipated: f64,
    /// Total force of the loads at this moment.
    pub load: Vec3,
    /// Total force of the clamps on the body at this moment.
    pub reaction: Vec3,
    /// |momentum - momentum at the start - impulse of loads and reactions| relative to the largest
    /// momentum or impulse so far.
    pub momentum_error: f64,
    /// |mass - mass at the start| / mass at the start.
    pub mass_error: f64,
}

/// What is known of a simulation before its first step.
#[derive(Clone, Debug)]
pub struct Description {
    /// Number of particles.
    pub particles: usize,
    /// Spacing dx.
    pub spacing: f64,
    /// Smoothing length h.
    pub smoothing_length: f64,
    /// Neighbours of an inner particle.
    pub neighbours: usize,
    /// Time step.
    pub dt: f64,
    /// Largest stable time step.
    pub dt_limit: f64,
    /// Whether viscosity (true) or wave speed (false) sets the limit.
    pub limited_by_viscosity: bool,
    /// Volume of the particles.
    pub volume: f64,
    /// Volume of the shape.
    pub shape_volume: f64,
    /// Total force of the loads at full ramp.
    pub load: Vec3,
    /// Things the user should know (one sentence each).
    pub notes: Vec<String>,
}

/// One value of a probe.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Column header: the probe's name, with `_x` etc. for a vector.
    pub name: String,
    /// Value.
    pub value: f64,
}

/// A running simulation.
#[derive(Debug)]
pub struct Simulation {
    setup: Setup,
}

impl Simulation {
    /// Samples the body, tags boundaries, loads and probes, and chooses the time step.
    ///
    /// # Errors
    /// The first input that can not be simulated.
    pub fn new(setup: Setup) -> Result<Self, InvalidInput> {
        Ok(Self { setup })
    }
    /// What it was made from.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }
    /// What is known before the first step.
    pub fn description(&self) -> &Description {
        todo!()
    }
    /// The sampled body.
    pub fn body(&self) -> &Body {
        todo!()
    }
    /// Advances by one time step of length `dt`.
    ///
    /// # Errors
    /// When the state becomes meaningless; the last good state is kept.
    pub fn step(&mut self) -> Result<(), Failure> {
        todo!()
    }
    /// Advances to the time `t` exactly, shortening the last step where needed. Stops early, at a
    /// whole step, when `keep_going` returns false (called after every step).
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn advance_to(&mut self, t: f64, keep_going: &mut dyn FnMut(&Self) -> bool) -> Result<(), Failure> {
        let _ = (t, keep_going);
        todo!()
    }
    /// Simulated time.
    pub fn time(&self) -> f64 {
        todo!()
    }
    /// Number of steps taken.
    pub fn step_count(&self) -> u64 {
        todo!()
    }
    /// Number of right-hand sides evaluated.
    pub fn rhs_evaluations(&self) -> u64 {
        todo!()
    }
    /// A picture of this moment.
    pub fn snapshot(&self) -> Snapshot {
        todo!()
    }
    /// The surface of this moment.
    pub fn surface(&self) -> Surface {
        todo!()
    }
    /// The probes' readings of this moment, in order.
    pub fn readings(&self) -> Vec<Reading> {
        todo!()
    }
    /// The conserved sums of this moment.
    pub fn conservation(&self) -> Conservation {
        todo!()
    }
}
