//! The liver of `equilibrium` for other Poisson's ratios, under its own weight, and what is read under its load.

use super::case::read;
use crate::Row;
use crate::case::LIVER_VISIBLE_HUMAN;
use crate::equilibrium::{accurate_liver, solved};
use crate::liver::{CENTRE, PRESSURE, RADIUS};
use rsph_core::tensor::Vec3;

/// Compliance (J) by Poisson's ratio; the references are good to 1 % (`validation/references/liver.py`).
const COMPLIANCE: [(f64, f64); 3] = [(0.45, 7.446e-4), (0.49, 7.42e-4), (0.499, 7.41e-4)];
/// Compliance (J) under its own weight, 9810 N/m^3, along each axis; good to 0.4 %.
pub const WEIGHT: [(&str, [f64; 3], f64); 3] =
    [("x", [9.81, 0.0, 0.0], 0.0735), ("y", [0.0, 9.81, 0.0], 0.0244), ("z", [0.0, 0.0, 9.81], 0.0926)];
/// Mean normal strain within half the radius of the load.
const STRAIN: f64 = -1.95e-3;

pub fn run(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    nearly_incompressible(quick, rows)?;
    own_weight(quick, rows)?;
    under_the_load(quick, rows)
}

fn nearly_incompressible(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let sizes = [(1_250, 2.5), (5_700, 1.5), (20_000, 0.7)];
    for (particles, bound) in sizes.into_iter().take(if quick { 1 } else { 3 }) {
        for (nu, exact) in COMPLIANCE {
            let mut sets = accurate_liver(particles);
            sets.push(format!("material.poisson_ratio={nu}"));
            let (_, found) = solved(LIVER_VISIBLE_HUMAN, &sets)?;
            let name = |of: &str| format!("surfaces: liver, nu = {nu}, {particles} particles, {of}");
            rows.push(Row::within(name("compliance"), found.compliance, exact, bound, "J"));
            let iterations = if nu > 0.49 { 80.0 } else { 40.0 };
            rows.push(Row::at_most(name("iterations"), found.iterations as f64, iterations, "1"));
        }
    }
    Ok(())
}

/// An edit of the scenario by which its own weight is the only load.
pub fn weight(acceleration: [f64; 3]) -> String {
    format!("load=[{{ kind = \"body_force\", region = \"all\", acceleration = {acceleration:?} }}]")
}

fn own_weight(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let sizes = [(1_505, 2.0), (6_362, 1.0), (21_350, 0.5)];
    for (particles, bound) in sizes.into_iter().take(if quick { 1 } else { 3 }) {
        for (axis, acceleration, exact) in WEIGHT {
            let mut sets = accurate_liver(particles);
            sets.push(weight(acceleration));
            let (_, found) = solved(LIVER_VISIBLE_HUMAN, &sets)?;
            let name = format!(
                "surfaces: liver under its own weight along {axis}, nu = 0.3, {particles} particles, compliance"
            );
            rows.push(Row::within(name, found.compliance, exact, bound, "J"));
        }
    }
    Ok(())
}

/// Normal strain and stress under the patch load, as Fig. 7 shows them.
fn under_the_load(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    // Bounds of the strain, and of the stress where there is one.
    let sizes = [
        (1_000, Some(15.0), None),
        (5_000, Some(7.0), None),
        (5_700, None, Some(12.0)),
        (20_000, None, Some(7.0)),
    ];
    for (particles, of_strain, of_stress) in sizes.into_iter().take(if quick { 2 } else { 4 }) {
        let (mut body, _) = solved(LIVER_VISIBLE_HUMAN, &accurate_liver(particles))?;
        let (mut strain, mut stress) = ([0.0; 2], [0.0; 2]);
        for v in read(&mut body, 1.0) {
            let d = (v.x - Vec3::from(CENTRE)).norm();
            if d < 0.5 * RADIUS && v.normal.y > 0.0 {
                strain[0] += v.area * v.normal_strain;
                strain[1] += v.area;
            }
            if v.normal.y > 0.0 {
                let t = -PRESSURE * (-(d / RADIUS).powi(2)).exp() * Vec3::y();
                stress[0] += v.area * t.dot(&v.stress.dot(&v.normal));
                stress[1] += v.area * t.dot(&t);
            }
        }
        let name = |of: &str| format!("surfaces: liver, nu = 0.3, {particles} particles, {of}");
        if let Some(bound) = of_strain {
            let strain = strain[0] / strain[1];
            rows.push(Row::within(name("normal strain under the load"), strain, STRAIN, bound, "1"));
        }
        if let Some(bound) = of_stress {
            let stress = stress[0] / stress[1];
            rows.push(Row::within(name("stress under the load over the load"), stress, 1.0, bound, "1"));
        }
    }
    Ok(())
}
