//! Bodies in the plane are solids like all others: whole simulations of them, remeshed and at rest.

mod common;

use common::every_law;
use rsph_core::error::FailureKind;
use rsph_core::material::{KelvinVoigt, Material, NeoHookean};
use rsph_core::particles::Field;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Boundary, Curve, Fix, Integration, Load, LoadKind, Motion, Probe, Quantity, RemeshTrigger, Scheme, Setup,
    SolidSetup, Solver, Units, VectorField,
};
use rsph_core::shape::{DiscShape, RectangleShape, Shape, SphereShape};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

fn neo_hookean(relaxation_time: f64) -> Arc<dyn Material> {
    Arc::new(NeoHookean::new(1.0, 10.0, 0.3, relaxation_time).unwrap())
}

fn setup(shape: impl Shape + 'static, spacing: f64, material: Arc<dyn Material>) -> Setup<SolidSetup> {
    Setup {
        units: Units::Normalised,
        solver: Solver::ACCURATE,
        ..Setup::new(Arc::new(shape), Resolution::Spacing(spacing), SolidSetup::new(material))
    }
}

fn square() -> RectangleShape {
    RectangleShape::new([1.0; 2], [0.0; 2]).unwrap()
}

fn plane(axis: Axis, at: f64, side: Side) -> Region {
    Region::Plane { axis, at, side }
}

fn hold(region: Region, fix: Fix) -> Boundary {
    Boundary { name: None, region, fix, motion: None }
}

fn bottom() -> Region {
    plane(Axis::Y, 0.0, Side::Below)
}

fn top() -> Region {
    plane(Axis::Y, 1.0, Side::Above)
}

fn affine(gradient: Mat3) -> VectorField {
    VectorField::Affine { constant: Vec3::zeros(), gradient }
}

fn probe(quantity: &str, region: Region) -> Probe {
    Probe { name: quantity.into(), quantity: Quantity::parse(quantity).unwrap(), region }
}

/// Pulled between rollers a block has the stress of plane strain everywhere, wherever its lattice lies.
#[test]
fn a_pulled_block_has_the_strain_of_plane_strain() {
    let (e, nu, pull) = (10.0, 0.3, 0.1);
    let material: Arc<dyn Material> = Arc::new(KelvinVoigt::new(1.0, e, nu, 0.0).unwrap());
    for spacing in [0.1, 0.13] {
        let mut setup = setup(square(), spacing, Arc::clone(&material));
        setup.mechanics.boundaries.push(hold(bottom(), Fix::Normal));
        setup.mechanics.boundaries.push(hold(plane(Axis::X, 0.0, Side::Below), Fix::Normal));
        let kind = LoadKind::Traction { region: top(), traction: pull * Vec3::y() };
        setup.mechanics.loads.push(Load { kind, curve: Curve::default() });
        let mut sim = Simulation::new(setup).unwrap();
        let found = sim.solve_static(0.0, &mut |_, _| true).unwrap();
        assert!((found.load.y - pull).abs() < 1e-9, "per metre of thickness: {}", found.load);
        let along = pull * (1.0 - nu * nu) / e;
        let across = -pull * nu * (1.0 + nu) / e;
        let snapshot = sim.snapshot();
        let strain = snapshot.column(Field::Strain);
        let stress = snapshot.column(Field::Stress);
        for a in 0..snapshot.len() {
            let (e, s) = (strain.tensor(a).0, stress.tensor(a).0);
            assert!((e[0] - across).abs() < 1e-6 && (e[1] - along).abs() < 1e-6, "{spacing}: {e:?}");
            assert!(e[2] == 0.0 && (s[2] - nu * pull).abs() < 1e-5 * pull, "{s:?}");
        }
        let surface = sim.surface(&snapshot);
        let read = &surface.field("strain").unwrap().values;
        assert!(read.chunks(6).all(|e| (e[1] - along).abs() < 1e-6 && e[2].abs() < 1e-12), "{spacing}");
    }
}

/// Remeshes a body that has been deformed by `a` and moves as `rate` x, and compares with both.
fn affine_body_stays_affine(mut setup: Setup<SolidSetup>, a: &Mat3, rate: &Mat3) {
    setup.remesh.trigger = RemeshTrigger::Steps(u64::MAX);
    setup.initial.displacement = affine(a - Mat3::identity());
    setup.initial.velocity = affine(rate * a);
    let law = Arc::clone(&setup.mechanics.material);
    let mut sim = Simulation::new(setup).unwrap();
    let before = sim.conservation();
    for _ in 0..2 {
        sim.remesh().unwrap();
        let p = sim.particles();
        let (x, u, v) =
            (p.column(Field::Reference), p.column(Field::Displacement), p.column(Field::Velocity));
        for k in 0..p.len() {
            assert!((x.vector(k) + u.vector(k) - a * x.vector(k)).norm() < 1e-9);
        }
        // Momentum and spin are those of before, which a lattice elsewhere has to correct by a little.
        let turned = |k: usize| (v.vector(k) - rate * a * x.vector(k)).norm();
        assert!((0..p.len()).map(turned).fold(0.0, f64::max) < 0.05);
        let strain = sim.snapshot();
        let strain = strain.column(Field::Strain);
        let exact = 0.5 * (a * a.transpose()).symmetric_eigenvalues().map(f64::ln).sum();
        for k in 0..strain.len() {
            let e = strain.tensor(k).0;
            assert!((e[0] + e[1] + e[2] - exact).abs() < 1e-7, "{e:?}");
        }
    }
    let after = sim.conservation();
    assert!((after.mass / before.mass - 1.0).abs() < 1e-12);
    assert!((after.momentum - before.momentum).norm() < 1e-13);
    // No particle has lost its elastic state.
    let exact = law.law().finite_strain().unwrap().energy(a) * after.mass;
    assert!((after.elastic_energy / exact - 1.0).abs() < 1e-7, "{} {exact}", after.elastic_energy);
}

