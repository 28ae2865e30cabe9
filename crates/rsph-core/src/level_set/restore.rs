//! Restoring a level set to the signed distance from its own surface, by fast sweeping.

use crate::grid::Grid;

/// Rounds of eight sweeps: one suffices for a convex surface, a second for most others.
const MAX_ROUNDS: usize = 8;

/// Makes `phi`, given at the cell centres of `grid` (x fastest, negative inside), the signed distance
/// from its zero level set: cells beside the surface get the distance of the plane through its
/// crossings with the grid lines, the others follow from |grad phi| = 1 by fast sweeping. The surface
/// stays where it is to second order. Without a surface nothing is changed.
pub fn restore(grid: &Grid, phi: &mut [f64]) {
    let mut distance: Vec<f64> = (0..phi.len()).map(|n| beside_surface(grid, phi, n)).collect();
    let fixed: Vec<bool> = distance.iter().map(|d| d.is_finite()).collect();
    if !fixed.contains(&true) {
        return;
    }
    for _ in 0..MAX_ROUNDS {
        if !sweep_all(grid, &mut distance, &fixed) {
            break;
        }
    }
    for (phi, d) in phi.iter_mut().zip(distance) {
        *phi = if *phi < 0.0 { -d } else { d };
    }
}

/// Distance of a cell from the surface if it lies between it and a neighbour, else infinity.
fn beside_surface(grid: &Grid, phi: &[f64], n: usize) -> f64 {
    let [nx, ny, _] = grid.cells;
    let (cell, strides) = ([n % nx, n / nx % ny, n / nx / ny], [1, nx, nx * ny]);
    let mut inverse2 = 0.0;
    for axis in 0..3 {
        let mut nearest = f64::INFINITY;
        let below = (cell[axis] > 0).then(|| n - strides[axis]);
        let above = (cell[axis] + 1 < grid.cells[axis]).then(|| n + strides[axis]);
        for m in below.into_iter().chain(above) {
            if (phi[n] < 0.0) != (phi[m] < 0.0) {
                nearest = nearest.min(grid.spacing * phi[n] / (phi[n] - phi[m]));
            }
        }
        inverse2 += nearest.powi(-2);
    }
    // 1/d^2 is the sum of 1/s_i^2 for a plane that cuts the axes at distances s_i.
    inverse2.powf(-0.5)
}

/// Sweeps in all eight directions; whether anything changed.
fn sweep_all(grid: &Grid, distance: &mut [f64], fixed: &[bool]) -> bool {
    let [nx, ny, nz] = grid.cells;
    let turned = |i: usize, n: usize, down: bool| if down { n - 1 - i } else { i };
    let mut changed = false;
    for direction in 0..8 {
        for n in 0..distance.len() {
            let i = turned(n % nx, nx, direction & 1 != 0);
            let j = turned(n / nx % ny, ny, direction & 2 != 0);
            let k = turned(n / nx / ny, nz, direction & 4 != 0);
            let n = (k * ny + j) * nx + i;
            if fixed[n] {
                continue;
            }
            let smaller = |i: usize, cells: usize, stride: usize| {
                let below = if i > 0 { distance[n - stride] } else { f64::INFINITY };
                let above = if i + 1 < cells { distance[n + stride] } else { f64::INFINITY };
                below.min(above)
            };
            let d = upwind([smaller(i, nx, 1), smaller(j, ny, nx), smaller(k, nz, nx * ny)], grid.spacing);
            if d < distance[n] * (1.0 - 1e-12) {
                distance[n] = d;
                changed = true;
            }
        }
    }
    changed
}

/// The solution of |grad d| = 1 from the smaller neighbour along each axis (Godunov's scheme).
fn upwind(mut near: [f64; 3], spacing: f64) -> f64 {
    near.sort_unstable_by(f64::total_cmp);
    let [a, b, c] = near;
    let mut d = a + spacing;
    if d > b {
        d = 0.5 * (a + b + (2.0 * spacing * spacing - (a - b).powi(2)).sqrt());
        if d > c {
            let (sum, square) = (a + b + c, a * a + b * b + c * c);
            d = (sum + (sum * sum - 3.0 * (square - spacing * spacing)).max(0.0).sqrt()) / 3.0;
        }
    }
    d
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level_set::volume_inside;
    use crate::tensor::Vec3;

    #[test]
    fn a_distorted_sphere_becomes_a_signed_distance_again() {
        let n = 40;
        let grid = Grid { origin: Vec3::zeros(), spacing: 1.0 / n as f64, cells: [n; 3] };
        let centre = Vec3::new(0.45, 0.5, 0.52);
        let exact: Vec<f64> = (0..grid.len())
            .map(|q| (grid.centre([q % n, q / n % n, q / n / n]) - centre).norm() - 0.27)
            .collect();
        // Steep on one side and flat on the other, with the same surface.
        let mut phi: Vec<f64> =
            exact.iter().enumerate().map(|(q, d)| d * (0.2 + 4.0 * (q % n) as f64 / n as f64)).collect();
        let before = volume_inside(&grid, &phi);
        restore(&grid, &mut phi);
        let after = volume_inside(&grid, &phi);
        let largest = phi
            .iter()
            .zip(&exact)
            .filter(|(_, e)| **e > -0.2)
            .map(|(p, e)| (p - e).abs())
            .fold(0.0, f64::max);
        assert!(largest < grid.spacing, "{largest}");
        assert!((after / before - 1.0).abs() < 0.01, "{before} {after}");
    }

    #[test]
    fn a_plane_is_restored_exactly_and_nothing_stays_nothing() {
        let grid = Grid { origin: Vec3::zeros(), spacing: 0.5, cells: [8, 4, 4] };
        let plane = |q: usize| (q % 8) as f64 * 0.5 - 1.7;
        let mut phi: Vec<f64> = (0..grid.len()).map(|q| 3.0 * plane(q)).collect();
        restore(&grid, &mut phi);
        for (q, p) in phi.iter().enumerate() {
            assert!((p - plane(q)).abs() < 1e-12, "{q} {p}");
        }
        let mut outside = vec![2.0; grid.len()];
        restore(&grid, &mut outside);
        assert!(outside.iter().all(|p| (p - 2.0).abs() < 1e-15));
    }
}
