//! The zero level set of a scalar grid as triangles.

use crate::mesh::TriangleMesh;
use crate::sample::Grid;
use crate::tensor::Vec3;
use splashsurf_lib::marching_cubes::triangulate_density_map;
use splashsurf_lib::nalgebra::Vector3;
use splashsurf_lib::{DensityMap, UniformGrid};

/// Values nearer to zero than this many spacings are moved away from it: a surface through a grid
/// point itself would give triangles without area.
const SMALLEST: f64 = 1e-4;

/// The zero level set of `phi`, given at the cell centres of `grid` (x fastest, negative inside),
/// by marching cubes: outward-oriented, and closed if `phi` is positive in the outermost cells. A
/// value that is not a number counts as outside. Empty if the grid is thinner than two cells or
/// `phi` does not have one value a cell.
pub fn zero_level_set(grid: &Grid, phi: &[f64]) -> TriangleMesh {
    let [nx, ny, nz] = grid.cells;
    if grid.cells.iter().any(|&n| n < 2) || phi.len() != grid.len() {
        return TriangleMesh::default();
    }
    let first = grid.centre([0, 0, 0]);
    let origin = Vector3::new(first.x, first.y, first.z);
    let cubes = grid.cells.map(|n| n as i64 - 1);
    let Ok(points) = UniformGrid::<i64, f64>::new(&origin, &cubes, grid.spacing) else {
        return TriangleMesh::default();
    };
    let smallest = SMALLEST * grid.spacing;
    let mut density = Vec::with_capacity(phi.len());
    for i in 0..nx {
        for j in 0..ny {
            for k in 0..nz {
                let value = phi[grid.index([i, j, k])];
                density.push(if value <= 0.0 { (-value).max(smallest) } else { (-value).min(-smallest) });
            }
        }
    }
    triangulate_density_map(&points, &DensityMap::from(density), 0.0)
        .map(|mesh| {
            let vertices = mesh.vertices.iter().map(|v| Vec3::new(v.x, v.y, v.z)).collect();
            // The library's order of triangles is that of a hash table: bring them in order.
            let mut triangles: Vec<_> =
                mesh.triangles.iter().map(|t| smallest_first(t.map(|v| v as u32))).collect();
            triangles.sort_unstable();
            TriangleMesh { vertices, triangles }
        })
        .unwrap_or_default()
}

fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn values(grid: &Grid, phi: impl Fn(&Vec3) -> f64) -> Vec<f64> {
        let [nx, ny, nz] = grid.cells;
        let mut all = Vec::new();
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    all.push(phi(&grid.centre([i, j, k])));
                }
            }
        }
        all
    }

    #[test]
    fn a_ball_is_closed_outward_and_second_order() {
        let mut errors = Vec::new();
        for n in [12, 24] {
            let grid = Grid { origin: Vec3::repeat(-1.5), spacing: 3.0 / n as f64, cells: [n; 3] };
            let m = zero_level_set(&grid, &values(&grid, |x| (x - Vec3::new(0.1, 0.2, 0.0)).norm() - 1.0));
            assert_eq!(m.genus(), Some(0));
            errors.push((m.volume() / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs());
        }
        assert!(errors[1] < 0.3 * errors[0] && errors[1] < 0.01, "{errors:?}");
    }

    #[test]
    fn a_surface_through_grid_points_is_sound() {
        let grid = Grid { origin: Vec3::zeros(), spacing: 1.0, cells: [7, 6, 5] };
        let m = zero_level_set(&grid, &values(&grid, |x| (x - Vec3::new(3.5, 2.5, 2.5)).amax() - 1.0));
        assert_eq!((m.components(), m.genus()), (1, Some(0)));
        assert_relative_eq!(m.bounds().unwrap().size(), Vec3::repeat(2.0), epsilon = 1e-3);
    }

    #[test]
    fn unusable_grids_give_nothing() {
        let grid = Grid { origin: Vec3::zeros(), spacing: 1.0, cells: [1, 5, 5] };
        assert!(zero_level_set(&grid, &[0.0; 25]).triangles.is_empty());
        let grid = Grid { origin: Vec3::zeros(), spacing: 1.0, cells: [3, 3, 3] };
        assert!(zero_level_set(&grid, &[0.0; 5]).triangles.is_empty());
        assert!(zero_level_set(&grid, &[f64::NAN; 27]).triangles.is_empty());
    }

    proptest! {
        /// Noise, with every ambiguous cube in it, still gives a closed surface.
        #[test]
        fn any_field_gives_a_closed_surface(noise in prop::collection::vec(-1.0..1.0_f64, 64)) {
            let grid = Grid { origin: Vec3::zeros(), spacing: 1.0, cells: [6; 3] };
            let mut phi = vec![1.0; 216];
            for (n, value) in noise.iter().enumerate() {
                phi[grid.index([1 + n % 4, 1 + n / 4 % 4, 1 + n / 16])] = *value;
            }
            let m = zero_level_set(&grid, &phi);
            let balanced = m.open_edges().len();
            prop_assert_eq!(balanced, 0);
            prop_assert_eq!(&m, &zero_level_set(&grid, &phi));
        }
    }
}
