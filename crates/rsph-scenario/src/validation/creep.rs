//! Implicit integration: SDIRK2 on the bar of Kelvin-Voigt material against its series and against the
//! same operator in tiny steps; the creep of a liver against steps ten times shorter.

use super::Row;
use super::case::{History, LIVER_LOAD, TENSILE_LIVER, simulation};
use super::figure::{Curve, Figure};
use super::kelvin_voigt_bar::extension;
use rsph_core::setup::{Load, LoadKind, PatchCentre, Ramp};
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
            let load = Load { kind: kind(k), ramp: Ramp::default() };
            liver.set_loads(vec![load]).map_err(|e| e.to_string())?;
            liver.advance_to(f64::from(k + 1) * dt, &mut |_| true).map_err(|e| e.to_string())?;
        }
        let rate = f64::from(FRAMES) / start.elapsed().as_secs_f64();
        let name = format!("creep: touched liver, {particles} particles, frames of 1/30 s");
        rows.push(Row::at_least(name, rate, bound, "frames/s"));
    }
    Ok(rows)
}

fn bar() -> Result<Vec<Row>, String> {
    let of = |more: [&str; 3]| -> Result<History, String> {
        let mut sets = vec!["material.poisson_ratio=0".to_owned(), "time.until=1".into()];
        sets.extend(more.map(String::from));
        let (mut cube, until) = simulation(TENSILE_LIVER, &sets)?;
        let (mut time, mut value) = (Vec::new(), Vec::new());
        for k in 1..=25 {
            let t = until * f64::from(k) / 25.0;
            cube.advance_to(t, &mut |_| true).map_err(|e| e.to_string())?;
            time.push(t);
            value.push(cube.readings()[0].value);
        }
        Ok(History { time, value, end: cube.conservation(), steps_per_second: 0.0, failure: None })
    };
    let fine = of(["time.integrator=rk4", "time.dt=auto", "time.tolerance=0.01"])?;
    let mut rows = Vec::new();
    let off = |run: &History, exact: &dyn Fn(usize) -> f64| {
        (0..run.value.len()).map(|k| (run.value[k] - exact(k)).abs()).fold(0.0, f64::max) / REST * 100.0
    };
    let mut errors = Vec::new();
    for dt in ["time.dt=0.04", "time.dt=0.02"] {
        let run = of(["time.integrator=sdirk2", dt, "time.tolerance=1e-6"])?;
        errors.push((off(&run, &|k| fine.value[k]), off(&run, &|k| extension(run.time[k], 100.0, 0.2))));
    }
    let unit = "% of the value at rest";
    rows.push(Row::at_most(
        "creep: bar, sdirk2, dt = 0.02, off the same operator in tiny steps",
        errors[1].0,
        0.2,
        unit,
    ));
    rows.push(Row::at_most("creep: bar, sdirk2, dt = 0.02, off the series", errors[1].1, 0.3, unit));
    rows.push(Row::at_least(
        "creep: bar, error at dt = 0.04 over that at 0.02",
        errors[0].0 / errors[1].0,
        2.5,
        "1",
    ));
    Ok(rows)
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
