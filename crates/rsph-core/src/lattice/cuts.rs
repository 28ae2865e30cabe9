//! Pairs of particles within reach of each other that nothing acts between: a gap lies between them.
//!
//! Sums over offsets take them in, and [`Cuts`] takes them out again, tile by tile, so that the sums are those over all other pairs.

use crate::tensor::Vec3;
use crate::tiles::Tiles;

/// A neighbour that a particle does not see.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Lane of the particle in its tile.
    pub lane: u8,
    /// Tile and lane of the neighbour.
    pub other: (u32, u8),
    /// X = x_b - x_a.
    pub x: Vec3,
    /// w(r) = -W'(r)/r.
    pub w: f64,
}

/// All of them, from both sides.
#[derive(Clone, Debug, Default)]
pub struct Cuts {
    /// Pairs of particles, in order.
    pairs: Vec<(u32, u32)>,
    /// The first pair of every tile, and their number; nothing if there are none.
    starts: Vec<u32>,
    /// The neighbours that the particles of each tile do not see.
    unseen: Vec<Cut>,
}

impl Cuts {
    /// Of `pairs` in order, each both ways round, with X and w.
    pub(super) fn new(
        tiles: &Tiles,
        pairs: Vec<(u32, u32)>,
        apart: impl Fn(u32, u32) -> (Vec3, f64),
    ) -> Self {
        if pairs.is_empty() {
            return Self::default();
        }
        let mut placed: Vec<(usize, Cut)> = pairs
            .iter()
            .map(|&(a, b)| {
                let ((tile, lane), (t, l)) = (tiles.place(a as usize), tiles.place(b as usize));
                let (x, w) = apart(a, b);
                (tile, Cut { lane: lane as u8, other: (t as u32, l as u8), x, w })
            })
            .collect();
        placed.sort_by_key(|(tile, _)| *tile);
        let mut starts = vec![0; tiles.len() + 1];
        for (tile, _) in &placed {
            starts[tile + 1] += 1;
        }
        for t in 0..tiles.len() {
            starts[t + 1] += starts[t];
        }
        Self { pairs, starts, unseen: placed.into_iter().map(|(_, cut)| cut).collect() }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// The pairs.
    pub(super) fn pairs(&self) -> &[(u32, u32)] {
        &self.pairs
    }

    /// What the particles in tile `t` do not see.
    #[inline(always)]
    pub fn of_tile(&self, t: usize) -> &[Cut] {
        if self.starts.is_empty() {
            return &[];
        }
        &self.unseen[self.starts[t] as usize..self.starts[t + 1] as usize]
    }

    /// Whether particle `a` has a neighbour that it does not see.
    pub fn has(&self, a: usize) -> bool {
        let at = self.pairs.partition_point(|p| (p.0 as usize) < a);
        self.pairs.get(at).is_some_and(|p| p.0 as usize == a)
    }

    /// Whether particle `a` does not see its neighbour `b`.
    #[inline(always)]
    pub fn part(&self, a: usize, b: usize) -> bool {
        !self.pairs.is_empty() && self.pairs.binary_search(&(a as u32, b as u32)).is_ok()
    }
}
