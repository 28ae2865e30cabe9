//! A fluid beside a solid on a line, section 4 and Fig. 4, against a fine reference and the ALE scheme
//! that the paper compares with.

mod ale;
mod reference;
mod remeshing;
mod sound;

use super::Row;
use super::case::{FSI_1D, simulation};
use super::figure::{Curve, Figure};
use ale::{Ale, Convection};
use reference::{INTERFACE, Profile};
use rsph_core::error::FailureKind;
use rsph_core::simulation::Simulation;
use std::path::Path;
use std::time::Instant;

/// When solutions are compared.
const END: f64 = 2.0;
/// Energy at the start, of fluid and solid together.
const ENERGY: f64 = 0.0075;

/// The scheme of the paper at a Courant number of 0.8 in the solid: M'4 every step, smoothing length 1.25.
fn paper() -> Vec<String> {
    vec!["remesh={every=1, kernel=\"m4-prime\"}".into(), "solver.smoothing=1.25".into()]
}

/// Edits for so many elements and a Courant number.
fn with(elements: u32, courant: f64, more: &[String]) -> Vec<String> {
    let dx = 1.0 / f64::from(elements);
    let mut sets = vec![format!("body.spacing={dx}"), format!("time.dt={}", courant * dx)];
    sets.extend_from_slice(more);
    sets
}

/// A run to the end.
fn finished(sets: &[String]) -> Result<Simulation, String> {
    let (mut sim, _) = simulation(FSI_1D, sets)?;
    sim.advance_to(END, &mut |_| true).map_err(|e| e.to_string())?;
    Ok(sim)
}

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let exact = Profile::reference(END)?;
    let name = |what: &str| format!("fsi_1d: {what}");
    let error = |rows: &mut Vec<Row>, what: &str, sets: &[String], bound: f64| {
        let profile = Profile::of(&finished(sets)?.snapshot());
        let error = profile.errors(&exact).0;
        rows.push(Row::at_most(name(what), error, bound, "of |u|"));
        Ok::<_, String>((profile, error))
    };
    let (of_paper, _) =
        error(&mut rows, "100 elements, scheme of the paper", &with(100, 0.8, &paper()), 0.04)?;
    let start = Instant::now();
    let (_, of_100) = error(&mut rows, "100 elements, default", &with(100, 0.8, &[]), 0.02)?;
    let seconds = start.elapsed().as_secs_f64();
    error(&mut rows, "100 elements, default, Courant number 0.4", &with(100, 0.4, &[]), 0.02)?;
    let (fine_of_paper, _) =
        error(&mut rows, "400 elements, scheme of the paper", &with(400, 0.8, &paper()), 0.005)?;
    let (_, of_400) = error(&mut rows, "400 elements, default", &with(400, 0.8, &[]), 0.005)?;
    rows.push(Row::at_least(name("order from 100 to 400"), (of_100 / of_400).log2() / 2.0, 1.5, "1"));
    rows.push(Row::at_most(name("wall time of 100 elements"), seconds, 0.5, "s"));

    let mut central = Profile::reference(0.0)?;
    for (what, convection, expected, in_fluid) in [
        ("advective", Convection::Central, 0.105, Some(0.155)),
        ("conservative", Convection::Conservative, 0.040, None),
        ("upwind", Convection::Upwind, 0.097, None),
    ] {
        let mut ale = Ale::new(50, convection);
        ale.advance(END, 252);
        let (all, fluid) = ale.profile().errors(&exact);
        rows.push(Row::within(name(&format!("ALE {what}, 100 elements")), all, expected, 10.0, "of |u|"));
        if let Some(expected) = in_fluid {
            let what = name(&format!("ALE {what}, 100 elements, fluid alone"));
            rows.push(Row::within(what, fluid, expected, 10.0, "of |u|").paper("0.14"));
            central = ale.profile();
        }
    }
    // As the paper measured: against its own fine run.
    let against = of_paper.errors(&fine_of_paper).0;
    rows.push(
        Row::at_most(name("scheme of the paper, 100 against 400 elements"), against, 0.04, "of |u|")
            .paper("0.04"),
    );
    let against = central.errors(&fine_of_paper).0;
    let what = name("ALE advective, 100 against 400 particles");
    rows.push(Row::within(what, against, 0.105, 10.0, "of |u|").paper("0.14"));

    crossing(&mut rows)?;
    remeshing::rows(quick, &mut rows)?;
    rows.extend(sound::rows(quick)?);
    if !quick {
        finest(of_400, &exact, &mut rows)?;
    }
    picture(folder)?;
    Ok(rows)
}

