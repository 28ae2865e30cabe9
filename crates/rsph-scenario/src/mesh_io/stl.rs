//! STL, ASCII and binary.

use super::MeshError;
use rsph_core::mesh::TriangleMesh;
use rsph_core::tensor::Vec3;
use std::io::{self, Cursor};
use std::path::Path;

/// Bytes before the triangles of a binary file, and of a triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    let prepared = prepared(path, bytes)?;
    let read = stl_io::read_stl(&mut Cursor::new(prepared))
        .map_err(|e| MeshError::malformed(path, format!("not a valid STL file: {e}")))?;
    Ok(TriangleMesh {
        vertices: read.vertices.iter().map(|v| Vec3::from(v.0.map(f64::from))).collect(),
        triangles: read.faces.iter().map(|f| f.vertices.map(|v| v as u32)).collect(),
    })
}

/// The file with a first line or header that leaves no doubt whether it is text. The length tells
/// the two apart: many programs begin binary files with "solid" too.
fn prepared(path: &Path, bytes: &[u8]) -> Result<Vec<u8>, MeshError> {
    let count = bytes.get(80..HEADER).map(|b| b.iter().rev().fold(0, |n, &d| n << 8 | usize::from(d)));
    let expected = count.map(|n| HEADER + TRIANGLE * n);
    let is_text = bytes.get(..5).is_some_and(|b| b.eq_ignore_ascii_case(b"solid"));
    if is_text && expected != Some(bytes.len()) {
        let line = bytes.iter().position(|&b| b == b'\n').unwrap_or(bytes.len());
        return Ok([b"solid text", &bytes[line..]].concat());
    }
    match (count, expected) {
        (Some(_), Some(expected)) if expected <= bytes.len() => {
            let mut binary = bytes.to_vec();
            binary[..80].fill(0);
            Ok(binary)
        }
        (Some(count), Some(expected)) => Err(MeshError::malformed(
            path,
            format!(
                "the STL file announces {count} triangles, which take {expected} bytes, but has {} bytes",
                bytes.len()
            ),
        )),
        _ => Err(MeshError::malformed(path, format!("{} bytes are too short for an STL file", bytes.len()))),
    }
}

pub(super) fn format(mesh: &TriangleMesh) -> io::Result<Vec<u8>> {
    let single = |x: Vec3| stl_io::Vector::new([x.x as f32, x.y as f32, x.z as f32]);
    let triangles: Vec<_> = (0..mesh.triangles.len())
        .map(|t| stl_io::Triangle { normal: single(mesh.normal(t)), vertices: mesh.corners(t).map(single) })
        .collect();
    let mut bytes = Vec::with_capacity(HEADER + TRIANGLE * triangles.len());
    stl_io::write_stl(&mut bytes, triangles.iter())?;
    Ok(bytes)
}
