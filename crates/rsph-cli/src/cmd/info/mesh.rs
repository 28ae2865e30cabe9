//! Triangle meshes.

use crate::cmd::unit::{is_gltf, scale_to_metres};
use crate::exit::Trouble;
use crate::output::{interval, number};
use rsph_core::grid::Bounds;
use rsph_core::mesh::TriangleMesh;
use rsph_core::shape::{MeshShape, Shape};
use rsph_scenario::mesh_io::{MeshWithParts, read_mesh_with_parts};
use std::fmt::Write;
use std::path::Path;

/// Most parts that are listed.
const MAX_PARTS: usize = 40;

pub fn describe(path: &Path) -> Result<String, Trouble> {
    let read = read_mesh_with_parts(path, 1.0).map_err(|e| Trouble::mesh(&e))?;
    if let Some(v) = read.mesh.first_not_finite() {
        return Err(Trouble::input(
            format!("{}: vertex {v} is not finite", path.display()),
            "repair the mesh, or export it again",
        ));
    }
    let mesh = read.mesh.merged();
    let mut text = String::new();
    let _ = writeln!(text, "mesh: {} vertices, {} triangles", mesh.vertices.len(), mesh.triangles.len());
    let open = mesh.open_edges().len();
    let closed = if open == 0 { "yes".into() } else { format!("no, {open} open edges") };
    let _ = writeln!(text, "closed: {closed}");
    let _ = writeln!(text, "pieces: {}", pieces(&mesh, open == 0));
    if let Some(genus) = mesh.genus() {
        let _ = writeln!(text, "genus: {genus}");
    }
    if let Some(bounds) = mesh.bounds() {
        for (axis, i) in ["x", "y", "z"].iter().zip(0..) {
            let [low, high] = interval(bounds.min[i], bounds.max[i]);
            let _ = writeln!(text, "{axis}: {low} to {high}, {} long", number(bounds.max[i] - bounds.min[i]));
        }
        let _ = writeln!(text, "unit: {}", unit(path, &bounds));
    }
    let _ = writeln!(text, "area: {}", number(mesh.area()));
    if open == 0 {
        let volume = mesh.volume();
        let turned = if volume < 0.0 { " (inside out)" } else { "" };
        let _ = writeln!(text, "volume: {}{turned}", number(volume.abs()));
    }
    text += &parts(&read);
    let name = format!("mesh {}", path.file_name().unwrap_or_default().to_string_lossy());
    match MeshShape::new(&mesh, &name) {
        Ok((shape, notes)) if !notes.is_empty() => {
            let _ = writeln!(text, "body: volume {}", number(shape.volume()));
            for note in notes {
                let _ = writeln!(text, "  {note}");
            }
        }
        Ok(_) => {}
        Err(e) => _ = writeln!(text, "body: none; {}", e.problem),
    }
    Ok(text)
}

/// Number of pieces, and of cavities of a closed mesh; where they can not be told apart, of both.
fn pieces(mesh: &TriangleMesh, is_closed: bool) -> String {
    let (_, volumes) = mesh.component_volumes();
    let outward = volumes.iter().filter(|v| **v > 0.0).count();
    match volumes.len() - outward {
        cavities if is_closed && outward > 0 && cavities > 0 => format!("{outward}, cavities: {cavities}"),
        _ => volumes.len().to_string(),
    }
}

/// The unit of length of a mesh, as far as it can be told.
fn unit(path: &Path, bounds: &Bounds) -> String {
    match scale_to_metres(path, bounds) {
        Some(_) if is_gltf(path) => "metres, by the format".into(),
        Some(1.0) => "metres, by the size of organs".into(),
        Some(scale) => format!("millimetres, by the size of organs: `scale = {scale}`"),
        None => "not clear from the size: millimetres, metres, or others; say which by `scale`".into(),
    }
}

/// The named parts of a mesh, the largest first.
fn parts(read: &MeshWithParts) -> String {
    let mut parts: Vec<_> = read.parts.keys().map(|name| (name, read.area_and_centre(name))).collect();
    parts.sort_by(|(_, (a, _)), (_, (b, _))| b.total_cmp(a));
    let mut text = String::new();
    for (name, (area, centre)) in parts.iter().take(MAX_PARTS) {
        let [x, y, z] = [centre.x, centre.y, centre.z].map(number);
        let _ = writeln!(text, "part \"{name}\": area {}, centre ({x}, {y}, {z})", number(*area));
    }
    if parts.len() > MAX_PARTS {
        let _ = writeln!(text, "  and {} smaller parts", parts.len() - MAX_PARTS);
    }
    text
}
