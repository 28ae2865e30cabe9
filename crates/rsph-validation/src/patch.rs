//! Patch and conservation tests: what must hold to rounding.

use super::Row;
use super::case::{TENSILE_LIVER, simulation};
use super::figure::{Curve, Figure};
use rsph_core::particles::Field;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::path::Path;

/// Gradient of a linear displacement field.
const GRADIENT: [[f64; 3]; 3] = [[0.02, 0.01, -0.03], [0.005, -0.04, 0.02], [0.01, 0.03, 0.05]];
/// Steps of free flight.
const STEPS: u32 = 500;

pub(super) fn run(_quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = fields()?;
    rows.extend(tension()?);
    rows.extend(flight(folder)?);
    Ok(rows)
}

/// A sphere without clamp or load, so that every kind of surface particle is there.
fn free(initial: &str) -> Result<Simulation, String> {
    let sets: Vec<String> =
        ["boundary=[]", "load=[]", "probe=[]", "body.shape={sphere={radius=0.5}}", "time.dt=auto", initial]
            .map(String::from)
            .to_vec();
    Ok(simulation(TENSILE_LIVER, &sets)?.0)
}

/// Strain of linear fields and of rotations.
fn fields() -> Result<Vec<Row>, String> {
    let affine = format!("initial.displacement={{affine={{constant=[0.1,0,0],gradient={GRADIENT:?}}}}}");
    let mut patch = free(&affine)?;
    let snapshot = patch.snapshot();
    let strain = snapshot.column(Field::Strain);
    let expected = |i: usize, j: usize| 0.5 * (GRADIENT[i][j] + GRADIENT[j][i]);
    let expected =
        [expected(0, 0), expected(1, 1), expected(2, 2), expected(0, 1), expected(1, 2), expected(0, 2)];
    let strain_error = (0..snapshot.len())
        .flat_map(|a| (0..6).map(move |c| (a, c)))
        .map(|(a, c)| (strain.component(c)[a] - expected[c]).abs())
        .fold(0.0, f64::max);

    let mut turned = free("initial.displacement={rotation={rate=[0.1,-0.2,0.3],centre=[1,2,3]}}")?;
    let snapshot = turned.snapshot();
    let largest = |field: Field, sim: &mut Simulation| {
        sim.snapshot().column(field).values().iter().fold(0.0_f64, |m, x| m.max(x.abs()))
    };
    let rotation_strain = largest(Field::Strain, &mut turned);
    let way = snapshot.column(Field::Displacement).values().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    turned.step().map_err(|e| e.to_string())?;
    let started = largest(Field::Velocity, &mut turned) * turned.time() / way;
    Ok(vec![
        Row::at_most("patch: strain of a linear field", strain_error, 1e-12, "1"),
        Row::at_most("patch: strain of a small rotation", rotation_strain, 1e-12, "1"),
        Row::at_most(
            "patch: motion that a small rotation starts in a step",
            started,
            1e-12,
            "of the rotation",
        ),
    ])
}

/// A clamped cube without sideways contraction under uniform tension: its strain is the same everywhere.
fn tension() -> Result<Vec<Row>, String> {
    let sets = ["material.poisson_ratio=0".to_owned(), "time.tolerance=1e-8".into()];
    let (mut cube, until) = simulation(TENSILE_LIVER, &sets)?;
    cube.solve_static(until, &mut |_, _| true).map_err(|e| e.to_string())?;
    let snapshot = cube.snapshot();
    let strain = snapshot.column(Field::Strain);
    // Component ZZ is load / E = 0.01, all others vanish.
    let expected = [0.0, 0.0, 0.01, 0.0, 0.0, 0.0];
    let error = (0..snapshot.len())
        .flat_map(|a| (0..6).map(move |c| (a, c)))
        .map(|(a, c)| (strain.component(c)[a] - expected[c]).abs())
        .fold(0.0, f64::max);
    Ok(vec![Row::at_most(
        "patch: strain of a clamped cube under tension, nu = 0",
        error / 0.01,
        1e-4,
        "relative",
    )])
}

/// Free flight of a body that is stretched, moves and turns: what must not change, and its history.
fn flight(folder: &Path) -> Result<Vec<Row>, String> {
    let affine = |constant: &str| format!("{{affine={{constant={constant},gradient={GRADIENT:?}}}}}");
    let initial =
        format!("initial={{displacement={}, velocity={}}}", affine("[0.1,0,0]"), affine("[1.0,2.0,-1.0]"));
    let mut flight = free(&initial)?;
    let (start, spin) = (flight.conservation(), angular_momentum(&flight));
    // The sphere turns slowly: rounding goes by the size of what is summed up.
    let size = turning_size(&flight);
    let (mut time, mut momentum, mut turning) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..STEPS {
        flight.step().map_err(|e| e.to_string())?;
        time.push(flight.time());
        momentum.push((flight.conservation().momentum - start.momentum).norm() / start.momentum.norm());
        turning.push((angular_momentum(&flight) - spin).norm() / size);
    }
    // Rounding as a power of ten; what is exactly kept is drawn at the bottom.
    let power = |v: &[f64]| v.iter().map(|x| x.max(1e-18).log10()).collect::<Vec<f64>>();
    let mut figure =
        Figure::new("Free flight of a stretched sphere", "time", "relative change, power of ten");
    figure.limit(-18.0, -10.0);
    figure.add(Curve::solid("momentum", &time, &power(&momentum)));
    figure.add(Curve::dashed("angular momentum", &time, &power(&turning)));
    figure.add(Curve::dotted("bound", &[0.0, flight.time()], &[-12.0; 2]));
    figure.save(folder, "patch")?;
    let largest = |v: &[f64]| v.iter().copied().fold(0.0, f64::max);
    Ok(vec![
        Row::at_most("patch: momentum in free flight", largest(&momentum), 1e-12, "relative"),
        Row::at_most("patch: angular momentum in free flight", largest(&turning), 1e-12, "relative"),
        Row::at_most("patch: mass in free flight", flight.conservation().mass_error, 0.0, "relative"),
    ])
}

/// m X x v of each particle about the origin. The law of small strain knows one place of a particle, X.
fn turning(sim: &Simulation) -> impl Iterator<Item = Vec3> {
    let p = sim.particles();
    let (mass, x, v) = (p.column(Field::Mass), p.column(Field::Reference), p.column(Field::Velocity));
    (0..p.len()).map(move |a| mass.values()[a] * x.vector(a).cross(&v.vector(a)))
}

fn angular_momentum(sim: &Simulation) -> Vec3 {
    turning(sim).sum()
}

fn turning_size(sim: &Simulation) -> f64 {
    turning(sim).map(|l| l.norm()).sum()
}
