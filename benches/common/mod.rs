//! The bodies that benchmarks measure. Not every benchmark uses all of them.
#![allow(dead_code)]

pub mod cycle;
pub mod liver;
pub mod remeshing;
pub mod sums;

use rsph_core::material::{KelvinVoigt, Material, NeoHookean};
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Boundary, Curve, Fix, Integration, Load, LoadKind, Remesh, RemeshTrigger, Scheme, Setup, SolidSetup,
    Solver, Units,
};
use rsph_core::shape::BoxShape;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// Smoothing with 122 neighbours, and the one with 26 that scenarios have by themselves.
pub const WIDE: Solver = Solver { smoothing: 1.25, ..Solver::ACCURATE };
pub const NARROW: Solver = Solver::ACCURATE;

/// The tensile cube of section 5.2 with n^3 particles: clamped below, pulled above, RK4.
pub fn cube(n: usize, solver: Solver) -> Simulation {
    cube_of(n, solver, Arc::new(KelvinVoigt::new(1.0, 100.0, 0.3, 0.2).expect("liver")), Remesh::default())
}

/// The same of a neo-Hookean solid, which can be remeshed.
pub fn neo_hookean_cube(n: usize, solver: Solver) -> Simulation {
    let remesh = Remesh { trigger: RemeshTrigger::Steps(u64::MAX), ..Remesh::default() };
    cube_of(n, solver, Arc::new(NeoHookean::new(1.0, 100.0, 0.3, 0.2).expect("liver")), remesh)
}

fn cube_of(n: usize, solver: Solver, material: Arc<dyn Material>, remesh: Remesh) -> Simulation {
    let face = |at, side| Region::Plane { axis: Axis::Z, at, side };
    Simulation::new(Setup {
        units: Units::Normalised,
        remesh,
        solver,
        integration: Integration { scheme: Scheme::Rk4, ..Integration::default() },
        ..Setup::new(
            Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).expect("a unit cube")),
            Resolution::Spacing(1.0 / n as f64),
            SolidSetup {
                foundations: Vec::new(),
                material,
                boundaries: vec![Boundary {
                    name: None,
                    region: face(0.0, Side::Below),
                    fix: Fix::ALL,
                    motion: None,
                }],
                loads: vec![Load {
                    kind: LoadKind::Traction { region: face(1.0, Side::Above), traction: Vec3::z() },
                    curve: Curve::default(),
                }],
            },
        )
    })
    .expect("a cube")
}

/// One step as a run takes it. `Simulation::step` has the watchdog look at every step, a run only at each twentieth.
pub fn run_step(body: &mut Simulation) {
    // Far away; it stops after the first step.
    body.advance_to(1e6, &mut |_| false).expect("a stable step");
}
