//! PLY, ASCII and binary.

use super::polygon::{self, MAX_CORNERS};
use super::{MAX_ELEMENTS, MeshError, MeshWithParts, shown};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    DefaultElement, ElementDef, Encoding, Ply, Property, PropertyAccess, PropertyAccessResult, PropertyDef,
    PropertyType, ScalarType,
};
use ply_rs_bw::writer::Writer;
use rsph_core::mesh::TriangleMesh;
use rsph_core::particles::{Field, suffixes};
use rsph_core::surface::SurfaceField;
use rsph_core::tensor::Vec3;
use std::io;
use std::path::Path;

/// What negative numbers of vertices become.
const NO_VERTEX: u32 = u32::MAX;

/// A vertex, a face, or something else in a file.
#[derive(Default)]
struct Item {
    position: Vec3,
    corners: Vec<u32>,
    colour: [Option<u8>; 3],
    /// Other whole numbers by their names.
    labels: Vec<(String, i64)>,
}

impl Item {
    /// The colour, as parts are called by it.
    fn colour_name(&self) -> Option<String> {
        let [r, g, b] = self.colour;
        Some(format!("#{:02x}{:02x}{:02x}", r?, g?, b?))
    }
}

impl PropertyAccess for Item {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            "vertex_indices" | "vertex_index" => {
                return match vertex_numbers(&property) {
                    Some(corners) => {
                        self.corners = corners;
                        PropertyAccessResult::Set
                    }
                    None => PropertyAccessResult::UnsupportedType,
                };
            }
            "red" | "green" | "blue" => {
                let channel = ["red", "green", "blue"].iter().position(|c| *c == name).unwrap_or_default();
                self.colour[channel] = channel_value(&property);
                return PropertyAccessResult::Set;
            }
            "alpha" | "flags" => return PropertyAccessResult::Ignored,
            _ => {
                return match whole_number(&property) {
                    Some(value) => {
                        self.labels.push((name.to_owned(), value));
                        PropertyAccessResult::Set
                    }
                    None => PropertyAccessResult::Ignored,
                };
            }
        };
        match number(&property) {
            Some(value) => {
                self.position[axis] = value;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
    }
}

fn number(property: &Property) -> Option<f64> {
    match *property {
        Property::Float(v) => Some(f64::from(v)),
        Property::Double(v) => Some(v),
        Property::Char(v) => Some(f64::from(v)),
        Property::UChar(v) => Some(f64::from(v)),
        Property::Short(v) => Some(f64::from(v)),
        Property::UShort(v) => Some(f64::from(v)),
        Property::Int(v) => Some(f64::from(v)),
        Property::UInt(v) => Some(f64::from(v)),
        _ => None,
    }
}

/// A channel of a colour, from 0 to 255 or from 0 to 1.
fn channel_value(property: &Property) -> Option<u8> {
    match *property {
        Property::Float(v) => Some((255.0 * v).round() as u8),
        Property::Double(v) => Some((255.0 * v).round() as u8),
        _ => whole_number(property).and_then(|v| u8::try_from(v).ok()),
    }
}

fn whole_number(property: &Property) -> Option<i64> {
    match property {
        Property::Float(_) | Property::Double(_) => None,
        _ => number(property).map(|v| v as i64),
    }
}

/// Vertex numbers of a face; a negative one becomes one that no vertex has.
fn vertex_numbers(property: &Property) -> Option<Vec<u32>> {
    fn from<T: Copy>(list: &[T]) -> Vec<u32>
    where
        u32: TryFrom<T>,
    {
        list.iter().map(|&v| u32::try_from(v).unwrap_or(NO_VERTEX)).collect()
    }
    match property {
        Property::ListChar(l) => Some(from(l)),
        Property::ListUChar(l) => Some(from(l)),
        Property::ListShort(l) => Some(from(l)),
        Property::ListUShort(l) => Some(from(l)),
        Property::ListInt(l) => Some(from(l)),
        Property::ListUInt(l) => Some(l.clone()),
        _ => None,
    }
}

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<MeshWithParts, MeshError> {
    let invalid =
        |e: &dyn std::fmt::Display| MeshError::malformed(path, format!("not a valid PLY file: {e}"));
    let unread = |e: &ParseError| invalid(&in_short(e));
    let parser = Parser::<Item>::new();
    let mut reader = Reader::new(bytes);
    let header = parser.read_header(&mut reader).map_err(|e| unread(&e))?;
    let has = |element: &str, property: &str| {
        header.elements.get(element).is_some_and(|e| e.properties.contains_key(property))
    };
    if let Some(missing) = ["x", "y", "z"].into_iter().find(|p| !has("vertex", p)) {
        return Err(invalid(&format!("vertices have no property \"{missing}\"")));
    }
    let (mut vertices, mut faces, mut strips) = (Vec::new(), Vec::new(), Vec::new());
    for (name, element) in &header.elements {
        // Every element takes a byte or more: without this check a header could fill the memory.
        if element.count > bytes.len() || element.properties.is_empty() && element.count > 0 {
            let problem = format!(
                "the header announces {} elements \"{name}\", more than the {} bytes of the file can hold",
                element.count,
                bytes.len()
            );
            return Err(invalid(&problem));
        }
        if element.count > MAX_ELEMENTS {
            let problem = format!("{} elements \"{name}\"; {MAX_ELEMENTS} are allowed", element.count);
            return Err(invalid(&problem));
        }
        let items = parser.read_payload_for_element(&mut reader, element, &header).map_err(|e| unread(&e))?;
        match name.as_str() {
            "vertex" => vertices = items,
            "face" => faces = items,
            "tristrips" => strips = items,
            _ => {}
        }
    }
    if let Some(face) = faces.iter().find(|face| face.corners.len() > MAX_CORNERS) {
        return Err(invalid(&format!("a face of {} corners; {MAX_CORNERS} are allowed", face.corners.len())));
    }
    faces.extend(strips.iter().flat_map(of_strip));
    Ok(with_parts(&vertices, &faces))
}

