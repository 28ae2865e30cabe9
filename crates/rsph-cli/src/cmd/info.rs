//! `rsph info`

use crate::exit::{Code, Trouble};
use clap::Args;
use std::path::PathBuf;

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
    let _ = arguments;
    Err(Trouble::input("to be wired", ""))
}
