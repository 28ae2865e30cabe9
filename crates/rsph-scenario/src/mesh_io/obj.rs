//! Wavefront OBJ.

use super::MeshError;
use rsph_core::mesh::TriangleMesh;
use rsph_core::tensor::Vec3;
use std::fmt::Write;
use std::io;
use std::path::Path;

pub(super) fn parse(path: &Path, mut bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    // Materials are of no interest and may be missing.
    let (models, _) = tobj::load_obj_buf(&mut bytes, &options, |_| Ok(Default::default()))
        .map_err(|e| MeshError::malformed(path, format!("not a valid OBJ file: {e}")))?;
    let mut mesh = TriangleMesh::default();
    for model in models {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(model.mesh.positions.chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2])));
        let corners = model.mesh.indices.chunks_exact(3);
        mesh.triangles.extend(corners.map(|t| [first + t[0], first + t[1], first + t[2]]));
    }
    Ok(mesh)
}

pub(super) fn format(mesh: &TriangleMesh) -> io::Result<Vec<u8>> {
    let mut text = String::new();
    let written =
        mesh.vertices.iter().try_for_each(|v| writeln!(text, "v {} {} {}", v.x, v.y, v.z)).and_then(|()| {
            let mut numbers = mesh.triangles.iter().map(|t| t.map(|v| v + 1));
            numbers.try_for_each(|[a, b, c]| writeln!(text, "f {a} {b} {c}"))
        });
    written.map_err(io::Error::other)?;
    Ok(text.into_bytes())
}
