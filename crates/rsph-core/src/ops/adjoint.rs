//! The passes of the adjoint sums sum w T_b X.

use super::PAIR_COMPONENTS;
use super::fold::Signs;
use super::gradient::{Taps, for_each_square_sum};
use super::stencil::Stencil;
use super::sweep::{Line, Passes, Ring};
use crate::lattice::{MAX_REACH, Weights};
use pulp::Simd;

/// Adjoint sums of a field of matrices.
#[derive(Clone, Copy, Debug)]
pub struct Adjoint<'a, T> {
    /// The offsets.
    pub stencil: T,
    /// Their weights.
    pub weights: &'a Weights,
    /// Signs of mirrored components; T_ij changes sign once more where j is the normal of the mirror.
    pub signs: Signs,
}

/// Sums along x for each m: of T_ix times X, of T_iy and of T_iz.
const ALONG_X: usize = 3;
/// What the pass along y keeps of a component for each |k|: what is complete, and what Z is still to be
/// multiplied with.
const KEPT: usize = 2;

impl<S: Simd, T: Stencil> Passes<S> for Adjoint<'_, T> {
    type Stencil = T;
    const SOURCE: (usize, usize) = (PAIR_COMPONENTS, 9);
    const SUMS: usize = 3;
    const ALONG_X: usize = ALONG_X;
    const ALONG_Y: usize = KEPT;

    #[inline(always)]
    fn stencil(&self) -> T {
        self.stencil
    }

    #[inline(always)]
    fn source_sign(sign: &[f64; 3], component: usize) -> f64 {
        let sign = sign[component / 3];
        if component.is_multiple_of(3) { -sign } else { sign }
    }

    #[inline(always)]
    fn along_x(&self, simd: S, lines: &[Line], lane: usize, out: &mut [S::f64s]) {
        let (stencil, weights) = (self.stencil, self.weights);
        for (lines, out) in
            lines.chunks_exact(3).zip(out.chunks_exact_mut(<Self as Passes<S>>::slot_len(self)))
        {
            let taps = Taps::new(simd, stencil, weights, &lines[0], lane);
            for_each_square_sum(
                stencil,
                0,
                #[inline(always)]
                |m| {
                    if m < stencil.cut() {
                        out[ALONG_X * m] = taps.odd(simd, stencil, weights, m);
                    }
                },
            );
            for c in 1..3 {
                let taps = Taps::new(simd, stencil, weights, &lines[c], lane);
                for_each_square_sum(
                    stencil,
                    1,
                    #[inline(always)]
                    |m| {
                        out[ALONG_X * m + c] = taps.even(simd, stencil, weights, m);
                    },
                );
            }
        }
    }

    #[inline(always)]
    fn along_y(&self, simd: S, rows: &Ring<'_, S::f64s>, out: &mut [S::f64s]) {
        let (cut, reach) = (self.stencil.cut(), self.stencil.reach());
        let slot = <Self as Passes<S>>::slot_len(self);
        for (i, out) in out.chunks_exact_mut(KEPT * (reach + 1)).enumerate() {
            let mut sum = [[simd.splat_f64s(0.0); KEPT]; MAX_REACH + 1];
            self.stencil.for_each_offset(
                #[inline(always)]
                |j| {
                    let Some((row, fold)) = rows.get(j) else { return };
                    let row = &row[i * slot..(i + 1) * slot];
                    let sign = self.signs[fold][i];
                    let normal = if fold == 0 { sign } else { -sign };
                    let y = simd.splat_f64s(normal * (j as f64 * self.weights.spacing));
                    let sign = simd.splat_f64s(sign);
                    self.stencil.for_each_distance(
                        #[inline(always)]
                        |k| {
                            let [complete, along_z] = &mut sum[k];
                            let m = (j * j) as usize + k * k;
                            if m < cut {
                                *complete = simd.mul_add_e_f64s(sign, row[ALONG_X * m], *complete);
                            }
                            if j != 0 && m <= cut {
                                *complete = simd.mul_add_e_f64s(y, row[ALONG_X * m + 1], *complete);
                            }
                            if k != 0 && m <= cut {
                                *along_z = simd.mul_add_e_f64s(sign, row[ALONG_X * m + 2], *along_z);
                            }
                        },
                    );
                },
            );
            for (out, sum) in out.chunks_exact_mut(KEPT).zip(sum) {
                out.copy_from_slice(&sum);
            }
        }
    }

    #[inline(always)]
    fn along_z(&self, simd: S, planes: &Ring<'_, S::f64s>, out: &mut [S::f64s]) {
        let reach = self.stencil.reach();
        let kept = KEPT * (reach + 1);
        self.stencil.for_each_offset(
            #[inline(always)]
            |k| {
                let Some((plane, fold)) = planes.get(k) else { return };
                let first = KEPT * k.unsigned_abs();
                for i in 0..3 {
                    let plane = &plane[i * kept..(i + 1) * kept][first..first + KEPT];
                    let sign = self.signs[fold][i];
                    let normal = if fold == 0 { sign } else { -sign };
                    let z = simd.splat_f64s(normal * (k as f64 * self.weights.spacing));
                    out[i] = simd.mul_add_e_f64s(simd.splat_f64s(sign), plane[0], out[i]);
                    if k != 0 {
                        out[i] = simd.mul_add_e_f64s(z, plane[1], out[i]);
                    }
                }
            },
        );
    }
}
