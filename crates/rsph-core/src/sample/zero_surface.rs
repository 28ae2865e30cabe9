//! The body's surface on its lattice: the zero of the level set, with the topology of the shape.

use super::lattice::{MARGIN, MAX_CELLS};
use super::occupy::Occupied;
use crate::grid::Grid;
use crate::marching_cubes::zero_level_set;
use crate::mesh::TriangleMesh;
use crate::shape::Shape;
use crate::tensor::Vec3;
use rayon::prelude::*;

/// How often the grid may be refined by two to find the topology of the shape.
const REFINEMENTS: usize = 4;
/// Distance from the surface, in spacings, up to which the level set must be exact outside.
const BAND: f64 = 2.0;

/// The level set at the particles and its zero.
pub(super) struct ZeroSurface {
    /// Signed distance at each particle.
    pub(super) level_set: Vec<f64>,
    /// Closed, outward-oriented triangles.
    pub(super) surface: TriangleMesh,
}

/// The level set of `shape` at the particles, and its zero by marching cubes on the lattice of
/// cell centres, extended by two cells all round. Where the lattice is too coarse to show the
/// shape's own number of pieces and handles, the grid is refined by two until it does.
pub(super) fn zero_surface(shape: &dyn Shape, body: &Occupied) -> ZeroSurface {
    let mut grid = extended(shape, &body.grid);
    let mut phi = shape.signed_distances(&grid, BAND * grid.spacing);
    let offset = offset_of(&body.grid, &grid);
    let level_set = body
        .cells
        .iter()
        .map(|c| phi[grid.index([c[0] + offset[0], c[1] + offset[1], c[2] + offset[2]])])
        .collect();

    let own = shape.surface();
    let expected = (own.components(), own.euler_characteristic());
    let mut surface = zero_level_set(&grid, &phi);
    for _ in 0..REFINEMENTS {
        let found = (surface.components(), surface.euler_characteristic());
        if found == expected || 8 * grid.len() > MAX_CELLS as usize {
            break;
        }
        (grid, phi) = refined(shape, &grid, &phi);
        surface = zero_level_set(&grid, &phi);
    }
    ZeroSurface { level_set, surface }
}

/// The lattice of the body, extended to two cells beyond the shape.
fn extended(shape: &dyn Shape, lattice: &Grid) -> Grid {
    let bounds = shape.bounds();
    let mut grid = lattice.clone();
    for i in 0..3 {
        let dx = lattice.spacing;
        let below = ((lattice.origin[i] - bounds.min[i]) / dx).ceil().max(0.0) as usize + MARGIN;
        let top = lattice.origin[i] + lattice.cells[i] as f64 * dx;
        let above = ((bounds.max[i] - top) / dx).ceil().max(0.0) as usize + MARGIN;
        grid.origin[i] -= below as f64 * dx;
        grid.cells[i] += below + above;
    }
    grid
}

/// Cells of `outer` below the first cell of `inner`, a part of the same lattice.
fn offset_of(inner: &Grid, outer: &Grid) -> [usize; 3] {
    std::array::from_fn(|i| ((inner.origin[i] - outer.origin[i]) / inner.spacing).round() as usize)
}

/// The values of a function of cell and cell centre on all cells.
fn on_rows(grid: &Grid, value: impl Fn([usize; 3], &Vec3) -> f64 + Sync) -> Vec<f64> {
    let [nx, ny, _] = grid.cells;
    let mut values = vec![0.0; grid.len()];
    values.par_chunks_mut(nx).enumerate().for_each(|(row, along_x)| {
        for (i, v) in along_x.iter_mut().enumerate() {
            let cell = [i, row % ny, row / ny];
            *v = value(cell, &grid.centre(cell));
        }
    });
    values
}

/// The level set on a grid of half the spacing; far from the surface a cell keeps the value of the
/// cell it is a part of, which has the same sign.
fn refined(shape: &dyn Shape, grid: &Grid, phi: &[f64]) -> (Grid, Vec<f64>) {
    let fine = Grid { origin: grid.origin, spacing: 0.5 * grid.spacing, cells: grid.cells.map(|n| 2 * n) };
    let values = on_rows(&fine, |cell, x| {
        let coarse = phi[grid.index(cell.map(|c| c / 2))];
        if coarse.abs() > BAND * grid.spacing { coarse } else { shape.signed_distance(x) }
    });
    (fine, values)
}

#[cfg(test)]
mod tests {
    use crate::mesh::TriangleMesh;
    use crate::sample::{Resolution, WhyLeftOut, sample};
    use crate::shape::{BoxShape, MeshShape, Shape, SphereShape};
    use crate::tensor::Vec3;
    use approx::assert_relative_eq;

    fn with(mesh: &mut TriangleMesh, other: &TriangleMesh) {
        let n = mesh.vertices.len() as u32;
        mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + n)));
        mesh.vertices.extend(&other.vertices);
    }

    #[test]
    fn the_surface_of_a_box_lies_on_its_faces() {
        let cube = BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap();
        let body = sample(&cube, Resolution::Particles(343), &[]).unwrap();
        let b = body.surface.bounds().unwrap();
        assert_relative_eq!(b.min, Vec3::zeros(), epsilon = 1e-9);
        assert_relative_eq!(b.max, Vec3::repeat(1.0), epsilon = 1e-9);
        assert_eq!(body.surface.genus(), Some(0));
    }

    #[test]
    fn a_gap_thinner_than_the_lattice_is_found_by_refining() {
        let mut mesh = BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap().surface().clone();
        let right = BoxShape::new(Vec3::repeat(1.0), Vec3::new(1.09, 0.0, 0.0)).unwrap();
        with(&mut mesh, right.surface());
        let shape = MeshShape::new(&mesh, "mesh two").unwrap().0;
        let body = sample(&shape, Resolution::Spacing(0.25), &[]).unwrap();
        assert_eq!((body.surface.components(), body.pieces()), (2, 2));
        assert!(body.dropped_volume == 0.0);
    }

    #[test]
    fn a_piece_that_is_left_out_has_no_surface() {
        let mut mesh = SphereShape::new(1.0, Vec3::zeros()).unwrap().surface().clone();
        with(&mut mesh, SphereShape::new(0.5, Vec3::new(3.0, 0.0, 0.0)).unwrap().surface());
        let shape = MeshShape::new(&mesh, "mesh two").unwrap().0;
        let mut body = sample(&shape, Resolution::Spacing(0.2), &[]).unwrap();
        assert_eq!((body.surface.components(), body.pieces()), (2, 2));
        assert_relative_eq!(body.volume(), shape.volume(), max_relative = 1e-9);
        body.leave_out(&shape, &[true, false], WhyLeftOut::Unheld);
        assert_eq!((body.surface.components(), body.pieces()), (1, 1));
        assert_relative_eq!(body.dropped_volume, std::f64::consts::PI / 6.0, max_relative = 0.03);
        assert_relative_eq!(body.volume(), shape.volume() * 8.0 / 9.0, max_relative = 0.01);
        assert!(body.surface.bounds().unwrap().max.x < 1.1);
        assert!(body.kept_surface.unwrap().bounds().unwrap().max.x < 1.1);
        assert_relative_eq!(body.left_out[0].centre(), Vec3::new(3.0, 0.0, 0.0), epsilon = 0.02);
    }
}
