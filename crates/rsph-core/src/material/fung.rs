//! Fung's exponential for isotropic tissue.

use super::isochoric::{Invariants, Isochoric};
use super::kelvin_voigt::positive;
use super::{Damped, Model, Parameter, TISSUE, tissue};
use crate::tensor::lanes::Real;
use std::sync::Arc;

/// w = mu / (2 b) (exp(b (I1 - 3)) - 1), mu the shear modulus at small strain.
///
/// (Y. C. Fung, Am. J. Physiol. 213, 1532, 1967; in this form by H. Demiray, J. Biomech. 5, 309, 1972.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FungEnergy {
    mu: f64,
    b: f64,
}

/// Fung's exponential solid with Kelvin-Voigt damping.
pub type Fung = Damped<Isochoric<FungEnergy>>;

pub(super) const MODEL: Model = Model {
    name: "fung",
    doc: "Fung's exponential in I1 (Demiray): isotropic tissue that stiffens",
    parameters: &[
        TISSUE[0],
        Parameter::new("shear_modulus", "Pa", "shear modulus mu at small strain"),
        Parameter::new("exponent", "1", "b, how fast it stiffens"),
        TISSUE[1],
        TISSUE[2],
        TISSUE[3],
    ],
    build: |v| {
        let energy = FungEnergy { mu: v.number("shear_modulus"), b: v.number("exponent") };
        positive(
            "material.exponent",
            energy.b,
            "liver: about 1 to 30; small ones are the neo-Hookean solid",
        )?;
        let small = tissue(v, ("material.shear_modulus", energy.mu))?;
        Ok(Arc::new(Isochoric::damped(MODEL.name, small, energy)))
    },
};

impl Invariants for FungEnergy {
    fn energy(&self, i1: f64, _: f64) -> f64 {
        0.5 * self.mu / self.b * (self.b * (i1 - 3.0)).exp_m1()
    }

    #[inline(always)]
    fn slopes<T: Real>(&self, i1: T, i2: T) -> [T; 2] {
        [((i1 + -3.0) * self.b).exp() * (0.5 * self.mu), i2 * 0.0]
    }

    #[inline(always)]
    fn curvature<T: Real>(&self, i1: T) -> T {
        ((i1 + -3.0) * self.b).exp() * (0.5 * self.mu * self.b)
    }
}
