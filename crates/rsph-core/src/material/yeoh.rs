//! Yeoh's solid.

use super::isochoric::{Invariants, Isochoric};
use super::{Damped, Model, Parameter, TISSUE, tissue};
use crate::tensor::lanes::Real;
use std::sync::Arc;

/// w = c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3; the shear modulus at small strain is 2 c1.
///
/// (O. H. Yeoh, Rubber Chem. Technol. 63, 792, 1990.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YeohEnergy {
    c: [f64; 3],
}

/// Yeoh's solid with Kelvin-Voigt damping.
pub type Yeoh = Damped<Isochoric<YeohEnergy>>;

pub(super) const MODEL: Model = Model {
    name: "yeoh",
    doc: "Yeoh's solid, a cubic in I1: tissue and gels that stiffen",
    parameters: &[
        TISSUE[0],
        Parameter::new("c1", "Pa", "c1, the factor of I1 - 3: half the shear modulus at small strain"),
        Parameter::new("c2", "Pa", "c2, the factor of (I1 - 3)^2").or(0.0),
        Parameter::new("c3", "Pa", "c3, the factor of (I1 - 3)^3").or(0.0),
        TISSUE[1],
        TISSUE[2],
        TISSUE[3],
    ],
    build: |v| {
        let c = ["c1", "c2", "c3"].map(|key| v.number(key));
        let small = tissue(v, ("material.c1", 2.0 * c[0]))?;
        Ok(Arc::new(Isochoric::damped(MODEL.name, small, YeohEnergy { c })))
    },
};

impl Invariants for YeohEnergy {
    fn energy(&self, i1: f64, _: f64) -> f64 {
        let ([c1, c2, c3], x) = (self.c, i1 - 3.0);
        ((c3 * x + c2) * x + c1) * x
    }

    #[inline(always)]
    fn slopes<T: Real>(&self, i1: T, _: T) -> [T; 2] {
        let ([c1, c2, c3], x) = (self.c, i1 + -3.0);
        [(x * (3.0 * c3) + 2.0 * c2) * x + c1, x * 0.0]
    }

    #[inline(always)]
    fn curvature<T: Real>(&self, i1: T) -> T {
        let ([_, c2, c3], x) = (self.c, i1 + -3.0);
        x * (6.0 * c3) + 2.0 * c2
    }
}
