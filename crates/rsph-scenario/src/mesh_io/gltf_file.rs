//! glTF, as text (`.gltf`) and binary (`.glb`).

use super::{FILE, MAX_ELEMENTS, MeshError, MeshWithParts, fan};
use crate::whole_file::Kind;
use base64::prelude::*;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::Source;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Node, Primitive};
use rsph_core::mesh::TriangleMesh;
use rsph_core::tensor::Vec3;
use std::collections::HashSet;
use std::path::Path;

/// Column-major 4 x 4 matrix, as the file has it.
type Transform = [[f64; 4]; 4];

/// The version of the format.
const VERSION: usize = 2;
/// Bytes of a binary file before its scene.
const GLB_HEADERS: usize = 20;
/// Most items of a scene.
const MAX_ITEMS: usize = 2_000_000;

const IDENTITY: Transform =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<MeshWithParts, MeshError> {
    let invalid = |e: &dyn std::fmt::Display| {
        let e = e.to_string();
        MeshError::malformed(path, format!("not a valid glTF file: {}", e.trim_end_matches([';', '.'])))
    };
    let is_binary = bytes.starts_with(b"glTF");
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb")) && !is_binary {
        return Err(invalid(&"a binary one begins with \"glTF\", and this does not"));
    }
    check_sizes(bytes, is_binary).map_err(|e| invalid(&e))?;
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(|e| invalid(&e))?;
    check_references(&document).map_err(|e| invalid(&e))?;
    let document = Document::from_json(document.into_json()).map_err(|e| invalid(&e))?;
    let buffers = buffers(&document, path, blob).map_err(|e| invalid(&e))?;
    let mut waiting: Vec<(Node, Transform)> = roots(&document).into_iter().map(|n| (n, IDENTITY)).collect();
    let mut visited = vec![false; document.nodes().len()];
    let mut read = MeshWithParts::default();
    while let Some((node, parent)) = waiting.pop() {
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(invalid(&format!("node {} has more than one parent", node.index())));
        }
        let placed = product(&parent, &node.transform().matrix().map(|c| c.map(f64::from)));
        if let Some(shown) = node.mesh() {
            for primitive in shown.primitives() {
                let first = read.mesh.triangles.len();
                append(&mut read.mesh, &primitive, &buffers, &placed).map_err(|e| invalid(&e))?;
                let names = [node.name(), shown.name(), primitive.material().name()];
                for t in first..read.mesh.triangles.len() {
                    names.iter().flatten().for_each(|name| read.name(name, t));
                }
            }
        }
        waiting.extend(node.children().map(|child| (child, placed)));
    }
    Ok(read)
}

/// The nodes to begin with: of the scene to show or the first one; where there is none, all that are nobody's children.
fn roots(document: &Document) -> Vec<Node<'_>> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return scene.nodes().collect();
    }
    let children: HashSet<usize> =
        document.nodes().flat_map(|node| node.children().map(|child| child.index())).collect();
    document.nodes().filter(|node| !children.contains(&node.index())).collect()
}

/// Refuses a binary file that is cut off, and more of a scene than memory holds: a few bytes of it are a node of
/// hundreds.
fn check_sizes(bytes: &[u8], is_binary: bool) -> Result<(), String> {
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|b| u32::from_le_bytes(*b) as usize);
    let mut scene = bytes;
    if is_binary {
        if let Some(version) = word(4).filter(|v| *v != VERSION) {
            return Err(format!("it has version {version}; version {VERSION} is read"));
        }
        let (length, scene_length) = (word(8).unwrap_or_default(), word(12).unwrap_or_default());
        if length < GLB_HEADERS || length > bytes.len() {
            return Err(format!("it announces {length} bytes, but has {}", bytes.len()));
        }
        let end = GLB_HEADERS.saturating_add(scene_length);
        scene = bytes
            .get(GLB_HEADERS..end)
            .ok_or_else(|| format!("its scene ends at byte {end}, the file at {}", bytes.len()))?;
    }
    let items = scene.iter().filter(|b| matches!(b, b'{' | b',')).count();
    if items > MAX_ITEMS {
        return Err(format!("its scene has {items} items; {MAX_ITEMS} are allowed"));
    }
    Ok(())
}

/// Refuses what the library does not check before it uses it, accessors that are not there, and extensions.
fn check_references(document: &Document) -> Result<(), String> {
    let json = document.as_json();
    if let Some(extension) = json.extensions_required.first() {
        return Err(format!("it needs {extension}, which is not read here: export it plain, not compressed"));
    }
    for attribute in json.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values()) {
        if attribute.value() >= json.accessors.len() {
            return Err(format!("a mesh names accessor {}, which is not there", attribute.value()));
        }
    }
    Ok(())
}

