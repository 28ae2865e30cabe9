//! The passes of the gradient sums H = sum w q_b (x) X and Q = sum w q_b.

use super::part::Part;
use super::stencil::Stencil;
use super::sweep::{Line, MAX_SOURCES, Passes, Place, Ring, copy_components};
use super::{PAIR_COMPONENTS, load};
use crate::lattice::{MAX_REACH, Weights};
use crate::tiles::{LANES, Tile, Tiles};
use pulp::Simd;

/// Gradient sums of a field of three components.
#[derive(Clone, Copy, Debug)]
pub struct Gradient<'a, T> {
    /// The offsets.
    pub stencil: T,
    /// Their weights.
    pub weights: &'a Weights,
    /// The particles.
    pub tiles: &'a Tiles,
    /// Where they are wanted; `None`: everywhere.
    pub part: Option<&'a Part>,
    /// The field.
    pub q: &'a [Tile],
}

/// What the pass along y keeps of a component for each |k|: sum, sum times Y, sum times X.
const KEPT: usize = 3;

impl<S: Simd, T: Stencil> Passes<S> for Gradient<'_, T> {
    type Stencil = T;
    const SOURCES: usize = 3;
    const GROUPS: usize = 3;
    const SUMS: usize = PAIR_COMPONENTS;
    const ALONG_X: usize = 2;
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
        copy_components(&self.q[3 * tile..][..3], lines, place);
    }

    #[inline(always)]
    fn along_x(&self, simd: S, lines: &[Line], lane: usize, out: &mut [S::f64s]) {
        for (line, out) in lines.iter().zip(out.chunks_exact_mut(<Self as Passes<S>>::slot_len(self))) {
            let taps = Taps::new(simd, self.stencil, self.weights, line, lane);
            for_each_square_sum(
                self.stencil,
                0,
                #[inline(always)]
                |m| {
                    out[2 * m] = taps.even(simd, self.stencil, self.weights, m);
                    if m < self.stencil.cut() {
                        out[2 * m + 1] = taps.odd(simd, self.stencil, self.weights, m);
                    }
                },
            );
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
                            let [plain, along_y, along_x] = &mut sum[k];
                            let m = (j * j) as usize + k * k;
                            if m <= cut {
                                *plain = simd.add_f64s(row[2 * m], *plain);
                                *along_y = simd.mul_add_e_f64s(y, row[2 * m], *along_y);
                            }
                            if m < cut {
                                *along_x = simd.add_f64s(row[2 * m + 1], *along_x);
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
        let (cut, reach) = (self.stencil.cut(), self.stencil.reach());
        let kept = KEPT * (reach + 1);
        self.stencil.for_each_offset(
            #[inline(always)]
            |k| {
                let Some(plane) = planes.get(k) else { return };
                let first = KEPT * k.unsigned_abs();
                let z = simd.splat_f64s(k as f64 * self.weights.spacing);
                for i in 0..3 {
                    let plane = &plane[i * kept..(i + 1) * kept][first..first + KEPT];
                    if ((k * k) as usize) < cut {
                        out[3 * i] = simd.add_f64s(plane[2], out[3 * i]);
                        out[3 * i + 1] = simd.add_f64s(plane[1], out[3 * i + 1]);
                    }
                    out[3 * i + 2] = simd.mul_add_e_f64s(z, plane[0], out[3 * i + 2]);
                    out[9 + i] = simd.add_f64s(plane[0], out[9 + i]);
                }
            },
        );
    }
}

/// Values of a row at +i and -i, added and subtracted.
#[derive(Clone, Copy, Debug)]
pub struct Taps<S: Simd> {
    center: S::f64s,
    sum: [S::f64s; MAX_REACH + 1],
    /// Difference times X.
    difference: [S::f64s; MAX_REACH + 1],
}

impl<S: Simd> Taps<S> {
    /// Of the lanes from `lane` on of the tile in the middle of `line`.
    #[inline(always)]
    pub fn new<T: Stencil>(simd: S, stencil: T, weights: &Weights, line: &Line, lane: usize) -> Self {
        let at = LANES + lane;
        let line = &line.0;
        let center = load(simd, line, at);
        let (mut sum, mut difference) = ([center; MAX_REACH + 1], [center; MAX_REACH + 1]);
        for i in 1..=stencil.reach() {
            let (after, before) = (load(simd, line, at + i), load(simd, line, at - i));
            sum[i] = simd.add_f64s(after, before);
            let x = simd.splat_f64s(i as f64 * weights.spacing);
            difference[i] = simd.mul_f64s(x, simd.sub_f64s(after, before));
        }
        Self { center, sum, difference }
    }

    /// Sum over the row at j^2 + k^2 = m of w q.
    #[inline(always)]
    pub fn even<T: Stencil>(&self, simd: S, stencil: T, weights: &Weights, m: usize) -> S::f64s {
        let mut sum = simd.mul_f64s(simd.splat_f64s(weights.by_square[m]), self.center);
        for i in 1..=stencil.reach() {
            if m + i * i <= stencil.cut() {
                sum = simd.mul_add_e_f64s(simd.splat_f64s(weights.by_square[m + i * i]), self.sum[i], sum);
            }
        }
        sum
    }

    /// Sum over the row at j^2 + k^2 = m of w q X; m lies below the cut.
    #[inline(always)]
    pub fn odd<T: Stencil>(&self, simd: S, stencil: T, weights: &Weights, m: usize) -> S::f64s {
        let mut sum = simd.mul_f64s(simd.splat_f64s(weights.by_square[m + 1]), self.difference[1]);
        for i in 2..=stencil.reach() {
            if m + i * i <= stencil.cut() {
                let w = simd.splat_f64s(weights.by_square[m + i * i]);
                sum = simd.mul_add_e_f64s(w, self.difference[i], sum);
            }
        }
        sum
    }
}

/// Visits every j^2 + k^2 >= `least` within the cut.
#[inline(always)]
pub fn for_each_square_sum<T: Stencil>(stencil: T, least: usize, mut visit: impl FnMut(usize)) {
    stencil.for_each_distance(
        #[inline(always)]
        |j| {
            stencil.for_each_distance(
                #[inline(always)]
                |k| {
                    let m = j * j + k * k;
                    if k <= j && m >= least && m <= stencil.cut() {
                        visit(m);
                    }
                },
            );
        },
    );
}
