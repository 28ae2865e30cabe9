//! Another fluid law in the same place: sound that meets the solid is partly reflected, partly let through.

use crate::Row;
use crate::case::FSI_1D;
use rsph_core::setup::VectorField;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use rsph_scenario::scenario::LoadedScenario;
use std::path::PathBuf;
use std::sync::Arc;

use super::reference::Profile;

/// Density and speed of sound of the fluid, density and elasticity of the solid.
const MEDIA: [[f64; 4]; 3] = [[1.0, 1.0, 1.0, 1.0], [1.0, 1.0, 2.0, 8.0], [2.0, 1.5, 1.0, 0.25]];
/// Peak of the initial velocity, small against all speeds of sound.
const PEAK: f64 = 1e-4;
/// Where the pulse starts, and its half width.
const START: (f64, f64) = (-1.0, 0.08);

/// Coefficients of velocity at an interface of impedances Z = rho c: reflected (Z1 - Z2)/(Z1 + Z2),
/// transmitted 2 Z1/(Z1 + Z2). A pulse of velocity alone splits into two halves; the right one meets the
/// interface. What is compared are integrals of u over x, which dispersion does not change; behind the
/// interface a pulse is longer by the ratio of the speeds.
pub(super) fn rows(quick: bool) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for [rho_1, c_1, rho_2, mu] in if quick { &MEDIA[1..2] } else { &MEDIA[..] } {
        let c_2 = (mu / rho_2).sqrt();
        let (z_1, z_2) = (rho_1 * c_1, rho_2 * c_2);
        // Reflected half-way back to where the pulse came from.
        let (reflected, transmitted) = meet(*rho_1, *c_1, *rho_2, *mu, 1.5 / c_1)?;
        let name = |what: &str| format!("fsi_1d: sound {what}, impedances {z_1} and {z_2}");
        let distance = 0.01;
        let exact = [(z_1 - z_2) / (z_1 + z_2), 2.0 * z_1 / (z_1 + z_2)];
        rows.push(Row::near(name("reflected"), reflected, exact[0], distance, "of what comes"));
        rows.push(Row::near(
            name("transmitted"),
            transmitted * c_1 / c_2,
            exact[1],
            distance,
            "of what comes",
        ));
    }
    Ok(rows)
}

/// Integrals of u left and right of the interface at time `t`, relative to that of what came.
fn meet(rho_1: f64, c_1: f64, rho_2: f64, mu: f64, t: f64) -> Result<(f64, f64), String> {
    let sets = [
        format!("dynamics.fluid={{acoustic={{density={rho_1}, sound_speed={c_1}}}}}"),
        format!("dynamics.solid={{elasticity={mu}, density={rho_2}}}"),
        "body.shape={box={size=[8.0, 0.1, 0.1], corner=[-4.0, 0.0, 0.0]}}".into(),
    ];
    let (name, text) = FSI_1D;
    let scenario = LoadedScenario::from_text(name, text.into(), PathBuf::new(), &sets);
    let mut setup = scenario.and_then(|s| s.lower()).map_err(|e| e.to_string())?.setup;
    let (centre, width) = START;
    let pulse = move |x: &[Vec3]| {
        x.iter().map(|x| Vec3::new(PEAK * (-((x.x - centre) / width).powi(2)).exp(), 0.0, 0.0)).collect()
    };
    setup.initial.velocity = VectorField::Function(Arc::new(pulse));
    let mut sim = Simulation::new(setup).map_err(|e| e.to_string())?;
    sim.advance_to(t, &mut |_| true).map_err(|e| e.to_string())?;
    let profile = Profile::of(&sim.snapshot());
    let came = 0.5 * PEAK * width * std::f64::consts::PI.sqrt();
    // What went left at the start is left of its own start.
    let integral = |(x, u): (&[f64], &[f64])| -> f64 {
        let pairs = x.windows(2).zip(u.windows(2)).filter(|(x, _)| x[0] > centre);
        pairs.map(|(x, u)| 0.5 * (u[0] + u[1]) * (x[1] - x[0])).sum::<f64>() / came
    };
    Ok((integral(profile.part(true)), integral(profile.part(false))))
}
