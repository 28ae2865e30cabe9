//! The walk of a kernel sum over a column of tiles.
//!
//! The weight of an offset (i, j, k) depends on i^2 + j^2 + k^2 only. So the sums along x are the same for
//! all rows at the same j^2 + k^2, and those sums, added along y, the same for all planes at the same
//! k^2: three short passes, along x, y and z, take the place of one over all offsets (123 at
//! h = 1.25 dx). What the passes along x and y leave is kept in rings, as far as the next pass reaches.

use super::fold::Folds;
use super::stencil::Stencil;
use crate::lattice::MAX_REACH;
use crate::tiles::{LANES, Tile, Tiles};
use pulp::Simd;
use std::cell::RefCell;
use std::ops::Range;

/// A tile between its neighbours along x.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Line(pub [f64; 3 * LANES]);

/// Most components that a pass reads, and results of a particle.
const MAX_SOURCES: usize = 9;
const MAX_SUMS: usize = 12;

/// What a kernel sum does in each of the three passes.
pub trait Passes<S: Simd>: Sync {
    /// Its offsets.
    type Stencil: Stencil;

    /// Components of the source field, and how many of them are read.
    const SOURCE: (usize, usize);

    /// Results of a particle.
    const SUMS: usize;

    /// Values that the pass along x leaves of a component of the results for each m = j^2 + k^2.
    const ALONG_X: usize;

    /// Values that the pass along y leaves of a component of the results for each |k|.
    const ALONG_Y: usize;

    /// Its offsets.
    fn stencil(&self) -> Self::Stencil;

    /// Values that the pass along x leaves of a component.
    #[inline(always)]
    fn slot_len(&self) -> usize {
        Self::ALONG_X * (self.stencil().cut() + 1)
    }

    /// Values that the pass along x leaves.
    #[inline(always)]
    fn along_x_len(&self) -> usize {
        3 * self.slot_len()
    }

    /// Values that the pass along y leaves.
    #[inline(always)]
    fn along_y_len(&self) -> usize {
        3 * Self::ALONG_Y * (self.stencil().reach() + 1)
    }

    /// Sign of a source component whose image is taken at a plane normal to x that mirrors vectors with
    /// `sign`.
    fn source_sign(sign: &[f64; 3], component: usize) -> f64;

    /// Sums along x of the lanes from `lane` on of all source components.
    fn along_x(&self, simd: S, lines: &[Line], lane: usize, out: &mut [S::f64s]);

    /// Sums along y of what the pass along x left in the rows around.
    fn along_y(&self, simd: S, rows: &Ring<'_, S::f64s>, out: &mut [S::f64s]);

    /// Sums along z of what the pass along y left in the planes around.
    fn along_z(&self, simd: S, planes: &Ring<'_, S::f64s>, out: &mut [S::f64s]);
}

/// What a pass left in the rows or planes around a place.
#[derive(Debug)]
pub struct Ring<'a, V> {
    values: &'a [V],
    /// Values of a slot.
    len: usize,
    slots: Slots,
    /// Rows or planes that are all zero, a bit each, the one `reach` before the center first.
    empty: u32,
    reach: isize,
}

/// Where the rows or planes around a place stand in a ring, and the number of the fold between.
type Slots = [(usize, usize); 2 * MAX_REACH + 1];

impl<V> Ring<'_, V> {
    /// Values `d` rows or planes away and the number of the fold that they are mirrored at, if they are
    /// not all zero.
    #[inline(always)]
    pub fn get(&self, d: isize) -> Option<(&[V], usize)> {
        let at = (d + self.reach) as usize;
        if self.empty >> at & 1 == 1 {
            return None;
        }
        let (first, fold) = self.slots[at];
        Some((&self.values[first..first + self.len], fold))
    }
}

thread_local! {
    /// The rings; they grow to what the largest body needs.
    static SCRATCH: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
}

/// A field that a kernel sum reads.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// Where the particles are.
    pub tiles: &'a Tiles,
    /// Mirror planes.
    pub folds: &'a Folds,
    /// The values.
    pub field: &'a [Tile],
}

