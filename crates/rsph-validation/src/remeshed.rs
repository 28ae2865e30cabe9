//! Solids remeshed on their lattice: the same displacement as without, and nothing lost.

use super::Row;
use super::case::{LIVER_LOAD, TENSILE_KIDNEY, TENSILE_LIVER, simulation};
use super::figure::{Curve, Figure};
use super::tensile::STATIC_E_U;
use rsph_core::simulation::{RemeshLog, Simulation};
use rsph_core::tensor::Vec3;
use std::path::Path;

/// Allowed change of the total momentum in one remeshing, rho0 x0^4 / T0 (issue 3).
const MOMENTUM: f64 = 1e-5;
/// Allowed relative change of the mass (issue 3).
const MASS: f64 = 1e-13;

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let mut figure = Figure::new("Tensile test with and without remeshing", "time", "E x extension");
    let intervals: &[u32] = if quick { &[100] } else { &[1, 10, 100] };
    for every in intervals {
        let sets = [format!("remesh.every={every}"), "time.until=2".into()];
        let (time, value, log) = tensile(TENSILE_LIVER, &sets, 2.0)?;
        let name = |what: &str| format!("remeshed: liver every {every} steps, {what}");
        rows.push(Row::within(name("at rest"), last(&value), STATIC_E_U / 100.0, 2.0, "extension"));
        rows.push(Row::at_most(name("mass jump"), log.largest_mass_jump, MASS, "1"));
        rows.push(Row::at_most(name("momentum jump"), log.largest_momentum_jump, MOMENTUM, "1"));
        let given_back = log.largest_momentum_correction;
        rows.push(Row::at_most(name("momentum given back"), given_back, MOMENTUM, "1"));
        let gain = log.energy_change / log.sums[1].energy;
        rows.push(Row::at_most(name("energy made"), gain.abs(), 0.005, "of the energy at rest"));
        let scaled: Vec<f64> = value.iter().map(|u| 100.0 * u).collect();
        figure.add(Curve::solid(&format!("liver, every {every} steps"), &time, &scaled));
    }
    for every in if quick { vec![0, 100] } else { vec![0, 10, 100] } {
        let sets = [format!("remesh.every={every}"), "time.dt=auto".into(), "time.until=4".into()];
        let (time, value, log) = tensile(TENSILE_KIDNEY, &sets, 4.0)?;
        let scaled: Vec<f64> = value.iter().map(|u| 10.0 * u).collect();
        if every == 0 {
            figure.add(Curve::dotted("kidney, never", &time, &scaled));
            continue;
        }
        let name = |what: &str| format!("remeshed: kidney every {every} steps, {what}");
        rows.push(Row::within(name("at rest"), last(&value), STATIC_E_U / 10.0, 2.0, "extension"));
        rows.push(Row::at_most(name("mass jump"), log.largest_mass_jump, MASS, "1"));
        rows.push(Row::at_most(name("momentum jump"), log.largest_momentum_jump, MOMENTUM, "1"));
        figure.add(Curve::dashed(&format!("kidney, every {every} steps"), &time, &scaled));
    }
    figure.save(folder, "remeshed")?;

    // The bound is the at the load of Figs. 6 and 7; at ten times that, where the dent is a third of
    // a spacing deep, it is our own.
    let every = if quick { 100 } else { 10 };
    for (pressure, percent) in [(270.0, 1.0), (2700.0, 5.0)] {
        let without = liver(pressure, 0)?;
        let with = liver(pressure, every)?;
        let name = |what: &str| format!("remeshed: organ under {pressure} Pa every {every} steps, {what}");
        rows.push(Row::at_most(
            name("difference of the surface's displacement"),
            100.0 * difference(&without.1, &with.1),
            percent,
            "% (mean square)",
        ));
        rows.push(Row::within(name("mean displacement"), mean(&with.1), mean(&without.1), 1.0, "m"));
        rows.push(Row::within(name("probe of the top"), with.0, without.0, 1.0, "m"));
    }
    Ok(rows)
}

fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(f64::NAN)
}

/// Times, extensions and what remeshing did.
fn tensile(
    scenario: (&str, &str),
    sets: &[String],
    until: f64,
) -> Result<(Vec<f64>, Vec<f64>, RemeshLog), String> {
    let (mut sim, _) = simulation(scenario, sets)?;
    let (mut time, mut value) = (Vec::new(), Vec::new());
    for k in 0..=100 {
        sim.advance_to(until * f64::from(k) / 100.0, &mut |_| true).map_err(|e| e.to_string())?;
        time.push(sim.time());
        value.push(sim.readings()[0].value);
    }
    Ok((time, value, sim.remesh_log().unwrap_or_default()))
}

/// The analytic liver of about 5,000 particles after 0.01 s: its probe of the top, and the displacement of
/// the vertices of its surface. With T = 0.02 s the transient takes a few hundred steps of RK4.
fn liver(pressure: f64, every: u32) -> Result<(f64, Vec<Vec3>), String> {
    let sets = [
        "body.particles=5000".into(),
        "solver.smoothing=0.8".into(),
        "material.relaxation_time=0.02".into(),
        "time.integrator=rk4".into(),
        "time.dt=auto".into(),
        format!(
            "load=[{{kind=\"patch\", pressure={pressure}, centre=\"upper-right\", direction=[0.0, -1.0, 0.0]}}]"
        ),
        format!("remesh={{every={every}}}"),
    ];
    let (mut sim, _) = simulation(LIVER_LOAD, &sets)?;
    let start = vertices(&mut sim);
    sim.advance_to(0.01, &mut |_| true).map_err(|e| e.to_string())?;
    if every > 0 && sim.remesh_log().is_none_or(|log| log.count < 2) {
        return Err(format!("the liver was not remeshed every {every} steps"));
    }
    let top = sim.readings()[0].value;
    Ok((top, vertices(&mut sim).iter().zip(start).map(|(x, x0)| x - x0).collect()))
}

fn vertices(sim: &mut Simulation) -> Vec<Vec3> {
    let snapshot = sim.snapshot();
    sim.surface(&snapshot).mesh.vertices
}

/// Root mean square of the difference over that of the first.
fn difference(a: &[Vec3], b: &[Vec3]) -> f64 {
    let square = |x: f64, y: f64| x + y;
    let d = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).fold(0.0, square);
    (d / a.iter().map(Vec3::norm_squared).fold(0.0, square)).sqrt()
}

/// Mean downward displacement.
fn mean(u: &[Vec3]) -> f64 {
    u.iter().map(|u| u.y).sum::<f64>() / u.len() as f64
}
