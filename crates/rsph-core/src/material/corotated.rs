//! The corotated linear solid with Kelvin-Voigt damping: Hooke's law in axes that turn with the material.

use super::{Damped, Formula, ISOTROPIC, KelvinVoigt, Model};
use crate::error::InvalidInput;
use crate::tensor::Mat3;
use crate::tensor::lanes::{Real, Tensor};
use std::sync::Arc;

/// Iterations for the rotation, which converge quadratically.
const MAX_ITERATIONS: usize = 30;
/// Change of the rotation at which it is found.
const CONVERGED: f64 = 1e-15;

/// W(F) = mu |F - R|^2 + lambda/2 (tr(R^T F) - 3)^2, R the rotation nearest to F; P = 2 mu (F - R) + lambda tr(R^T F - 1) R.
///
/// (Mueller and Gross, Graphics Interface 2004, 239-246; with the exact tangent of McAdams et al., ACM Trans. Graph. 30(4), 2011.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorotatedEnergy {
    mu: f64,
    lambda: f64,
}

/// The corotated linear solid with Kelvin-Voigt damping: Hooke's law for small strain at any rotation.
pub type Corotated = Damped<CorotatedEnergy>;

pub(super) const MODEL: Model = Model {
    name: "corotated",
    doc: "linear elastic solid with Kelvin-Voigt damping that may turn: small strain, any rotation",
    parameters: &ISOTROPIC,
    build: |v| {
        let [density, young_modulus, poisson_ratio, relaxation_time] = v.isotropic();
        Ok(Arc::new(Corotated::new(density, young_modulus, poisson_ratio, relaxation_time)?))
    },
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
        let small = KelvinVoigt::new(density, young_modulus, poisson_ratio, relaxation_time)?;
        let (mu, lambda) = small.lame();
        Ok(Self { name: MODEL.name, small, law: CorotatedEnergy { mu, lambda } })
    }
}

/// The rotation R of the polar decomposition F = R S, det F > 0, by Newton's iteration R <- (R + R^-T)/2.
/// (Higham, SIAM J. Sci. Stat. Comput. 7, 1160, 1986.)
#[inline(always)]
fn rotation<T: Real>(f: &Tensor<T>) -> Tensor<T> {
    let mut r = *f;
    for _ in 0..MAX_ITERATIONS {
        let next = (r + r.inverse_transpose().0) * 0.5;
        let change = (next - r).largest();
        r = next;
        if change.is_nan() || change <= CONVERGED {
            break;
        }
    }
    r
}

/// The rotation nearest to F; none where F turns inside out.
pub(crate) fn rotation_of(f: &Mat3) -> Option<Mat3> {
    (f.determinant() > 0.0).then(|| rotation(&Tensor::from(f)).into())
}

/// Change of the rotation R of F when F changes by dF: R W, where W S + S W = R^T dF - dF^T R.
#[inline(always)]
fn rotation_change<T: Real>(f: &Tensor<T>, r: &Tensor<T>, df: &Tensor<T>) -> Tensor<T> {
    let (s, turned) = (r.transpose().times(f), r.transpose().times(df));
    let spin = turned - turned.transpose();
    let axial = [spin.0[2][1], spin.0[0][2], spin.0[1][0]];
    // (tr S - S) w is the axial vector of W S + S W, w that of W.
    let (inverse, _) = (s * -1.0).plus_diagonal(s.trace()).inverse_transpose();
    let mut w = axial;
    for (w, row) in w.iter_mut().zip(inverse.0) {
        *w = row[0].mul_add(axial[0], row[1].mul_add(axial[1], row[2] * axial[2]));
    }
    let [x, y, z] = w;
    let zero = x * 0.0;
    r.times(&Tensor([[zero, -z, y], [z, zero, -x], [-y, x, zero]]))
}

impl Formula for CorotatedEnergy {
    fn energy(&self, f: &Mat3) -> f64 {
        if f.determinant().is_nan() || f.determinant() <= 0.0 {
            return f64::INFINITY;
        }
        let (Self { mu, lambda }, f) = (*self, Tensor::from(f));
        let r = rotation(&f);
        mu * (f - r).dot(&(f - r)) + 0.5 * lambda * (r.dot(&f) - 3.0).powi(2)
    }

    #[inline(always)]
    fn first_piola<T: Real>(&self, f: &Tensor<T>) -> Tensor<T> {
        let (Self { mu, lambda }, r) = (*self, rotation(f));
        ((*f - r) * (2.0 * mu)).plus((r.dot(f) + -3.0) * lambda, &r)
    }

    #[inline(always)]
    fn tangent<T: Real>(&self, f: &Tensor<T>, df: &Tensor<T>) -> Tensor<T> {
        let (Self { mu, lambda }, r) = (*self, rotation(f));
        let dr = rotation_change(f, &r, df);
        // dR : F = 0, W being antisymmetric and S symmetric.
        ((*df - dr) * (2.0 * mu)).plus(r.dot(df) * lambda, &r).plus((r.dot(f) + -3.0) * lambda, &dr)
    }
}
