//! The St. Venant-Kirchhoff solid with Kelvin-Voigt damping: Hooke's law between Green's strain and the second Piola-Kirchhoff
//! stress.

use super::{Formula, ISOTROPIC, KelvinVoigt, Law, Material, Model, damping};
use crate::error::InvalidInput;
use crate::tensor::Mat3;
use crate::tensor::lanes::{Real, Tensor};
use std::sync::Arc;

/// W(F) = lambda/2 (tr E)^2 + mu E:E with Green's strain E = (F^T F - 1)/2; P = F (lambda tr E 1 + 2 mu E).
///
/// For moderate strain at any rotation: it softens in compression and has no resistance left at a stretch of 0.58.
/// (Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd edition 2008, section 6.4.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SaintVenantKirchhoff {
    small: KelvinVoigt,
}

pub(super) const MODEL: Model = Model {
    name: "st-venant-kirchhoff",
    doc: "Hooke's law for Green's strain, with Kelvin-Voigt damping: moderate strain, any rotation",
    parameters: &ISOTROPIC,
    build: |p| Ok(Arc::new(SaintVenantKirchhoff::new(p[0], p[1], p[2], p[3])?)),
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
        Ok(Self { small: KelvinVoigt::new(density, young_modulus, poisson_ratio, relaxation_time)? })
    }

    /// Hooke's law for a symmetric tensor.
    #[inline(always)]
    fn hooke<T: Real>(&self, e: &Tensor<T>) -> Tensor<T> {
        let (mu, lambda) = self.small.lame();
        (*e * (2.0 * mu)).plus_diagonal(e.trace() * lambda)
    }
}

/// E.
#[inline(always)]
fn green<T: Real>(f: &Tensor<T>) -> Tensor<T> {
    (f.transpose().times(f) * 0.5).plus_number(-0.5)
}

impl Material for SaintVenantKirchhoff {
    fn name(&self) -> &'static str {
        MODEL.name
    }

    fn density(&self) -> f64 {
        self.small.density()
    }

    fn relaxation_time(&self) -> f64 {
        self.small.relaxation_time()
    }

    fn law(&self) -> Law<'_> {
        Law::FiniteStrain(self)
    }
}

impl Formula for SaintVenantKirchhoff {
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

    #[inline(always)]
    fn viscous_piola<T: Real>(&self, f: &Tensor<T>, f_rate: &Tensor<T>) -> Tensor<T> {
        damping::spatial(&self.small, f, f_rate)
    }
}
