//! The passes of the adjoint sums sum w T_b X.

use super::PAIR_COMPONENTS;
use super::gradient::{Taps, for_each_square_sum};
use super::part::Part;
use super::stencil::Stencil;
use super::sweep::{Line, MAX_SOURCES, Passes, Place, Ring, copy_components};
use crate::lattice::{MAX_REACH, Weights};
use crate::tiles::{Tile, Tiles};
use pulp::Simd;

/// Adjoint sums of a field of matrices.
#[derive(Clone, Copy, Debug)]
pub struct Adjoint<'a, T> {
    /// The offsets.
    pub stencil: T,
    /// Their weights.
    pub weights: &'a Weights,
    /// The particles.
    pub tiles: &'a Tiles,
    /// Where they are wanted; `None`: everywhere.
    pub part: Option<&'a Part>,
    /// The field.
    pub t: &'a [Tile],
}

/// Sums along x for each m: of T_ix times X, of T_iy and of T_iz.
const ALONG_X: usize = 3;
/// What the pass along y keeps of a component for each |k|: what is complete, and what Z is still to be
/// multiplied with.
const KEPT: usize = 2;

impl<S: Simd, T: Stencil> Passes<S> for Adjoint<'_, T> {
    type Stencil = T;
    const SOURCES: usize = 9;
    const GROUPS: usize = 3;
    const SUMS: usize = 3;
    const ALONG_X: usize = ALONG_X;
    const ALONG_Y: usize = KEPT;

    #[inline(always)]
    fn stencil(&self) -> T {
        self.stencil
    }

    #[inline(always)]
    fn tiles(&self) -> &Tiles {
        self.tiles
    }

    #[inline(always)]
    fn part(&self) -> Option<&Part> {
        self.part
    }

    #[inline(always)]
    fn read(&self, _: S, tile: usize, lines: &mut [Line; MAX_SOURCES], place: Place) {
        copy_components(&self.t[PAIR_COMPONENTS * tile..][..9], lines, place);
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
                    let Some(row) = rows.get(j) else { return };
                    let row = &row[i * slot..(i + 1) * slot];
                    let y = simd.splat_f64s(j as f64 * self.weights.spacing);
                    self.stencil.for_each_distance(
                        #[inline(always)]
                        |k| {
                            let [complete, along_z] = &mut sum[k];
                            let m = (j * j) as usize + k * k;
                            if m < cut {
                                *complete = simd.add_f64s(row[ALONG_X * m], *complete);
                            }
                            if j != 0 && m <= cut {
                                *complete = simd.mul_add_e_f64s(y, row[ALONG_X * m + 1], *complete);
                            }
                            if k != 0 && m <= cut {
                                *along_z = simd.add_f64s(row[ALONG_X * m + 2], *along_z);
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
                let Some(plane) = planes.get(k) else { return };
                let first = KEPT * k.unsigned_abs();
                let z = simd.splat_f64s(k as f64 * self.weights.spacing);
                for i in 0..3 {
                    let plane = &plane[i * kept..(i + 1) * kept][first..first + KEPT];
                    out[i] = simd.add_f64s(plane[0], out[i]);
                    if k != 0 {
                        out[i] = simd.mul_add_e_f64s(z, plane[1], out[i]);
                    }
                }
            },
        );
    }
}
