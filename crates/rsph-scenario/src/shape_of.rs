//! The body's shape from its table: the one place that knows how shapes are built.

use crate::mesh_io::read_mesh;
use crate::scenario::{BodyTable, Document, KeyPath, ScenarioError, ShapeTable};
use rsph_core::shape::{
    BoxShape, CylinderShape, DiscShape, MeshShape, RectangleShape, Shape, SphereShape, organ,
};
use rsph_core::tensor::Vec3;
use std::path::Path;
use std::sync::Arc;

/// The shape of the body, and what the user should know about it (one sentence each). A relative
/// mesh path starts at `base_dir`.
///
/// # Errors
/// A size out of range, or a mesh that can not be read or is no closed surface.
pub fn shape_of(
    doc: &Document,
    body: &BodyTable,
    base_dir: &Path,
) -> Result<(Arc<dyn Shape>, Vec<String>), ScenarioError> {
    let refused = |e| doc.invalid_input(&e);
    let plain = |shape: Arc<dyn Shape>| Ok((shape, Vec::new()));
    match &body.shape {
        ShapeTable::Box { size, corner } => {
            plain(Arc::new(BoxShape::new(Vec3::from(*size), Vec3::from(*corner)).map_err(refused)?))
        }
        ShapeTable::Sphere { radius, centre } => {
            plain(Arc::new(SphereShape::new(*radius, Vec3::from(*centre)).map_err(refused)?))
        }
        ShapeTable::Cylinder { radius, height, axis, centre } => plain(Arc::new(
            CylinderShape::new(axis.axis(), *radius, *height, Vec3::from(*centre)).map_err(refused)?,
        )),
        ShapeTable::Rectangle { size, corner } => {
            plain(Arc::new(RectangleShape::new(*size, *corner).map_err(refused)?))
        }
        ShapeTable::Disc { radius, centre } => {
            plain(Arc::new(DiscShape::new(*radius, *centre).map_err(refused)?))
        }
        ShapeTable::Organ(name) => plain(Arc::new(organ(&name.0).map_err(refused)?)),
        ShapeTable::Mesh { path, scale } => {
            let place = KeyPath::from("body.shape.mesh");
            if *scale <= 0.0 {
                return Err(doc.error(
                    &place.key("scale"),
                    "the scale of a mesh must be greater than 0",
                    "1.0 if the mesh is in the units of the scenario, 0.001 from mm to m",
                ));
            }
            let file = base_dir.join(path);
            let mesh = read_mesh(&file, *scale).map_err(|e| {
                doc.error(&place.key("path"), format!("{}: {}", e.path().display(), e.problem()), e.remedy())
            })?;
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let (shape, notes) = MeshShape::new(&mesh, &format!("mesh {name}")).map_err(refused)?;
            Ok((Arc::new(shape), notes))
        }
    }
}
