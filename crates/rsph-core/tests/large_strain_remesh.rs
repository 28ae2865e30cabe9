//! Remeshing at large strain: what is exact stays exact, and whole simulations with it.

mod common;

use rsph_core::boundary::nodal_load::NodalLoad;
use rsph_core::dynamics::large_strain::body::LargeBody;
use rsph_core::error::FailureKind;
use rsph_core::fit::Degree;
use rsph_core::material::{KelvinVoigt, NeoHookean};
use rsph_core::particles::Field;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Boundary, Fix, Initial, Load, LoadKind, Mechanics, Motion, Probe, Quantity, Ramp, Remesh, RemeshTrigger,
    Setup, Solver, TimeStep, Units, VectorField,
};
use rsph_core::shape::{BoxShape, DiscShape, RectangleShape, Shape, SphereShape};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

fn setup(shape: impl Shape + 'static, spacing: f64, relaxation_time: f64) -> Setup {
    Setup {
        units: Units::Normalised,
        shape: Arc::new(shape),
        resolution: Resolution::Spacing(spacing),
        material: Arc::new(NeoHookean::new(1.0, 10.0, 0.3, relaxation_time).unwrap()),
        initial: Initial::default(),
        boundaries: Vec::new(),
        loads: Vec::new(),
        mechanics: Mechanics::Solid,
        remesh: Remesh::default(),
        solver: Solver::default(),
        integration: rsph_core::setup::Integration::default(),
        time_step: TimeStep::Auto,
        allow_unstable: false,
        probes: Vec::new(),
    }
}

fn square() -> RectangleShape {
    RectangleShape::new([1.0; 2], [0.0; 2]).unwrap()
}

fn plane(axis: Axis, at: f64, side: Side) -> Region {
    Region::Plane { axis, at, side }
}

fn clamp(region: Region) -> Boundary {
    Boundary { region, fix: Fix::ALL, motion: None }
}

/// Remeshes a body that has been deformed by `a` and moves as `rate` x, and compares with both.
fn affine_body_stays_affine<const D: usize>(setup: &Setup, a: &Mat3, rate: &Mat3) {
    let (mut body, _) = LargeBody::<D>::sampled(setup).unwrap();
    let back = a.try_inverse().unwrap();
    let mut x: Vec<Vec3> = body.reference().iter().map(|x| a * x).collect();
    let mut v: Vec<Vec3> = x.iter().map(|x| rate * x).collect();
    for _ in 0..2 {
        let mass: f64 = body.dynamics.mass.iter().sum();
        let new = body.remesh(0.0, &x, &v).unwrap();
        (x, v) = (body.nodes().to_vec(), new.velocity);
        // The body is shifted so that its centre of mass stays: that is how far it is from affine.
        let shift = x[0] - a * body.reference()[0];
        assert!(shift.norm() < 0.05 * body.spacing, "{shift}");
        for (x, x0) in x.iter().zip(body.reference()) {
            assert!((back * (x - shift) - x0).norm() < 1e-9);
        }
        for f in &body.dynamics.configuration.first_gradient {
            assert!((f - a).norm() < 1e-8);
        }
        assert!((body.dynamics.mass.iter().sum::<f64>() / mass - 1.0).abs() < 1e-13);
        assert!(new.raw_mass_error.abs() < 0.01, "{}", new.raw_mass_error);
        assert!((new.momentum[2] - new.momentum[0]).norm() < 1e-14);
        let [before, after] = new.angular_momentum;
        assert!((before - after).norm() < 1e-14 * (1.0 + before.norm()));
        assert_eq!(new.guarded, 0);
    }
    // No particle has lost its elastic state.
    let mut force = vec![Vec3::zeros(); x.len()];
    let energy = body.dynamics.elastic_force(0.0, &x, &mut force);
    let volume: f64 = body.dynamics.configuration.reference_volume.iter().sum();
    let exact = setup.material.law().finite_strain().unwrap().energy(a) * volume;
    assert!((energy / exact - 1.0).abs() < 1e-7, "{energy} {exact}");
}

#[test]
fn affine_bodies_stay_affine() {
    let rate = Mat3::new(0.3, -1.0, 0.0, 1.2, 0.1, 0.0, 0.0, 0.0, 0.0);
    let a = Mat3::new(1.3, 0.3, 0.0, -0.2, 0.8, 0.0, 0.0, 0.0, 1.0);
    affine_body_stays_affine::<2>(&setup(square(), 0.1, 0.0), &a, &rate);
    affine_body_stays_affine::<2>(&setup(DiscShape::new(0.5, [0.2, 0.1]).unwrap(), 0.08, 0.0), &a, &rate);
    let a = Mat3::new(1.2, 0.2, 0.0, 0.0, 0.9, 0.1, -0.1, 0.0, 1.1);
    affine_body_stays_affine::<3>(&setup(SphereShape::new(0.5, Vec3::zeros()).unwrap(), 0.1, 0.0), &a, &rate);
}

