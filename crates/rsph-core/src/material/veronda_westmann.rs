//! The solid of Veronda and Westmann.

use super::isochoric::{Invariants, Isochoric};
use super::kelvin_voigt::positive;
use super::{Damped, Model, Parameter, TISSUE, tissue};
use crate::tensor::lanes::Real;
use std::sync::Arc;

/// w = c1 (exp(c2 (I1 - 3)) - 1) - c1 c2 / 2 (I2 - 3); the shear modulus at small strain is c1 c2.
///
/// (D. R. Veronda and R. A. Westmann, J. Biomech. 3, 111, 1970: skin; the liver in K. Miller and others.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerondaWestmannEnergy {
    c1: f64,
    c2: f64,
}

/// The solid of Veronda and Westmann with Kelvin-Voigt damping.
pub type VerondaWestmann = Damped<Isochoric<VerondaWestmannEnergy>>;

pub(super) const MODEL: Model = Model {
    name: "veronda-westmann",
    doc: "solid of Veronda and Westmann, exponential in I1: skin, liver",
    parameters: &[
        TISSUE[0],
        Parameter::new("c1", "Pa", "c1, the scale of the stress; c1 c2 is the shear modulus at small strain"),
        Parameter::new("c2", "1", "c2, how fast it stiffens"),
        TISSUE[1],
        TISSUE[2],
        TISSUE[3],
    ],
    build: |v| {
        let energy = VerondaWestmannEnergy { c1: v.number("c1"), c2: v.number("c2") };
        positive("material.c2", energy.c2, "liver: about 1 to 30")?;
        let small = tissue(v, ("material.c1", energy.c1 * energy.c2))?;
        Ok(Arc::new(Isochoric::damped(MODEL.name, small, energy)))
    },
};

impl Invariants for VerondaWestmannEnergy {
    fn energy(&self, i1: f64, i2: f64) -> f64 {
        let Self { c1, c2 } = *self;
        c1 * (c2 * (i1 - 3.0)).exp_m1() - 0.5 * c1 * c2 * (i2 - 3.0)
    }

    #[inline(always)]
    fn slopes<T: Real>(&self, i1: T, i2: T) -> [T; 2] {
        let Self { c1, c2 } = *self;
        [((i1 + -3.0) * c2).exp() * (c1 * c2), i2 * 0.0 + -0.5 * c1 * c2]
    }

    #[inline(always)]
    fn curvature<T: Real>(&self, i1: T) -> T {
        let Self { c1, c2 } = *self;
        ((i1 + -3.0) * c2).exp() * (c1 * c2 * c2)
    }
}
