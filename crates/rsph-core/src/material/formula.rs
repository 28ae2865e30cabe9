//! Laws as formulas in numbers of one particle or of several at once.

use super::FiniteStrain;
use crate::tensor::Mat3;
use crate::tensor::lanes::{Real, Tensor, Tensors};
use pulp::{Arch, Simd, WithSimd};
use std::fmt::Debug;

/// A [`FiniteStrain`] law whose stress is a formula in [`Real`] numbers, which vector registers evaluate for several particles.
/// Formulas and all that they call are `#[inline(always)]`.
pub trait Formula: Debug + Send + Sync {
    /// [`FiniteStrain::energy`].
    fn energy(&self, f: &Mat3) -> f64;

    /// [`FiniteStrain::first_piola`].
    fn first_piola<T: Real>(&self, f: &Tensor<T>) -> Tensor<T>;

    /// [`FiniteStrain::tangent`].
    fn tangent<T: Real>(&self, f: &Tensor<T>, df: &Tensor<T>) -> Tensor<T>;

    /// [`FiniteStrain::viscous_piola`].
    fn viscous_piola<T: Real>(&self, f: &Tensor<T>, f_rate: &Tensor<T>) -> Tensor<T>;
}

impl<L: Formula> FiniteStrain for L {
    fn energy(&self, f: &Mat3) -> f64 {
        Formula::energy(self, f)
    }

    fn first_piola(&self, f: &Mat3) -> Mat3 {
        Formula::first_piola(self, &Tensor::from(f)).into()
    }

    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3 {
        Formula::tangent(self, &Tensor::from(f), &Tensor::from(df)).into()
    }

    fn viscous_piola(&self, f: &Mat3, f_rate: &Mat3) -> Mat3 {
        Formula::viscous_piola(self, &Tensor::from(f), &Tensor::from(f_rate)).into()
    }

    fn stresses(&self, _: usize, f: &Tensors, f_rate: Option<&Tensors>, piola: &mut Tensors) {
        Arch::new().dispatch(Stresses { law: self, f, f_rate, piola });
    }

    fn tangents(&self, _: usize, f: &Tensors, df: &Tensors, shares: [f64; 2], change: &mut Tensors) {
        Arch::new().dispatch(Tangents { law: self, f, df, shares, change });
    }
}

struct Stresses<'a, L> {
    law: &'a L,
    f: &'a Tensors,
    f_rate: Option<&'a Tensors>,
    piola: &'a mut Tensors,
}

impl<L: Formula> WithSimd for Stresses<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let f = self.f.load(simd);
        let mut piola = self.law.first_piola(&f);
        if let Some(f_rate) = self.f_rate {
            piola = piola + self.law.viscous_piola(&f, &f_rate.load(simd));
        }
        self.piola.store(&piola);
    }
}

struct Tangents<'a, L> {
    law: &'a L,
    f: &'a Tensors,
    df: &'a Tensors,
    shares: [f64; 2],
    change: &'a mut Tensors,
}

impl<L: Formula> WithSimd for Tangents<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (f, df, [elastic, viscous]) = (self.f.load(simd), self.df.load(simd), self.shares);
        let mut change = self.law.tangent(&f, &df) * elastic;
        if viscous > 0.0 {
            change = change + self.law.viscous_piola(&f, &df) * viscous;
        }
        self.change.store(&change);
    }
}
