//! The sums that the equations conserve, and what changes them.

use crate::dynamics::Energy;
use crate::dynamics::ForceSums;
use crate::integrate::StepSums;
use crate::particles::{Field, Particles};
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
    /// momentum or impulse, that of the loads alone included, so far.
    pub momentum_error: f64,
    /// |mass - mass at the start| / mass at the start.
    pub mass_error: f64,
}

/// The balance of a simulation since its start.
#[derive(Clone, Copy, Debug)]
pub(super) struct Balance {
    mass: f64,
    momentum: Vec3,
    energy: Energy,
    impulse: Vec3,
    load_impulse: Vec3,
    /// Work of loads and boundaries so far.
    pub work: f64,
    largest_momentum: f64,
    forces: ForceSums,
}

impl Balance {
    /// Starts from particles with that energy and those forces on them.
    pub fn new(particles: &Particles, energy: Energy, forces: ForceSums) -> Self {
        let momentum = momentum(particles);
        Self {
            mass: total_mass(particles),
            momentum,
            energy,
            impulse: Vec3::zeros(),
            load_impulse: Vec3::zeros(),
            work: 0.0,
            largest_momentum: momentum.norm(),
            forces,
        }
    }

    /// Adds what a step did; `forces` are those at its start.
    pub fn add(&mut self, step: &StepSums, forces: ForceSums) {
        self.forces = forces;
        self.impulse += step.load + step.reaction;
        self.work += step.work;
        self.load_impulse += step.load;
        let reached = self.impulse.norm().max(self.load_impulse.norm());
        self.largest_momentum = self.largest_momentum.max(reached);
    }

    /// The body has been brought to rest under `forces`, as slowly as it takes to dissipate nothing.
    pub fn settle(&mut self, energy: Energy, forces: ForceSums) {
        self.forces = forces;
        self.work = energy.kinetic + energy.elastic - self.energy.kinetic - self.energy.elastic;
        self.impulse = -self.momentum;
    }

    /// The sums of this moment.
    pub fn conservation(&self, particles: &Particles, energy: Energy) -> Conservation {
        let Energy { kinetic, elastic } = energy;
        let (mass, momentum) = (total_mass(particles), momentum(particles));
        let defect = (momentum - self.momentum - self.impulse).norm();
        let scale = self.largest_momentum.max(momentum.norm());
        Conservation {
            mass,
            momentum,
            kinetic_energy: kinetic,
            elastic_energy: elastic,
            external_work: self.work,
            dissipated: self.energy.kinetic + self.energy.elastic + self.work - kinetic - elastic,
            load: self.forces.load,
            reaction: self.forces.reaction,
            momentum_error: if scale > 0.0 { defect / scale } else { 0.0 },
            mass_error: (mass - self.mass).abs() / self.mass,
        }
    }
}

/// Sum of the masses.
pub(super) fn total_mass(particles: &Particles) -> f64 {
    particles.column(Field::Mass).values().iter().sum()
}

/// Sum of mass times velocity; zero where particles carry no velocity.
pub(super) fn momentum(particles: &Particles) -> Vec3 {
    let (m, v) = (particles.column(Field::Mass), particles.column(Field::Velocity));
    if v.is_empty() {
        return Vec3::zeros();
    }
    (0..particles.len()).map(|a| m.values()[a] * v.vector(a)).sum()
}