#[test]
fn the_lattice_follows_a_plate_and_clamps_stay_clean() {
    let mut setup = setup(square(), 0.1, 0.0);
    setup.boundaries.push(clamp(plane(Axis::Y, 0.0, Side::Below)));
    let displacement = Vec3::new(0.1, 0.27, 0.0);
    let motion = Motion::Ramp { displacement, ramp: Ramp { from: 0.0, to: 1.0 } };
    let plate = Boundary { motion: Some(motion), ..clamp(plane(Axis::Y, 1.0, Side::Above)) };
    setup.boundaries.push(plate);
    let (mut body, _) = LargeBody::<2>::sampled(&setup).unwrap();
    let mut x: Vec<Vec3> = body.nodes().iter().map(|x| x + displacement * x.y).collect();
    body.dynamics.equilibrate(1.0, &mut x, 1e-8).unwrap();
    let v = vec![Vec3::zeros(); x.len()];
    body.remesh(1.0, &x, &v).unwrap();
    let highest = body.nodes().iter().map(|x| x.y).fold(0.0, f64::max);
    let spacing = body.lattice.spacing.y;
    assert!((1.27 / spacing - (1.27 / spacing).round()).abs() < 1e-9);
    assert!((highest - (1.27 - 0.5 * spacing)).abs() < 1e-9, "half a cell below the plate");
    // On the walls particles are where the walls are.
    let on_walls = [Vec3::new(0.5, 0.0, 0.0), Vec3::new(0.5, 1.0, 0.0)];
    let mut x = body.nodes().to_vec();
    body.dynamics.equilibrate(1.0, &mut x, 1e-8).unwrap();
    let there = body.positions_of(&on_walls, &x, 1.0);
    assert!((there[0] - on_walls[0]).norm() < 2e-3, "{}", there[0]);
    assert!((there[1] - on_walls[1] - displacement).norm() < 2e-3, "{}", there[1]);
}

#[test]
fn a_pulled_block_goes_on_through_a_remesh() {
    let run = |trigger: RemeshTrigger| {
        let mut setup = setup(square(), 0.125, 0.1);
        setup.boundaries.push(clamp(plane(Axis::Y, 0.0, Side::Below)));
        let top = plane(Axis::Y, 1.0, Side::Above);
        let kind = LoadKind::Traction { region: top.clone(), traction: 3.0 * Vec3::y() };
        setup.loads.push(Load { kind, ramp: Ramp { from: 0.0, to: 1.0 } });
        let quantity = Quantity::parse("displacement.y").unwrap();
        setup.probes.push(Probe { name: "top".into(), quantity, region: top });
        setup.remesh.trigger = trigger;
        let mut sim = Simulation::new(setup).unwrap();
        sim.advance_to(1.5, &mut |_| true).unwrap();
        (sim.readings()[0].value, sim)
    };
    let (never, _) = run(RemeshTrigger::Never);
    let (steps, mut sim) = run(RemeshTrigger::Steps(40));
    // Eight particles an edge.
    assert!((steps / never - 1.0).abs() < 0.02, "{steps} {never}");
    let end = sim.conservation();
    let log = sim.remesh_log().unwrap();
    let [before, after] = &log.sums;
    assert!(log.count >= 3 && after.particles > before.particles, "{log:?}");
    assert!(end.mass_error < 1e-12 && end.momentum_error < 1e-10, "{end:?}");
    assert!(end.dissipated > 0.0);
    // What a snapshot shows makes sense: density is mass over current volume.
    let snapshot = sim.snapshot();
    let density = snapshot.column(Field::Density).values();
    assert!(density.iter().all(|d| *d > 0.5 && *d < 1.2), "{density:?}");
    let (auto, sim) = run(RemeshTrigger::Strain);
    assert!(sim.remesh_log().unwrap().count >= 1);
    assert!((auto / never - 1.0).abs() < 0.02);
}

