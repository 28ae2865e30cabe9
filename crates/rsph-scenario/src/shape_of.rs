//! The body's shape from its table: the one place that knows how shapes are built.

use crate::mesh_io::read_mesh;
use crate::scenario::{BodyTable, Document, KeyPath, OrganName, ScenarioError, ShapeTable};
use rsph_core::error::InvalidInput;
use rsph_core::shape::{self, BoxShape, CylinderShape, MeshShape, Shape, SphereShape};
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
    let refuse = |e: &InvalidInput| doc.invalid_input(e);
    let analytic = |shape: Arc<dyn Shape>| Ok((shape, Vec::new()));
    match &body.shape {
        ShapeTable::Box { size, corner } => {
            analytic(Arc::new(BoxShape::new((*size).into(), (*corner).into()).map_err(|e| refuse(&e))?))
        }
        ShapeTable::Sphere { radius, centre } => {
            analytic(Arc::new(SphereShape::new(*radius, (*centre).into()).map_err(|e| refuse(&e))?))
        }
        ShapeTable::Cylinder { radius, height, axis, centre } => analytic(Arc::new(
            CylinderShape::new(axis.axis(), *radius, *height, (*centre).into()).map_err(|e| refuse(&e))?,
        )),
        ShapeTable::Organ(organ) => {
            let name = match organ {
                OrganName::Liver => "liver",
                OrganName::Kidney => "kidney",
            };
            analytic(Arc::new(shape::organ(name).map_err(|e| refuse(&e))?))
        }
        ShapeTable::Mesh { path, scale } => {
            let key = KeyPath::from("body.shape.mesh.path");
            let mesh = read_mesh(&base_dir.join(path), *scale).map_err(|e| {
                doc.error(&key, format!("{}: {}", e.path().display(), e.problem()), e.remedy())
            })?;
            let (shape, notes) = MeshShape::new(&mesh, &format!("mesh {path}")).map_err(|e| refuse(&e))?;
            Ok((Arc::new(shape), notes))
        }
    }
}
