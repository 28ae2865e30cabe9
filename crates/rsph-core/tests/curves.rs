//! Loads and motions that follow curves in time.

use rsph_core::material::KelvinVoigt;
use rsph_core::particles::Field;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Between, Boundary, Curve, Fix, Integration, Load, LoadKind, Motion, Scheme, Setup, SolidSetup, Solver,
    TimeStep, Units,
};
use rsph_core::shape::BoxShape;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// A cube whose foot is held, moved or not, and whose top is pulled along a curve.
fn cube(motion: Option<Motion>, pull: Curve, scheme: Scheme) -> Setup<SolidSetup> {
    let face = |at, side| Region::Plane { axis: Axis::Z, at, side };
    let foot = Region::Box { min: Vec3::repeat(-1.0), max: Vec3::new(2.0, 2.0, 0.3) };
    let kind = LoadKind::Traction { region: face(1.0, Side::Above), traction: Vec3::z() };
    let mut solid = SolidSetup::new(Arc::new(KelvinVoigt::new(1.0, 20.0, 0.3, 0.2).unwrap()));
    solid.boundaries.push(Boundary { name: None, region: foot, fix: Fix::ALL, motion });
    solid.loads.push(Load { kind, curve: pull });
    Setup {
        units: Units::Normalised,
        solver: Solver::ACCURATE,
        integration: Integration { scheme, ..Integration::default() },
        ..Setup::new(
            Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap()),
            Resolution::Spacing(0.2),
            solid,
        )
    }
}

/// Displacement and velocity of the particle nearest to a point.
fn at(simulation: &Simulation, x: Vec3) -> [Vec3; 2] {
    let particles = simulation.particles();
    let reference = particles.column(Field::Reference);
    let distance = |a: &usize| (reference.vector(*a) - x).norm();
    let a = (0..particles.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
    [Field::Displacement, Field::Velocity].map(|f| particles.column(f).vector(a))
}

const TOP: Vec3 = Vec3::new(0.5, 0.5, 0.9);

/// A scheme that chooses long steps would pass over a short pulse, if its steps did not end at the points of the curve.
#[test]
fn no_step_passes_over_a_pulse() {
    let pulse = Curve::new(&[5.0, 5.02, 5.04], &[0.0, 5.0, 0.0], Between::Linear, false).unwrap();
    let [found, exact] = [Scheme::Sdirk2, Scheme::Rk4].map(|scheme| {
        let mut cube = Simulation::new(cube(None, pulse.clone(), scheme)).unwrap();
        cube.advance_to(5.3, &mut |_| true).unwrap();
        println!("{scheme:?}: {} steps", cube.step_count());
        at(&cube, TOP)[0].z
    });
    assert!(exact > 1e-4 && (found / exact - 1.0).abs() < 0.1, "{found} {exact}");
}

#[test]
fn a_prescribed_motion_is_where_its_curve_is() {
    let by = Vec3::new(0.01, 0.0, -0.02);
    for (scheme, between) in [
        (Scheme::Rk4, Between::Linear),
        (Scheme::Rk4, Between::Smooth),
        (Scheme::Sdirk2, Between::Smooth),
        (Scheme::BackwardEuler, Between::Linear),
    ] {
        let curve = Curve::new(&[0.0, 0.3, 0.5], &[0.0, 1.0, 0.0], between, true).unwrap();
        let motion = Motion::Curve { displacement: by, curve: curve.clone() };
        let mut setup = cube(Some(motion), Curve::default(), scheme);
        if scheme.is_implicit() {
            setup.time_step = TimeStep::Fixed(0.05);
        }
        let mut cube = Simulation::new(setup).unwrap();
        for t in [0.21, 0.44, 1.13] {
            cube.advance_to(t, &mut |_| true).unwrap();
            let [u, v] = at(&cube, Vec3::new(0.5, 0.5, 0.1));
            assert!((u - by * curve.at(t)).norm() < 1e-12, "{scheme:?} {t}: {u:?}");
            assert!((v - by * curve.rate(t)).norm() < 1e-12, "{scheme:?} {t}: {v:?}");
        }
    }
}

#[test]
fn at_rest_a_load_has_the_factor_of_the_moment() {
    let curve = Curve::new(&[0.0, 1.0, 2.0], &[0.0, -2.0, 0.5], Between::Step, false).unwrap();
    let mut cube = Simulation::new(cube(None, curve, Scheme::Auto)).unwrap();
    let mut rest = |t: f64| {
        cube.solve_static(t, &mut |_, _| true).unwrap();
        at(&cube, TOP)[0].z
    };
    let unit = -0.5 * rest(1.5);
    assert!(unit > 1e-3 && rest(0.5).abs() < 1e-5 * unit);
    assert!((rest(7.0) / (0.5 * unit) - 1.0).abs() < 1e-4);
}
