//! How the planes of a body are shared out between threads, and the stencil and instructions that work on them.

use super::stencil::{Any, Fixed, Stencil};
use crate::lattice::Lattice;
use crate::tiles::{Tile, Tiles};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Pieces of a body that every thread gets.
const PIECES_A_THREAD: usize = 2;
/// Least planes of a piece, in reaches: where a column is cut, both pieces work on the planes that a reach covers.
const PIECE_REACHES: usize = 4;

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
    pub out: &'a mut [Tile],
}

impl Block<'_> {
    /// The first tile.
    pub fn first(&self) -> usize {
        self.tiles.start(self.column, self.planes.start)
    }
}

/// Every column of tiles, cut into blocks of planes where the pieces of the threads meet. What a particle gets does
/// not depend on the block it is in.
pub fn for_each_block(lattice: &Lattice, out: &mut [Tile], components: usize, sum: &impl Sum) {
    let (tiles, cut) = (&lattice.tiles, lattice.weights.cut);
    if tiles.is_empty() {
        return;
    }
    let pieces = match rayon::current_num_threads() {
        1 => 1,
        threads => PIECES_A_THREAD * threads,
    };
    let reach = cut.isqrt().max(1);
    Blocks { sum, cut, tiles, components, reach, arch: Arch::new() }.pieces(
        0..tiles.columns * tiles.planes,
        pieces,
        out,
    );
}

/// How a field is cut into blocks. Planes are numbered through all columns.
#[derive(Clone, Copy)]
struct Blocks<'a, K> {
    sum: &'a K,
    cut: usize,
    tiles: &'a Tiles,
    components: usize,
    /// Planes to each side that a sum reads.
    reach: usize,
    arch: Arch,
}

impl<K: Sum> Blocks<'_, K> {
    /// First tile of a plane.
    fn start(&self, plane: usize) -> usize {
        self.tiles.start(plane / self.tiles.planes, plane % self.tiles.planes)
    }

    /// Cuts `planes` into so many pieces with about as many tiles each.
    fn pieces(&self, planes: Range<usize>, pieces: usize, out: &mut [Tile]) {
        let is_worth_it = pieces > 1 && planes.len() >= 2 * PIECE_REACHES * self.reach;
        let middle = if is_worth_it { self.middle(&planes, pieces) } else { planes.start };
        if middle == planes.start || middle == planes.end {
            self.run(planes, out);
            return;
        }
        let tiles = self.start(middle) - self.start(planes.start);
        let (before, after) = out.split_at_mut(tiles * self.components);
        rayon::join(
            || self.pieces(planes.start..middle, pieces / 2, before),
            || self.pieces(middle..planes.end, pieces - pieces / 2, after),
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
    fn run(&self, planes: Range<usize>, mut out: &mut [Tile]) {
        let (mut at, of_column) = (planes.start, self.tiles.planes);
        while at < planes.end {
            let column = at / of_column;
            let end = planes.end.min((column + 1) * of_column);
            let (here, rest) = out.split_at_mut((self.start(end) - self.start(at)) * self.components);
            let planes = at - column * of_column..end - column * of_column;
            let block = Block { tiles: self.tiles, column, planes, out: here };
            self.arch.dispatch(Task { sum: self.sum, cut: self.cut, block });
            (at, out) = (end, rest);
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