/// Runs `passes` for the tiles of `column` in `planes` and hands what comes out to
/// `finish(tile, first lane, sums)`.
#[inline(always)]
pub fn sweep<S: Simd, P: Passes<S>>(
    simd: S,
    passes: &P,
    source: Source<'_>,
    column: usize,
    planes: Range<usize>,
    finish: impl FnMut(usize, usize, &mut [S::f64s; MAX_SUMS]),
) {
    let reach = passes.stencil().reach();
    let (ring_y, ring_z) = (ring(reach), 2 * reach + 1);
    let values = ring_y * passes.along_x_len() + ring_z * source.tiles.rows * passes.along_y_len();
    // Taken out rather than borrowed: a closure would not inherit the instruction set.
    let mut scratch = SCRATCH.take();
    let len = values * S::F64_LANES;
    if scratch.len() < len + LANES {
        scratch.resize(len + LANES, 0.0);
    }
    let start = scratch.as_ptr().align_offset(size_of::<Tile>()).min(LANES);
    let rings = S::as_mut_simd_f64s(&mut scratch[start..start + len]).0;
    let (along_x, along_y) = rings.split_at_mut(ring_y * passes.along_x_len());
    Walk { simd, passes, source, column, planes }.run(along_x, along_y, finish);
    SCRATCH.set(scratch);
}

/// Rows that the ring along y holds.
#[inline(always)]
fn ring(reach: usize) -> usize {
    (2 * reach + 1).next_power_of_two()
}

struct Walk<'a, S: Simd, P: Passes<S>> {
    simd: S,
    passes: &'a P,
    source: Source<'a>,
    column: usize,
    planes: Range<usize>,
}

