//! `rsph surface`

use crate::exit::{Code, Trouble};
use crate::output::{number, print};
use clap::Args;
use rsph_core::mesh::TriangleMesh;
use rsph_core::particles::shown_columns;
use rsph_core::surface::SurfaceField;
use rsph_core::tensor::Vec3;
use rsph_scenario::mesh_io::write_mesh;
use rsph_scenario::output::polydata::{Cells, PolyData};
use rsph_scenario::output::{vtkhdf, vtp};
use std::path::{Path, PathBuf};

/// Write the surface of a stored state, its zero level set, as a triangle mesh
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  rsph surface out/liver_load --output liver.stl
  rsph surface out/liver_load/surface.vtkhdf --step 0 --output before.vtp

VTP and PLY files carry the fields on the surface (displacement, strain, ...); STL and OBJ the shape.")]
pub struct Arguments {
    /// The folder of a run, or a .vtkhdf file in it
    #[arg(value_name = "SNAPSHOT")]
    snapshot: PathBuf,
    /// Which frame, from 0 [default: the last]
    #[arg(long, value_name = "K")]
    step: Option<usize>,
    /// STL, PLY, OBJ or VTP file, by its extension
    #[arg(short, long, value_name = "FILE", default_value = "surface.stl")]
    output: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<Code, Trouble> {
    let source = surface_file(&arguments.snapshot);
    let state = vtkhdf::read_step(&source, arguments.step).map_err(|e| Trouble::results(&e))?;
    let Cells::Triangles(triangles) = &state.cells else {
        return Err(Trouble::input(
            format!("{} holds particles, no surface", source.display()),
            "name the folder of the run, or the surface.vtkhdf in it",
        ));
    };
    let path = &arguments.output;
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("vtp")) {
        vtp::write(path, &state)
            .map_err(|e| Trouble::input(e.to_string(), "choose another file with --output"))?;
    } else {
        let vertices = state.points.iter().map(|p| Vec3::from(*p)).collect();
        let mesh = TriangleMesh { vertices, triangles: triangles.clone() };
        write_mesh(path, &mesh, &fields(&state)).map_err(|e| Trouble::mesh(&e))?;
    }
    print(&format!("{}: {} triangles at t = {}\n", path.display(), triangles.len(), number(state.time)))?;
    Ok(Code::Good)
}

/// The surface lies beside the particles.
fn surface_file(path: &Path) -> PathBuf {
    let beside = path.with_file_name("surface.vtkhdf");
    if path.is_dir() {
        path.join("surface.vtkhdf")
    } else if path.file_name().is_some_and(|n| n == "particles.vtkhdf") && beside.exists() {
        beside
    } else {
        path.to_owned()
    }
}

/// The fields whose names the core knows.
fn fields(state: &PolyData) -> Vec<SurfaceField> {
    let known = shown_columns().map(|c| c.name).chain(["normal_strain", "shear_strain"]);
    known
        .filter_map(|name| {
            let field = state.field(name)?;
            Some(SurfaceField { name, components: field.components, values: field.values.clone() })
        })
        .collect()
}
