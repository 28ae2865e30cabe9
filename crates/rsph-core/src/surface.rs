//! The body's surface: the zero level set as triangles, with the fields sampled on it.

use crate::mesh::TriangleMesh;

/// A field on the vertices of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceField {
    /// Name in files.
    pub name: &'static str,
    /// 1, 3 or 6 components.
    pub components: usize,
    /// Values, vertex by vertex (`components` values each).
    pub values: Vec<f64>,
}

/// The deformed surface of one moment.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Triangles at their current place.
    pub mesh: TriangleMesh,
    /// Fields on its vertices: those of the snapshot, `normal_strain` and `shear_strain`.
    pub fields: Vec<SurfaceField>,
}
