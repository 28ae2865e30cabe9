//! `rsph image`

use crate::exit::{Code, Trouble};
use crate::output::{number, print};
use clap::{Args, ValueEnum};
use rsph_scenario::label_map::{Axes, read_grid};
use rsph_scenario::output::voxels::{Registration, on_voxels, registration};
use rsph_scenario::output::{nifti, vtkhdf};
use std::path::{Path, PathBuf};

/// Write a field of a stored state on the voxels of a CT or MR image, for overlay on it
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  rsph image out/liver --like ct.nii.gz --output u.nii.gz
  rsph image out/liver --like ct.nii.gz --field strain --output strain.nii.gz --step 3
  rsph image out/liver --like ct.nii.gz --field stress.zz --outside nan --output stress.nii

The field is shown on the undeformed body, where the image shows it. A displacement is a displacement
field (NIfTI intent 1006) in the units and along the axes of the image: x to the right, y to the front, z up.")]
pub struct Arguments {
    /// The folder of a run, or the particles.vtkhdf in it
    #[arg(value_name = "SNAPSHOT")]
    snapshot: PathBuf,
    /// The image whose voxels are taken (.nii, .nii.gz)
    #[arg(long, value_name = "IMAGE")]
    like: PathBuf,
    /// A field or a component of it: displacement, strain, stress.zz, von_mises
    #[arg(long, value_name = "FIELD", default_value = "displacement")]
    field: String,
    /// Which frame, from 0 [default: the last]
    #[arg(long, value_name = "K")]
    step: Option<usize>,
    /// Value of the voxels outside the body
    #[arg(long, value_enum, default_value_t = Outside::Zero)]
    outside: Outside,
    /// Units of the body in one of the image [default: that of the scenario's label map, else as the image says]
    #[arg(long, value_name = "S")]
    scale: Option<f64>,
    /// Axes of the body [default: those of the scenario's label map, else image]
    #[arg(long, value_enum)]
    axes: Option<AxesName>,
    /// NIfTI file; compressed if its name ends with .gz
    #[arg(short, long, value_name = "FILE", default_value = "field.nii.gz")]
    output: PathBuf,
}

/// What voxels outside the body hold.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Outside {
    /// 0
    #[value(name = "0")]
    Zero,
    /// Not a number
    Nan,
}

/// Axes of the body.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum AxesName {
    /// Axes of the image
    Image,
    /// x to the left of the body, y up, z to the front
    Organ,
}

pub fn run(arguments: &Arguments) -> Result<Code, Trouble> {
    let Arguments { snapshot, like, field, step, outside, scale, axes, output } = arguments;
    if scale.is_some_and(|s| !(s.is_finite() && s > 0.0)) {
        return Err(Trouble::input("--scale must be greater than 0", "0.001 makes metres of mm"));
    }
    let particles = if snapshot.is_dir() { snapshot.join("particles.vtkhdf") } else { snapshot.clone() };
    let state = vtkhdf::read_step(&particles, *step).map_err(|e| Trouble::results(&e))?;
    let of_scenario = registration(particles.parent().unwrap_or(Path::new("")))?;
    let registration = Registration {
        scale: scale.or(of_scenario.scale),
        axes: match axes {
            Some(AxesName::Image) => Axes::Image,
            Some(AxesName::Organ) => Axes::Organ,
            None => of_scenario.axes,
        },
    };
    let grid = read_grid(like)
        .map_err(|e| Trouble::input(format!("{}: {}", e.path.display(), e.problem), e.remedy))?;
    let shown = on_voxels(&state, field, &grid, registration).map_err(|e| {
        let subject = match e.key.as_str() {
            "like" => like.display().to_string(),
            "field" => format!("--field {field}"),
            _ => particles.display().to_string(),
        };
        Trouble::input(format!("{subject}: {}", e.problem), e.remedy)
    })?;
    let outside = match outside {
        Outside::Zero => 0.0,
        Outside::Nan => f32::NAN,
    };
    nifti::write(output, &grid, &shown, outside)
        .map_err(|e| Trouble::input(e.to_string(), "choose another file with --output"))?;
    print(&format!(
        "{}: {field} in {} voxels of the body at t = {}\n",
        output.display(),
        shown.voxels.len(),
        number(state.time)
    ))?;
    Ok(Code::Good)
}
