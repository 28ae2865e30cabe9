//! How the planes of a body are shared out between threads, and the stencil and instructions that work on them.

use super::part::Part;
use super::stencil::{Any, Fixed, Stencil};
use crate::lattice::Lattice;
use crate::tiles::{Tile, Tiles};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Pieces of a body that every thread gets.
const PIECES_PER_THREAD: usize = 2;
/// Least planes of a piece, in reaches: where a column is cut, both pieces work on the planes that a reach covers.
const PIECE_REACHES: usize = 4;

/// Rows and planes to each side that the passes of a sum with that cut read: some of them with weights of zero.
pub(super) fn reach(cut: usize) -> usize {
    match cut {
        0..=3 => Fixed::<3>.reach(),
        4..=9 => Fixed::<9>.reach(),
        cut => Any(cut).reach(),
    }
}

/// A kernel sum that works on blocks.
pub trait Sum: Sync {
    /// Works on one block.
    fn run<S: Simd, T: Stencil>(&self, simd: S, stencil: T, block: Block<'_>);
}

/// Some planes of a column of tiles.
pub struct Block<'a> {
    pub tiles: &'a Tiles,
    pub column: usize,
    pub planes: Range<usize>,
    /// Results of these planes.
    pub out: Results<'a>,
    /// More results of these planes.
    pub sides: [Results<'a>; 2],
}

/// Results of some planes, on all of their tiles or on those of a part.
#[derive(Debug)]
pub struct Results<'a> {
    part: Option<&'a Part>,
    components: usize,
    /// The first tile that has results, by its number among those that do.
    first: usize,
    values: &'a mut [Tile],
}

impl<'a> Results<'a> {
    /// On all tiles, or on those of a part, with so many components each.
    pub fn new(part: Option<&'a Part>, components: usize, values: &'a mut [Tile]) -> Self {
        Self { part, components, first: 0, values }
    }

    /// None.
    pub(super) fn none() -> Self {
        Self::new(None, 0, &mut [])
    }

    /// The results of a tile; empty if it has none.
    #[inline(always)]
    pub fn of(&mut self, tile: usize) -> &mut [Tile] {
        if self.values.is_empty() {
            return &mut [];
        }
        match self.part.map_or(Some(tile), |part| part.number(tile)) {
            Some(number) => &mut self.values[(number - self.first) * self.components..][..self.components],
            None => &mut [],
        }
    }

    /// Cuts them before a tile of the body.
    fn split(self, tile: usize) -> (Self, Self) {
        let Self { part, components, first, values } = self;
        let next = part.map_or(tile, |part| part.first_from(tile));
        let at = ((next - first) * components).min(values.len());
        let (before, after) = values.split_at_mut(at);
        let results = |first, values| Self { part, components, first, values };
        (results(first, before), results(next, after))
    }
}

/// Cuts all of them before a tile of the body.
fn split(results: [Results<'_>; 2], tile: usize) -> ([Results<'_>; 2], [Results<'_>; 2]) {
    let [first, second] = results.map(|results| results.split(tile));
    ([first.0, second.0], [first.1, second.1])
}

/// Every column of tiles, cut into blocks of planes where the pieces of the threads meet. What a particle gets does
/// not depend on the block it is in. Only blocks with tiles of `part` are worked on, if there is one.
pub fn for_each_block(
    lattice: &Lattice,
    part: Option<&Part>,
    out: Results<'_>,
    sides: [Results<'_>; 2],
    sum: &impl Sum,
) {
    let (tiles, cut) = (&lattice.tiles, lattice.weights.cut);
    if tiles.is_empty() {
        return;
    }
    let pieces = match rayon::current_num_threads() {
        1 => 1,
        threads => PIECES_PER_THREAD * threads,
    };
    let reach = reach(cut).max(1);
    let planes = 0..tiles.columns * tiles.planes;
    Blocks { sum, cut, tiles, part, reach, arch: Arch::new() }.pieces(planes, pieces, out, sides);
}

/// How a field is cut into blocks. Planes are numbered through all columns.
#[derive(Clone, Copy)]
struct Blocks<'a, K> {
    sum: &'a K,
    cut: usize,
    tiles: &'a Tiles,
    /// Where there is work.
    part: Option<&'a Part>,
    /// Planes to each side that a sum reads.
    reach: usize,
    arch: Arch,
}

impl<K: Sum> Blocks<'_, K> {
    /// First tile of a plane.
    fn tile(&self, plane: usize) -> usize {
        self.tiles.start(plane / self.tiles.planes, plane % self.tiles.planes)
    }

    /// First tile of a plane, by its number among those with work.
    fn start(&self, plane: usize) -> usize {
        let tile = self.tile(plane);
        self.part.map_or(tile, |part| part.first_from(tile))
    }

    /// Cuts `planes` into so many pieces with about as many tiles each.
    fn pieces(&self, planes: Range<usize>, pieces: usize, out: Results<'_>, sides: [Results<'_>; 2]) {
        let is_worth_it = pieces > 1 && planes.len() >= 2 * PIECE_REACHES * self.reach;
        let middle = if is_worth_it { self.middle(&planes, pieces) } else { planes.start };
        if middle == planes.start || middle == planes.end {
            self.run(planes, out, sides);
            return;
        }
        let (out, out_after) = out.split(self.tile(middle));
        let (sides, sides_after) = split(sides, self.tile(middle));
        rayon::join(
            || self.pieces(planes.start..middle, pieces / 2, out, sides),
            || self.pieces(middle..planes.end, pieces - pieces / 2, out_after, sides_after),
        );
    }

    /// Where half of the pieces end: between two columns if one ends within a reach.
    fn middle(&self, planes: &Range<usize>, pieces: usize) -> usize {
        let (first, end) = (self.start(planes.start), self.start(planes.end));
        let target = first + (end - first) * (pieces / 2) / pieces;
        let (mut low, mut high) = (planes.start, planes.end);
        while low < high {
            let plane = low.midpoint(high);
            if self.start(plane) < target { low = plane + 1 } else { high = plane }
        }
        let column = (low + self.tiles.planes / 2) / self.tiles.planes * self.tiles.planes;
        let is_inside = planes.start < column && column < planes.end;
        if is_inside && low.abs_diff(column) <= self.reach { column } else { low }
    }

    /// Works on `planes`, column by column.
    fn run(&self, planes: Range<usize>, mut out: Results<'_>, mut sides: [Results<'_>; 2]) {
        let (mut at, of_column) = (planes.start, self.tiles.planes);
        while at < planes.end {
            let column = at / of_column;
            let end = planes.end.min((column + 1) * of_column);
            let (out_here, out_rest) = out.split(self.tile(end));
            let (sides_here, sides_rest) = split(sides, self.tile(end));
            if self.start(end) > self.start(at) {
                let planes = at - column * of_column..end - column * of_column;
                let block = Block { tiles: self.tiles, column, planes, out: out_here, sides: sides_here };
                self.arch.dispatch(Task { sum: self.sum, cut: self.cut, block });
            }
            (at, out, sides) = (end, out_rest, sides_rest);
        }
    }
}

struct Task<'a, K> {
    sum: &'a K,
    cut: usize,
    block: Block<'a>,
}

impl<K: Sum> WithSimd for Task<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // h up to 0.8 dx, 1.26 dx, and beyond.
        match self.cut {
            0..=3 => self.sum.run(simd, Fixed::<3>, self.block),
            4..=9 => self.sum.run(simd, Fixed::<9>, self.block),
            cut => self.sum.run(simd, Any(cut), self.block),
        }
    }
}
