//! What moves the particles: one dynamics a file.

pub mod elastic;
pub mod paper;

use crate::particles::{Column, Field, Particles};
use crate::tensor::Vec3;

/// Sums over the body at one evaluation of the rates; the integrator integrates them in time with the
/// weights of the state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceSums {
    /// Total force of the loads.
    pub load: Vec3,
    /// Total force of clamps and moved parts on the body.
    pub reaction: Vec3,
    /// Power of loads and moved parts.
    pub power: f64,
}

impl ForceSums {
    /// `self + k other`.
    #[must_use]
    pub fn add_scaled(self, k: f64, other: &Self) -> Self {
        Self {
            load: self.load + k * other.load,
            reaction: self.reaction + k * other.reaction,
            power: self.power + k * other.power,
        }
    }
}

/// Energies at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Elastic energy, that of the hourglass term included.
    pub elastic: f64,
}

/// A right-hand side.
pub trait Dynamics: std::fmt::Debug + Send + Sync {
    /// The columns that are integrated in time.
    fn integrated(&self) -> &'static [Field];

    /// Rates of change of the integrated columns at time `t`, in the order of
    /// [`Dynamics::integrated`].
    fn rates(&mut self, t: f64, particles: &Particles, rates: &mut [Column]) -> ForceSums;

    /// Sets what is prescribed at time `t`; returns the momentum that this added.
    fn impose(&self, t: f64, particles: &mut Particles) -> Vec3;

    /// Adds the derived columns (strain, stress, density, ...) to a copy of the state.
    fn derive(&mut self, t: f64, particles: &mut Particles);

    /// Energies at this moment.
    fn energy(&mut self, t: f64, particles: &Particles) -> Energy;
}
