//! What loads and boundaries do to the body at one moment.

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
    /// Power that viscosity takes, where the dynamics sums it up by itself.
    pub dissipation: f64,
}

impl ForceSums {
    /// `self + k other`.
    #[must_use]
    pub fn add_scaled(self, k: f64, other: &Self) -> Self {
        Self {
            load: self.load + k * other.load,
            reaction: self.reaction + k * other.reaction,
            power: self.power + k * other.power,
            dissipation: self.dissipation + k * other.dissipation,
        }
    }
}

/// What setting prescribed velocities adds to the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Imposed {
    /// Momentum.
    pub momentum: Vec3,
    /// Kinetic energy.
    pub energy: f64,
}

impl Default for Imposed {
    fn default() -> Self {
        Self { momentum: Vec3::zeros(), energy: 0.0 }
    }
}
