//! Energies at any strain, with the stress and the tangent that follow from them.

use crate::tensor::lanes::{Real, Tensor, Tensors};
use crate::tensor::{Mat3, Vec3};
use pulp::{Arch, Simd, WithSimd};
use std::fmt::Debug;

/// A solid's energy as a function of the deformation gradient F = dx/dX. Plane strain is F with F_zz = 1 and no other z component.
///
/// A law that is a formula in the components of F implements [`Formula`] instead, and vector registers evaluate it for several
/// particles at once.
pub trait Hyperelastic: Debug + Send + Sync {
    /// Energy W(F) per undeformed volume (J/m^3); infinite where det F <= 0.
    fn energy(&self, f: &Mat3) -> f64;

    /// First Piola-Kirchhoff stress P = dW/dF (Pa): force per undeformed area. Meaningless where det F <= 0.
    fn first_piola(&self, f: &Mat3) -> Mat3;

    /// Change of P when F changes by `df`: (d2W/dF2) dF.
    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3;

    /// Direction of its fibres, a unit vector; `None` if it has none.
    fn fibre(&self) -> Option<Vec3> {
        None
    }

    /// P of the first `count` particles.
    fn stresses(&self, count: usize, f: &Tensors, piola: &mut Tensors) {
        for lane in 0..count {
            piola.set(lane, &self.first_piola(&f.get(lane)));
        }
    }

    /// Change of P, times `share`, of the first `count` particles.
    fn tangents(&self, count: usize, f: &Tensors, df: &Tensors, share: f64, change: &mut Tensors) {
        for lane in 0..count {
            change.set(lane, &(self.tangent(&f.get(lane), &df.get(lane)) * share));
        }
    }
}

/// A [`Hyperelastic`] law whose stress is a formula in [`Real`] numbers. Formulas and all that they call are `#[inline(always)]`.
pub trait Formula: Debug + Send + Sync {
    /// [`Hyperelastic::energy`].
    fn energy(&self, f: &Mat3) -> f64;

    /// [`Hyperelastic::first_piola`].
    fn first_piola<T: Real>(&self, f: &Tensor<T>) -> Tensor<T>;

    /// [`Hyperelastic::tangent`].
    fn tangent<T: Real>(&self, f: &Tensor<T>, df: &Tensor<T>) -> Tensor<T>;

    /// [`Hyperelastic::fibre`].
    fn fibre(&self) -> Option<Vec3> {
        None
    }
}

impl<L: Formula> Hyperelastic for L {
    fn energy(&self, f: &Mat3) -> f64 {
        Formula::energy(self, f)
    }

    fn first_piola(&self, f: &Mat3) -> Mat3 {
        Formula::first_piola(self, &Tensor::from(f)).into()
    }

    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3 {
        Formula::tangent(self, &Tensor::from(f), &Tensor::from(df)).into()
    }

    fn fibre(&self) -> Option<Vec3> {
        Formula::fibre(self)
    }

    fn stresses(&self, _: usize, f: &Tensors, piola: &mut Tensors) {
        Arch::new().dispatch(Stresses { law: self, f, piola });
    }

    fn tangents(&self, _: usize, f: &Tensors, df: &Tensors, share: f64, change: &mut Tensors) {
        Arch::new().dispatch(Tangents { law: self, f, df, share, change });
    }
}

struct Stresses<'a, L> {
    law: &'a L,
    f: &'a Tensors,
    piola: &'a mut Tensors,
}

impl<L: Formula> WithSimd for Stresses<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.piola.store(&self.law.first_piola(&self.f.load(simd)));
    }
}

struct Tangents<'a, L> {
    law: &'a L,
    f: &'a Tensors,
    df: &'a Tensors,
    share: f64,
    change: &'a mut Tensors,
}

impl<L: Formula> WithSimd for Tangents<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (f, df) = (self.f.load(simd), self.df.load(simd));
        self.change.store(&(self.law.tangent(&f, &df) * self.share));
    }
}
