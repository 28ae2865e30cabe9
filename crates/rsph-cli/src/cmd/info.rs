//! `rsph info`

use crate::exit::{Code, Trouble};
use crate::output::{number, print};
use clap::Args;
use rsph_core::shape::{MeshShape, Shape};
use rsph_scenario::mesh_io::{MeshWithParts, read_mesh_with_parts};
use rsph_scenario::output::vtkhdf;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Say what a results file or a triangle mesh holds
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  rsph info out/liver_load/particles.vtkhdf
  rsph info organ.stl")]
pub struct Arguments {
    /// A .vtkhdf file of a run, or a mesh (.stl, .obj, .ply, .glb)
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<Code, Trouble> {
    let path = &arguments.file;
    if path.is_dir() {
        return Err(Trouble::input(
            format!("{} is a folder", path.display()),
            "name a file in it, such as particles.vtkhdf",
        ));
    }
    let is_results = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("vtkhdf"));
    print(&if is_results { results(path)? } else { mesh(path)? })?;
    Ok(Code::Good)
}

fn results(path: &Path) -> Result<String, Trouble> {
    let info = vtkhdf::describe(path).map_err(|e| Trouble::results(&e))?;
    let mut text = String::new();
    let _ = writeln!(text, "results: VTKHDF PolyData, {:.1} kB", info.bytes as f64 / 1e3);
    let _ = writeln!(text, "frames: {}", info.steps());
    if let (Some(first), Some(last)) = (info.times.first(), info.times.last()) {
        let _ = writeln!(text, "time: {} to {}", number(*first), number(*last));
    }
    for (name, counts) in [("points", &info.points), ("triangles", &info.polygons)] {
        let (least, most) = (counts.iter().min().unwrap_or(&0), counts.iter().max().unwrap_or(&0));
        let _ = if least == most {
            writeln!(text, "{name}: {most}")
        } else {
            writeln!(text, "{name}: {least} to {most}")
        };
    }
    for field in &info.fields {
        let kind = match field.components {
            1 => "scalar",
            3 => "vector",
            6 => "symmetric tensor, XX YY ZZ XY YZ XZ",
            _ => "other",
        };
        let _ = writeln!(text, "field: {} ({kind})", field.name);
    }
    Ok(text)
}

fn mesh(path: &Path) -> Result<String, Trouble> {
    let read = read_mesh_with_parts(path, 1.0).map_err(|e| Trouble::mesh(&e))?;
    let mesh = &read.mesh;
    if let Some(t) = mesh.first_bad_triangle() {
        return Err(Trouble::input(
            format!("{}: triangle {t} names a vertex that is not there", path.display()),
            "export the mesh again",
        ));
    }
    if let Some(v) = mesh.first_not_finite() {
        return Err(Trouble::input(
            format!("{}: vertex {v} is not finite", path.display()),
            "repair the mesh, or export it again",
        ));
    }
    let mesh = mesh.merged();
    let mut text = String::new();
    let _ = writeln!(text, "mesh: {} vertices, {} triangles", mesh.vertices.len(), mesh.triangles.len());
    let open = mesh.open_edges().len();
    let closed = if open == 0 { "yes".into() } else { format!("no, {open} open edges") };
    let _ = writeln!(text, "closed: {closed}");
    let _ = writeln!(text, "pieces: {}", mesh.components());
    if let Some(genus) = mesh.genus() {
        let _ = writeln!(text, "genus: {genus}");
    }
    if let Some(bounds) = mesh.bounds() {
        for (axis, i) in ["x", "y", "z"].iter().zip(0..) {
            let _ = writeln!(text, "{axis}: {} to {}", number(bounds.min[i]), number(bounds.max[i]));
        }
    }
    let _ = writeln!(text, "area: {}", number(mesh.area()));
    if open == 0 {
        let volume = mesh.volume();
        let turned = if volume < 0.0 { " (inside out)" } else { "" };
        let _ = writeln!(text, "volume: {}{turned}", number(volume.abs()));
    }
    let name = format!("mesh {}", path.file_name().unwrap_or_default().to_string_lossy());
    text += &parts(&read);
    match MeshShape::new(&mesh, &name) {
        Ok((shape, notes)) if shape.repair().is_some() => {
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

/// Most parts that are listed.
const MAX_PARTS: usize = 40;

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
