//! Shapes of bodies: anything with a signed distance and a surface. One shape a file.

mod box_shape;
pub(crate) mod check;
mod columns;
mod cut;
mod cylinder;
mod disc;
mod fill;
mod implicit;
mod kidney;
mod liver;
mod polygon;
mod rectangle;
mod repair;
mod slab;
mod sphere;
mod triangle_mesh;
mod voxels;

pub use box_shape::BoxShape;
pub use cut::cut;
pub use cylinder::CylinderShape;
pub use disc::DiscShape;
pub use polygon::PolygonShape;
pub use rectangle::RectangleShape;
pub use repair::{Repair, winding_field};
pub use sphere::SphereShape;
pub use triangle_mesh::MeshShape;
pub use voxels::{Placement, Run, voxel_shape};

use crate::error::InvalidInput;
use crate::grid::{Bounds, Grid};
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use rayon::prelude::*;
use std::fmt::Debug;

/// The shape of a body in its undeformed state.
pub trait Shape: Debug + Send + Sync {
    /// Name for messages and summaries, e.g. `box`, `organ liver`, `mesh liver.stl`.
    fn name(&self) -> String;

    /// 3, or 2 for a plane body: its surface and volume are those of a slab of thickness one about z = 0,
    /// and its signed distance ignores z.
    fn dimension(&self) -> usize {
        3
    }

    /// Signed distance from `x` to the surface, negative inside.
    fn signed_distance(&self, x: &Vec3) -> f64;

    /// Signed distances at the centres of all cells of a grid, x fastest. Outside and farther than `reach`
    /// from the surface a value may be less than the distance, but not less than `reach`.
    fn signed_distances(&self, grid: &Grid, _reach: f64) -> Vec<f64> {
        let [nx, ny, _] = grid.cells;
        let mut values = vec![0.0; grid.len()];
        values.par_chunks_mut(nx.max(1)).enumerate().for_each(|(row, along_x)| {
            for (i, value) in along_x.iter_mut().enumerate() {
                *value = self.signed_distance(&grid.centre([i, row % ny, row / ny]));
            }
        });
        values
    }

    /// Tight bounding box.
    fn bounds(&self) -> Bounds;

    /// Volume enclosed by the surface.
    fn volume(&self) -> f64 {
        self.surface().volume()
    }

    /// The surface as closed, outward-oriented triangles (curved shapes: fine enough that volume
    /// and area hold to about 0.1 %).
    fn surface(&self) -> &TriangleMesh;

    /// For a shape whose faces are those of its bounding box: true. The lattice starts at its lower corner.
    fn is_box(&self) -> bool {
        false
    }

    /// How the given surface became this one, if it was open or overlapped itself.
    fn repair(&self) -> Option<&Repair> {
        None
    }

    /// Inside fractions (0 to 1) of all cells of a grid, x fastest; by the signed distance, if not said otherwise.
    fn fill(&self, grid: &Grid) -> Vec<f64> {
        fill::fill_by_distance(grid, |x| self.signed_distance(x))
    }
}

/// An analytic organ: its name in scenarios and how it is built.
type Organ = (&'static str, fn() -> MeshShape);

/// The analytic organs. Axes as in the meshes of real organs: x from the right side of the body
/// to its left, y up, z to the front; metres; about centred on the origin.
const ORGANS: &[Organ] = &[("liver", liver::liver), ("kidney", kidney::kidney)];

/// Names of the analytic organs.
pub fn organ_names() -> impl Iterator<Item = &'static str> {
    ORGANS.iter().map(|(name, _)| *name)
}

/// The analytic organ of that name, of adult size in metres.
///
/// # Errors
/// `body.shape.organ` when there is no organ of that name.
pub fn organ(name: &str) -> Result<MeshShape, InvalidInput> {
    let known = ORGANS.iter().find(|(n, _)| *n == name);
    known.map(|(_, build)| build()).ok_or_else(|| {
        let names: Vec<_> = organ_names().map(|n| format!("\"{n}\"")).collect();
        InvalidInput::new(
            "body.shape.organ",
            format!("\"{name}\""),
            "there is no analytic organ of that name",
            format!("choose one of {}, or give a surface by `mesh = {{ path = ... }}`", names.join(", ")),
        )
    })
}