impl<S: Simd, P: Passes<S>> Walk<'_, S, P> {
    #[inline(always)]
    fn run(
        &self,
        along_x: &mut [S::f64s],
        along_y: &mut [S::f64s],
        mut finish: impl FnMut(usize, usize, &mut [S::f64s; MAX_SUMS]),
    ) {
        let (simd, passes, rows) = (self.simd, self.passes, self.source.tiles.rows);
        let reach = passes.stencil().reach() as isize;
        let ring_z = 2 * reach + 1;
        let (start, end) = (self.planes.start as isize, self.planes.end as isize);
        let plane_len = rows * passes.along_y_len();
        let mut lines = [[Line([0.0; 3 * LANES]); MAX_SOURCES]; 2];
        for lane in (0..LANES).step_by(S::F64_LANES) {
            // Rows of every plane of the ring that are not all zero.
            let mut kept: [Range<isize>; 2 * MAX_REACH + 1] = std::array::from_fn(|_| 0..0);
            for z in start - reach..end + reach {
                let at = z.rem_euclid(ring_z) as usize;
                let plane = &mut along_y[at * plane_len..(at + 1) * plane_len];
                kept[at] = self.plane((z, lane), &mut lines, along_x, plane);
                let target = z - reach;
                if target < start {
                    continue;
                }
                let mut slots = Slots::default();
                let mut rows_of = [(0, 0); 2 * MAX_REACH + 1];
                for k in -reach..=reach {
                    let (source, fold) = self.source.folds.source(2, target + k);
                    let at = source.rem_euclid(ring_z) as usize;
                    let around = (target - reach..=target + reach).contains(&source);
                    rows_of[(k + reach) as usize] =
                        if around { (kept[at].start, kept[at].end) } else { (0, 0) };
                    slots[(k + reach) as usize] = (at * plane_len, fold);
                }
                for y in self.source.tiles.occupied(self.column, target) {
                    let mut planes = Ring {
                        values: &along_y[y as usize * passes.along_y_len()..],
                        len: passes.along_y_len(),
                        slots,
                        empty: 0,
                        reach,
                    };
                    for (k, (start, end)) in rows_of[..ring_z as usize].iter().enumerate() {
                        planes.empty |= u32::from(y < *start || y >= *end) << k;
                    }
                    let mut sums = [simd.splat_f64s(0.0); MAX_SUMS];
                    passes.along_z(simd, &planes, &mut sums[..P::SUMS]);
                    let t = self.source.tiles.tile(self.column, target as usize, y as usize);
                    finish(t, lane, &mut sums);
                }
            }
        }
    }

    /// The passes along x and y over the lanes from `lane` on of the plane `z`, as far as other passes need them;
    /// returns the rows that were written. `lines` holds two rows of the source.
    #[inline(always)]
    fn plane(
        &self,
        (z, lane): (isize, usize),
        lines: &mut [[Line; MAX_SOURCES]; 2],
        ring: &mut [S::f64s],
        out: &mut [S::f64s],
    ) -> Range<isize> {
        let (passes, reach) = (self.passes, self.passes.stencil().reach() as isize);
        let sources =
            hull((self.column as isize - 1..=self.column as isize + 1).map(|c| self.occupied(c, z)));
        let targets = (z - reach..=z + reach)
            .filter(|z| (self.planes.start as isize..self.planes.end as isize).contains(z));
        let targets = hull(targets.map(|z| self.occupied(self.column as isize, z)));
        let written = overlap(&targets, &(sources.start - reach..sources.end + reach));
        if sources.is_empty() || written.is_empty() {
            return 0..0;
        }
        let sources = overlap(&sources, &(written.start - reach..written.end + reach));
        let (slot_len, out_len) = (passes.along_x_len(), passes.along_y_len());
        let slots = self::ring(reach as usize) as isize;
        let mut next = sources.start;
        self.copy(z, next, &mut lines[(next & 1) as usize]);
        for y in written.clone() {
            while next < sources.end && next <= y + reach {
                // A row ahead: what was just written is slow to read at other places.
                if next + 1 < sources.end {
                    self.copy(z, next + 1, &mut lines[((next + 1) & 1) as usize]);
                }
                let first = (next & (slots - 1)) as usize * slot_len;
                let lines = &lines[(next & 1) as usize][..P::SOURCE.1];
                passes.along_x(self.simd, lines, lane, &mut ring[first..first + slot_len]);
                next += 1;
            }
            let mut rows = Ring { values: &*ring, len: slot_len, slots: Slots::default(), empty: 0, reach };
            for j in -reach..=reach {
                let (source, fold) = self.source.folds.source(1, y + j);
                let there = sources.contains(&source) && (y - reach..=y + reach).contains(&source);
                rows.empty |= u32::from(!there) << (j + reach);
                rows.slots[(j + reach) as usize] = ((source & (slots - 1)) as usize * slot_len, fold);
            }
            let first = y as usize * out_len;
            passes.along_y(self.simd, &rows, &mut out[first..first + out_len]);
        }
        written
    }

    #[inline(always)]
    fn occupied(&self, column: isize, z: isize) -> Range<isize> {
        if (0..self.source.tiles.columns as isize).contains(&column) {
            self.source.tiles.occupied(column as usize, z)
        } else {
            0..0
        }
    }

    /// The source's values in row `y` of plane `z`, with those beside the tile.
    #[inline(always)]
    fn copy(&self, z: isize, y: isize, lines: &mut [Line; MAX_SOURCES]) {
        let (components, read) = P::SOURCE;
        // The tiles before, here and after; zeros where there is none.
        let tile = |side: isize| {
            let column = self.column as isize + side;
            let there = self.occupied(column, z).contains(&y);
            there.then(|| self.source.tiles.tile(column as usize, z as usize, y as usize) * components)
        };
        for (side, at) in [tile(-1), tile(0), tile(1)].into_iter().enumerate() {
            for (c, Line(line)) in lines.iter_mut().enumerate().take(read) {
                let to = &mut line[side * LANES..(side + 1) * LANES];
                match at {
                    Some(at) => to.copy_from_slice(&self.source.field[at + c].0),
                    None => to.fill(0.0),
                }
            }
        }
        let origin = (self.column as isize - 1) * LANES as isize;
        for fold in self.source.folds.along_x() {
            let reach = P::stencil(self.passes).reach() as isize;
            for d in 0..reach {
                let (below, above) = (fold.face - 1 - d - origin, fold.face + d - origin);
                if below < 0 || above >= 3 * LANES as isize {
                    continue;
                }
                let (to, from) = if fold.above { (below, above) } else { (above, below) };
                for (c, Line(line)) in lines.iter_mut().enumerate().take(read) {
                    line[to as usize] = P::source_sign(&fold.sign, c) * line[from as usize];
                }
            }
        }
    }
}

/// The smallest range that holds all of them.
#[inline(always)]
fn hull(ranges: impl Iterator<Item = Range<isize>>) -> Range<isize> {
    ranges
        .filter(|r| !r.is_empty())
        .fold(0..0, |all, r| if all.is_empty() { r } else { all.start.min(r.start)..all.end.max(r.end) })
}

#[inline(always)]
fn overlap(a: &Range<isize>, b: &Range<isize>) -> Range<isize> {
    a.start.max(b.start)..a.end.min(b.end)
}
