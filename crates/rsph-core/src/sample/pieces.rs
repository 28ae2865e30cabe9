//! Pieces of a shape that hang together by nothing: which of them are simulated.

use super::Body;
use super::occupy::{Occupied, coordinates, neighbours};
use crate::mesh::TriangleMesh;
use crate::shape::Shape;
use crate::tensor::Vec3;

/// Particles of a piece below which it is a crumb, three along every edge of a cube: with two across a piece every particle lies in a corner,
/// and the hourglass term alone resists bending.
const CRUMB: usize = 27;
/// Depths below the surface, in spacings, at which the cell of a particle is looked for.
const DEPTHS: [f64; 3] = [0.25, 0.75, 1.25];

/// Why a piece is not simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhyLeftOut {
    /// It has too few particles to deform.
    Crumb,
    /// Nothing holds it, so that it has no equilibrium.
    Unheld,
    /// The scheme of the paper has one piece, the largest.
    Smaller,
}

/// A piece of a shape that is not simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Why.
    pub why: WhyLeftOut,
    /// Centres of its cells.
    pub cells: Vec<Vec3>,
    /// Its volume.
    pub volume: f64,
}

impl LeftOut {
    /// The mean of the centres of its cells.
    pub fn centre(&self) -> Vec3 {
        self.cells.iter().sum::<Vec3>() / self.cells.len().max(1) as f64
    }
}

/// Which pieces with these numbers of particles are no crumbs; the largest is none.
pub(super) fn without_crumbs(sizes: &[usize]) -> Vec<bool> {
    let largest = sizes.iter().copied().max().unwrap_or(0);
    sizes.iter().map(|&n| n >= CRUMB.min(largest)).collect()
}

/// Number of particles without crumbs.
pub(super) fn particles(occupied: &Occupied) -> usize {
    let sizes = occupied.sizes();
    sizes.iter().zip(without_crumbs(&sizes)).filter(|(_, keep)| *keep).map(|(n, _)| n).sum()
}

impl Body {
    /// Number of pieces that hang together by nothing.
    pub fn pieces(&self) -> usize {
        self.piece.iter().max().map_or(0, |last| *last as usize + 1)
    }

    /// The surface that is loaded and held, of `shape` or what is kept of it.
    pub fn boundary_surface<'a>(&'a self, shape: &'a dyn Shape) -> &'a TriangleMesh {
        self.kept_surface.as_ref().unwrap_or_else(|| shape.surface())
    }

    /// The piece that each triangle of a surface of this body bounds, if it bounds one.
    pub fn bounded_pieces(&self, surface: &TriangleMesh) -> Vec<Option<u32>> {
        let mut piece_at = vec![u32::MAX; self.grid.len()];
        for (cell, piece) in self.cells.iter().zip(&self.piece) {
            piece_at[self.grid.index(*cell)] = *piece;
        }
        let (part_of, parts) = surface.component_of_triangles();
        let mut votes = vec![vec![0_u32; self.pieces()]; parts];
        // Parts that lie above no particle count those beside them.
        for only_below in [true, false] {
            let decided: Vec<bool> = votes.iter().map(|votes| votes.iter().any(|v| *v > 0)).collect();
            for (t, &part) in part_of.iter().enumerate().filter(|(_, part)| !decided[**part]) {
                let (x, normal) = (surface.centroid(t), surface.normal(t));
                for depth in DEPTHS {
                    let mut below = x - depth * self.grid.spacing * normal;
                    if self.dimension == 2 {
                        below.z = 0.0;
                    }
                    let Some(cell) = self.grid.cell_at(&below) else { continue };
                    let own = (piece_at[cell] != u32::MAX).then_some(cell);
                    let around = neighbours(&self.grid, coordinates(&self.grid, cell));
                    let beside = around.filter(|c| !only_below && piece_at[*c] != u32::MAX);
                    if let Some(found) = own.or_else(|| beside.min()) {
                        votes[part][piece_at[found] as usize] += 1;
                        break;
                    }
                }
            }
        }
        let winner = |votes: &Vec<u32>| {
            let most = votes.iter().copied().max().filter(|most| *most > 0)?;
            votes.iter().position(|v| *v == most).map(|piece| piece as u32)
        };
        let piece_of: Vec<Option<u32>> = votes.iter().map(winner).collect();
        part_of.iter().map(|part| piece_of[*part]).collect()
    }

    /// Leaves out the pieces for which `keep` is false.
    pub fn leave_out(&mut self, shape: &dyn Shape, keep: &[bool], why: WhyLeftOut) {
        let is_kept = |piece: u32| keep.get(piece as usize).copied().unwrap_or(false);
        if self.piece.iter().all(|piece| is_kept(*piece)) {
            return;
        }
        let retained = |surface: &TriangleMesh| {
            let piece_of = self.bounded_pieces(surface);
            surface.retain(|t| piece_of[t].is_some_and(is_kept))
        };
        let (kept_surface, surface) = (retained(self.boundary_surface(shape)), retained(&self.surface));
        (self.kept_surface, self.surface) = (Some(kept_surface), surface);
        for piece in (0..keep.len()).filter(|piece| !keep[*piece]) {
            let of = || (0..self.piece.len()).filter(|a| self.piece[*a] as usize == piece);
            let volume = of().map(|a| self.volume[a]).sum();
            self.dropped_volume += volume;
            let cells = of().map(|a| self.grid.centre(self.cells[a])).collect();
            self.left_out.push(LeftOut { why, cells, volume });
        }
        let mut number = 0;
        let renumbered: Vec<u32> = keep
            .iter()
            .map(|keep| {
                number += u32::from(*keep);
                number.saturating_sub(1)
            })
            .collect();
        let kept: Vec<bool> = self.piece.iter().map(|piece| is_kept(*piece)).collect();
        filter(&mut self.cells, &kept);
        filter(&mut self.fraction, &kept);
        filter(&mut self.level_set, &kept);
        filter(&mut self.volume, &kept);
        filter(&mut self.piece, &kept);
        self.piece.iter_mut().for_each(|piece| *piece = renumbered[*piece as usize]);
    }
}

fn filter<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    values.retain(|_| keep.next() == Some(&true));
}
