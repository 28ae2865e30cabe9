//! The corotated linear solid with Kelvin-Voigt damping: Hooke's law in axes that turn with the material.

use super::damping::{self, inverse_transpose};
use super::{FiniteStrain, ISOTROPIC, KelvinVoigt, Law, Material, Model};
use crate::error::InvalidInput;
use crate::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// Iterations for the rotation, which converge quadratically.
const MAX_ITERATIONS: usize = 30;
/// Change of the rotation at which it is found.
const CONVERGED: f64 = 1e-15;

/// W(F) = mu |F - R|^2 + lambda/2 (tr(R^T F) - 3)^2, R the rotation nearest to F; P = 2 mu (F - R) + lambda tr(R^T F - 1) R.
///
/// Hooke's law for small strain at any rotation. (Mueller and Gross, Graphics Interface 2004, 239-246; with the exact tangent of
/// McAdams et al., ACM Trans. Graph. 30(4), 2011.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corotated {
    small: KelvinVoigt,
}

pub(super) const MODEL: Model = Model {
    name: "corotated",
    doc: "linear elastic solid with Kelvin-Voigt damping that may turn: small strain, any rotation",
    parameters: &ISOTROPIC,
    build: |p| Ok(Arc::new(Corotated::new(p[0], p[1], p[2], p[3])?)),
};

impl Corotated {
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
}

/// The rotation R of the polar decomposition F = R S, det F > 0, by Newton's iteration R <- (R + R^-T)/2.
/// (Higham, SIAM J. Sci. Stat. Comput. 7, 1160, 1986.)
fn rotation(f: &Mat3) -> Mat3 {
    let mut r = *f;
    for _ in 0..MAX_ITERATIONS {
        let next = 0.5 * (r + inverse_transpose(&r).0);
        let change = (next - r).amax();
        r = next;
        if change.is_nan() || change <= CONVERGED {
            break;
        }
    }
    r
}

/// Change of the rotation of `f` with that rotation when F changes by `df`: R W, where W S + S W = R^T dF - dF^T R.
fn rotation_change(f: &Mat3, r: &Mat3, df: &Mat3) -> Mat3 {
    let s = r.transpose() * f;
    let turned = r.transpose() * df;
    let spin = turned - turned.transpose();
    let axial = Vec3::new(spin[(2, 1)], spin[(0, 2)], spin[(1, 0)]);
    let resistance = Mat3::identity() * s.trace() - s;
    let rate = resistance.try_inverse().map_or_else(Vec3::zeros, |inverse| inverse * axial);
    r * rate.cross_matrix()
}

impl Material for Corotated {
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

impl FiniteStrain for Corotated {
    fn energy(&self, f: &Mat3) -> f64 {
        if f.determinant().is_nan() || f.determinant() <= 0.0 {
            return f64::INFINITY;
        }
        let ((mu, lambda), r) = (self.small.lame(), rotation(f));
        mu * (f - r).norm_squared() + 0.5 * lambda * (r.dot(f) - 3.0).powi(2)
    }

    fn first_piola(&self, f: &Mat3) -> Mat3 {
        let ((mu, lambda), r) = (self.small.lame(), rotation(f));
        (f - r) * (2.0 * mu) + r * (lambda * (r.dot(f) - 3.0))
    }

    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3 {
        let ((mu, lambda), r) = (self.small.lame(), rotation(f));
        let dr = rotation_change(f, &r, df);
        // dR : F = 0, W being antisymmetric and S symmetric.
        (df - dr) * (2.0 * mu) + r * (lambda * r.dot(df)) + dr * (lambda * (r.dot(f) - 3.0))
    }

    fn viscous_piola(&self, f: &Mat3, f_rate: &Mat3) -> Mat3 {
        damping::spatial(&self.small, f, f_rate)
    }
}
