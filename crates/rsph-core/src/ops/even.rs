//! The passes of sums without an offset, S = sum w q_b, of fields on a part of the body.

use super::EvenField;
use super::gradient::{Taps, for_each_square_sum};
use super::part::Part;
use super::stencil::Stencil;
use super::sweep::{Line, MAX_SOURCES, Passes, Place, Ring};
use crate::lattice::{MAX_REACH, Weights};
use crate::tiles::{LANES, Tiles};
use pulp::Simd;

/// Sums of `C` components.
#[derive(Clone, Copy, Debug)]
pub struct Even<'a, T, F, const C: usize> {
    /// The offsets.
    pub stencil: T,
    /// Their weights.
    pub weights: &'a Weights,
    /// The particles.
    pub tiles: &'a Tiles,
    /// What they are wanted for.
    pub part: &'a Part,
    /// The field.
    pub field: &'a F,
}

impl<T, F: EvenField<C>, const C: usize> Even<'_, T, F, C> {
    /// Puts `N` lanes of a tile from `first` on to the places from `at` on of the lines.
    #[inline(always)]
    fn put<const N: usize>(&self, tile: usize, first: usize, lines: &mut [Line; MAX_SOURCES], at: usize) {
        let values = self.field.lanes::<N>(tile, first).unwrap_or([[0.0; N]; C]);
        for (Line(line), values) in lines.iter_mut().zip(&values) {
            line[at..at + N].copy_from_slice(values);
        }
    }
}

impl<S: Simd, T: Stencil, F: EvenField<C>, const C: usize> Passes<S> for Even<'_, T, F, C> {
    type Stencil = T;
    const SOURCES: usize = C;
    const GROUPS: usize = C;
    const SUMS: usize = C;
    const ALONG_X: usize = 1;
    const ALONG_Y: usize = 1;

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
        Some(self.part)
    }

    #[inline(always)]
    fn read(&self, _: S, tile: usize, lines: &mut [Line; MAX_SOURCES], place: Place) {
        match place {
            Place::Before => self.put::<MAX_REACH>(tile, LANES - MAX_REACH, lines, LANES - MAX_REACH),
            Place::Middle => self.put::<LANES>(tile, 0, lines, LANES),
            Place::After => self.put::<MAX_REACH>(tile, 0, lines, 2 * LANES),
        }
    }

    #[inline(always)]
    fn along_x(&self, simd: S, lines: &[Line], lane: usize, out: &mut [S::f64s]) {
        for (line, out) in lines.iter().zip(out.chunks_exact_mut(<Self as Passes<S>>::slot_len(self))) {
            let taps = Taps::new(simd, self.stencil, self.weights, line, lane);
            for_each_square_sum(
                self.stencil,
                0,
                #[inline(always)]
                |m| out[m] = taps.even(simd, self.stencil, self.weights, m),
            );
        }
    }

    #[inline(always)]
    fn along_y(&self, simd: S, rows: &Ring<'_, S::f64s>, out: &mut [S::f64s]) {
        let (cut, reach) = (self.stencil.cut(), self.stencil.reach());
        let slot = <Self as Passes<S>>::slot_len(self);
        for (i, out) in out.chunks_exact_mut(reach + 1).enumerate() {
            let mut sum = [simd.splat_f64s(0.0); MAX_REACH + 1];
            self.stencil.for_each_offset(
                #[inline(always)]
                |j| {
                    let Some(row) = rows.get(j) else { return };
                    let row = &row[i * slot..(i + 1) * slot];
                    self.stencil.for_each_distance(
                        #[inline(always)]
                        |k| {
                            let m = (j * j) as usize + k * k;
                            if m <= cut {
                                sum[k] = simd.add_f64s(row[m], sum[k]);
                            }
                        },
                    );
                },
            );
            out.copy_from_slice(&sum[..=reach]);
        }
    }

    #[inline(always)]
    fn along_z(&self, simd: S, planes: &Ring<'_, S::f64s>, out: &mut [S::f64s]) {
        let kept = self.stencil.reach() + 1;
        self.stencil.for_each_offset(
            #[inline(always)]
            |k| {
                let Some(plane) = planes.get(k) else { return };
                for (i, out) in out.iter_mut().enumerate() {
                    *out = simd.add_f64s(plane[i * kept + k.unsigned_abs()], *out);
                }
            },
        );
    }
}
