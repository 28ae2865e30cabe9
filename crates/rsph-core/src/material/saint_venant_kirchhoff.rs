//! The St. Venant-Kirchhoff solid with Kelvin-Voigt damping: Hooke's law between Green's strain and the second Piola-Kirchhoff
//! stress.

use super::{Damped, Formula, ISOTROPIC, KelvinVoigt, Model};
use crate::error::InvalidInput;
use crate::tensor::Mat3;
use crate::tensor::lanes::{Real, Tensor};
use std::sync::Arc;

/// W(F) = lambda/2 (tr E)^2 + mu E:E with Green's strain E = (F^T F - 1)/2; P = F (lambda tr E 1 + 2 mu E).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SaintVenantKirchhoffEnergy {
    mu: f64,
    lambda: f64,
}

/// The St. Venant-Kirchhoff solid with Kelvin-Voigt damping.
///
/// For moderate strain at any rotation: it softens in compression and has no resistance left at a stretch of 0.58.
/// (Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd edition 2008, section 6.4.)
pub type SaintVenantKirchhoff = Damped<SaintVenantKirchhoffEnergy>;

pub(super) const MODEL: Model = Model {
    name: "st-venant-kirchhoff",
    doc: "Hooke's law for Green's strain, with Kelvin-Voigt damping: moderate strain, any rotation",
    parameters: &ISOTROPIC,
    build: |v| {
        let [density, young_modulus, poisson_ratio, relaxation_time] = v.isotropic();
        Ok(Arc::new(SaintVenantKirchhoff::new(density, young_modulus, poisson_ratio, relaxation_time)?))
    },
};

impl SaintVenantKirchhoff {
    /// A material from undeformed density rho (kg/m^3), Young's modulus E (Pa), Poisson's ratio nu and relaxation time T (s).
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(
        density: f64,
        young_modulus: f64,
        poisson_ratio: f64,
        relaxation_time: f64,
    ) -> Result<Self, InvalidInput> {
        let small = KelvinVoigt::new(density, young_modulus, poisson_ratio, relaxation_time)?;
        let (mu, lambda) = small.lame();
        Ok(Self { name: MODEL.name, small, law: SaintVenantKirchhoffEnergy { mu, lambda } })
    }
}

impl SaintVenantKirchhoffEnergy {
    /// Hooke's law for a symmetric tensor.
    #[inline(always)]
    fn hooke<T: Real>(&self, e: &Tensor<T>) -> Tensor<T> {
        (*e * (2.0 * self.mu)).plus_diagonal(e.trace() * self.lambda)
    }
}

/// E.
#[inline(always)]
fn green<T: Real>(f: &Tensor<T>) -> Tensor<T> {
    (f.transpose().times(f) * 0.5).plus_number(-0.5)
}

impl Formula for SaintVenantKirchhoffEnergy {
    fn energy(&self, f: &Mat3) -> f64 {
        let e = green(&Tensor::from(f));
        if f.determinant() > 0.0 { 0.5 * self.hooke(&e).dot(&e) } else { f64::INFINITY }
    }

    #[inline(always)]
    fn first_piola<T: Real>(&self, f: &Tensor<T>) -> Tensor<T> {
        f.times(&self.hooke(&green(f)))
    }

    #[inline(always)]
    fn tangent<T: Real>(&self, f: &Tensor<T>, df: &Tensor<T>) -> Tensor<T> {
        let change = f.transpose().times(df).symmetric_part();
        df.times(&self.hooke(&green(f))) + f.times(&self.hooke(&change))
    }
}