/// The faces of strips of triangles, each of which turns the other way; a number that no vertex has (-1) begins another strip.
fn of_strip(strip: &Item) -> impl Iterator<Item = Item> + '_ {
    strip.corners.split(|&v| v == NO_VERTEX).flat_map(|strip| {
        let triangles =
            strip.windows(3).enumerate().filter(|(_, t)| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
        triangles.map(|(i, t)| {
            let corners = if i % 2 == 0 { vec![t[0], t[1], t[2]] } else { vec![t[1], t[0], t[2]] };
            Item { corners, ..Item::default() }
        })
    })
}

/// The mesh of vertices and faces, with the parts that their colours and the faces' numbers make.
fn with_parts(vertices: &[Item], faces: &[Item]) -> MeshWithParts {
    let positions: Vec<Vec3> = vertices.iter().map(|v| v.position).collect();
    let mut read = MeshWithParts::default();
    for face in faces {
        for triangle in polygon::triangles(&face.corners, &positions) {
            let t = read.mesh.triangles.len();
            read.mesh.triangles.push(triangle);
            let of_corners = || {
                let [a, b, c] = triangle.map(|v| vertices.get(v as usize).and_then(Item::colour_name));
                if a == b || a == c { a } else { b.filter(|b| Some(b) == c.as_ref()) }
            };
            if let Some(colour) = face.colour_name().or_else(of_corners) {
                read.name(&colour, t);
            }
            face.labels.iter().for_each(|(label, value)| read.name(&format!("{label}={value}"), t));
        }
    }
    read.mesh.vertices = positions;
    read
}

/// The line, and what the library says first about it, in plain words.
fn in_short(error: &ParseError) -> String {
    let text = error.to_string();
    let said = text.lines().next().unwrap_or_default().trim_end_matches('.');
    let said = said.split_once(": ").filter(|_| error.line().is_some()).map_or(said, |(_, rest)| rest);
    let said = match said {
        "Couldn't read element line" => "these are not the numbers that the header announces",
        "Couldn't parse line" => "no line of a PLY header is like this",
        other => other,
    };
    let quoted = text.lines().find_map(|l| l.trim().strip_prefix("String: '"));
    match (error.line(), quoted) {
        (Some(line), Some(text)) => {
            format!("line {line}, \"{}\": {said}", shown(text.trim_end_matches('\'')))
        }
        (Some(line), None) => format!("line {line}: {said}"),
        (None, _) => said.to_owned(),
    }
}

/// What the components of a field are called.
fn suffixes_of(name: &str, components: usize) -> &'static [&'static str] {
    Field::from_name(name).map_or_else(|| suffixes(components), |field| field.spec().suffixes)
}

pub(super) fn format(mesh: &TriangleMesh, fields: &[SurfaceField]) -> io::Result<Vec<u8>> {
    let mut vertex = ElementDef::new("vertex".into());
    let mut names: Vec<String> = ["x", "y", "z"].map(String::from).to_vec();
    for field in fields {
        match field.components {
            1 => names.push(field.name.into()),
            n => names.extend(suffixes_of(field.name, n).iter().map(|s| format!("{}_{s}", field.name))),
        }
    }
    for name in &names {
        let property = PropertyDef::new(name.clone(), PropertyType::Scalar(ScalarType::Double));
        vertex.properties.insert(name.clone(), property);
    }
    let mut face = ElementDef::new("face".into());
    let corners =
        PropertyDef::new("vertex_indices".into(), PropertyType::List(ScalarType::UChar, ScalarType::UInt));
    face.properties.insert("vertex_indices".into(), corners);

    let mut ply = Ply::<DefaultElement>::new();
    ply.header.encoding = Encoding::BinaryLittleEndian;
    ply.header.elements.insert("vertex".into(), vertex);
    ply.header.elements.insert("face".into(), face);
    let vertices = mesh.vertices.iter().enumerate().map(|(v, x)| {
        let values = x.iter().chain(fields.iter().flat_map(|f| {
            let n = f.components;
            f.values.get(v * n..(v + 1) * n).unwrap_or_default()
        }));
        names.iter().cloned().zip(values.map(|&value| Property::Double(value))).collect()
    });
    ply.payload.insert("vertex".into(), vertices.collect());
    let faces = mesh
        .triangles
        .iter()
        .map(|t| std::iter::once(("vertex_indices".into(), Property::ListUInt(t.to_vec()))).collect());
    ply.payload.insert("face".into(), faces.collect());
    let mut bytes = Vec::new();
    Writer::new().write_ply(&mut bytes, &mut ply)?;
    Ok(bytes)
}
