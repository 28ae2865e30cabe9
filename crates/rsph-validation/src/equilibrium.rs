//! Static solves against finite elements: the clamped cube of section 5.2 held in several ways, and a real liver
//! at several positions of its lattice; iterations of the solver.

mod iterations;
mod oblique;
mod phases;

pub(super) use phases::Placed;

use super::Row;
use super::case::{LIVER_VISIBLE_HUMAN, TENSILE_LIVER, simulation};
use super::figure::{Curve, Figure};
use super::liver;
use rsph_core::simulation::{Equilibrium, Simulation};
use rsph_core::tensor::Vec3;
use std::path::Path;

/// Extension at rest of the clamped cube times E, nu = 0.3 (validation/tensile/README.md).
const CUBE: f64 = 0.97055;
/// Particles, and the bound of displacement and compliance (%); 1,000 and 5,000 must keep those of the next finer body.
const LIVER: [(usize, f64); 6] =
    [(1_000, 1.5), (1_250, 1.5), (5_000, 1.0), (5_700, 1.0), (20_000, 0.5), (60_000, 0.3)];

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    cubes(quick, &mut rows)?;
    if !quick {
        rows.extend(oblique::run()?);
        sphere(&mut rows)?;
    }
    if liver::is_there() {
        real_liver(quick, &mut rows, folder)?;
        rows.extend(phases::run(quick)?);
    }
    rows.extend(iterations::run(quick)?);
    Ok(rows)
}

pub(super) fn solved(scenario: (&str, &str), sets: &[String]) -> Result<(Simulation, Equilibrium), String> {
    let (mut simulation, until) = simulation(scenario, sets)?;
    let found = simulation.solve_static(until, &mut |_, _| true).map_err(|e| e.to_string())?;
    Ok((simulation, found))
}

fn cubes(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let accurate = ["solver.smoothing=0.8".to_owned()];
    let sizes: &[(usize, f64)] =
        if quick { &[(7, 0.5), (13, 0.25)] } else { &[(7, 0.5), (13, 0.25), (25, 0.12)] };
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
                0.25,
                "1",
            ));
        }
    }
    Ok(())
}

/// A sphere under uniform pressure, held in its middle: the same stress everywhere, e = -p (1 - 2 nu) / E.
fn sphere(rows: &mut Vec<Row>) -> Result<(), String> {
    const RADIUS: f64 = 0.5;
    let strain = -(1.0 - 2.0 * 0.3) / 100.0;
    for per_radius in [10, 20] {
        let spacing = RADIUS / f64::from(per_radius);
        let sets = [
            format!("body.spacing={spacing}"),
            format!("body.shape={{ sphere = {{ radius = {RADIUS} }} }}"),
            // The eight particles around its centre: a larger held part would change the answer.
            format!("boundary.0.region={{ ball = {{ centre = [0.0, 0.0, 0.0], radius = {spacing} }} }}"),
            "load=[{ kind = \"pressure\", region = \"all\", pressure = 1.0 }]".into(),
            "probe=[]".into(),
            "solver.smoothing=0.8".into(),
            "time.dt=auto".into(),
        ];
        let (mut body, _) = solved(TENSILE_LIVER, &sets)?;
        let snapshot = body.snapshot();
        let surface = body.surface(&snapshot);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let field = |name: &str| surface.field(name).map(|f| f.values.clone()).unwrap_or_default();
        let moved: Vec<f64> = surface
            .mesh
            .vertices
            .iter()
            .zip(field("displacement").chunks_exact(3))
            .map(|(x, u)| {
                let u = Vec3::from_column_slice(u);
                u.dot(&(x - u).normalize())
            })
            .collect();
        let name = |of: &str| format!("equilibrium: sphere under pressure, dx = R/{per_radius}, {of}");
        rows.push(Row::within(
            name("mean displacement of the surface"),
            mean(&moved),
            strain * RADIUS,
            0.01,
            "length",
        ));
        let normal = mean(&field("normal_strain"));
        rows.push(Row::within(name("mean normal strain on the surface"), normal, strain, 0.01, "1"));
    }
    Ok(())
}

/// What turns the shipped liver into the reference's.
pub(super) fn accurate_liver(particles: usize) -> Vec<String> {
    let mut sets = liver::edits(particles);
    sets.extend(["solver.smoothing=0.8", "time.integrator=auto"].map(String::from));
    sets
}

fn real_liver(quick: bool, rows: &mut Vec<Row>, folder: &Path) -> Result<(), String> {
    let (mut count, mut error) = (Vec::new(), Vec::new());
    for (particles, bound) in LIVER.into_iter().take(if quick { 4 } else { 6 }) {
        let (mut body, found) = solved(LIVER_VISIBLE_HUMAN, &accurate_liver(particles))?;
        let u: Vec<f64> = body.readings().iter().map(|r| r.value).collect();
        let name = |what: &str| format!("equilibrium: liver, {particles} particles, {what}");
        rows.push(Row::at_most(name("displacement off by"), 100.0 * liver::off(&u, 1.0), bound, "%"));
        rows.push(Row::within(name("compliance"), found.compliance, liver::COMPLIANCE, bound, "J"));
        let about = body.description();
        rows.push(Row::within(name("volume"), about.volume, about.shape_volume, 1.0, "m^3"));
        rows.push(Row::within(name("load"), found.load.y, liver::LOAD, 0.5, "N"));
        let unbalanced = (found.load + found.reaction).norm() / found.load.norm();
        rows.push(Row::at_most(name("load and reaction"), unbalanced, 1e-4, "1"));
        count.push(body.description().particles as f64 / 1000.0);
        error.push(100.0 * (found.compliance / liver::COMPLIANCE - 1.0));
    }
    let mut figure =
        Figure::new("Liver at rest against finite elements", "thousand particles", "error of compliance (%)");
    figure.add(Curve::marked("particles", &count, &error));
    figure.add(Curve::dotted("finite elements", &[0.0, count[count.len() - 1]], &[0.0; 2]));
    figure.save(folder, "equilibrium")
}
