//! A triangle surface: what readers deliver, bodies expose and the zero level set becomes.

use crate::tensor::Vec3;

/// A triangle surface. Triangles turn counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions (length unit of the scenario; metres in SI).
    pub vertices: Vec<Vec3>,
    /// Three vertex indices a triangle.
    pub triangles: Vec<[u32; 3]>,
}
