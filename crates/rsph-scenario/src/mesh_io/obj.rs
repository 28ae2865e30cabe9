//! Wavefront OBJ. Read here and not by a library: those there are refuse comments in other encodings, comments behind a face and
//! continued lines, cut polygons with dents wrongly, and do not say in which line something is wrong.

use super::polygon::{self, MAX_CORNERS};
use super::text::decode;
use super::{MAX_ELEMENTS, MeshError, MeshWithParts, shown};
use rsph_core::mesh::TriangleMesh;
use rsph_core::tensor::Vec3;
use std::borrow::Cow;
use std::fmt::Write;
use std::io;
use std::path::Path;

/// Most groups of a face that are read.
const MAX_GROUPS: usize = 16;

/// The faces of the file, with the groups, the object and the material of each as parts.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<MeshWithParts, MeshError> {
    let text = decode(bytes);
    let mut read = MeshWithParts::default();
    let (mut groups, mut object, mut material) = (Vec::new(), String::new(), String::new());
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let mut line = Cow::Borrowed(line);
        while let Some(start) = line.trim_end().strip_suffix('\\') {
            line = format!("{start} {}", lines.next().map_or("", |(_, next)| next)).into();
        }
        let mut words = line.split_whitespace();
        // Names may hold a #.
        let numbers = line.split('#').next().into_iter().flat_map(str::split_whitespace).skip(1);
        let done = match words.next() {
            Some("v") => vertex(numbers).map(|vertex| read.mesh.vertices.push(vertex)),
            Some("f") => face(numbers, &read.mesh).map(|triangles| {
                let first = read.mesh.triangles.len();
                read.mesh.triangles.extend(triangles);
                for t in first..read.mesh.triangles.len() {
                    groups.iter().chain([&object, &material]).for_each(|name| read.name(name, t));
                }
            }),
            Some("g") => {
                groups = words.take(MAX_GROUPS).map(str::to_owned).collect();
                Ok(())
            }
            Some("o") => {
                object = words.collect::<Vec<_>>().join(" ");
                Ok(())
            }
            Some("usemtl") => {
                material = words.collect::<Vec<_>>().join(" ");
                Ok(())
            }
            _ => Ok(()),
        };
        done.map_err(|why| {
            let place = format!("line {}, \"{}\"", number + 1, shown(&line));
            MeshError::malformed(path, format!("not a valid OBJ file: {place}: {why}"))
        })?;
    }
    Ok(read)
}

fn vertex<'a>(numbers: impl Iterator<Item = &'a str>) -> Result<Vec3, String> {
    let mut numbers = numbers.map(|word| word.parse().ok().filter(|x: &f64| x.is_finite()));
    let mut next = || numbers.next().flatten();
    match (next(), next(), next()) {
        (Some(x), Some(y), Some(z)) => Ok(Vec3::new(x, y, z)),
        _ => Err("a vertex is three numbers, with decimal points".into()),
    }
}

/// The triangles of a face, whose corners are vertices counted from 1, or back from the last one by negative numbers.
fn face<'a>(corners: impl Iterator<Item = &'a str>, mesh: &TriangleMesh) -> Result<Vec<[u32; 3]>, String> {
    let count = mesh.vertices.len();
    let polygon = corners.map(|word| {
        let number = word.split('/').next().and_then(|number| number.parse::<i64>().ok());
        let number = number.ok_or("a face is a list of vertex numbers")?;
        let index = if number < 0 { count as i64 + number } else { number - 1 };
        u32::try_from(index).ok().filter(|v| (*v as usize) < count).ok_or_else(|| {
            format!("there is no vertex {number}: {count} stand before this line, numbered from 1")
        })
    });
    let polygon = polygon.collect::<Result<Vec<u32>, String>>()?;
    if polygon.len() > MAX_CORNERS {
        return Err(format!("a face of {} corners; {MAX_CORNERS} are allowed", polygon.len()));
    }
    if mesh.triangles.len() + polygon.len() > MAX_ELEMENTS {
        return Err(format!("more than the {MAX_ELEMENTS} triangles that are allowed"));
    }
    Ok(polygon::triangles(&polygon, &mesh.vertices))
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
