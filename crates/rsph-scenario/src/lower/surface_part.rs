//! Regions on named parts of a mesh.

use super::checks::positive;
use crate::mesh_io::{MeshWithParts, read_mesh_with_parts};
use crate::scenario::{Document, KeyPath, PartTable, ScenarioError, ShapeTable, suggestion};
use rsph_core::region::{Region, SurfacePart};
use std::path::PathBuf;

/// Most names that a message lists.
const MAX_NAMES: usize = 12;

/// The region at `path` that holds the parts of `table`.
///
/// # Errors
/// A mesh that is not there or can not be read, and a name that no part of it has.
pub fn surface_part(doc: &Document, path: &KeyPath, table: &PartTable) -> Result<Region, ScenarioError> {
    let place = path.key("part");
    let is_table = table.path.is_some() || table.scale.is_some();
    let at = |key: &str| if is_table { place.key(key) } else { place.clone() };
    let (file, scale) = mesh_of(doc, &at("path"), table)?;
    positive(doc, &at("scale"), scale, "the scale of a mesh")?;
    let read = read_mesh_with_parts(&file, scale).map_err(|e| {
        doc.error(&at("path"), format!("{}: {}", e.path().display(), e.problem()), e.remedy())
    })?;
    let shown = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if let Some(v) = read.mesh.first_not_finite() {
        let problem = format!("{shown}: vertex {v} is not finite");
        return Err(doc.error(&at("path"), problem, "repair the mesh, or export it again"));
    }
    let names = &table.name.0;
    if names.is_empty() {
        return Err(doc.error(&at("name"), "needs at least one name", listed(&read, &shown)));
    }
    let mut belongs = vec![false; read.mesh.triangles.len()];
    for name in names {
        let Some(triangles) = read.parts.get(name) else {
            let known: Vec<&str> = read.parts.keys().map(String::as_str).collect();
            let remedy = suggestion(name, &known)
                .map_or_else(|| listed(&read, &shown), |near| format!("did you mean \"{near}\"?"));
            return Err(doc.error(&at("name"), format!("{shown} has no part \"{name}\""), remedy));
        };
        for &t in triangles {
            if let Some(own) = belongs.get_mut(t as usize) {
                *own = true;
            }
        }
    }
    let name = format!("{} of {shown}", names.join(", "));
    let part = SurfacePart::new(&name, &read.mesh.vertices, &read.mesh.triangles, |t| belongs[t]);
    part.map(Region::Part).ok_or_else(|| {
        doc.error(&at("name"), format!("the part holds no triangle of {shown}"), listed(&read, &shown))
    })
}

/// The file of the parts and the scale of its numbers: those named, or else those of the body.
fn mesh_of(doc: &Document, at: &KeyPath, table: &PartTable) -> Result<(PathBuf, f64), ScenarioError> {
    let body = match doc.tables()?.body.shape {
        Some(ShapeTable::Mesh { path, scale, .. }) => Some((path, scale)),
        _ => None,
    };
    let (own, own_scale) = body.map_or((None, 1.0), |(path, scale)| (Some(path), scale));
    match table.path.clone().or(own) {
        Some(file) => Ok((doc.folder().join(file), table.scale.unwrap_or(own_scale))),
        None => Err(doc.error(
            at,
            "is a part of the body's mesh, and the body is none",
            "name a mesh of the body's surface: { part = { name = \"...\", path = \"...\" } }",
        )),
    }
}

/// What parts there are.
fn listed(read: &MeshWithParts, file: &str) -> String {
    let count = read.parts.len();
    if count == 0 {
        return format!(
            "{file} names no parts: name groups, objects or materials in a mesh editor and export OBJ or GLB, or paint it \
             and export PLY"
        );
    }
    let names: Vec<String> = read.parts.keys().take(MAX_NAMES).map(|n| format!("\"{n}\"")).collect();
    let more = if count > MAX_NAMES {
        format!(" and {} more: see `rsph info`", count - MAX_NAMES)
    } else {
        String::new()
    };
    format!("its parts are {}{more}", names.join(", "))
}
