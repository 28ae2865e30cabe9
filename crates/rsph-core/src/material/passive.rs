//! A material that does nothing: for bodies that move as told.

use super::Material;
use crate::tensor::SymTensor;

/// Mass without stiffness: it takes no stress and makes none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passive {
    /// Density (kg/m^3).
    pub density: f64,
}

impl Material for Passive {
    fn name(&self) -> &'static str {
        "passive"
    }

    fn density(&self) -> f64 {
        self.density
    }

    fn relaxation_time(&self) -> f64 {
        0.0
    }

    fn stress(&self, _effective_strain: SymTensor) -> SymTensor {
        SymTensor::ZERO
    }

    fn energy_density(&self, _strain: SymTensor) -> f64 {
        0.0
    }

    fn p_wave_modulus(&self) -> f64 {
        0.0
    }
}
