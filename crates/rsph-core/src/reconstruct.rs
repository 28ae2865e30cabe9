//! A field from the particles that carry it, Eq. (8), on a grid fine enough to take its surface.

use crate::grid::Grid;
use crate::kernel::QuarticSpline;
use crate::tensor::Vec3;
use rayon::prelude::*;

/// Most cells of a grid; with more, its spacing is doubled.
const MAX_CELLS: f64 = 5e7;

/// A grid of about that spacing around points, with a margin on all sides; its cell centres are at
/// (i + 1/2) spacing. A single cell if there is no (finite) point.
pub fn grid_around(points: &[Vec3], margin: f64, spacing: f64) -> Grid {
    let finite = || points.iter().filter(|x| x.iter().all(|c| c.is_finite()));
    let low = finite().fold(Vec3::repeat(f64::INFINITY), |m, x| m.inf(x));
    let high = finite().fold(Vec3::repeat(f64::NEG_INFINITY), |m, x| m.sup(x));
    if finite().next().is_none() {
        return Grid { origin: Vec3::zeros(), spacing, cells: [1; 3] };
    }
    let mut spacing = spacing;
    loop {
        let first = low.map(|c| ((c - margin) / spacing).floor());
        let count = high.map(|c| ((c + margin) / spacing).ceil()) - first;
        if count.product() <= MAX_CELLS {
            let cells = std::array::from_fn(|i| count[i].max(1.0) as usize);
            return Grid { origin: first * spacing, spacing, cells };
        }
        spacing *= 2.0;
    }
}

/// C(x) = sum_p amount_p W(x - x_p), Eq. (8), at the cell centres of `grid` (x fastest); `amount` is
/// the extensive quantity, c V.
pub fn reconstruct(positions: &[Vec3], amount: &[f64], smoothing_length: f64, grid: &Grid) -> Vec<f64> {
    let kernel = QuarticSpline::<3>::new(smoothing_length);
    let support = kernel.support();
    // Particles by the plane of cells that they are in, in a fixed order within it.
    let plane_of = |z: f64| (z - grid.origin.z) / grid.spacing;
    let mut order: Vec<(i64, u32)> = positions
        .iter()
        .enumerate()
        .filter(|(_, x)| x.iter().all(|c| c.is_finite()))
        .map(|(p, x)| (plane_of(x.z).floor() as i64, p as u32))
        .collect();
    order.sort_unstable();
    let planes = (support / grid.spacing).ceil() as i64 + 1;
    let [nx, ny, _] = grid.cells;
    let mut field = vec![0.0; grid.len()];
    field.par_chunks_mut(nx * ny).enumerate().for_each(|(k, plane)| {
        let first = order.partition_point(|o| o.0 < k as i64 - planes);
        let near = order[first..].iter().take_while(|o| o.0 <= k as i64 + planes);
        for p in near.map(|o| o.1 as usize) {
            add(plane, grid, k, &positions[p], amount[p], &kernel);
        }
    });
    field
}

/// Cells whose centres are within `radius` of `x` along an axis.
fn within(grid: &Grid, axis: usize, x: f64, radius: f64) -> std::ops::Range<usize> {
    let q = |x: f64| (x - grid.origin[axis]) / grid.spacing - 0.5;
    let end = (q(x + radius).floor() + 1.0).max(0.0) as usize;
    let start = q(x - radius).ceil().max(0.0) as usize;
    start..end.min(grid.cells[axis]).max(start)
}

/// Adds one particle to plane `k`.
fn add(plane: &mut [f64], grid: &Grid, k: usize, x: &Vec3, amount: f64, kernel: &QuarticSpline<3>) {
    let centre = |axis: usize, i: usize| grid.origin[axis] + (i as f64 + 0.5) * grid.spacing;
    let support2 = kernel.support().powi(2);
    let z2 = (centre(2, k) - x.z).powi(2);
    if z2 >= support2 {
        return;
    }
    for j in within(grid, 1, x.y, (support2 - z2).sqrt()) {
        let yz2 = z2 + (centre(1, j) - x.y).powi(2);
        let along = within(grid, 0, x.x, (support2 - yz2).max(0.0).sqrt());
        let start = along.start;
        for (i, value) in plane[j * grid.cells[0]..][along].iter_mut().enumerate() {
            let r = (yz2 + (centre(0, start + i) - x.x).powi(2)).sqrt();
            *value += amount * kernel.value(r); // Eq. (8)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_over_the_grid_is_the_sum_over_particles() {
        let points = [Vec3::new(0.31, -0.2, 0.77), Vec3::new(0.5, 0.1, 0.7), Vec3::repeat(f64::NAN)];
        let h = 0.1;
        let grid = grid_around(&points, 2.5 * h, 0.25 * h);
        let field = reconstruct(&points, &[2.0, -0.5, 1.0], h, &grid);
        let total: f64 = field.iter().sum::<f64>() * grid.spacing.powi(3);
        assert!((total - 1.5).abs() < 1e-3, "{total}");
        let direct = |x: &Vec3| {
            let w = QuarticSpline::<3>::new(h);
            2.0 * w.value((x - points[0]).norm()) - 0.5 * w.value((x - points[1]).norm())
        };
        for c in [[4, 5, 6], [10, 12, 9], [0, 0, 0]] {
            let difference = field[grid.index(c)] - direct(&grid.centre(c));
            assert!(difference.abs() < 1e-10, "{c:?} {difference}");
        }
    }

    #[test]
    fn grids_stay_finite() {
        let far = [Vec3::zeros(), Vec3::new(1e6, 1e3, 0.0)];
        assert!(grid_around(&far, 0.1, 1e-3).len() as f64 <= MAX_CELLS);
        assert_eq!(grid_around(&[], 0.1, 1e-3).len(), 1);
    }
}
