//! Wavefront OBJ.

use super::{MeshError, MeshWithParts, shown};
use rsph_core::mesh::TriangleMesh;
use rsph_core::tensor::Vec3;
use std::fmt::Write;
use std::io;
use std::path::Path;

/// Most groups of a face that are read.
const MAX_GROUPS: usize = 16;

pub(super) fn parse(path: &Path, mut bytes: &[u8]) -> Result<MeshWithParts, MeshError> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    let text = bytes;
    // Files of materials are of no interest and may be missing.
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
    let mut read = MeshWithParts { mesh, ..MeshWithParts::default() };
    name_parts(&mut read, text);
    Ok(read)
}

/// Names triangles by the groups, the object and the material of their faces, which the library tells in part only.
fn name_parts(read: &mut MeshWithParts, bytes: &[u8]) {
    let (mut groups, mut object, mut material) = (Vec::new(), String::new(), String::new());
    let mut next = 0;
    for line in String::from_utf8_lossy(bytes).lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("g") => groups = words.take(MAX_GROUPS).map(str::to_owned).collect(),
            Some("o") => object = words.collect::<Vec<_>>().join(" "),
            Some("usemtl") => material = words.collect::<Vec<_>>().join(" "),
            // A polygon of n corners is n - 2 triangles.
            Some("f") => {
                let end = next + words.count().saturating_sub(2);
                for t in next..end.min(read.mesh.triangles.len()) {
                    groups.iter().chain([&object, &material]).for_each(|name| read.name(name, t));
                }
                next = end;
            }
            _ => {}
        }
    }
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
