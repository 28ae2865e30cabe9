//! The Mooney-Rivlin solid.

use super::isochoric::{Invariants, Isochoric};
use super::{Damped, Model, Parameter, TISSUE, tissue};
use crate::tensor::lanes::Real;
use std::sync::Arc;

/// w = c10 (I1 - 3) + c01 (I2 - 3); the shear modulus at small strain is 2 (c10 + c01).
///
/// (M. Mooney, J. Appl. Phys. 11, 582, 1940; R. S. Rivlin, Phil. Trans. R. Soc. A 241, 379, 1948.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MooneyRivlinEnergy {
    c10: f64,
    c01: f64,
}

/// The Mooney-Rivlin solid with Kelvin-Voigt damping.
pub type MooneyRivlin = Damped<Isochoric<MooneyRivlinEnergy>>;

pub(super) const MODEL: Model = Model {
    name: "mooney-rivlin",
    doc: "Mooney-Rivlin solid, linear in I1 and I2: gels and tissue at moderate strain",
    parameters: &[
        TISSUE[0],
        Parameter::new("c10", "Pa", "c10, the factor of I1 - 3"),
        Parameter::new("c01", "Pa", "c01, the factor of I2 - 3").or(0.0),
        TISSUE[1],
        TISSUE[2],
        TISSUE[3],
    ],
    build: |v| {
        let energy = MooneyRivlinEnergy { c10: v.number("c10"), c01: v.number("c01") };
        let small = tissue(v, ("material.c10", 2.0 * (energy.c10 + energy.c01)))?;
        Ok(Arc::new(Isochoric::damped(MODEL.name, small, energy)))
    },
};

impl Invariants for MooneyRivlinEnergy {
    fn energy(&self, i1: f64, i2: f64) -> f64 {
        self.c10 * (i1 - 3.0) + self.c01 * (i2 - 3.0)
    }

    #[inline(always)]
    fn slopes<T: Real>(&self, i1: T, _: T) -> [T; 2] {
        let zero = i1 * 0.0;
        [zero + self.c10, zero + self.c01]
    }

    #[inline(always)]
    fn curvature<T: Real>(&self, i1: T) -> T {
        i1 * 0.0
    }
}
