//! Laws of a fluid in one dimension, for a fluid beside a solid. One law a file.

mod acoustic;
mod burgers;

pub use acoustic::Acoustic;
pub use burgers::Burgers;

use std::fmt::Debug;

/// A fluid that particles follow: rho Du/Dt = d sigma/dx + rho s with the stress sigma = viscosity
/// du/dx - p.
///
/// Wall, interface, remeshing and time integration know a fluid by these functions only.
pub trait FluidLaw: Debug + Send + Sync {
    /// Name in scenario files.
    fn name(&self) -> &'static str;

    /// Density rho.
    fn density(&self) -> f64;

    /// Viscosity: stress per rate of strain du/dx.
    fn viscosity(&self) -> f64;

    /// Bulk modulus K, by which the pressure that particles carry follows their strain: Dp/Dt = -K
    /// du/dx. `None`: the fluid has no pressure.
    fn bulk_modulus(&self) -> Option<f64>;

    /// The acceleration s that is no divergence of a stress, at velocity `u` and gradient `u_x`.
    fn source(&self, u: f64, u_x: f64) -> f64;

    /// Density of energy (per length) at velocity `u` and pressure `p`.
    fn energy_density(&self, u: f64, p: f64) -> f64 {
        let stored = self.bulk_modulus().map_or(0.0, |k| 0.5 * p * p / k);
        0.5 * self.density() * u * u + stored
    }

    /// Speed of sound; 0 without pressure.
    fn sound_speed(&self) -> f64 {
        self.bulk_modulus().map_or(0.0, |k| (k / self.density()).sqrt())
    }
}
