//! A liver under a patch load as three functions that JavaScript can call: steps in WebAssembly.

use rsph_core::material::KelvinVoigt;
use rsph_core::particles::Field;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{SolidSetup, Fix, 
    Boundary, Initial, Integration, Load, LoadKind, Mechanics, PatchCentre, Curve, Remesh, Scheme, Setup,
    Solver, TimeStep, Units,
};
use rsph_core::shape::organ;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::cell::RefCell;
use std::sync::Arc;

thread_local!(static SIMULATION: RefCell<Option<Simulation>> = const { RefCell::new(None) });

/// Makes a liver of about that many particles and returns their number; 0 if it can not be made.
#[unsafe(no_mangle)]
pub extern "C" fn setup(particles: usize) -> usize {
    let simulation = liver(particles);
    let made = simulation.as_ref().map_or(0, |s| s.particles().len());
    SIMULATION.set(simulation);
    made
}

/// Takes so many Runge-Kutta steps and returns the norm of the displacement (m); NaN if that fails.
#[unsafe(no_mangle)]
pub extern "C" fn steps(count: usize) -> f64 {
    with(|s| (0..count).try_for_each(|_| s.step()).is_ok())
}

/// Solves for the equilibrium and returns the norm of the displacement (m); NaN if that fails.
#[unsafe(no_mangle)]
pub extern "C" fn settle() -> f64 {
    with(|s| s.solve_static(0.0, &mut |_, _| true).is_ok())
}

fn with(act: impl FnOnce(&mut Simulation) -> bool) -> f64 {
    SIMULATION.with_borrow_mut(|simulation| {
        let Some(s) = simulation.as_mut() else { return f64::NAN };
        if !act(s) {
            return f64::NAN;
        }
        let u = s.particles().column(Field::Displacement);
        u.values().iter().map(|u| u * u).sum::<f64>().sqrt()
    })
}

fn liver(particles: usize) -> Option<Simulation> {
    let held = Region::Plane { axis: Axis::Y, at: -0.05, side: Side::Below };
    let patch = LoadKind::Patch {
        pressure: 270.0,
        centre: PatchCentre::At(Vec3::new(0.07, 0.05, 0.0)),
        radius: Some(0.037),
        direction: -Vec3::y(),
    };
    Simulation::new(Setup { solver: Solver::ACCURATE, integration: Integration { scheme: Scheme::Rk4, ..Integration::default() }, ..Setup::new(Arc::new(organ("liver").ok()?), Resolution::Particles(particles), SolidSetup { material: Arc::new(KelvinVoigt::new(1000.0, 1e5, 0.3, 0.2).ok()?), boundaries: vec![Boundary { name: None, region: held, fix: Fix::ALL, motion: None }], loads: vec![Load { kind: patch, curve: Curve::default() }], foundations: Vec::new() }) })
    .ok()
}
