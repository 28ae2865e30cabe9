//! The walk of a kernel sum over a column of tiles.
//!
//! The weight of an offset (i, j, k) depends on i^2 + j^2 + k^2 only. So the sums along x are the same for
//! all rows at the same j^2 + k^2, and those sums, added along y, the same for all planes at the same
//! k^2: three short passes, along x, y and z, take the place of one over all offsets (123 at
//! h = 1.25 dx). What the passes along x and y leave is kept in rings, as far as the next pass reaches.

use super::part::Part;
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

/// Where a tile stands in a [`Line`]. Of the tiles beside the middle a line holds what is within reach.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    Before,
    Middle,
    After,
}

/// Most components that a pass reads.
pub const MAX_SOURCES: usize = 12;
/// Most results of a particle.
const MAX_SUMS: usize = 12;

/// What a kernel sum does in each of the three passes.
pub trait Passes<S: Simd>: Sync {
    /// Its offsets.
    type Stencil: Stencil;

    /// Components that the pass along x reads.
    const SOURCES: usize;

    /// Components that the passes keep apart.
    const GROUPS: usize;

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
        Self::GROUPS * self.slot_len()
    }

    /// Values that the pass along y leaves.
    #[inline(always)]
    fn along_y_len(&self) -> usize {
        Self::GROUPS * Self::ALONG_Y * (self.stencil().reach() + 1)
    }

    /// The particles.
    fn tiles(&self) -> &Tiles;

    /// The part of the body that results are wanted for; `None`: all of it.
    fn part(&self) -> Option<&Part>;

    /// Copies the source's values in a tile to its places in the lines.
    fn read(&self, simd: S, tile: usize, lines: &mut [Line; MAX_SOURCES], place: Place);

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

/// Where the rows or planes around a place stand in a ring.
type Slots = [usize; 2 * MAX_REACH + 1];

impl<V> Ring<'_, V> {
    /// Values `d` rows or planes away, if they are not all zero.
    #[inline(always)]
    pub fn get(&self, d: isize) -> Option<&[V]> {
        let at = (d + self.reach) as usize;
        if self.empty >> at & 1 == 1 {
            return None;
        }
        let first = self.slots[at];
        Some(&self.values[first..first + self.len])
    }
}

thread_local! {
    /// The rings; they grow to what the largest body needs.
    static SCRATCH: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
}

