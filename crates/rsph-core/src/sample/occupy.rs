//! Which cells of a lattice the body occupies.

use super::{Grid, MIN_FRACTION};
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
    let dropped_volume = if piece.len() == filled.len() { 0.0 } else { dropped * grid.spacing.powi(3) };
    let cells: Vec<_> = piece.iter().map(|&c| coordinates(&grid, c)).collect();
    let (grid, cells) = trimmed(grid, cells);
    Occupied { grid, cells, fraction: piece.iter().map(|&c| fraction[c]).collect(), dropped_volume }
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

/// The largest set of the given cells (in rising order) that hangs together by faces, edges or
/// corners, in rising order; the first one of equally large ones.
fn largest_piece(grid: &Grid, filled: &[usize]) -> Vec<usize> {
    const EMPTY: u32 = u32::MAX;
    const UNSEEN: u32 = u32::MAX - 1;
    let mut piece_of = vec![EMPTY; grid.len()];
    for &c in filled {
        piece_of[c] = UNSEEN;
    }
    let mut sizes: Vec<usize> = Vec::new();
    let mut open = Vec::new();
    for &seed in filled {
        if piece_of[seed] != UNSEEN {
            continue;
        }
        let piece = sizes.len() as u32;
        sizes.push(0);
        piece_of[seed] = piece;
        open.push(seed);
        while let Some(cell) = open.pop() {
            sizes[piece as usize] += 1;
            for n in neighbours(grid, coordinates(grid, cell)) {
                if piece_of[n] == UNSEEN {
                    piece_of[n] = piece;
                    open.push(n);
                }
            }
        }
    }
    let largest = sizes.iter().max().and_then(|max| sizes.iter().position(|s| s == max));
    filled.iter().copied().filter(|&c| Some(piece_of[c] as usize) == largest).collect()
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
}
