//! The level set that particles carry: surface normals, Eq. (15), the volume inside, and its
//! restoring to a signed distance.

mod restore;

pub use restore::restore;

use crate::grid::Grid;
use crate::kernel::QuarticSpline;
use crate::neighbors::Pairs;
use crate::tensor::Vec3;
use rayon::prelude::*;

/// Unit normals n = grad phi / |grad phi| of every particle, Eq. (15), with the gradient by Eq. (10);
/// zero where the gradient vanishes.
pub fn normals(
    positions: &[Vec3],
    volume: &[f64],
    level_set: &[f64],
    pairs: &Pairs,
    kernel: &QuarticSpline<3>,
) -> Vec<Vec3> {
    (0..positions.len())
        .into_par_iter()
        .map(|a| {
            let mut gradient = Vec3::zeros();
            for &b in pairs.of(a) {
                let b = b as usize;
                let x = positions[b] - positions[a];
                let r = x.norm();
                if r > 0.0 {
                    let w = kernel.gradient_weight(r);
                    gradient += volume[b] * (level_set[b] - level_set[a]) * w * x; // Eq. (10)
                }
            }
            gradient.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vec3::zeros)
        })
        .collect()
}

/// Volume in which `phi`, given at the cell centres of `grid` (x fastest), is negative. A cell that
/// the surface passes counts by the distance of its centre from the surface.
pub fn volume_inside(grid: &Grid, phi: &[f64]) -> f64 {
    let [nx, ny, nz] = grid.cells;
    let plane = |k: usize| -> f64 {
        let mut cells = 0.0;
        for j in 0..ny {
            for i in 0..nx {
                let at = |i, j, k| phi[grid.index([i, j, k])];
                let value = at(i, j, k);
                // Difference of the neighbours along an axis, at its ends to one side.
                let slope = |low: f64, high: f64, cells: usize| (high - low) / cells.max(1) as f64;
                let (i0, i1) = (i.saturating_sub(1), (i + 1).min(nx - 1));
                let (j0, j1) = (j.saturating_sub(1), (j + 1).min(ny - 1));
                let (k0, k1) = (k.saturating_sub(1), (k + 1).min(nz - 1));
                let gradient = Vec3::new(
                    slope(at(i0, j, k), at(i1, j, k), i1 - i0),
                    slope(at(i, j0, k), at(i, j1, k), j1 - j0),
                    slope(at(i, j, k0), at(i, j, k1), k1 - k0),
                )
                .norm();
                // Within half a cell of the surface a share, else all or nothing.
                cells += if gradient > 0.0 {
                    (0.5 - value / gradient).clamp(0.0, 1.0)
                } else {
                    f64::from(u8::from(value < 0.0))
                };
            }
        }
        cells
    };
    // Planes are summed in order, whoever computes them.
    let planes: Vec<f64> = (0..nz).into_par_iter().map(plane).collect();
    planes.iter().sum::<f64>() * grid.spacing.powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_volume_inside_a_sphere() {
        let grid = Grid { origin: Vec3::zeros(), spacing: 0.05, cells: [20; 3] };
        let centre = Vec3::new(0.51, 0.48, 0.5);
        for (scale, radius) in [(1.0, 0.3), (-20.0, 0.41)] {
            let phi: Vec<f64> = (0..grid.len())
                .map(|q| grid.centre([q % 20, q / 20 % 20, q / 400]))
                .map(|x| scale * ((x - centre).norm() - radius))
                .collect();
            let ball = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
            let expected = if scale > 0.0 { ball } else { 1.0 - ball };
            let volume = volume_inside(&grid, &phi);
            assert!((volume / expected - 1.0).abs() < 1e-2, "{volume} {expected}");
        }
    }

    #[test]
    fn normals_of_a_plane_and_a_sphere() {
        let dx = 0.1;
        let n = 9;
        let positions: Vec<Vec3> = (0..n * n * n)
            .map(|k| Vec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64) * dx)
            .collect();
        let volume = vec![dx * dx * dx; positions.len()];
        let kernel = QuarticSpline::<3>::new(1.25 * dx);
        let pairs = Pairs::new(&positions, kernel.support());
        let direction = Vec3::new(1.0, -2.0, 0.5).normalize();
        let centre = Vec3::repeat(-1.0);
        let plane: Vec<f64> = positions.iter().map(|x| x.dot(&direction)).collect();
        let sphere: Vec<f64> = positions.iter().map(|x| (x - centre).norm() - 1.0).collect();
        let middle = (n * n * n) / 2;
        let from_plane = normals(&positions, &volume, &plane, &pairs, &kernel);
        assert!((from_plane[middle] - direction).norm() < 1e-12);
        let from_sphere = normals(&positions, &volume, &sphere, &pairs, &kernel);
        assert!((from_sphere[middle] - (positions[middle] - centre).normalize()).norm() < 1e-2);
    }
}
