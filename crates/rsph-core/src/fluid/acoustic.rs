//! A fluid that carries sound.

use super::FluidLaw;
use crate::error::InvalidInput;

/// Linear acoustics: rho Du/Dt = -p_x, Dp/Dt = -rho c^2 u_x. Valid while velocities are small against
/// the speed of sound c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acoustic {
    density: f64,
    sound_speed: f64,
}

impl Acoustic {
    /// The fluid with density rho and speed of sound c.
    ///
    /// # Errors
    /// A value that is not positive.
    pub fn new(density: f64, sound_speed: f64) -> Result<Self, InvalidInput> {
        for (key, value, example) in [
            ("density", density, "1000 kg/m^3 for water"),
            ("sound_speed", sound_speed, "1480 m/s for water"),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(InvalidInput::new(
                    format!("dynamics.fluid.acoustic.{key}"),
                    value,
                    "must be a positive number",
                    format!("for example {example}"),
                ));
            }
        }
        Ok(Self { density, sound_speed })
    }
}

impl FluidLaw for Acoustic {
    fn name(&self) -> &'static str {
        "acoustic"
    }

    fn density(&self) -> f64 {
        self.density
    }

    fn viscosity(&self) -> f64 {
        0.0
    }

    fn bulk_modulus(&self) -> Option<f64> {
        Some(self.density * self.sound_speed.powi(2))
    }

    fn source(&self, _u: f64, _u_x: f64) -> f64 {
        0.0
    }
}
