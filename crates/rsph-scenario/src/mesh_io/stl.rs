//! STL, ASCII and binary.

mod ascii;

use super::text::decode;
use super::{MeshError, MeshWithParts};
use rsph_core::mesh::TriangleMesh;
use rsph_core::tensor::Vec3;
use std::io::{self, Cursor};
use std::path::Path;

/// Bytes before the triangles of a binary file, and of a triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// The triangles of a file. The length tells numbers from text: many programs begin binary files with "solid" too, and a text as
/// long as it would announce is larger than any file that is read.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<MeshWithParts, MeshError> {
    let count: Option<[u8; 4]> = bytes.get(80..HEADER).and_then(|b| b.try_into().ok());
    let length = |count: u32| HEADER + TRIANGLE * count as usize;
    let expected = count.map(|n| length(u32::from_le_bytes(n)));
    if expected.is_some_and(|expected| expected <= bytes.len()) {
        return binary(path, bytes);
    }
    let text = decode(bytes);
    let start: String = text.trim_start().chars().take(HEADER).collect();
    let is_text = start.chars().all(|c| !c.is_control() || c.is_whitespace());
    if is_text && start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case("solid")) {
        return ascii::triangles(&text).map_err(|problem| MeshError::malformed(path, problem));
    }
    let problem = match (count, expected) {
        _ if is_text => "this is a text, but no STL file: such a text begins with \"solid\"".into(),
        (Some(count), _) if length(u32::from_be_bytes(count)) == bytes.len() => {
            "the bytes of its numbers are in the wrong order: STL files are little-endian".into()
        }
        (Some(count), Some(expected)) => format!(
            "the STL file announces {} triangles, which take {expected} bytes, but has {} bytes",
            u32::from_le_bytes(count),
            bytes.len()
        ),
        _ => format!("{} bytes are too short for an STL file", bytes.len()),
    };
    Err(MeshError::malformed(path, problem))
}

fn binary(path: &Path, bytes: &[u8]) -> Result<MeshWithParts, MeshError> {
    let mut bytes = bytes.to_vec();
    // The library takes a header that begins with "solid" for text.
    bytes[..80].fill(0);
    let read = stl_io::read_stl(&mut Cursor::new(bytes))
        .map_err(|e| MeshError::malformed(path, format!("not a valid STL file: {e}")))?;
    let mesh = TriangleMesh {
        vertices: read.vertices.iter().map(|v| Vec3::from(v.0.map(f64::from))).collect(),
        triangles: read.faces.iter().map(|f| f.vertices.map(|v| v as u32)).collect(),
    };
    Ok(MeshWithParts { mesh, ..MeshWithParts::default() })
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
