//! `rsph new`

use crate::exit::{Code, Trouble};
use crate::output::print;
use clap::Args;

/// Print a commented scenario to start from
#[derive(Debug, Args)]
#[command(after_help = "\
Templates:
  liver_load            a liver pushed by a smeared load (the default)
  liver_load_transient  its first moments, with the paper's integrator
  liver_load_144        the same with 144 particles, as in the paper
  liver_visible_human   the same on a triangle mesh
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
  rsph new tensile_liver > tensile.toml")]
pub struct Arguments {
    /// Which template
    #[arg(default_value = "liver_load")]
    template: String,
}

const TEMPLATES: &[(&str, &str)] = &[
    ("liver_load", include_str!("../../../../scenarios/liver_load.toml")),
    ("liver_load_transient", include_str!("../../../../scenarios/liver_load_transient.toml")),
    ("liver_load_144", include_str!("../../../../scenarios/liver_load_144.toml")),
    ("liver_visible_human", include_str!("../../../../scenarios/liver_visible_human.toml")),
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
