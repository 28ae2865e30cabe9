//! A material that does nothing: for bodies that move as told.

use super::{Law, Material, Stiffness};

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

    fn law(&self) -> Law<'_> {
        Law::Linear(Stiffness::isotropic(0.0, 0.0))
    }
}
