//! A part of a body that a kernel sum is wanted for, and what the passes have to do for it.

use super::blocks::reach;
use crate::lattice::Lattice;

/// Some tiles of a body, numbered in their order: fields on them are stored for them alone.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// How many of its tiles come before each tile of the body; at the end, all.
    before: Vec<u32>,
    /// What has to be done in every row of every plane of every column of the box, a bit a pass.
    wanted: Vec<u8>,
    planes: usize,
    rows: usize,
}

impl Part {
    /// Results are wanted in the row.
    pub(super) const RESULT: u8 = 1;
    /// The pass along y has to work there, for planes within reach.
    pub(super) const ALONG_Y: u8 = 2;
    /// The pass along x has to work there, for rows within reach of those.
    pub(super) const ALONG_X: u8 = 4;

    /// The tiles for which `belongs` holds, for sums on `lattice`.
    pub fn new(lattice: &Lattice, belongs: impl Fn(usize) -> bool) -> Self {
        let (tiles, reach) = (&lattice.tiles, reach(lattice.weights.cut));
        let (columns, planes, rows) = (tiles.columns, tiles.planes, tiles.rows);
        let mut wanted = vec![0; columns * planes * rows];
        let mut before = vec![0; tiles.len() + 1];
        for column in 0..columns {
            for z in 0..planes {
                for y in tiles.occupied(column, z as isize) {
                    let y = y as usize;
                    let tile = tiles.tile(column, z, y);
                    if !belongs(tile) {
                        continue;
                    }
                    before[tile + 1] = 1;
                    wanted[(column * planes + z) * rows + y] |= Self::RESULT;
                    for k in z.saturating_sub(reach)..=(z + reach).min(planes - 1) {
                        let plane = &mut wanted[(column * planes + k) * rows..][..rows];
                        plane[y] |= Self::ALONG_Y;
                        for row in &mut plane[y.saturating_sub(reach)..=(y + reach).min(rows - 1)] {
                            *row |= Self::ALONG_X;
                        }
                    }
                }
            }
        }
        for tile in 0..tiles.len() {
            before[tile + 1] += before[tile];
        }
        Self { before, wanted, planes, rows }
    }

    /// Number of its tiles.
    pub fn len(&self) -> usize {
        self.before.last().map_or(0, |all| *all as usize)
    }

    /// Whether it has no tile.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of a tile of the body among those of the part, if it is one.
    #[inline(always)]
    pub fn number(&self, tile: usize) -> Option<usize> {
        let next = *self.before.get(tile + 1)?;
        (next > self.before[tile]).then_some(self.before[tile] as usize)
    }

    /// Number of the first of its tiles that is not before `tile` of the body.
    #[inline(always)]
    pub(super) fn first_from(&self, tile: usize) -> usize {
        self.before[tile] as usize
    }

    /// Whether a pass has to work at row `y` of plane `z`, which may lie outside of the box.
    #[inline(always)]
    pub(super) fn wants(&self, pass: u8, column: usize, z: isize, y: isize) -> bool {
        let inside = (0..self.planes as isize).contains(&z) && (0..self.rows as isize).contains(&y);
        inside && self.wanted[(column * self.planes + z as usize) * self.rows + y as usize] & pass != 0
    }
}
