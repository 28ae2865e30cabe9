//! Wavefront OBJ.

use super::{MeshError, shown};
use rsph_core::mesh::TriangleMesh;
use rsph_core::tensor::Vec3;
use std::fmt::Write;
use std::io;
use std::path::Path;

pub(super) fn parse(path: &Path, mut bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    let text = bytes;
    // Materials are of no interest and may be missing.
    let (models, _) = tobj::load_obj_buf(&mut bytes, &options, |_| Ok(Default::default())).map_err(|e| {
        let why = culprit(text).unwrap_or_else(|| e.to_string());
        MeshError::malformed(path, format!("not a valid OBJ file: {why}"))
    })?;
    let mut mesh = TriangleMesh::default();
    for model in models {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(model.mesh.positions.chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2])));
        let corners = model.mesh.indices.chunks_exact(3);
        mesh.triangles.extend(corners.map(|t| [first + t[0], first + t[1], first + t[2]]));
    }
    Ok(mesh)
}

/// The first line that is wrong about vertices or faces, and what is: the library tells neither.
fn culprit(bytes: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(bytes);
    let count = text.lines().filter(|l| l.split_whitespace().next() == Some("v")).count();
    text.lines().enumerate().find_map(|(number, line)| {
        let mut words = line.split_whitespace();
        let why = match words.next()? {
            "v" => {
                let numbers = words.map_while(|w| w.parse::<f64>().ok()).count();
                (numbers < 3).then(|| "a vertex is three numbers, with decimal points".to_owned())
            }
            "f" => words.find_map(|word| {
                let index = word.split('/').next().and_then(|i| i.parse::<isize>().ok());
                match index {
                    None => Some("a face is a list of vertex numbers".into()),
                    Some(i) if i == 0 || i.unsigned_abs() > count => {
                        Some(format!("there is no vertex {i}: the file has {count}, numbered from 1"))
                    }
                    Some(_) => None,
                }
            }),
            _ => None,
        };
        why.map(|why| format!("line {}, \"{}\": {why}", number + 1, shown(line)))
    })
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