#[test]
fn loads_and_thick_clamps_survive_a_remesh() {
    let ball = SphereShape::new(0.5, Vec3::zeros()).unwrap();
    let mut setup = setup(ball, 0.1, 0.0);
    setup.boundaries.push(clamp(plane(Axis::Z, -0.25, Side::Below)));
    let everywhere = Region::All;
    let pressure = LoadKind::Pressure { region: plane(Axis::Z, 0.3, Side::Above), pressure: 1.0 };
    setup.loads.push(Load { kind: pressure, ramp: Ramp::default() });
    let weight = LoadKind::BodyForce { region: everywhere, acceleration: -Vec3::z() };
    setup.loads.push(Load { kind: weight, ramp: Ramp::default() });
    let (mut body, _) = LargeBody::<3>::sampled(&setup).unwrap();
    let total = |body: &LargeBody<3>| body.dynamics.loads.iter().map(NodalLoad::total).sum::<Vec3>();
    let before = total(&body);
    let mut x = body.nodes().to_vec();
    body.dynamics.equilibrate(0.0, &mut x, 1e-6).unwrap();
    let held_volume = |body: &LargeBody<3>| -> f64 {
        let held = body.dynamics.fixed.particles.iter().map(|p| p.particle);
        held.map(|a| body.dynamics.configuration.volume[a]).sum()
    };
    let held = held_volume(&body);
    let v = vec![Vec3::zeros(); x.len()];
    body.remesh(0.0, &x, &v).unwrap();
    assert!((total(&body) - before).norm() < 1e-9 * before.norm());
    // Slivers below a tenth of a cell, which sampling leaves out, are merged by the remesh.
    let ratio = held_volume(&body) / held;
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
    // The held part has not moved.
    for p in &body.dynamics.fixed.particles {
        assert!((body.nodes()[p.particle] - body.reference()[p.particle]).norm() < 1e-6);
    }
}

#[test]
fn weights_reproduce_reference_positions() {
    let (body, _) = LargeBody::<2>::sampled(&setup(square(), 0.1, 0.0)).unwrap();
    let points = [Vec3::new(0.0, 1.0, 0.5), Vec3::new(0.37, 0.61, -0.5)];
    let weights = body.weights(Degree::Quadratic, &points);
    for (i, p) in points.iter().enumerate() {
        let square: f64 = weights.row(i).map(|(a, w)| w * body.reference()[a as usize].x.powi(2)).sum();
        assert!((square - p.x * p.x).abs() < 1e-9);
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut setup = setup(SphereShape::new(0.5, Vec3::zeros()).unwrap(), 0.125, 0.05);
            let gradient = Mat3::new(1.5, -1.0, 0.0, 1.0, -1.5, 0.0, 0.0, 0.0, 0.0);
            setup.initial.velocity = VectorField::Affine { constant: Vec3::zeros(), gradient };
            setup.remesh.trigger = RemeshTrigger::Steps(40);
            let mut sim = Simulation::new(setup).unwrap();
            for _ in 0..100 {
                sim.step().unwrap();
            }
            sim.particles().column(Field::Displacement).values().to_vec()
        })
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn a_body_that_is_crushed_fails_with_a_place() {
    let mut setup = setup(square(), 0.125, 0.0);
    setup.boundaries.push(clamp(plane(Axis::Y, 0.0, Side::Below)));
    let displacement = Vec3::new(0.0, -0.97, 0.0);
    let motion = Motion::Ramp { displacement, ramp: Ramp { from: 0.0, to: 0.2 } };
    let plate = Boundary { motion: Some(motion), ..clamp(plane(Axis::Y, 1.0, Side::Above)) };
    setup.boundaries.push(plate);
    let mut sim = Simulation::new(setup).unwrap();
    let failure = sim.advance_to(0.2, &mut |_| true).unwrap_err();
    assert_eq!(failure.kind, FailureKind::Inverted, "{failure}");
    assert!(failure.place.is_some() && failure.time > 0.0 && !failure.remedy.is_empty());
    assert!(sim.particles().column(Field::Displacement).values().iter().all(|u| u.is_finite()));
}

#[test]
fn what_large_strain_can_not_do_is_refused() {
    let refused = |setup: Setup, key: &str| {
        let error = Simulation::new(setup).unwrap_err();
        assert_eq!(error.key, key, "{error}");
    };
    let mut small = setup(square(), 0.1, 0.0);
    small.material = Arc::new(KelvinVoigt::new(1.0, 10.0, 0.3, 0.0).unwrap());
    refused(small, "body.shape");
    let mut across = setup(square(), 0.1, 0.0);
    across.boundaries.push(clamp(plane(Axis::Z, 0.0, Side::Below)));
    refused(across, "boundary[0].region");
    let cube = || BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap();
    let mut literal = setup(cube(), 0.2, 0.0);
    literal.solver.formulation = rsph_core::setup::Formulation::Paper;
    refused(literal, "solver.formulation");
    let mut kernel = setup(square(), 0.1, 0.0);
    kernel.remesh.kernel = rsph_core::kernel::RemeshKernel::Lambda42;
    refused(kernel, "remesh.kernel");
    let mut folded = setup(cube(), 0.2, 0.0);
    let gradient = Mat3::from_diagonal(&Vec3::new(-1.5, 0.0, 0.0));
    folded.initial.displacement = VectorField::Affine { constant: Vec3::zeros(), gradient };
    refused(folded, "initial.displacement");
}