#[test]
fn affine_bodies_stay_affine() {
    let rate = Mat3::new(0.3, -1.0, 0.0, 1.2, 0.1, 0.0, 0.0, 0.0, 0.0);
    let a = Mat3::new(1.3, 0.3, 0.0, -0.2, 0.8, 0.0, 0.0, 0.0, 1.0);
    affine_body_stays_affine(setup(square(), 0.1, neo_hookean(0.0)), &a, &rate);
    let disc = DiscShape::new(0.5, [0.2, 0.1]).unwrap();
    affine_body_stays_affine(setup(disc, 0.08, neo_hookean(0.0)), &a, &rate);
    let a = Mat3::new(1.2, 0.2, 0.0, 0.0, 0.9, 0.1, -0.1, 0.0, 1.1);
    let ball = SphereShape::new(0.5, Vec3::zeros()).unwrap();
    affine_body_stays_affine(setup(ball, 0.1, neo_hookean(0.0)), &a, &rate);
}

/// A body that has turned by far more than a radian since it was remeshed is found again.
#[test]
fn a_half_turned_body_is_remeshed() {
    let turn = *nalgebra::Rotation3::new(Vec3::new(0.0, 0.0, 2.9)).matrix();
    let stretch = Mat3::from_diagonal(&Vec3::new(1.1, 0.9, 1.0));
    let disc = DiscShape::new(0.5, [0.2, 0.1]).unwrap();
    affine_body_stays_affine(setup(disc, 0.08, neo_hookean(0.0)), &(turn * stretch), &Mat3::zeros());
}

#[test]
fn a_plate_pulls_through_a_remesh() {
    let displacement = Vec3::new(0.1, 0.27, 0.0);
    let motion = Motion::Curve { displacement, curve: Curve::ramp(0.0, 1.0) };
    let mut setup = setup(square(), 0.1, neo_hookean(0.0));
    setup.mechanics.boundaries.push(hold(bottom(), Fix::ALL));
    setup.mechanics.boundaries.push(Boundary { name: None, motion: Some(motion), ..hold(top(), Fix::ALL) });
    setup.probes.push(probe("displacement", Region::Point(Vec3::new(0.5, 0.0, 0.0))));
    setup.probes.push(probe("displacement", Region::Point(Vec3::new(0.5, 1.0, 0.0))));
    setup.remesh.trigger = RemeshTrigger::Steps(u64::MAX);
    let mut sim = Simulation::new(setup).unwrap();
    sim.solve_static(1.0, &mut |_, _| true).unwrap();
    sim.remesh().unwrap();
    sim.solve_static(1.0, &mut |_, _| true).unwrap();
    let read: Vec<f64> = sim.readings().iter().map(|r| r.value).collect();
    assert!(read[..3].iter().all(|u| u.abs() < 3e-3), "{read:?}");
    assert!((Vec3::from_column_slice(&read[3..]) - displacement).norm() < 5e-3, "{read:?}");
}

#[test]
fn a_pulled_block_goes_on_through_a_remesh() {
    let run = |trigger: RemeshTrigger, scheme: Scheme| {
        let mut setup = setup(square(), 0.125, neo_hookean(0.1));
        setup.mechanics.boundaries.push(hold(bottom(), Fix::ALL));
        let kind = LoadKind::Traction { region: top(), traction: 3.0 * Vec3::y() };
        setup.mechanics.loads.push(Load { kind, curve: Curve::ramp(0.0, 1.0) });
        setup.probes.push(probe("displacement.y", top()));
        setup.remesh.trigger = trigger;
        setup.integration = Integration { scheme, tolerance: 0.01 };
        let mut sim = Simulation::new(setup).unwrap();
        sim.advance_to(1.5, &mut |_| true).unwrap();
        (sim.readings()[0].value, sim)
    };
    let (never, _) = run(RemeshTrigger::Never, Scheme::Rk4);
    let (steps, mut sim) = run(RemeshTrigger::Steps(40), Scheme::Rk4);
    // Eight particles an edge.
    assert!((steps / never - 1.0).abs() < 0.01, "{steps} {never}");
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
    let (auto, sim) = run(RemeshTrigger::Strain, Scheme::Rk4);
    assert!(sim.remesh_log().unwrap().count >= 1);
    assert!((auto / never - 1.0).abs() < 0.01);
    let (implicit, _) = run(RemeshTrigger::Never, Scheme::Sdirk2);
    assert!((implicit / never - 1.0).abs() < 5e-3, "{implicit} {never}");
}

