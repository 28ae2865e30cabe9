//! Which cells of a lattice the body occupies.

use super::cell_pieces::{CellPiece, cell_pieces};
use super::sight::Sight;
use super::{MIN_FRACTION, is_cut};
use crate::grid::Grid;
use crate::shape::Shape;
use crate::tensor::Vec3;
use rayon::prelude::*;

/// The cells of a body.
#[derive(Clone, Debug)]
pub(super) struct Occupied {
    /// The lattice that was filled.
    pub(super) lattice: Grid,
    /// Its part around the cells.
    pub(super) grid: Grid,
    /// Integer coordinates of the cells, x fastest order.
    pub(super) cells: Vec<[usize; 3]>,
    /// Their inside fractions.
    pub(super) fraction: Vec<f64>,
    /// The same with what lies in neighbouring cells that are too empty for a particle.
    pub(super) share: Vec<f64>,
    /// The piece of the body that each belongs to; pieces are numbered by their first cells.
    pub(super) piece: Vec<u32>,
    /// Centres of the cells with so much tissue on both sides of a gap that each could be a particle, and the smaller share.
    pub(super) parted: Vec<(Vec3, f64)>,
}

impl Occupied {
    /// Sum of the smaller shares of cells with tissue on both sides of a gap.
    pub(super) fn moved(&self) -> f64 {
        self.parted.iter().map(|(_, share)| share).sum()
    }

    /// Number of cells of each piece.
    pub(super) fn sizes(&self) -> Vec<usize> {
        let mut sizes = Vec::new();
        for &piece in &self.piece {
            sizes.resize(sizes.len().max(piece as usize + 1), 0);
            sizes[piece as usize] += 1;
        }
        sizes
    }
}

/// What a cell gives to those around it.
struct Sliver {
    cell: usize,
    fraction: f64,
    home: Vec3,
}

/// The cells of `grid` that `shape` fills by at least [`MIN_FRACTION`]; across a gap none of them hangs together or shares with another,
/// as far as `sight` tells.
pub(super) fn occupy(shape: &dyn Shape, grid: Grid, sight: Option<&mut Sight>) -> Occupied {
    let mut fraction = shape.fill(&grid);
    let (mut slivers, mut parted) = (Vec::new(), Vec::new());
    let mut sight = sight;
    if let Some(sight) = &mut sight {
        part_cells(sight, &grid, &mut fraction, &mut slivers);
        let large = slivers.iter().filter(|s| s.fraction >= MIN_FRACTION);
        parted = large.map(|s| (grid.centre(coordinates(&grid, s.cell)), s.fraction)).collect();
    }
    let sight = sight.as_deref();
    let filled: Vec<usize> = (0..fraction.len()).filter(|&c| fraction[c] >= MIN_FRACTION).collect();
    let centre = |c: usize| grid.centre(coordinates(&grid, c));
    let sees = |a: &Vec3, cell: usize| {
        sight.is_none_or(|sight| !sight.is_near(a) || !sight.is_blocked(a, &sight.home(&centre(cell))))
    };
    let piece = match sight {
        None => pieces(&grid, &filled),
        Some(sight) => pieces_by(&grid, &filled, |a, b| sees(&sight.home(&centre(a)), b)),
    };
    let too_empty = (0..fraction.len()).filter(|&c| fraction[c] > 0.0 && fraction[c] < MIN_FRACTION);
    let home = |c: usize| sight.map_or_else(|| centre(c), |sight| sight.home(&centre(c)));
    slivers.splice(0..0, too_empty.map(|cell| Sliver { cell, fraction: fraction[cell], home: home(cell) }));
    let share = shares(&grid, &fraction, &filled, &slivers, sees);
    let cells: Vec<_> = filled.iter().map(|&c| coordinates(&grid, c)).collect();
    let (trimmed, cells) = trimmed(&grid, cells);
    let fraction = filled.iter().map(|&c| fraction[c]).collect();
    Occupied { lattice: grid, grid: trimmed, cells, fraction, share, piece, parted }
}

/// Leaves every cell near a gap the largest piece of its tissue; the others become slivers.
fn part_cells(sight: &mut Sight, grid: &Grid, fraction: &mut [f64], slivers: &mut Vec<Sliver>) {
    let centre = |c: usize| grid.centre(coordinates(grid, c));
    let parted: Vec<(usize, Vec<CellPiece>)> = (0..fraction.len())
        .into_par_iter()
        .filter(|&c| {
            let x = centre(c);
            fraction[c] > 0.0 && (sight.may_part(&x) || is_cut(fraction[c]) && sight.is_near(&x))
        })
        .map(|c| (c, cell_pieces(sight, &centre(c), grid.spacing, fraction[c])))
        .collect();
    for (cell, pieces) in parted {
        for (k, CellPiece { fraction: part, home }) in pieces.into_iter().enumerate() {
            if k == 0 {
                fraction[cell] = part;
                sight.set_home(&centre(cell), home);
            } else {
                slivers.push(Sliver { cell, fraction: part, home });
            }
        }
    }
}

