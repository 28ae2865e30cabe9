//! Which cells of a lattice the body occupies.

use super::MIN_FRACTION;
use crate::grid::Grid;
use crate::shape::Shape;

/// The cells of a body.
#[derive(Clone, Debug)]
pub(super) struct Occupied {
    /// The lattice, just large enough.
    pub(super) grid: Grid,
    /// Integer coordinates of the cells, x fastest order.
    pub(super) cells: Vec<[usize; 3]>,
    /// Their inside fractions.
    pub(super) fraction: Vec<f64>,
    /// The same with what lies in neighbouring cells that are too empty for a particle.
    pub(super) share: Vec<f64>,
    /// Volume of filled cells that do not hang together with these.
    pub(super) dropped_volume: f64,
}

/// The cells of `grid` that `shape` fills by at least [`MIN_FRACTION`] and that hang together.
pub(super) fn occupy(shape: &dyn Shape, grid: Grid) -> Occupied {
    let fraction = shape.fill(&grid);
    let filled: Vec<usize> = (0..fraction.len()).filter(|&c| fraction[c] >= MIN_FRACTION).collect();
    let piece = largest_piece(&grid, &filled);
    let dropped: f64 =
        filled.iter().map(|&c| fraction[c]).sum::<f64>() - piece.iter().map(|&c| fraction[c]).sum::<f64>();
    let dropped_volume =
        if piece.len() == filled.len() { 0.0 } else { dropped * grid.spacing.powi(shape.dimension() as i32) };
    let cells: Vec<_> = piece.iter().map(|&c| coordinates(&grid, c)).collect();
    let share = shares(&grid, &fraction, &piece);
    let (grid, cells) = trimmed(grid, cells);
    Occupied { grid, cells, fraction: piece.iter().map(|&c| fraction[c]).collect(), share, dropped_volume }
}

/// Inside fractions of the cells `piece` of all, with those of the cells around them that are below [`MIN_FRACTION`]: such
/// a cell gives its own to the 26 around it, in proportion theta / d^4 at the distance d.
fn shares(grid: &Grid, fraction: &[f64], piece: &[usize]) -> Vec<f64> {
    let mut share: Vec<f64> = piece.iter().map(|&c| fraction[c]).collect();
    let mut number = vec![u32::MAX; fraction.len()];
    for (k, &c) in piece.iter().enumerate() {
        number[c] = k as u32;
    }
    for sliver in (0..fraction.len()).filter(|&c| fraction[c] > 0.0 && fraction[c] < MIN_FRACTION) {
        let here = coordinates(grid, sliver);
        let weight = |c: usize| {
            let there = coordinates(grid, c);
            let square: usize = (0..3).map(|i| there[i].abs_diff(here[i]).pow(2)).sum();
            fraction[c] / (square * square).max(1) as f64
        };
        let around = || neighbours(grid, here).filter(|&c| number[c] != u32::MAX);
        let total: f64 = around().map(weight).sum();
        for c in around() {
            share[number[c] as usize] += fraction[sliver] * weight(c) / total;
        }
    }
    share
}

/// Integer coordinates of the cell with that index.
pub(super) fn coordinates(grid: &Grid, index: usize) -> [usize; 3] {
    let [nx, ny, _] = grid.cells;
    [index % nx, index / nx % ny, index / (nx * ny)]
}

/// Indices of the cells around a cell that share a face, an edge or a corner with it.
pub(super) fn neighbours(grid: &Grid, cell: [usize; 3]) -> impl Iterator<Item = usize> + '_ {
    let range = move |i: usize| cell[i].saturating_sub(1)..(cell[i] + 2).min(grid.cells[i]);
    range(2).flat_map(move |z| range(1).flat_map(move |y| range(0).map(move |x| grid.index([x, y, z]))))
}

/// Filled cells side by side along x.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// First cell and the one after the last, on its row.
    cells: (usize, usize),
    /// Where its cells begin in the list.
    first: usize,
}

/// The largest set of the given cells (in rising order) that hangs together by faces, edges or
/// corners, in rising order; the first one of equally large ones.
fn largest_piece(grid: &Grid, filled: &[usize]) -> Vec<usize> {
    let [nx, ny, nz] = grid.cells;
    let mut runs: Vec<Run> = Vec::new();
    let mut rows = vec![0; ny * nz + 1];
    for (first, cell) in filled.iter().enumerate() {
        let (row, x) = (cell / nx, cell % nx);
        match runs.last_mut() {
            Some(run) if rows[row + 1] > 0 && run.cells.1 == x => run.cells.1 += 1,
            _ => {
                runs.push(Run { cells: (x, x + 1), first });
                rows[row + 1] += 1;
            }
        }
    }
    for row in 0..ny * nz {
        rows[row + 1] += rows[row];
    }
    // Runs touch those of the four rows before theirs that overlap them or end beside them.
    let mut parent: Vec<usize> = (0..runs.len()).collect();
    for row in 0..ny * nz {
        let (y, z) = (row % ny, row / ny);
        let before = [
            (y.wrapping_sub(1), z),
            (y.wrapping_sub(1), z.wrapping_sub(1)),
            (y, z.wrapping_sub(1)),
            (y + 1, z.wrapping_sub(1)),
        ];
        for (y, z) in before {
            if y >= ny || z >= nz {
                continue;
            }
            let other = z * ny + y;
            let mut k = rows[other];
            for r in rows[row]..rows[row + 1] {
                let (low, high) = runs[r].cells;
                while k < rows[other + 1] && runs[k].cells.1 < low {
                    k += 1;
                }
                let mut touching = k;
                while touching < rows[other + 1] && runs[touching].cells.0 <= high {
                    let (a, b) = (root(&mut parent, r), root(&mut parent, touching));
                    // The first run of a piece is its root.
                    parent[a.max(b)] = a.min(b);
                    touching += 1;
                }
            }
        }
    }
    let length = |r: &Run| r.cells.1 - r.cells.0;
    let mut sizes = vec![0; runs.len()];
    for (r, run) in runs.iter().enumerate() {
        sizes[root(&mut parent, r)] += length(run);
    }
    let largest = (0..runs.len()).rev().max_by_key(|r| sizes[*r]);
    let mut piece = Vec::with_capacity(largest.map_or(0, |r| sizes[r]));
    for (r, run) in runs.iter().enumerate() {
        if Some(root(&mut parent, r)) == largest {
            piece.extend_from_slice(&filled[run.first..run.first + length(run)]);
        }
    }
    piece
}

