//! The viscous fluid of section 4 of the paper.

use super::FluidLaw;
use crate::error::InvalidInput;

/// Burgers' equation as Eq. (19) has it: Du/Dt = -u u_x / 2 + nu u_xx, that is u_t + (3/2) u u_x = nu
/// u_xx, with density 1. The factor 3/2 is what lets energy pass a moving interface without loss:
/// d/dt int u^2/2 dx = nu u u_x at the interface - int nu u_x^2 dx.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Burgers {
    viscosity: f64,
}

impl Burgers {
    /// The fluid with that kinematic viscosity nu (length^2 / time).
    ///
    /// # Errors
    /// A viscosity that is not positive.
    pub fn new(viscosity: f64) -> Result<Self, InvalidInput> {
        if viscosity.is_finite() && viscosity > 0.0 {
            return Ok(Self { viscosity });
        }
        Err(InvalidInput::new(
            "dynamics.fluid.burgers.viscosity",
            viscosity,
            "must be positive: without viscosity the fluid makes shocks that particles can not follow",
            "the paper has 0.001",
        ))
    }
}

impl FluidLaw for Burgers {
    fn name(&self) -> &'static str {
        "burgers"
    }

    fn density(&self) -> f64 {
        1.0
    }

    fn viscosity(&self) -> f64 {
        self.viscosity
    }

    fn bulk_modulus(&self) -> Option<f64> {
        None
    }

    fn source(&self, u: f64, u_x: f64) -> f64 {
        -0.5 * u * u_x // Eq. (19)
    }
}
