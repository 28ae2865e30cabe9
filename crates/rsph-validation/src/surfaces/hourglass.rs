//! The default modulus of the hourglass term: half of it, once and twice on bodies of several shapes, loads and Poisson's
//! ratios, at both smoothing lengths that it is given for.

use super::case::Case;
use super::{
    CANTILEVER, CANTILEVER_WEIGHT, CUBE, POSITIONS, TURNS, clamped_beam, clamped_cube, end_shear, livers,
    local_load, own_weight, placed,
};
use crate::Row;
use crate::case::LIVER_VISIBLE_HUMAN;
use crate::equilibrium::{accurate_liver, solved};
use crate::figure::{Curve, Figure};
use crate::liver;
use rsph_core::setup::Solver;
use rsph_core::tensor::Vec3;
use std::path::Path;

/// Multiples of the default.
const MULTIPLES: [f64; 3] = [0.5, 1.0, 2.0];
/// Smoothing lengths in spacings.
const SMOOTHING: [f64; 2] = [0.8, 1.25];
/// Root mean square of the errors (%) at the default, at most.
const ERROR: f64 = 3.0;
/// Root mean square of the errors at the default over the least of the three, at most.
const WORSE: f64 = 1.25;

/// Errors (%) by multiple.
type Errors = [f64; MULTIPLES.len()];

/// Errors of the compliance by multiple of the default.
pub fn study(quick: bool, rows: &mut Vec<Row>, folder: &Path) -> Result<(), String> {
    let mut figure = Figure::new(
        "Compliance by the modulus of the hourglass term, h = 0.8 dx",
        "multiple of the default",
        "error (%)",
    );
    for smoothing in &SMOOTHING[..if quick { 1 } else { 2 }] {
        let mut squares = [0.0; MULTIPLES.len()];
        let mut count = 0.0;
        for (name, errors) in errors(*smoothing, quick)? {
            count += 1.0;
            for (sum, error) in squares.iter_mut().zip(errors) {
                *sum += error * error;
            }
            if *smoothing == SMOOTHING[0] {
                figure.add(Curve::marked(&name, &MULTIPLES, &errors));
            }
        }
        let rms = squares.map(|s| (s / count).sqrt());
        let least = rms.iter().copied().fold(f64::INFINITY, f64::min);
        let name = |of: &str| format!("surfaces: hourglass, h = {smoothing} dx, {of}");
        rows.push(Row::at_most(name("rms error of the compliance"), rms[1], ERROR, "%"));
        rows.push(Row::at_most(
            name("over the least of half, once and twice the default"),
            rms[1] / least,
            WORSE,
            "1",
        ));
    }
    figure.save(folder, "hourglass")
}

/// Errors (%) of every body for all multiples.
fn errors(smoothing: f64, quick: bool) -> Result<Vec<(String, Errors)>, String> {
    let (oblique, turn) = TURNS[2];
    let mut bodies: Vec<(String, Case, f64)> = Vec::new();
    for (nu, exact) in [CUBE[0], CUBE[2]] {
        let placed = placed(Vec3::repeat(1.0), oblique, Vec3::from(POSITIONS[0]), 1.0 / 7.0)?;
        bodies.push((format!("cube 7 across, {turn}, nu = {nu}"), clamped_cube(placed, 7.0, nu), exact));
        let (sphere, exact) = local_load::with_compliance(6.0, nu)?;
        bodies.push((format!("sphere under a local load, R/dx = 6, nu = {nu}"), sphere, exact));
    }
    for (nu, exact) in [CANTILEVER[0], CANTILEVER[3]] {
        let beam = clamped_beam(6.0, oblique, nu, end_shear)?;
        bodies.push((format!("beam 6 across, {turn}, nu = {nu}"), beam, exact));
    }
    let beam = clamped_beam(6.0, None, 0.3, own_weight)?;
    bodies.push(("beam 6 across, own weight, nu = 0.3".into(), beam, CANTILEVER_WEIGHT));
    let mut found = Vec::new();
    for (name, case, exact) in bodies {
        let compliance = |hourglass| {
            let solver = Solver { smoothing, hourglass, ..Solver::ACCURATE };
            Ok(case.clone().solve_by(solver)?.1.compliance)
        };
        found.push((name, off(compliance, exact)?));
    }
    if liver::is_there() && !quick {
        let of = |more: Option<String>| {
            move |hourglass: f64| {
                let mut sets = accurate_liver(1_505);
                sets.extend([
                    format!("solver.smoothing={smoothing}"),
                    format!("solver.hourglass={hourglass}"),
                ]);
                sets.extend(more.clone());
                Ok(solved(LIVER_VISIBLE_HUMAN, &sets)?.1.compliance)
            }
        };
        found.push(("liver, 1,505 particles, patch, nu = 0.3".into(), off(of(None), liver::COMPLIANCE)?));
        for (axis, acceleration, exact) in livers::WEIGHT {
            let weight = livers::weight(acceleration);
            found.push((format!("liver, own weight along {axis}"), off(of(Some(weight)), exact)?));
        }
    }
    Ok(found)
}

/// Errors (%) of what `compliance` makes of each multiple.
fn off(compliance: impl Fn(f64) -> Result<f64, String>, exact: f64) -> Result<Errors, String> {
    let mut errors = Errors::default();
    for (error, multiple) in errors.iter_mut().zip(MULTIPLES) {
        *error = 100.0 * (compliance(multiple)? / exact - 1.0);
    }
    Ok(errors)
}
