//! glTF, as text (`.gltf`) and binary (`.glb`).

use super::{MeshError, fan};
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::Data;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Node, Primitive};
use rsph_core::mesh::TriangleMesh;
use rsph_core::tensor::Vec3;
use std::path::Path;

/// Column-major 4 x 4 matrix, as the file has it.
type Transform = [[f64; 4]; 4];

const IDENTITY: Transform =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    let invalid =
        |e: &dyn std::fmt::Display| MeshError::malformed(path, format!("not a valid glTF file: {e}"));
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(|e| invalid(&e))?;
    check_references(&document).map_err(|e| invalid(&e))?;
    let document = Document::from_json(document.into_json()).map_err(|e| invalid(&e))?;
    let buffers = gltf::import_buffers(&document, path.parent(), blob).map_err(|e| invalid(&e))?;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let mut waiting: Vec<(Node, Transform)> =
        scene.iter().flat_map(gltf::Scene::nodes).map(|n| (n, IDENTITY)).collect();
    let mut visited = vec![false; document.nodes().len()];
    let mut mesh = TriangleMesh::default();
    while let Some((node, parent)) = waiting.pop() {
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(invalid(&format!("node {} has more than one parent", node.index())));
        }
        let placed = product(&parent, &node.transform().matrix().map(|c| c.map(f64::from)));
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            append(&mut mesh, &primitive, &buffers, &placed).map_err(|e| invalid(&e))?;
        }
        waiting.extend(node.children().map(|child| (child, placed)));
    }
    Ok(mesh)
}

/// Refuses what the library does not check before it uses it: accessors that are not there, and
/// buffers in places that a mesh file has no business with, where reading might not end.
fn check_references(document: &Document) -> Result<(), String> {
    let json = document.as_json();
    for attribute in json.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values()) {
        if attribute.value() >= json.accessors.len() {
            return Err(format!("a mesh names accessor {}, which is not there", attribute.value()));
        }
    }
    for uri in json.buffers.iter().filter_map(|b| b.uri.as_ref()).filter(|u| !u.starts_with("data:")) {
        if uri.starts_with(['/', '\\']) || uri.contains("..") || uri.contains([':', '%']) {
            return Err(format!("the buffer \"{uri}\" does not lie beside the file or below it"));
        }
    }
    Ok(())
}

/// Appends the triangles of a primitive; points and lines have none.
fn append(
    mesh: &mut TriangleMesh,
    primitive: &Primitive,
    buffers: &[Data],
    placed: &Transform,
) -> Result<(), String> {
    if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    let Some(positions) = primitive.get(&gltf::Semantic::Positions) else {
        return Ok(());
    };
    check(&positions, buffers, Dimensions::Vec3, &[DataType::F32])?;
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(|d| &d[..]));
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
    buffers: &[Data],
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
    let available = buffers.get(view.buffer().index()).map_or(0, |d| d.len());
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