/// Root of `r` in a forest of parents, shortening the way on the way.
fn root(parent: &mut [usize], mut r: usize) -> usize {
    while parent[r] != r {
        parent[r] = parent[parent[r]];
        r = parent[r];
    }
    r
}

/// The lattice without the empty layers around the cells.
fn trimmed(grid: Grid, mut cells: Vec<[usize; 3]>) -> (Grid, Vec<[usize; 3]>) {
    let Some(&first) = cells.first() else {
        return (grid, cells);
    };
    let (mut low, mut high) = (first, first);
    for c in &cells {
        for i in 0..3 {
            low[i] = low[i].min(c[i]);
            high[i] = high[i].max(c[i]);
        }
    }
    for c in &mut cells {
        for i in 0..3 {
            c[i] -= low[i];
        }
    }
    let mut origin = grid.origin;
    for i in 0..3 {
        origin[i] += low[i] as f64 * grid.spacing;
    }
    let size = std::array::from_fn(|i| high[i] - low[i] + 1);
    (Grid { origin, spacing: grid.spacing, cells: size }, cells)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{BoxShape, MeshShape};
    use crate::tensor::Vec3;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    /// Two boxes side by side on the unit lattice, `gap` apart.
    fn two_boxes(gap: f64) -> MeshShape {
        let mut mesh = BoxShape::new(Vec3::repeat(3.0), Vec3::zeros()).unwrap().surface().clone();
        let small = BoxShape::new(Vec3::repeat(2.0), Vec3::new(3.0 + gap, 0.0, 0.0)).unwrap();
        mesh.triangles.extend(small.surface().triangles.iter().map(|t| t.map(|v| v + 8)));
        mesh.vertices.extend(&small.surface().vertices);
        MeshShape::new(&mesh, "mesh two").unwrap().0
    }

    fn unit_grid() -> Grid {
        Grid { origin: Vec3::repeat(-1.0), spacing: 1.0, cells: [9, 5, 5] }
    }

    #[test]
    fn only_the_largest_piece_stays() {
        let o = occupy(&two_boxes(1.0), unit_grid());
        assert_eq!((o.cells.len(), o.grid.cells), (27, [3; 3]));
        assert_relative_eq!(o.dropped_volume, 8.0, epsilon = 1e-9);
        assert_eq!(o.grid.origin, Vec3::zeros());
    }

    #[test]
    fn pieces_that_touch_stay_together() {
        let o = occupy(&two_boxes(1e-9), unit_grid());
        assert_eq!(o.cells.len(), 35);
        assert!(o.dropped_volume == 0.0);
    }

    #[test]
    fn cells_come_in_x_fastest_order() {
        let o = occupy(&two_boxes(1.0), unit_grid());
        let index: Vec<_> = o.cells.iter().map(|&c| o.grid.index(c)).collect();
        assert!(index.is_sorted() && coordinates(&o.grid, index[5]) == o.cells[5]);
    }

    proptest! {
        /// Runs give the piece that a flood from cell to cell gives.
        #[test]
        fn the_largest_piece_is_that_of_a_flood(
            size in prop::array::uniform3(1..7_usize),
            chance in 0.1..0.6_f64,
            noise in prop::collection::vec(0.0..1.0_f64, 216),
        ) {
            let grid = Grid { origin: Vec3::zeros(), spacing: 1.0, cells: size };
            let filled: Vec<usize> = (0..grid.len()).filter(|&c| noise[c] < chance).collect();
            let mut unseen: std::collections::BTreeSet<usize> = filled.iter().copied().collect();
            let mut best: Vec<usize> = Vec::new();
            while let Some(seed) = unseen.pop_first() {
                let (mut piece, mut next) = (vec![seed], 0);
                while next < piece.len() {
                    let around = neighbours(&grid, coordinates(&grid, piece[next]));
                    piece.extend(around.filter(|n| unseen.remove(n)).collect::<Vec<_>>());
                    next += 1;
                }
                if piece.len() > best.len() {
                    best = piece;
                }
            }
            best.sort_unstable();
            prop_assert_eq!(largest_piece(&grid, &filled), best);
        }
    }
}