/// The bytes of all buffers: in the file itself, or in files beside it or below.
fn buffers(document: &Document, path: &Path, mut blob: Option<Vec<u8>>) -> Result<Vec<Vec<u8>>, String> {
    let mut left = FILE.limit;
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let bytes = match buffer.source() {
            Source::Bin => blob.take().ok_or("it has no second chunk with the numbers")?,
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => {
                    let (_, data) = data.split_once(";base64,").ok_or("a buffer is not in base64")?;
                    BASE64_STANDARD.decode(data).map_err(|e| format!("a buffer is not in base64: {e}"))?
                }
                None => beside(path, uri, left)?,
            },
        };
        left = left.saturating_sub(bytes.len() as u64);
        if bytes.len() < buffer.length() || left == 0 {
            let (index, length) = (buffer.index(), buffer.length());
            return Err(format!("buffer {index} should have {length} bytes, but {} are there", bytes.len()));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

/// The bytes of the file `uri` beside that at `path` or below.
fn beside(path: &Path, uri: &str, limit: u64) -> Result<Vec<u8>, String> {
    if uri.starts_with(['/', '\\']) || uri.contains("..") || uri.contains([':', '%']) {
        return Err(format!("the buffer \"{uri}\" does not lie beside the file or below it"));
    }
    let file = path.parent().unwrap_or(Path::new("")).join(uri);
    let kind = Kind { what: "a buffer", limit, ..FILE };
    kind.read(&file).map_err(|e| format!("the buffer \"{uri}\": {}", e.problem))
}

/// Appends the triangles of a primitive; points and lines have none.
fn append(
    mesh: &mut TriangleMesh,
    primitive: &Primitive,
    buffers: &[Vec<u8>],
    placed: &Transform,
) -> Result<(), String> {
    if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    let Some(positions) = primitive.get(&gltf::Semantic::Positions) else {
        return Ok(());
    };
    check(&positions, buffers, Dimensions::Vec3, &[DataType::F32])?;
    let count = primitive.indices().map_or(positions.count(), |i| i.count());
    // A scene may show the same numbers again and again.
    if (mesh.vertices.len() + positions.count()).max(mesh.triangles.len() + count) > MAX_ELEMENTS {
        return Err(format!("it has more than the {MAX_ELEMENTS} vertices or triangles that are allowed"));
    }
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
    let points: Vec<[f32; 3]> =
        reader.read_positions().ok_or("the positions of a mesh are missing")?.collect();
    let corners: Vec<u32> = match primitive.indices() {
        None => (0..points.len() as u32).collect(),
        Some(indices) => {
            check(&indices, buffers, Dimensions::Scalar, &[DataType::U8, DataType::U16, DataType::U32])?;
            reader.read_indices().ok_or("the vertex numbers of a mesh are missing")?.into_u32().collect()
        }
    };
    if let Some(bad) = corners.iter().find(|&&v| v as usize >= points.len()) {
        return Err(format!("a triangle names vertex {bad} of {}", points.len()));
    }
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(points.iter().map(|p| transformed(placed, &p.map(f64::from))));
    let mut add = |[a, b, c]: [u32; 3]| {
        // A node that mirrors turns its triangles inside out: turn them back.
        let t = if is_mirror(placed) { [a, c, b] } else { [a, b, c] };
        mesh.triangles.push(t.map(|v| first + v));
    };
    match primitive.mode() {
        Mode::TriangleStrip => corners.windows(3).enumerate().for_each(|(i, t)| {
            add(if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] });
        }),
        Mode::TriangleFan => fan(&corners).for_each(add),
        _ => corners.chunks_exact(3).for_each(|t| add([t[0], t[1], t[2]])),
    }
    Ok(())
}

/// Refuses what the library would trip over: an accessor of another type, or beyond its buffer.
fn check(
    accessor: &Accessor,
    buffers: &[Vec<u8>],
    dimensions: Dimensions,
    types: &[DataType],
) -> Result<(), String> {
    let refuse = |why: &str| Err(format!("accessor {} {why}", accessor.index()));
    if accessor.dimensions() != dimensions || !types.contains(&accessor.data_type()) {
        return refuse("has a type that does not fit its use");
    }
    let (Some(view), None) = (accessor.view(), accessor.sparse()) else {
        return refuse("is sparse, which is not supported");
    };
    let size = accessor.size();
    let stride = view.stride().unwrap_or(size);
    if stride < size {
        return refuse("has items that overlap");
    }
    let in_view = accessor
        .count()
        .checked_sub(1)
        .and_then(|n| n.checked_mul(stride)?.checked_add(size)?.checked_add(accessor.offset()))
        .is_some_and(|end| end <= view.length());
    let available = buffers.get(view.buffer().index()).map_or(0, Vec::len);
    let in_buffer = view.offset().checked_add(view.length()).is_some_and(|end| end <= available);
    if in_view && in_buffer { Ok(()) } else { refuse("is empty or reaches beyond its buffer") }
}

fn product(a: &Transform, b: &Transform) -> Transform {
    std::array::from_fn(|c| std::array::from_fn(|r| (0..4).map(|k| a[k][r] * b[c][k]).sum()))
}

fn transformed(m: &Transform, p: &[f64; 3]) -> Vec3 {
    Vec3::from_fn(|r, _| m[0][r] * p[0] + m[1][r] * p[1] + m[2][r] * p[2] + m[3][r])
}

fn is_mirror(m: &Transform) -> bool {
    let column = |c: usize| Vec3::new(m[c][0], m[c][1], m[c][2]);
    column(0).cross(&column(1)).dot(&column(2)) < 0.0
}
