//! The analytic liver under a local load, as in `scenarios/liver_load.toml`.

use rsph_core::material::KelvinVoigt;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Boundary, Curve, Fix, Integration, Load, LoadKind, PatchCentre, Scheme, Setup, SolidSetup, Solver,
    TimeStep,
};
use rsph_core::shape::organ;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// Length of a frame of a moving load (s).
pub const FRAME: f64 = 1.0 / 30.0;

/// Frames after which the load is where it was.
pub const CYCLE: u32 = 60;

/// A liver of about that many particles.
pub fn liver(particles: usize, solver: Solver, scheme: Scheme) -> Simulation {
    let time_step = if scheme == Scheme::Sdirk2 { TimeStep::Fixed(FRAME) } else { TimeStep::Auto };
    let held = Region::Plane { axis: Axis::Y, at: -0.05, side: Side::Below };
    Simulation::new(Setup {
        solver,
        time_step,
        integration: Integration { scheme, ..Integration::default() },
        ..Setup::new(
            Arc::new(organ("liver").expect("an organ")),
            Resolution::Particles(particles),
            SolidSetup {
                foundations: Vec::new(),
                material: Arc::new(KelvinVoigt::new(1000.0, 1e5, 0.3, 0.2).expect("liver")),
                boundaries: vec![Boundary { name: None, region: held, fix: Fix::ALL, motion: None }],
                loads: vec![press(0, 270.0)],
            },
        )
    })
    .expect("a liver")
}

/// The load of a frame: a finger with that pressure (Pa) that goes to and fro along the top.
pub fn press(frame: u32, pressure: f64) -> Load {
    let along = f64::from(30 - (frame % CYCLE).abs_diff(30) as i32);
    Load {
        kind: LoadKind::Patch {
            pressure,
            centre: PatchCentre::At(Vec3::new(0.07 - 0.003 * along, 0.05, 0.0)),
            radius: Some(0.037),
            direction: -Vec3::y(),
        },
        curve: Curve::default(),
    }
}
