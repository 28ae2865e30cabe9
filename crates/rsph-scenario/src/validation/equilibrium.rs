//! Static solves against finite elements: the clamped cube of section 5.2 held in several ways, and a real liver
//! at several positions of its lattice; iterations of the solver.

mod iterations;
mod oblique;
mod phases;

use super::Row;
use super::case::{LIVER_VISIBLE_HUMAN, TENSILE_LIVER, simulation};
use super::figure::{Curve, Figure};
use rsph_core::simulation::{Equilibrium, Simulation};
use std::path::Path;

/// Extension at rest of the clamped cube times E, nu = 0.3 (validation/tensile/README.md).
const CUBE: f64 = 0.97055;
/// Compliance (J) and displacement at the centre of the load (m) of the liver, by quadratic tetrahedra on the
/// body cut at the clamp (validation/equilibrium/README.md).
const COMPLIANCE: f64 = 7.372e-4;
const DISPLACEMENT: [f64; 3] = [0.4680e-3, -1.4347e-3, -1.3508e-3];
/// Where the mesh is looked for, beside the repository.
const MESH: &str = "../shared/data/meshes/visible_human_liver_female.stl";
/// Height of the clamp: 15 % of the mesh.
const CLAMP: f64 = -0.060_008_288_9;
/// Particles, and the bounds of displacement and compliance (%), of issue 5.
const LIVER: [(usize, f64, f64); 4] =
    [(1_250, 8.5, 5.5), (5_700, 4.7, 2.0), (20_000, 2.9, 1.0), (60_000, 1.6, 0.5)];

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    cubes(quick, &mut rows)?;
    if !quick {
        rows.extend(oblique::run()?);
    }
    if Path::new(MESH).is_file() {
        liver(quick, &mut rows, folder)?;
        rows.extend(phases::run(quick)?);
    }
    rows.extend(iterations::run(quick)?);
    Ok(rows)
}

fn solved(scenario: (&str, &str), sets: &[String]) -> Result<(Simulation, Equilibrium), String> {
    let (mut simulation, until) = simulation(scenario, sets)?;
    let found = simulation.solve_static(until, &mut |_, _| true).map_err(|e| e.to_string())?;
    Ok((simulation, found))
}

fn cubes(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let accurate = ["solver.smoothing=0.8".to_owned(), "solver.hourglass=0.4".to_owned()];
    let sizes: &[(usize, f64)] =
        if quick { &[(7, 1.1), (13, 0.55)] } else { &[(7, 1.1), (13, 0.55), (25, 0.3)] };
    for (n, bound) in sizes {
        let spacing = format!("body.spacing={}", 1.0 / *n as f64);
        let mut sets = accurate.to_vec();
        sets.extend([spacing.clone(), "time.dt=auto".into()]);
        let (mut cube, found) = solved(TENSILE_LIVER, &sets)?;
        let name = format!("equilibrium: clamped cube {n}^3, E u");
        rows.push(Row::within(name, 100.0 * cube.readings()[0].value, CUBE, *bound, "1"));
        if *n == 13 {
            let iterations = found.iterations as f64;
            rows.push(Row::at_most("equilibrium: iterations, cube 13^3", iterations, 20.0, "1"));
            // The same cube on a held foot, clamped by a plane that the lattice of the box does not know.
            sets.extend([
                "body.shape={ box = { size = [1.0, 1.0, 1.37], corner = [0.0, 0.0, -0.37] } }".into()
            ]);
            let (mut cube, _) = solved(TENSILE_LIVER, &sets)?;
            let value = 100.0 * cube.readings()[0].value;
            rows.push(Row::within(
                "equilibrium: the same, clamped by a plane through a longer box",
                value,
                CUBE,
                1.1,
                "1",
            ));
        }
    }
    Ok(())
}

/// What turns the shipped liver into the reference's.
fn edits(particles: usize) -> Vec<String> {
    vec![
        format!("body.shape.mesh.path=\"{MESH}\""),
        format!("body.particles={particles}"),
        "solver.smoothing=0.8".into(),
        "solver.hourglass=0.4".into(),
        "time.integrator=auto".into(),
        format!("boundary.0.region.plane.at={CLAMP}"),
        "load.0.centre=[0.078748, 0.051970, -0.003656]".into(),
        "load.0.radius=0.037132".into(),
        "probe=[{ name = \"c\", quantity = \"displacement\", region = { point = [0.078748, 0.051970, -0.003656] } }]"
            .into(),
    ]
}

fn liver(quick: bool, rows: &mut Vec<Row>, folder: &Path) -> Result<(), String> {
    let (mut count, mut error) = (Vec::new(), Vec::new());
    for (particles, of_displacement, of_compliance) in LIVER.into_iter().take(if quick { 2 } else { 4 }) {
        let sets = edits(particles);
        let (mut liver, found) = solved(LIVER_VISIBLE_HUMAN, &sets)?;
        let u: Vec<f64> = liver.readings().iter().map(|r| r.value).collect();
        let size = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
        let off =
            size(&mut u.iter().zip(DISPLACEMENT).map(|(u, e)| u - e)) / size(&mut DISPLACEMENT.into_iter());
        let name = |what: &str| format!("equilibrium: liver, {particles} particles, {what}");
        rows.push(Row::at_most(name("displacement off by"), 100.0 * off, of_displacement, "%"));
        rows.push(Row::within(name("compliance"), found.compliance, COMPLIANCE, of_compliance, "J"));
        let unbalanced = (found.load + found.reaction).norm() / found.load.norm();
        rows.push(Row::at_most(name("load and reaction"), unbalanced, 1e-4, "1"));
        count.push(liver.description().particles as f64 / 1000.0);
        error.push(100.0 * (found.compliance / COMPLIANCE - 1.0));
    }
    let mut figure =
        Figure::new("Liver at rest against finite elements", "thousand particles", "error of compliance (%)");
    figure.add(Curve::solid("rsph", &count, &error));
    figure.add(Curve::dotted("finite elements", &[0.0, count[count.len() - 1]], &[0.0; 2]));
    figure.save(folder, "equilibrium")
}
