//! Implicit integration: SDIRK2 on the bar of Kelvin-Voigt material against its series and against the
//! exact motion of the same operator in its modes; the creep of a liver against steps ten times shorter.

use super::Row;
use super::case::{History, LIVER_LOAD, TENSILE_LIVER, simulation};
use super::figure::{Curve, Figure};
use super::kelvin_voigt_bar::extension;
use super::modal::Modes;
use rsph_core::particles::Field;
use rsph_core::setup::{Load, LoadKind, PatchCentre};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::path::Path;
use std::time::Instant;

/// Value at rest of the bar.
const REST: f64 = 0.01;

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = bar()?;
    rows.extend(liver(quick, folder)?);
    if !quick {
        rows.extend(touched()?);
    }
    Ok(rows)
}

/// Frames a second of a liver that is touched somewhere else in every frame of 1/30 s.
fn touched() -> Result<Vec<Row>, String> {
    const FRAMES: u32 = 60;
    let mut rows = Vec::new();
    for (particles, bound) in [(5_000, 30.0), (10_000, 0.0), (20_000, 0.0)] {
        let dt = 1.0 / 30.0;
        let sets = [format!("body.particles={particles}"), format!("time.dt={dt}"), "time.until=10".into()];
        let (mut liver, _) = simulation(LIVER_LOAD, &sets)?;
        let kind = |k: u32| LoadKind::Patch {
            pressure: 270.0,
            centre: PatchCentre::At(Vec3::new(0.07 - 0.0015 * f64::from(k), 0.05, 0.0)),
            radius: Some(0.037),
            direction: -Vec3::y(),
        };
        let start = Instant::now();
        for k in 0..FRAMES {
            let load = Load { kind: kind(k), curve: rsph_core::setup::Curve::default() };
            liver.set_loads(vec![load]).map_err(|e| e.to_string())?;
            liver.advance_to(f64::from(k + 1) * dt, &mut |_| true).map_err(|e| e.to_string())?;
        }
        let rate = f64::from(FRAMES) / start.elapsed().as_secs_f64();
        let name = format!("creep: touched liver, {particles} particles, frames of 1/30 s");
        rows.push(Row::at_least(name, rate, bound, "frames/s"));
    }
    Ok(rows)
}

/// SDIRK2 on the clamped cube of 7^3, nu = 0, E = 100, against the motion of the same operator in its modes,
/// and against the series of the bar that the operator stands for.
fn bar() -> Result<Vec<Row>, String> {
    const T: f64 = 0.2;
    let sets = |more: [&str; 2]| {
        let exact = ["material.poisson_ratio=0", "time.until=1", "time.tolerance=1e-6"];
        exact.into_iter().chain(more).map(String::from).collect::<Vec<_>>()
    };
    let displacement = |cube: &Simulation| cube.particles().column(Field::Displacement).values().to_vec();
    let modes = {
        let (mut cube, until) = simulation(TENSILE_LIVER, &sets(["time.dt=auto", "time.integrator=sdirk2"]))?;
        cube.solve_static(until, &mut |_, _| true).map_err(|e| e.to_string())?;
        let rest = displacement(&cube);
        Modes::new(&mut cube, &rest, T)?
    };
    let mut errors = Vec::new();
    for dt in ["time.dt=0.04", "time.dt=0.02", "time.dt=0.01", "time.dt=0.005"] {
        let (mut cube, until) = simulation(TENSILE_LIVER, &sets(["time.integrator=sdirk2", dt]))?;
        let (mut of_modes, mut of_series) = (0.0_f64, 0.0_f64);
        for k in 1..=25 {
            let t = until * f64::from(k) / 25.0;
            cube.advance_to(t, &mut |_| true).map_err(|e| e.to_string())?;
            let off = displacement(&cube).into_iter().zip(modes.displacement(t)).map(|(u, e)| (u - e).abs());
            of_modes = off.fold(of_modes, f64::max);
            of_series = of_series.max((cube.readings()[0].value - extension(t, 100.0, T)).abs());
        }
        errors.push([of_modes, of_series].map(|off| 100.0 * off / REST));
    }
    let unit = "% of the extension at rest";
    let name = |what: &str| format!("creep: bar, sdirk2, {what}");
    // 4 is second order, 2 the first.
    let ratio = |what: &str, i: usize| Row::at_least(name(what), errors[i][0] / errors[i + 1][0], 2.5, "1");
    Ok(vec![
        Row::at_most(name("dt = 0.02, any particle off the same operator in modes"), errors[1][0], 0.2, unit),
        Row::at_most(name("dt = 0.02, off the series"), errors[1][1], 0.3, unit),
        ratio("error at dt = 0.04 over that at 0.02", 0),
        ratio("error at dt = 0.02 over that at 0.01", 1),
        ratio("error at dt = 0.01 over that at 0.005", 2),
    ])
}

fn liver(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let particles = if quick { 2_000 } else { 20_000 };
    let of = |how: &str| -> Result<History, String> {
        let sets = [format!("body.particles={particles}"), how.into(), "time.until=1".into()];
        let (mut liver, until) = simulation(LIVER_LOAD, &sets)?;
        let (mut time, mut value) = (vec![0.0], vec![0.0]);
        let start = Instant::now();
        for k in 1..=10 {
            let t = until * f64::from(k) / 10.0;
            liver.advance_to(t, &mut |_| true).map_err(|e| e.to_string())?;
            time.push(t);
            value.push(liver.readings()[0].value);
        }
        let seconds = start.elapsed().as_secs_f64();
        Ok(History { time, value, end: liver.conservation(), steps_per_second: 1.0 / seconds, failure: None })
    };
    let (coarse, fine) = (of("time.tolerance=0.05")?, of("time.dt=0.01")?);
    let (_, rest) = {
        let (mut liver, until) = simulation(LIVER_LOAD, &[format!("body.particles={particles}")])?;
        let found = liver.solve_static(until, &mut |_, _| true).map_err(|e| e.to_string())?;
        (found, liver.readings()[0].value)
    };
    let mut figure = Figure::new("Creep of the liver", "time (s)", "displacement (mm)");
    let mm = |v: &[f64]| v.iter().map(|x| 1e3 * x).collect::<Vec<f64>>();
    figure.add(Curve::solid("sdirk2, its own steps", &coarse.time, &mm(&coarse.value)));
    figure.add(Curve::dashed("dt = 0.01 s", &fine.time, &mm(&fine.value)));
    figure.add(Curve::dotted("equilibrium", &[0.0, 1.0], &[1e3 * rest; 2]));
    figure.save(folder, "creep")?;
    let largest = coarse.value.iter().zip(&fine.value).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let name = format!("creep: liver, {particles} particles, tolerance 0.05 off dt = 0.01");
    let mut rows = vec![Row::at_most(name, 100.0 * largest / rest.abs(), 1.0, "% of the value at rest")];
    // What is left of the creep after a second is exp(-1/T).
    let left = 1.0 - coarse.last() / rest;
    rows.push(Row::at_most("creep: liver, what is left after 1 s", 100.0 * left.abs(), 1.0, "%"));
    if !quick {
        rows.push(Row::at_least("creep: liver, seconds a wall second", coarse.steps_per_second, 1.0, "1"));
    }
    Ok(rows)
}
