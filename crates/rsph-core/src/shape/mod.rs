//! Shapes of bodies: anything with a signed distance and a surface. One shape a file.

use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use std::fmt::Debug;

/// An axis-aligned bounding box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl Bounds {
    /// Edge lengths.
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }
}

/// The shape of a body in its undeformed state.
pub trait Shape: Debug + Send + Sync {
    /// Name for messages and summaries, e.g. `box`, `organ liver`, `mesh liver.stl`.
    fn name(&self) -> String;

    /// Signed distance from `x` to the surface, negative inside.
    fn signed_distance(&self, x: &Vec3) -> f64;

    /// Tight bounding box.
    fn bounds(&self) -> Bounds;

    /// Volume enclosed by the surface.
    fn volume(&self) -> f64;

    /// The surface as closed, outward-oriented triangles (curved shapes: fine enough that volume
    /// and area hold to about 0.1 %).
    fn surface(&self) -> &TriangleMesh;

    /// For a shape whose faces are those of its bounding box: true. Loads on such faces use the
    /// area vectors of the operator, curved ones a quadrature over the triangles.
    fn is_box(&self) -> bool {
        false
    }

    /// Inside fractions (0 to 1) of all cells of a grid, x fastest.
    fn fill(&self, grid: &crate::sample::Grid) -> Vec<f64>;
}