/// Inside fractions of the `filled` cells of all, with the `slivers` that each gets of those around it: one gives what it has to the 26
/// cells around it that it sees, in proportion theta / d^4 at the distance d.
fn shares(
    grid: &Grid,
    fraction: &[f64],
    filled: &[usize],
    slivers: &[Sliver],
    sees: impl Fn(&Vec3, usize) -> bool,
) -> Vec<f64> {
    let mut share: Vec<f64> = filled.iter().map(|&c| fraction[c]).collect();
    let mut number = vec![u32::MAX; fraction.len()];
    for (k, &c) in filled.iter().enumerate() {
        number[c] = k as u32;
    }
    for sliver in slivers {
        let here = coordinates(grid, sliver.cell);
        let weight = |c: usize| {
            let there = coordinates(grid, c);
            let square: usize = (0..3).map(|i| there[i].abs_diff(here[i]).pow(2)).sum();
            fraction[c] / (square * square).max(1) as f64
        };
        let around: Vec<usize> = neighbours(grid, here)
            .filter(|&c| c != sliver.cell && number[c] != u32::MAX && sees(&sliver.home, c))
            .collect();
        let total: f64 = around.iter().map(|&c| weight(c)).sum();
        for &c in &around {
            share[number[c] as usize] += sliver.fraction * weight(c) / total;
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

/// The piece of each of the given cells (in rising order): those of one piece hang together by faces, edges or corners.
fn pieces(grid: &Grid, filled: &[usize]) -> Vec<u32> {
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
    let mut numbers = Numbers::default();
    let mut piece = vec![0; filled.len()];
    for (r, run) in runs.iter().enumerate() {
        let number = numbers.of(root(&mut parent, r));
        piece[run.first..][..run.cells.1 - run.cells.0].fill(number);
    }
    piece
}

/// The piece of each of the given cells (in rising order): those of one piece hang together by faces, edges or corners across which they
/// see each other.
fn pieces_by(grid: &Grid, filled: &[usize], sees: impl Fn(usize, usize) -> bool) -> Vec<u32> {
    let mut number = vec![u32::MAX; grid.len()];
    for (k, &c) in filled.iter().enumerate() {
        number[c] = k as u32;
    }
    let mut parent: Vec<usize> = (0..filled.len()).collect();
    for (k, &c) in filled.iter().enumerate() {
        let before = neighbours(grid, coordinates(grid, c)).filter(|&other| other < c);
        for other in before.filter(|&other| number[other] != u32::MAX) {
            let (a, b) = (root(&mut parent, k), root(&mut parent, number[other] as usize));
            if a != b && sees(c, other) {
                parent[a.max(b)] = a.min(b);
            }
        }
    }
    let mut numbers = Numbers::default();
    (0..filled.len()).map(|k| numbers.of(root(&mut parent, k))).collect()
}

/// Numbers of pieces in the order in which their roots come.
#[derive(Default)]
struct Numbers(std::collections::HashMap<usize, u32>);

impl Numbers {
    fn of(&mut self, root: usize) -> u32 {
        let next = self.0.len() as u32;
        *self.0.entry(root).or_insert(next)
    }
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
fn trimmed(grid: &Grid, mut cells: Vec<[usize; 3]>) -> (Grid, Vec<[usize; 3]>) {
    let Some(&first) = cells.first() else {
        return (grid.clone(), cells);
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
    fn bodies_with_an_empty_cell_between_them_are_two_pieces() {
        let o = occupy(&two_boxes(1.0), unit_grid(), None);
        assert_eq!((o.cells.len(), o.grid.cells, o.sizes()), (35, [6, 3, 3], vec![27, 8]));
        assert_eq!(o.grid.origin, Vec3::zeros());
    }

    #[test]
    fn bodies_that_touch_are_one_piece_and_those_with_a_gap_are_two() {
        for (gap, sizes) in [(0.0, vec![35]), (1e-9, vec![35]), (1e-3, vec![27, 8]), (0.3, vec![27, 12])] {
            let shape = two_boxes(gap);
            let mut sight = Sight::new(shape.surface(), &unit_grid());
            let o = occupy(&shape, unit_grid(), sight.as_mut());
            assert_eq!(o.sizes(), sizes, "{gap}");
            assert_relative_eq!(o.share.iter().sum::<f64>(), 35.0, epsilon = 0.2);
        }
    }

    #[test]
    fn cells_come_in_x_fastest_order() {
        let o = occupy(&two_boxes(1.0), unit_grid(), None);
        let index: Vec<_> = o.cells.iter().map(|&c| o.grid.index(c)).collect();
        assert!(index.is_sorted() && coordinates(&o.grid, index[5]) == o.cells[5]);
    }

    proptest! {
        /// Runs give the pieces that the cells around each cell give.
        #[test]
        fn pieces_are_those_of_cells_side_by_side(
            size in prop::array::uniform3(1..7_usize),
            chance in 0.1..0.6_f64,
            noise in prop::collection::vec(0.0..1.0_f64, 216),
        ) {
            let grid = Grid { origin: Vec3::zeros(), spacing: 1.0, cells: size };
            let filled: Vec<usize> = (0..grid.len()).filter(|&c| noise[c] < chance).collect();
            prop_assert_eq!(pieces(&grid, &filled), pieces_by(&grid, &filled, |_, _| true));
        }
    }
}
