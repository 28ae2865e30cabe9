//! Laws in the invariants of the part of a deformation that keeps the volume.

use super::{Damped, Formula, KelvinVoigt};
use crate::tensor::Mat3;
use crate::tensor::lanes::{Real, Tensor};
use std::fmt::Debug;

/// The isochoric part w of an energy, as a function of I1 = J^-2/3 tr C and I2 = J^-4/3 ((tr C)^2 - tr C^2)/2, C = F^T F.
/// Its functions are `#[inline(always)]`.
pub trait Invariants: Debug + Send + Sync {
    /// w (J/m^3), zero at I1 = I2 = 3.
    fn energy(&self, i1: f64, i2: f64) -> f64;
    /// dw/dI1 and dw/dI2.
    fn slopes<T: Real>(&self, i1: T, i2: T) -> [T; 2];
    /// d2w/dI1^2; w is linear in I2 and has no mixed term.
    fn curvature<T: Real>(&self, i1: T) -> T;
}

/// W(F) = w(I1, I2) + K/2 (ln J)^2, with the bulk modulus K.
///
/// (G. A. Holzapfel, Nonlinear Solid Mechanics, 2000, chapter 6; the volumetric part is that of FEBio.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Isochoric<L> {
    /// w.
    pub(super) invariants: L,
    /// K (Pa).
    pub(super) bulk_modulus: f64,
}

impl<L> Isochoric<L> {
    /// The material of that name, which is the solid `small` at small strain.
    pub(super) fn damped(name: &'static str, small: KelvinVoigt, invariants: L) -> Damped<Self> {
        let bulk_modulus = small.bulk_modulus();
        Damped { name, small, law: Self { invariants, bulk_modulus } }
    }
}

/// What the invariants of F and their changes are made of.
struct Kinematics<T> {
    /// F^-T.
    inverse_transpose: Tensor<T>,
    /// C = F^T F, and F C.
    c: Tensor<T>,
    fc: Tensor<T>,
    ln_j: T,
    /// J^-2/3.
    scale: T,
    /// I1 and I2 with the change of volume in them.
    raw: [T; 2],
    /// I1 and I2.
    invariants: [T; 2],
    /// dI1/dF and dI2/dF.
    slopes: [Tensor<T>; 2],
}

impl<T: Real> Kinematics<T> {
    #[inline(always)]
    fn new(f: &Tensor<T>) -> Self {
        let (inverse_transpose, j) = f.inverse_transpose();
        let ln_j = j.ln();
        let scale = (ln_j * (-2.0 / 3.0)).exp();
        let c = f.transpose().times(f);
        let (trace, fc) = (c.trace(), f.times(&c));
        let second = (trace * trace - c.dot(&c)) * 0.5;
        let squared = scale * scale;
        let first_slope = (*f * 2.0).plus(trace * (-2.0 / 3.0), &inverse_transpose).scaled(scale);
        let second_slope = (f.scaled(trace) - fc)
            .scaled(squared * 2.0)
            .plus(squared * second * (-4.0 / 3.0), &inverse_transpose);
        Self {
            inverse_transpose,
            c,
            fc,
            ln_j,
            scale,
            raw: [trace, second],
            invariants: [trace * scale, second * squared],
            slopes: [first_slope, second_slope],
        }
    }
}

impl<L: Invariants> Formula for Isochoric<L> {
    fn energy(&self, f: &Mat3) -> f64 {
        if f.determinant().is_nan() || f.determinant() <= 0.0 {
            return f64::INFINITY;
        }
        let k = Kinematics::new(&Tensor::from(f));
        self.invariants.energy(k.invariants[0], k.invariants[1]) + 0.5 * self.bulk_modulus * k.ln_j * k.ln_j
    }

    #[inline(always)]
    fn first_piola<T: Real>(&self, f: &Tensor<T>) -> Tensor<T> {
        let k = Kinematics::new(f);
        let [w1, w2] = self.invariants.slopes(k.invariants[0], k.invariants[1]);
        k.slopes[0].scaled(w1).plus(w2, &k.slopes[1]).plus(k.ln_j * self.bulk_modulus, &k.inverse_transpose)
    }

    #[inline(always)]
    fn tangent<T: Real>(&self, f: &Tensor<T>, df: &Tensor<T>) -> Tensor<T> {
        let k = Kinematics::new(f);
        let [w1, w2] = self.invariants.slopes(k.invariants[0], k.invariants[1]);
        let w11 = self.invariants.curvature(k.invariants[0]);
        let g = &k.inverse_transpose;
        // dg = -t, d(ln J) = s.
        let (t, s) = (g.times(&df.transpose()).times(g), g.dot(df));
        let ([trace, second], squared) = (k.raw, k.scale * k.scale);
        let first = df.dot(f) * 2.0;
        let change_of_first = (*df * 2.0)
            .plus(first * (-2.0 / 3.0), g)
            .plus(trace * (2.0 / 3.0), &t)
            .scaled(k.scale)
            .plus(s * (-2.0 / 3.0), &k.slopes[0]);
        let dc = f.transpose().times(df);
        let dc = dc + dc.transpose();
        let raw_slope = (f.scaled(trace) - k.fc) * 2.0;
        let change_of_second = (f.scaled(first) + df.scaled(trace) - df.times(&k.c) - f.times(&dc))
            .scaled(squared * 2.0)
            .plus(squared * raw_slope.dot(df) * (-4.0 / 3.0), g)
            .plus(squared * second * (4.0 / 3.0), &t)
            .plus(s * (-4.0 / 3.0), &k.slopes[1]);
        k.slopes[0]
            .scaled(w11 * k.slopes[0].dot(df))
            .plus(w1, &change_of_first)
            .plus(w2, &change_of_second)
            .plus(s * self.bulk_modulus, g)
            .plus(k.ln_j * -self.bulk_modulus, &t)
    }
}
