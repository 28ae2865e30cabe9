//! Inside fractions of cells by sub-sampling a signed distance.

use crate::sample::Grid;
use crate::tensor::Vec3;
use rayon::prelude::*;

/// Sub-cells along each edge of a cell.
const SUBDIVISIONS: usize = 6;

/// Inside fractions of all cells of `grid`, x fastest, for the interior of an exact signed
/// distance. Each of 6^3 sub-cells of width delta counts clip(1/2 - phi/delta), which is exact for
/// a face that is parallel to the lattice; only cells that the surface can touch are divided.
pub(super) fn fill_by_distance(grid: &Grid, distance: impl Fn(&Vec3) -> f64 + Sync) -> Vec<f64> {
    let [nx, ny, _] = grid.cells;
    let reach = 0.5 * 3.0_f64.sqrt() * grid.spacing;
    let mut fraction = vec![0.0; grid.len()];
    fraction.par_chunks_mut(nx.max(1)).enumerate().for_each(|(row, cells)| {
        for (i, theta) in cells.iter_mut().enumerate() {
            let centre = grid.centre([i, row % ny, row / ny]);
            let phi = distance(&centre);
            *theta = if phi.abs() >= reach {
                f64::from(u8::from(phi < 0.0))
            } else {
                divided(&centre, grid.spacing, &distance)
            };
        }
    });
    fraction
}

/// Inside fraction of one cell by its sub-cells.
fn divided(centre: &Vec3, spacing: f64, distance: &impl Fn(&Vec3) -> f64) -> f64 {
    let delta = spacing / SUBDIVISIONS as f64;
    let offset = |i: usize| (i as f64 + 0.5) * delta - 0.5 * spacing;
    let mut sum = 0.0;
    for k in 0..SUBDIVISIONS {
        for j in 0..SUBDIVISIONS {
            for i in 0..SUBDIVISIONS {
                let x = centre + Vec3::new(offset(i), offset(j), offset(k));
                sum += (0.5 - distance(&x) / delta).clamp(0.0, 1.0);
            }
        }
    }
    let theta = sum / SUBDIVISIONS.pow(3) as f64;
    // A cell that is full but for rounding is full.
    if theta > 1.0 - 1e-9 { 1.0 } else { theta }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A half-space parallel to the lattice fills its cells exactly, wherever it cuts.
        #[test]
        fn an_aligned_face_is_exact(at in 0.0..3.0_f64) {
            let grid = Grid { origin: Vec3::zeros(), spacing: 1.0, cells: [3, 1, 1] };
            let fraction = fill_by_distance(&grid, |x| x.x - at);
            for (i, theta) in fraction.iter().enumerate() {
                let expected = (at - i as f64).clamp(0.0, 1.0);
                prop_assert!((theta - expected).abs() < 1e-9, "{theta} {expected}");
            }
        }
    }
}
