//! The reproductions and benchmarks of `validation/`, as rows of a table and a figure each: `rsph validate`.
#![forbid(unsafe_code)]

mod case;
mod column;
mod creep;
mod deformation;
mod equilibrium;
mod figure;
mod figure_6;
mod figure_7;
mod fsi_1d;
mod imperfect;
mod kelvin_voigt_bar;
mod large_strain;
mod literal;
mod liver;
mod modal;
mod oscillation;
mod patch;
mod picture;
mod remeshed;
mod render;
pub mod report;
mod row;
mod series;
mod surfaces;
mod tensile;
mod two_materials;

pub use row::Row;

use std::path::{Path, PathBuf};
use std::time::Instant;

/// A validation that could not be carried out: a bug of the program, not of its user.
#[derive(Debug, thiserror::Error)]
#[error("validation {name}: {problem}")]
pub struct ValidationError {
    /// Name of the validation.
    pub name: &'static str,
    /// What went wrong.
    pub problem: String,
}

/// A validation: shortened or in full, with its figures and curves in a folder.
type Run = fn(quick: bool, folder: &Path) -> Result<Vec<Row>, String>;

/// A validation before it is run.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Name on the command line, and of its folder in `validation/`.
    pub name: &'static str,
    /// What it compares, in one line.
    pub about: &'static str,
    /// Whence its bounds come, where its README does not say otherwise.
    pub bounds: &'static str,
    run: Run,
}

/// Checks, time and figure of a validation that has run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The validation.
    pub case: Case,
    /// Its checks.
    pub rows: Vec<Row>,
    /// Wall time (s).
    pub seconds: f64,
    /// Today's figure (SVG), if it draws one.
    pub figure: Option<PathBuf>,
}

const fn case(name: &'static str, about: &'static str, bounds: &'static str, run: Run) -> Case {
    Case { name, about, bounds, run }
}

/// All validations, those of the paper's figures first.
pub const CASES: &[Case] = &[
    case(
        "deformation",
        "Figs. 1 to 3: a sphere drawn out to a sheet, torn or whole; the exact sheet",
        "issue 3, our own where the README says so",
        deformation::run,
    ),
    case(
        "fsi_1d",
        "Fig. 4: a fluid beside a solid; a fine reference, three ALE schemes, sound",
        "the paper (0.04), a prototype (ALE), issue 4",
        fsi_1d::run,
    ),
    case(
        "surfaces",
        "curved, cut and oblique surfaces, nu up to 0.499; exact solutions, finite elements",
        "issue 15",
        surfaces::run,
    ),
    case(
        "tensile",
        "Fig. 5: the tensile test of liver and kidney; finite elements",
        "issue 2; speed: the paper",
        tensile::run,
    ),
    case(
        "two_materials",
        "a stiff tumour in an organ from a segmentation of two labels; finite elements",
        "issue 17",
        two_materials::run,
    ),
    case("figure_6", "Fig. 6: a liver's surface beside that of 144 particles", "our own", figure_6::run),
    case(
        "figure_7",
        "Fig. 7: normal and shear strain under a local load, early on",
        "our own",
        figure_7::run,
    ),
    case(
        "imperfect",
        "surfaces that are none: exact unions, a published liver of 26 open parts",
        "issue 8 (the liver's volume, one piece), our own",
        imperfect::run,
    ),
    case("literal", "the paper's scheme to the letter, which is unstable", "issue 2", literal::run),
    case(
        "patch",
        "what must hold to rounding: linear fields, rotations, conservation",
        "rounding",
        patch::run,
    ),
    case("column", "a hanging column: the exact sag", "our own", column::run),
    case("series", "a Kelvin-Voigt bar: the exact history", "issue 2", series::run),
    case(
        "oscillation",
        "a free bar and a free beam: exact frequencies, second order, energy",
        "our own",
        oscillation::run,
    ),
    case(
        "equilibrium",
        "rest of the clamped cube and of a real liver: finite elements",
        "issue 5; volume and load: our own",
        equilibrium::run,
    ),
    case(
        "creep",
        "implicit steps: the exact bar, a liver against steps ten times shorter, speed",
        "issue 5, our own where the README says so",
        creep::run,
    ),
    case(
        "remeshed",
        "solids remeshed: finite elements, and the same runs without remeshing",
        "issue 3",
        remeshed::run,
    ),
    case(
        "large_strain",
        "large strain, at rest and remeshed: finite elements, energy, angular momentum",
        "issue 3; shear: one and a half times a prototype",
        large_strain::run,
    ),
];

/// Names that [`run`] knows.
pub fn names() -> impl Iterator<Item = &'static str> {
    CASES.iter().map(|case| case.name)
}

/// Runs the checks of these names (all of them if the list is empty); `quick` shortens them. Each
/// leaves its figures (SVG) and curves (CSV) in `folder`. `progress` is told the name of each as it
/// starts.
///
/// # Errors
/// A validation that could not be carried out, or a folder that can not be written.
pub fn run(
    names: &[String],
    quick: bool,
    folder: &Path,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<Outcome>, ValidationError> {
    let mut outcomes = Vec::new();
    for case in CASES.iter().filter(|case| names.is_empty() || names.iter().any(|n| n == case.name)) {
        progress(case.name);
        let failed = |problem| ValidationError { name: case.name, problem };
        std::fs::create_dir_all(folder)
            .map_err(|e| failed(format!("cannot make the folder {}: {e}", folder.display())))?;
        let drawn = folder.join(case.name).with_extension("svg");
        // A figure of an earlier day must not pass for one of today.
        if drawn.exists() {
            std::fs::remove_file(&drawn)
                .map_err(|e| failed(format!("cannot replace {}: {e}", drawn.display())))?;
        }
        let start = Instant::now();
        let rows = (case.run)(quick, folder).map_err(failed)?;
        let seconds = start.elapsed().as_secs_f64();
        let figure = Some(drawn).filter(|path| path.exists());
        outcomes.push(Outcome { case: *case, rows, seconds, figure });
    }
    Ok(outcomes)
}
