//! `rsph info`

mod folder;
mod image;
mod mesh;
mod results;

use crate::exit::{Code, Trouble};
use crate::output::print;
use clap::Args;
use std::path::PathBuf;

/// Say what a mesh, an image, a results file or the folder of a run holds
#[derive(Debug, Args)]
#[command(after_help = "\
Of a mesh: whether it is closed, its pieces, extents, volume, named parts, the unit that its size suggests,
and the body that a run would make of it. Of an image: its voxels, where they are, and the volume of each
label.

Examples:
  rsph info organ.stl
  rsph info segmentation.nii.gz
  rsph info out/liver_load")]
pub struct Arguments {
    /// A mesh (.stl, .obj, .ply, .glb), an image (.nii, .nii.gz, .nrrd), a .vtkhdf file, or the folder of a run
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<Code, Trouble> {
    let path = &arguments.file;
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let ends = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
    let text = if path.is_dir() {
        folder::describe(path)
    } else if ends(&[".vtkhdf"]) {
        results::describe(path)
    } else if ends(&[".nii", ".nii.gz", ".nrrd", ".nhdr"]) {
        image::describe(path)
    } else if ends(&[".toml"]) {
        Err(Trouble::input(
            format!("{} is a scenario", path.display()),
            format!("`rsph run {}` runs it; `rsph info` describes its mesh or image", path.display()),
        ))
    } else {
        mesh::describe(path)
    }?;
    print(&text)?;
    Ok(Code::Good)
}