/// Runs `passes` for the tiles of `column` in `planes` and hands what comes out to
/// `finish(tile, first lane, sums)`.
#[inline(always)]
pub fn sweep<S: Simd, P: Passes<S>>(
    simd: S,
    passes: &P,
    column: usize,
    planes: Range<usize>,
    finish: impl FnMut(usize, usize, &mut [S::f64s; MAX_SUMS]),
) {
    let reach = passes.stencil().reach();
    let (ring_y, ring_z) = (ring(reach), 2 * reach + 1);
    let values = ring_y * passes.along_x_len() + ring_z * passes.tiles().rows * passes.along_y_len();
    // Taken out rather than borrowed: a closure would not inherit the instruction set.
    let mut scratch = SCRATCH.take();
    let len = values * S::F64_LANES;
    if scratch.len() < len + LANES {
        scratch.resize(len + LANES, 0.0);
    }
    let start = scratch.as_ptr().align_offset(size_of::<Tile>()).min(LANES);
    let rings = S::as_mut_simd_f64s(&mut scratch[start..start + len]).0;
    let (along_x, along_y) = rings.split_at_mut(ring_y * passes.along_x_len());
    Walk { simd, passes, column, planes }.run(along_x, along_y, finish);
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
        let (simd, passes, tiles) = (self.simd, self.passes, self.passes.tiles());
        let rows = tiles.rows;
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
                    let at = (target + k).rem_euclid(ring_z) as usize;
                    rows_of[(k + reach) as usize] = (kept[at].start, kept[at].end);
                    slots[(k + reach) as usize] = at * plane_len;
                }
                for y in tiles.occupied(self.column, target) {
                    if !self.wanted(Part::RESULT, target, y) {
                        continue;
                    }
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
                    let t = tiles.tile(self.column, target as usize, y as usize);
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
        if self.wanted(Part::ALONG_X, z, next) {
            self.copy((z, next), lane, &mut lines[(next & 1) as usize]);
        }
        for y in written.clone() {
            while next < sources.end && next <= y + reach {
                // A row ahead: what was just written is slow to read at other places.
                if next + 1 < sources.end && self.wanted(Part::ALONG_X, z, next + 1) {
                    self.copy((z, next + 1), lane, &mut lines[((next + 1) & 1) as usize]);
                }
                if self.wanted(Part::ALONG_X, z, next) {
                    let first = (next & (slots - 1)) as usize * slot_len;
                    let lines = &lines[(next & 1) as usize][..P::SOURCES];
                    passes.along_x(self.simd, lines, lane, &mut ring[first..first + slot_len]);
                }
                next += 1;
            }
            if !self.wanted(Part::ALONG_Y, z, y) {
                continue;
            }
            let mut rows = Ring { values: &*ring, len: slot_len, slots: Slots::default(), empty: 0, reach };
            for j in -reach..=reach {
                rows.empty |= u32::from(!sources.contains(&(y + j))) << (j + reach);
                rows.slots[(j + reach) as usize] = ((y + j) & (slots - 1)) as usize * slot_len;
            }
            let first = y as usize * out_len;
            passes.along_y(self.simd, &rows, &mut out[first..first + out_len]);
        }
        written
    }

    #[inline(always)]
    fn occupied(&self, column: isize, z: isize) -> Range<isize> {
        let tiles = self.passes.tiles();
        if (0..tiles.columns as isize).contains(&column) { tiles.occupied(column as usize, z) } else { 0..0 }
    }

    /// Whether a pass has to work at row `y` of plane `z`, which may lie outside of the box.
    #[inline(always)]
    fn wanted(&self, pass: u8, z: isize, y: isize) -> bool {
        self.passes.part().is_none_or(|part| part.wants(pass, self.column, z, y))
    }

    /// The source's values in row `y` of plane `z` that sums over the lanes from `lane` on see; zeros where there is none.
    #[inline(always)]
    fn copy(&self, (z, y): (isize, isize), lane: usize, lines: &mut [Line; MAX_SOURCES]) {
        let column = self.column as isize;
        let reach = self.passes.stencil().reach();
        self.copy_tile((column, z, y), lines, Place::Middle);
        if lane < reach {
            self.copy_tile((column - 1, z, y), lines, Place::Before);
        }
        if lane + S::F64_LANES + reach > LANES {
            self.copy_tile((column + 1, z, y), lines, Place::After);
        }
    }

    #[inline(always)]
    fn copy_tile(
        &self,
        (column, z, y): (isize, isize, isize),
        lines: &mut [Line; MAX_SOURCES],
        place: Place,
    ) {
        if self.occupied(column, z).contains(&y) {
            let tile = self.passes.tiles().tile(column as usize, z as usize, y as usize);
            self.passes.read(self.simd, tile, lines, place);
        } else {
            clear_components(&mut lines[..P::SOURCES], place);
        }
    }
}

/// Copies the components of a tile to its place in the lines.
#[inline(always)]
pub fn copy_components(components: &[Tile], lines: &mut [Line], place: Place) {
    for (Line(line), Tile(component)) in lines.iter_mut().zip(components) {
        match place {
            Place::Before => line[LANES - MAX_REACH..LANES].copy_from_slice(&component[LANES - MAX_REACH..]),
            Place::Middle => line[LANES..2 * LANES].copy_from_slice(component),
            Place::After => line[2 * LANES..2 * LANES + MAX_REACH].copy_from_slice(&component[..MAX_REACH]),
        }
    }
}

/// Zeros at the place of a tile in the lines.
#[inline(always)]
pub fn clear_components(lines: &mut [Line], place: Place) {
    const NONE: [Tile; MAX_SOURCES] = [Tile([0.0; LANES]); MAX_SOURCES];
    copy_components(&NONE, lines, place);
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
