//! Kelvin-Voigt damping for any deformation.

use super::{KelvinVoigt, Material};
use crate::tensor::lanes::{Real, Tensor, Tensors};
use pulp::{Arch, Simd, WithSimd};

/// First Piola-Kirchhoff stress of the damping that acts on the rate of strain in space, d = sym(grad v): its Kirchhoff stress
/// is J sigma_v = T (2 mu d + lambda tr d I), the viscous part of Eq. (5) per undeformed volume.
///
/// It does not feel rotations, and its power T (2 mu d:d + lambda (tr d)^2) is never negative for nu >= 0.
#[inline(always)]
pub(super) fn spatial<T: Real>(solid: &KelvinVoigt, f: &Tensor<T>, f_rate: &Tensor<T>) -> Tensor<T> {
    let (inverse_transpose, _) = f.inverse_transpose();
    // grad v = (dF/dt) F^-1; P = J sigma_v F^-T.
    let d = f_rate.times(&inverse_transpose.transpose()).symmetric_part();
    let ((mu, lambda), time) = (solid.lame(), solid.relaxation_time());
    (d * (2.0 * mu * time)).plus_diagonal(d.trace() * (lambda * time)).times(&inverse_transpose)
}

/// Adds `share` of [`spatial`] to the stress of several particles.
pub(super) fn add(solid: &KelvinVoigt, f: &Tensors, f_rate: &Tensors, share: f64, piola: &mut Tensors) {
    Arch::new().dispatch(Added { solid, f, f_rate, share, piola });
}

struct Added<'a> {
    solid: &'a KelvinVoigt,
    f: &'a Tensors,
    f_rate: &'a Tensors,
    share: f64,
    piola: &'a mut Tensors,
}

impl WithSimd for Added<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let damping = spatial(self.solid, &self.f.load(simd), &self.f_rate.load(simd));
        let sum = self.piola.load(simd) + damping * self.share;
        self.piola.store(&sum);
    }
}
