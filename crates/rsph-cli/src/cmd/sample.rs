//! `rsph sample`

use crate::exit::{Code, Trouble};
use crate::output::{number, print};
use clap::{ArgGroup, Args};
use rsph_core::error::InvalidInput;
use rsph_core::sample::{Body, Resolution, sample};
use rsph_core::shape::{MeshShape, Shape};
use rsph_scenario::mesh_io::read_mesh;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Turn a triangle mesh into particles, and say how well they fill it
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("resolution").required(true))]
#[command(after_help = "\
Examples:
  rsph sample organ.stl --particles 1000
  rsph sample organ.stl --scale 0.001 --spacing 0.005 --output particles.csv")]
pub struct Arguments {
    /// A triangle mesh (.stl, .obj, .ply, .glb)
    #[arg(value_name = "MESH")]
    mesh: PathBuf,
    /// Distance between particles, in the units of the mesh times the scale
    #[arg(long, value_name = "S", allow_negative_numbers = true, group = "resolution")]
    spacing: Option<f64>,
    /// Number of particles (about)
    #[arg(long, value_name = "N", group = "resolution")]
    particles: Option<usize>,
    /// Factor on the mesh's coordinates (0.001: millimetres to metres)
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
    scale: f64,
    /// Write the particles to this CSV file: x, y, z, volume, level_set
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<Code, Trouble> {
    let mesh = read_mesh(&arguments.mesh, arguments.scale).map_err(|e| Trouble::mesh(&e))?;
    let name = arguments.mesh.file_name().unwrap_or_default().to_string_lossy();
    let (shape, notes) = MeshShape::new(&mesh, &format!("mesh {name}")).map_err(|e| wrong(&e))?;
    for note in notes {
        tracing::warn!("{note}");
    }
    let resolution = match (arguments.spacing, arguments.particles) {
        (Some(s), _) => Resolution::Spacing(s),
        // clap makes sure that one of the two is there.
        (None, n) => Resolution::Particles(n.unwrap_or_default()),
    };
    let body = sample(&shape, resolution, &[]).map_err(|e| wrong(&e))?;
    if let Some(path) = &arguments.output {
        write_csv(path, &body).map_err(|e| {
            Trouble::input(
                format!("cannot write {}: {e}", path.display()),
                "choose another file with --output",
            )
        })?;
    }
    print(&description(&shape, &body))?;
    Ok(Code::Good)
}

/// The core's words are keys of a scenario; here they are options.
fn wrong(e: &InvalidInput) -> Trouble {
    let option = match e.key.as_str() {
        "body.spacing" => "--spacing",
        "body.particles" => "--particles",
        _ => "mesh",
    };
    Trouble::input(format!("{option} {}: {}", e.value, e.problem), &e.remedy)
}

fn description(shape: &MeshShape, body: &Body) -> String {
    let surface = shape.surface();
    let volume = body.fraction.iter().sum::<f64>() * body.grid.spacing.powi(3);
    let closed = if surface.is_closed() { "closed" } else { "open" };
    let pieces = match surface.components() {
        1 => "1 piece".into(),
        several => format!("{several} pieces"),
    };
    let genus = surface.genus().map_or_else(String::new, |g| format!(", genus {g}"));
    let mut text = String::new();
    let _ = writeln!(text, "mesh: {} triangles, {closed}, {pieces}{genus}", surface.triangles.len());
    let _ = writeln!(text, "particles: {}", body.cells.len());
    let _ = writeln!(text, "spacing: {}", number(body.grid.spacing));
    let off = 100.0 * (volume / shape.volume() - 1.0);
    let _ =
        writeln!(text, "volume: {} of the mesh's {} ({off:+.2} %)", number(volume), number(shape.volume()));
    text
}

fn write_csv(path: &Path, body: &Body) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    writeln!(file, "x,y,z,volume,level_set")?;
    for ((c, volume), level_set) in body.cells.iter().zip(&body.volume).zip(&body.level_set) {
        let x = body.grid.centre(*c);
        writeln!(file, "{},{},{},{},{level_set}", x.x, x.y, x.z, volume)?;
    }
    file.flush()
}