#[test]
fn every_law_and_every_cut_rests_in_the_plane() {
    for material in every_law(10.0) {
        let disc = DiscShape::new(0.5, [0.0; 2]).unwrap();
        let mut setup = setup(disc, 0.08, Arc::clone(&material));
        let (point, normal) = (Vec3::new(0.0, -0.2, 0.0), Vec3::new(0.2, 1.0, 0.0));
        setup.mechanics.boundaries.push(hold(Region::HalfSpace { point, normal }, Fix::ALL));
        let kind = LoadKind::BodyForce { region: Region::All, acceleration: Vec3::new(0.3, -0.5, 0.0) };
        setup.mechanics.loads.push(Load { kind, curve: Curve::default() });
        let mut sim = Simulation::new(setup).unwrap();
        let found = sim.solve_static(0.0, &mut |_, _| true).unwrap();
        assert!(found.iterations < 60, "{}: {}", material.name(), found.iterations);
        let sums = sim.conservation();
        assert!((sums.load + sums.reaction).norm() < 1e-6 * sums.load.norm(), "{}", material.name());
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let run = |threads: usize, shape: Arc<dyn Shape>| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut setup = Setup { shape, ..setup(square(), 0.1, neo_hookean(0.05)) };
            setup.initial.velocity = affine(Mat3::new(1.5, -1.0, 0.0, 1.0, -1.5, 0.0, 0.0, 0.0, 0.0));
            setup.remesh.trigger = RemeshTrigger::Steps(40);
            let mut sim = Simulation::new(setup).unwrap();
            for _ in 0..100 {
                sim.step().unwrap();
            }
            sim.particles().column(Field::Displacement).values().to_vec()
        })
    };
    let shapes: [Arc<dyn Shape>; 2] = [
        Arc::new(SphereShape::new(0.5, Vec3::zeros()).unwrap()),
        Arc::new(DiscShape::new(0.5, [0.0; 2]).unwrap()),
    ];
    for shape in shapes {
        assert_eq!(run(1, Arc::clone(&shape)), run(3, shape));
    }
}

#[test]
fn a_body_that_is_crushed_fails_with_a_place() {
    let displacement = Vec3::new(0.0, -0.97, 0.0);
    let motion = Motion::Curve { displacement, curve: Curve::ramp(0.0, 0.2) };
    let mut setup = setup(square(), 0.125, neo_hookean(0.0));
    setup.mechanics.boundaries.push(hold(bottom(), Fix::ALL));
    setup.mechanics.boundaries.push(Boundary { name: None, motion: Some(motion), ..hold(top(), Fix::ALL) });
    let mut sim = Simulation::new(setup).unwrap();
    let failure = sim.advance_to(0.2, &mut |_| true).unwrap_err();
    assert_eq!(failure.kind, FailureKind::Inverted, "{failure}");
    assert!(failure.place.is_some() && failure.time > 0.0 && !failure.remedy.is_empty());
    assert!(sim.particles().column(Field::Displacement).values().iter().all(|u| u.is_finite()));
}

#[test]
fn what_leaves_the_plane_is_refused() {
    let block = || setup(square(), 0.1, neo_hookean(0.0));
    let refused = |setup: Setup<SolidSetup>, key: &str| {
        let error = Simulation::new(setup).unwrap_err();
        assert_eq!(error.key, key, "{error}");
    };
    let mut across = block();
    across.mechanics.boundaries.push(hold(plane(Axis::Z, 0.0, Side::Below), Fix::ALL));
    refused(across, "boundary[0].region");
    let mut pushed = block();
    let kind = LoadKind::Traction { region: top(), traction: Vec3::z() };
    pushed.mechanics.loads.push(Load { kind, curve: Curve::default() });
    refused(pushed, "load[0].traction");
    let mut moved = block();
    let motion = Motion::Curve { displacement: Vec3::z(), curve: Curve::default() };
    moved.mechanics.boundaries.push(Boundary {
        name: None,
        motion: Some(motion),
        ..hold(bottom(), Fix::ALL)
    });
    refused(moved, "boundary[0].motion");
    let mut literal = block();
    literal.solver.formulation = rsph_core::setup::Formulation::Paper;
    refused(literal, "solver.formulation");
    let mut folded = block();
    folded.initial.displacement = affine(Mat3::from_diagonal(&Vec3::new(-1.5, 0.0, 0.0)));
    refused(folded, "initial.displacement");
}