/// Without remeshing the run stops by itself.
fn crossing(rows: &mut Vec<Row>) -> Result<(), String> {
    let (mut sim, _) = simulation(FSI_1D, &with(100, 0.8, &["remesh.every=0".into()]))?;
    let failure = sim.advance_to(END, &mut |_| true).err();
    let crossed = failure.filter(|f| f.kind == FailureKind::Crossed);
    let time = crossed.map_or(f64::NAN, |f| f.time);
    rows.push(Row::near("fsi_1d: without remeshing particles pass each other", time, 1.1, 0.1, "time"));
    Ok(())
}

/// 1600 elements: order, interface and energy.
fn finest(of_400: f64, exact: &Profile, rows: &mut Vec<Row>) -> Result<(), String> {
    let (mut sim, _) = simulation(FSI_1D, &["body.spacing=0.000625".into()])?;
    let (mut x_off, mut u_off, mut energy) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (time, x, u) in INTERFACE {
        sim.advance_to(time, &mut |s| {
            if s.step_count() % 20 == 0 {
                energy = energy.max(s.conservation().energy_error.unwrap_or(f64::NAN));
            }
            true
        })
        .map_err(|e| e.to_string())?;
        let profile = Profile::of(&sim.snapshot());
        let i = profile.interface;
        x_off = x_off.max((profile.x[i] - x).abs());
        u_off = u_off.max((profile.u[i] - u).abs());
    }
    let error = Profile::of(&sim.snapshot()).errors(exact).0;
    let name = |what: &str| format!("fsi_1d: {what}, 1600 elements");
    rows.push(Row::at_least(name("order from 400"), (of_400 / error).log2() / 2.0, 1.5, "1"));
    rows.push(Row::at_most(name("error of the interface's position"), x_off, 2e-4, "length"));
    rows.push(Row::at_most(name("error of the interface's velocity"), u_off, 2e-4, "velocity"));
    rows.push(Row::at_most(name("energy that is not accounted for"), energy, 1e-4, &format!("of {ENERGY}")));
    Ok(())
}

/// Fig. 4: velocity profiles at four times.
fn picture(folder: &Path) -> Result<(), String> {
    let mut figure = Figure::new("Fluid beside a solid: particles and ALE, 100 elements", "x", "velocity");
    let (mut sim, _) = simulation(FSI_1D, &with(100, 0.8, &[]))?;
    let mut ale = Ale::new(50, Convection::Central);
    let mut before = 0.0;
    for time in [0.0, 0.5, 1.0, 2.0] {
        sim.advance_to(time, &mut |_| true).map_err(|e| e.to_string())?;
        if time > before {
            ale.advance(time - before, (126.0 * (time - before)) as usize);
            before = time;
        }
        let profile = Profile::of(&sim.snapshot());
        let (x, u) = profile.part(true);
        figure.add(Curve::dashed(&format!("t = {time}, fluid"), x, u));
        let (x, u) = profile.part(false);
        figure.add(Curve::solid(&format!("t = {time}, solid"), x, u));
        let profile = ale.profile();
        figure.add(Curve::dotted(&format!("t = {time}, ALE"), &profile.x, &profile.u));
    }
    figure.save(folder, "fsi_1d")
}
