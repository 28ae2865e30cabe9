//! `rsph new`

use crate::cmd::unit::scale_to_metres;
use crate::exit::{Code, Trouble};
use crate::output::{number, print};
use clap::Args;
use rsph_core::shape::{MeshShape, Shape};
use rsph_scenario::mesh_io::read_mesh;
use std::path::{Path, PathBuf};

/// Print a commented scenario to start from
#[derive(Debug, Args)]
#[command(after_help = "\
Templates:
  liver_load            a liver pushed by a smeared load (the default)
  liver_load_transient  its first moments, with the paper's integrator
  liver_load_144        the same with 144 particles, as in the paper
  tensile_liver         tensile test of a cube, stiff
  tensile_kidney        tensile test of a cube, soft: it overshoots
  hanging_column        a column under its own weight
  oscillating_bar       a free bar that swings along its axis
  oscillating_beam      a free beam that bends to and fro
  block_large_strain    a plane block, pulled by 40 % and remeshed
  cook_membrane         a plane membrane at rest, nearly incompressible
  liver_with_tumour     a liver of two materials at rest under a local load
  deformation           a sphere that a given velocity field tears
  deformation_remeshed  the same with remeshing: it stays whole
  fsi_1d                a viscous fluid beside an elastic solid, on a line

Examples:
  rsph new > my.toml
  rsph new tensile_liver > tensile.toml
  rsph new --mesh organ.stl > organ.toml")]
pub struct Arguments {
    /// Which template
    #[arg(default_value = "liver_load")]
    template: String,
    /// Instead of a template: an organ of your own (.stl, .obj, .ply, .glb), at rest under its weight
    #[arg(long, value_name = "FILE", conflicts_with = "template")]
    mesh: Option<PathBuf>,
    /// Factor from the mesh's coordinates to metres [default: as its size suggests]
    #[arg(long, requires = "mesh", allow_negative_numbers = true)]
    scale: Option<f64>,
}

const TEMPLATES: &[(&str, &str)] = &[
    ("liver_load", include_str!("../../../../scenarios/liver_load.toml")),
    ("liver_load_transient", include_str!("../../../../scenarios/liver_load_transient.toml")),
    ("liver_load_144", include_str!("../../../../scenarios/liver_load_144.toml")),
    ("tensile_liver", include_str!("../../../../scenarios/tensile_liver.toml")),
    ("tensile_liver_remeshed", include_str!("../../../../scenarios/tensile_liver_remeshed.toml")),
    ("tensile_kidney", include_str!("../../../../scenarios/tensile_kidney.toml")),
    ("hanging_column", include_str!("../../../../scenarios/hanging_column.toml")),
    ("oscillating_bar", include_str!("../../../../scenarios/oscillating_bar.toml")),
    ("oscillating_beam", include_str!("../../../../scenarios/oscillating_beam.toml")),
    ("block_large_strain", include_str!("../../../../scenarios/block_large_strain.toml")),
    ("cook_membrane", include_str!("../../../../scenarios/cook_membrane.toml")),
    ("liver_with_tumour", include_str!("../../../../scenarios/liver_with_tumour.toml")),
    ("deformation", include_str!("../../../../scenarios/deformation.toml")),
    ("deformation_remeshed", include_str!("../../../../scenarios/deformation_remeshed.toml")),
    ("fsi_1d", include_str!("../../../../scenarios/fsi_1d.toml")),
];

pub fn run(arguments: &Arguments) -> Result<Code, Trouble> {
    if let Some(path) = &arguments.mesh {
        print(&of_mesh(path, arguments.scale)?)?;
        return Ok(Code::Good);
    }
    let name = arguments.template.trim_end_matches(".toml");
    let Some((_, text)) = TEMPLATES.iter().find(|(n, _)| *n == name) else {
        let known = TEMPLATES.iter().map(|(n, _)| *n).collect::<Vec<_>>().join(", ");
        return Err(Trouble::input(
            format!("there is no template \"{}\"", arguments.template),
            format!("templates: {known}"),
        ));
    };
    print(text)?;
    Ok(Code::Good)
}

/// Share of its height by which an organ is held.
const HELD: f64 = 0.2;

/// A scenario of the organ in the mesh file.
fn of_mesh(path: &Path, scale: Option<f64>) -> Result<String, Trouble> {
    let mut mesh = read_mesh(path, scale.unwrap_or(1.0)).map_err(|e| Trouble::mesh(&e))?;
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let Some(to_metres) = scale.or_else(|| scale_to_metres(path, &mesh.bounds()?)) else {
        return Err(Trouble::input(
            format!("{}: its size does not tell the unit", path.display()),
            "give `--scale`: 0.001 for millimetres, 0.01 for centimetres, 1 for metres",
        ));
    };
    if scale.is_none() {
        mesh.vertices.iter_mut().for_each(|v| *v *= to_metres);
    }
    let (shape, notes) = MeshShape::new(&mesh, &format!("mesh {file}"))
        .map_err(|e| Trouble::input(format!("{}: {}", path.display(), e.problem), e.remedy))?;
    let (low, size) = (shape.bounds().min.z, shape.bounds().size());
    let [x, y, z] = <[f64; 3]>::from(size).map(|length| number(1e3 * length));
    let notes = notes.into_iter().map(|note| format!("# {note}\n")).collect::<Vec<_>>().concat();
    // The scenario may be saved anywhere.
    let place = path.canonicalize().unwrap_or_else(|_| path.into());
    let (name, place) = (file.rsplit_once('.').map_or(&*file, |(name, _)| name), place.display().to_string());
    Ok(format!(
        "\
# {file}: {x} x {y} x {z} mm, {volume} ml. It hangs by its upper fifth, and its weight deforms it.
# `rsph run` computes where it comes to rest; every key: docs/guide/scenario.md, `rsph schema`.
{notes}title = {name:?}
units = \"SI\"                # m, kg, s, Pa

[body]
shape = {{ mesh = {{ path = {place:?}, scale = {to_metres} }} }}
particles = 2000            # about; more are more accurate

[material]                  # soft tissue at any strain; take the figures of yours
model = \"neo-hookean\"
density = 1060.0            # kg/m^3
young_modulus = 2e4         # Pa
poisson_ratio = 0.45        # nearly incompressible: up to 0.499
relaxation_time = 0.0       # s, of the damping; of no matter at rest

[solver]
mode = \"static\"           # straight to rest; \"dynamic\" moves it, up to `until` in [time]

[[boundary]]                # held above a plane, a fifth of its height from above
kind = \"clamp\"
region = {{ plane = {{ axis = \"z\", at = {at}, side = \"above\" }} }}

[[load]]                    # its weight
kind = \"body_force\"
acceleration = [0.0, 0.0, -9.81]

[[probe]]                   # how far its lower end goes down
name = \"tip\"
quantity = \"displacement.z\"
region = {{ plane = {{ axis = \"z\", at = {tip}, side = \"below\" }} }}
",
        volume = number(1e6 * shape.volume()),
        at = short(low + (1.0 - HELD) * size.z),
        tip = short(low + 0.5 * HELD * size.z),
    ))
}

/// A position to the hundredth of a millimetre.
fn short(x: f64) -> f64 {
    (1e5 * x).round() / 1e5
}
