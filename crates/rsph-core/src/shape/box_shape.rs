//! An axis-aligned box.

use super::{Shape, check};
use crate::error::InvalidInput;
use crate::grid::{Bounds, Grid};
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use rayon::prelude::*;

/// An axis-aligned box.
#[derive(Clone, Debug)]
pub struct BoxShape {
    bounds: Bounds,
    surface: TriangleMesh,
}

impl BoxShape {
    /// A box of edge lengths `size` whose lower corner is `min`.
    ///
    /// # Errors
    /// `body.shape.box.size[i]` when a length is not positive and finite,
    /// `body.shape.box.corner[i]` when a coordinate is not finite.
    pub fn new(size: Vec3, min: Vec3) -> Result<Self, InvalidInput> {
        check::positive_vector("body.shape.box.size", &size)?;
        check::finite("body.shape.box.corner", &min)?;
        let bounds = Bounds { min, max: min + size };
        Ok(Self { surface: faces(&bounds), bounds })
    }
}

/// Twelve triangles. Bit i of a vertex number says whether it is at the upper end of axis i.
fn faces(b: &Bounds) -> TriangleMesh {
    let vertices =
        (0..8).map(|v| Vec3::from_fn(|i, _| if v >> i & 1 == 1 { b.max[i] } else { b.min[i] })).collect();
    let quads: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh { vertices, triangles }
}

impl Shape for BoxShape {
    fn name(&self) -> String {
        "box".into()
    }

    fn signed_distance(&self, x: &Vec3) -> f64 {
        let beyond = (self.bounds.min - x).sup(&(x - self.bounds.max));
        beyond.sup(&Vec3::zeros()).norm() + beyond.max().min(0.0)
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn volume(&self) -> f64 {
        self.bounds.size().product()
    }

    fn surface(&self) -> &TriangleMesh {
        &self.surface
    }

    fn is_box(&self) -> bool {
        true
    }

    fn fill(&self, grid: &Grid) -> Vec<f64> {
        let overlap: [Vec<f64>; 3] =
            std::array::from_fn(|i| (0..grid.cells[i]).map(|c| self.overlap(grid, i, c)).collect());
        let [nx, ny, _] = grid.cells;
        let mut fraction = vec![0.0; grid.len()];
        fraction.par_chunks_mut(nx.max(1)).enumerate().for_each(|(row, cells)| {
            let across = overlap[1][row % ny] * overlap[2][row / ny];
            for (theta, along) in cells.iter_mut().zip(&overlap[0]) {
                *theta = along * across;
            }
        });
        fraction
    }
}

impl BoxShape {
    /// The part of cell `c` along axis `i` that lies in the box, in spacings; exactly 1 for a cell
    /// that is inside but for rounding.
    fn overlap(&self, grid: &Grid, i: usize, c: usize) -> f64 {
        let low = (self.bounds.min[i] - grid.origin[i]) / grid.spacing;
        let high = (self.bounds.max[i] - grid.origin[i]) / grid.spacing;
        let part = (high.min(c as f64 + 1.0) - low.max(c as f64)).max(0.0);
        if part > 1.0 - 1e-9 { 1.0 } else { part }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn distance_is_exact_inside_and_outside() {
        let b = BoxShape::new(Vec3::new(2.0, 4.0, 6.0), Vec3::zeros()).unwrap();
        assert_relative_eq!(b.signed_distance(&Vec3::new(1.0, 2.0, 0.5)), -0.5);
        assert_relative_eq!(b.signed_distance(&Vec3::new(-3.0, -4.0, 3.0)), 5.0);
        assert_relative_eq!(b.signed_distance(&Vec3::new(2.0, 1.0, 1.0)), 0.0);
    }

    #[test]
    fn the_surface_is_closed_and_outward() {
        let b = BoxShape::new(Vec3::new(2.0, 4.0, 6.0), Vec3::repeat(-1.0)).unwrap();
        assert_relative_eq!(b.surface().volume(), 48.0, epsilon = 1e-12);
        assert_eq!(b.surface().genus(), Some(0));
    }

    #[test]
    fn cells_are_filled_exactly() {
        let b = BoxShape::new(Vec3::new(1.0, 1.0, 0.75), Vec3::zeros()).unwrap();
        let grid = Grid { origin: Vec3::zeros(), spacing: 0.5, cells: [2, 2, 2] };
        assert_eq!(b.fill(&grid), [1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 0.5]);
    }

    #[test]
    fn bad_sizes_name_their_key() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let e = BoxShape::new(Vec3::new(1.0, bad, 1.0), Vec3::zeros()).unwrap_err();
            assert_eq!(e.key, "body.shape.box.size[1]");
        }
        let e = BoxShape::new(Vec3::repeat(1.0), Vec3::new(0.0, 0.0, f64::NAN)).unwrap_err();
        assert_eq!(e.key, "body.shape.box.corner[2]");
    }
}
