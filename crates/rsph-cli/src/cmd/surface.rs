//! `rsph surface`

use crate::exit::{Code, Trouble};
use clap::Args;
use std::path::PathBuf;

/// Write the surface of a stored state as a triangle mesh
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  rsph surface out/liver_load/surface.vtkhdf --output liver.stl
  rsph surface out/liver_load/surface.vtkhdf --step 0 --output before.vtp")]
pub struct Arguments {
    /// surface.vtkhdf of a run, or its folder
    #[arg(value_name = "SNAPSHOT")]
    snapshot: PathBuf,
    /// Which frame, from 0 [default: the last]
    #[arg(long, value_name = "K")]
    step: Option<usize>,
    /// STL, PLY, OBJ or VTP file, by its extension [default: surface.stl]
    #[arg(short, long, value_name = "FILE", default_value = "surface.stl", hide_default_value = true)]
    output: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<Code, Trouble> {
    let _ = arguments;
    Err(Trouble::input("to be wired", ""))
}
