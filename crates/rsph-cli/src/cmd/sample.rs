//! `rsph sample`

use crate::exit::{Code, Trouble};
use clap::Args;
use std::path::PathBuf;

/// Turn a triangle mesh into particles, and say how well they fill it
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  rsph sample organ.stl --particles 1000
  rsph sample organ.stl --scale 0.001 --spacing 0.005 --output particles.csv")]
pub struct Arguments {
    /// A closed triangle mesh (.stl, .obj, .ply, .glb)
    #[arg(value_name = "MESH")]
    mesh: PathBuf,
    /// Distance between particles, in the units of the mesh times the scale
    #[arg(long, value_name = "S", required_unless_present = "particles", conflicts_with = "particles")]
    spacing: Option<f64>,
    /// Number of particles (about)
    #[arg(long, value_name = "N")]
    particles: Option<usize>,
    /// Factor on the mesh's coordinates (0.001: millimetres to metres)
    #[arg(long, default_value_t = 1.0)]
    scale: f64,
    /// Write the particles to this CSV file: x, y, z, volume, level_set
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<Code, Trouble> {
    let _ = arguments;
    Err(Trouble::input("to be wired", ""))
}
