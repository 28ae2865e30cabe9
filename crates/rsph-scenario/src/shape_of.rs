//! The body's shape from its table: the one place that knows how shapes are built.

use crate::scenario::{BodyTable, Document, KeyPath, ScenarioError, ShapeTable};
use rsph_core::mesh::TriangleMesh;
use rsph_core::sample::Grid;
use rsph_core::shape::{Bounds, Shape};
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
    check_sizes(doc, &body.shape)?;
    let bounds = |min: Vec3, size: Vec3| Ok((Arc::new(Stub(Bounds { min, max: min + size })) as _, vec![]));
    match &body.shape {
        ShapeTable::Box { size, corner } => bounds(Vec3::from(*corner), Vec3::from(*size)),
        ShapeTable::Mesh { path, .. } => {
            let file = base_dir.join(path);
            std::fs::metadata(&file).map_err(|e| {
                doc.error(
                    &KeyPath::from("body.shape.mesh.path"),
                    format!("cannot read the mesh {}: {e}", file.display()),
                    "check the path; a relative one starts at the scenario file",
                )
            })?;
            bounds(Vec3::zeros(), Vec3::repeat(1.0))
        }
        _ => bounds(Vec3::zeros(), Vec3::repeat(1.0)),
    }
}

fn check_sizes(doc: &Document, shape: &ShapeTable) -> Result<(), ScenarioError> {
    let path = KeyPath::from("body.shape");
    let checks: Vec<(KeyPath, f64)> = match shape {
        ShapeTable::Box { size, .. } => {
            let path = path.key("box").key("size");
            size.iter().enumerate().map(|(i, x)| (path.index(i), *x)).collect()
        }
        ShapeTable::Sphere { radius, .. } => vec![(path.key("sphere").key("radius"), *radius)],
        ShapeTable::Cylinder { radius, height, .. } => {
            vec![(path.key("cylinder").key("radius"), *radius), (path.key("cylinder").key("height"), *height)]
        }
        ShapeTable::Mesh { scale, .. } => vec![(path.key("mesh").key("scale"), *scale)],
        ShapeTable::Organ(_) => vec![],
    };
    match checks.into_iter().find(|(_, x)| *x <= 0.0) {
        None => Ok(()),
        Some((path, _)) => Err(doc.error(&path, "must be greater than 0", "write a positive number")),
    }
}

#[derive(Debug)]
struct Stub(Bounds);

impl Shape for Stub {
    fn name(&self) -> String {
        "stub".into()
    }
    fn signed_distance(&self, _: &Vec3) -> f64 {
        -1.0
    }
    fn bounds(&self) -> Bounds {
        self.0
    }
    fn volume(&self) -> f64 {
        self.0.size().product()
    }
    fn surface(&self) -> &TriangleMesh {
        static EMPTY: TriangleMesh = TriangleMesh { vertices: Vec::new(), triangles: Vec::new() };
        &EMPTY
    }
    fn fill(&self, grid: &Grid) -> Vec<f64> {
        vec![1.0; grid.len()]
    }
}
