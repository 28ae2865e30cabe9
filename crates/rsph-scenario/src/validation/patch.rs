//! Patch and conservation tests: what must hold to rounding.

use super::Row;
use super::case::{TENSILE_LIVER, simulation};
use rsph_core::particles::Field;
use std::path::Path;

pub(super) fn run(_quick: bool, _folder: &Path) -> Result<Vec<Row>, String> {
    // A sphere without clamp or load, so that every kind of surface particle is there.
    let free = |extra: &str| {
        let sets: Vec<String> =
            ["boundary=[]", "load=[]", "probe=[]", "body.shape={sphere={radius=0.5}}", "time.dt=auto", extra]
                .map(String::from)
                .to_vec();
        simulation(TENSILE_LIVER, &sets)
    };
    let gradient = [[0.02, 0.01, -0.03], [0.005, -0.04, 0.02], [0.01, 0.03, 0.05]];
    let affine = format!("{{affine={{constant=[0.1,0,0],gradient={gradient:?}}}}}");

    let (mut patch, _) = free(&format!("initial.displacement={affine}"))?;
    let snapshot = patch.snapshot();
    let strain = snapshot.column(Field::Strain);
    let expected = |i: usize, j: usize| 0.5 * (gradient[i][j] + gradient[j][i]);
    let expected =
        [expected(0, 0), expected(1, 1), expected(2, 2), expected(0, 1), expected(1, 2), expected(0, 2)];
    let strain_error = (0..snapshot.len())
        .flat_map(|a| (0..6).map(move |c| (a, c)))
        .map(|(a, c)| (strain.component(c)[a] - expected[c]).abs())
        .fold(0.0, f64::max);

    let (mut flight, _) =
        free(&format!("initial={{displacement={affine}, velocity={{constant=[1.0,2.0,-1.0]}}}}"))?;
    let start = flight.conservation();
    for _ in 0..500 {
        flight.step().map_err(|e| e.to_string())?;
    }
    let end = flight.conservation();
    let drift = (end.momentum - start.momentum).norm() / start.momentum.norm();

    let (mut turned, _) = free("initial.displacement={rotation={rate=[0.1,-0.2,0.3],centre=[1,2,3]}}")?;
    let turned = turned.snapshot();
    let rotation_strain = turned.column(Field::Strain).values().iter().fold(0.0_f64, |m, e| m.max(e.abs()));
    Ok(vec![
        Row::at_most("patch: strain of a linear field", strain_error, 1e-12, "1"),
        Row::at_most("patch: strain of a small rotation", rotation_strain, 1e-12, "1"),
        Row::at_most("patch: momentum in free flight", drift, 1e-12, "relative"),
        Row::at_most("patch: mass in free flight", end.mass_error, 0.0, "relative"),
    ])
}
