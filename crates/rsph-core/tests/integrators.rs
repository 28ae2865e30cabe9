//! Schemes of integration against the exact series of a bar, against each other, and at rest.

use rsph_core::grid::Grid;
use rsph_core::marching_cubes::zero_level_set;
use rsph_core::material::{KelvinVoigt, NeoHookean};
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Boundary, Curve, Fix, Integration, Load, LoadKind, Probe, Quantity, Scheme, Setup, SolidSetup, Solver,
    TimeStep, Units,
};
use rsph_core::shape::{BoxShape, MeshShape};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

fn plane(at: f64, side: Side) -> Region {
    Region::Plane { axis: Axis::Z, at, side }
}

/// The tensile cube of section 5.2 with nu = 0.
fn cube(scheme: Scheme, step: TimeStep) -> Setup<SolidSetup> {
    Setup {
        units: Units::Normalised,
        time_step: step,
        integration: Integration { scheme, tolerance: 1e-5 },
        probes: vec![Probe {
            name: "extension".into(),
            quantity: Quantity::parse("displacement.z").unwrap(),
            region: plane(1.0, Side::Above),
        }],
        ..Setup::new(
            Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap()),
            Resolution::Particles(343),
            SolidSetup {
                boundaries: vec![Boundary {
                    name: None,
                    region: plane(0.0, Side::Below),
                    fix: Fix::ALL,
                    motion: None,
                }],
                loads: vec![Load {
                    kind: LoadKind::Traction { region: plane(1.0, Side::Above), traction: Vec3::z() },
                    curve: Curve::default(),
                }],
                ..SolidSetup::new(Arc::new(KelvinVoigt::new(1.0, 100.0, 0.0, 0.2).unwrap()))
            },
        )
    }
}

/// Extension of the cube at each of `times`.
fn extensions(setup: Setup<SolidSetup>, times: &[f64]) -> (Vec<f64>, Simulation) {
    let mut simulation = Simulation::new(setup).unwrap();
    let read = times.iter().map(|&t| {
        simulation.advance_to(t, &mut |_| true).unwrap();
        simulation.readings()[0].value
    });
    let read = read.collect();
    (read, simulation)
}

/// u(L, t)/L of a Kelvin-Voigt bar, E = 100, rho = L = load = 1, T = 0.2, by its eigenfunctions.
fn series(t: f64) -> f64 {
    let (stiffness, relaxation) = (100.0_f64, 0.2);
    let mut sum = 1.0 / stiffness;
    for k in 0..4000 {
        let wave = (f64::from(k) + 0.5) * std::f64::consts::PI;
        let lambda = stiffness * wave * wave;
        let half = 0.5 * relaxation * lambda;
        let d = half * half - lambda;
        let decay = if d > 0.0 {
            let slow = -lambda / (half + d.sqrt());
            let fast = -half - d.sqrt();
            (fast * (slow * t).exp() - slow * (fast * t).exp()) / (fast - slow)
        } else {
            let w = (-d).sqrt();
            (-half * t).exp() * ((w * t).cos() + half / w * (w * t).sin())
        };
        sum -= 2.0 / (stiffness * wave * wave) * decay;
    }
    sum
}

const TIMES: [f64; 5] = [0.1, 0.2, 0.3, 0.5, 1.0];

fn worst(found: &[f64], expected: &[f64]) -> f64 {
    found.iter().zip(expected).map(|(f, e)| (f - e).abs()).fold(0.0, f64::max) / 0.01
}

#[test]
fn sdirk2_follows_the_series_and_is_of_second_order() {
    let exact = TIMES.map(series);
    let (fine, _) = extensions(cube(Scheme::Rk4, TimeStep::Auto), &TIMES);
    let errors = [0.04, 0.02, 0.01].map(|dt| {
        let mut setup = cube(Scheme::Sdirk2, TimeStep::Fixed(dt));
        setup.integration.tolerance = 1e-8;
        let (found, simulation) = extensions(setup, &TIMES);
        let balance = simulation.rhs_evaluations();
        println!(
            "dt = {dt}: {:.2e} of the same operator, {:.2e} of the series, {balance} applications",
            worst(&found, &fine),
            worst(&found, &exact)
        );
        (worst(&found, &fine), worst(&found, &exact))
    });
    assert!(errors[1].0 < 0.002 && errors[1].1 < 0.003, "{errors:?}");
    // Halving the step divides the error by four.
    assert!(errors[0].0 / errors[2].0 > 3.0_f64.powi(2), "{errors:?}");
}

#[test]
fn the_other_schemes_agree() {
    let (fine, _) = extensions(cube(Scheme::Rk4, TimeStep::Auto), &TIMES);
    let (chebyshev, _) = extensions(cube(Scheme::Rkc2, TimeStep::Fixed(0.01)), &TIMES);
    assert!(worst(&chebyshev, &fine) < 2e-3, "{}", worst(&chebyshev, &fine));
    let (euler, _) = extensions(cube(Scheme::BackwardEuler, TimeStep::Fixed(0.002)), &TIMES);
    assert!(worst(&euler, &fine) < 1e-2, "{}", worst(&euler, &fine));
    let mut setup = cube(Scheme::Sdirk2, TimeStep::Auto);
    setup.integration.tolerance = 1e-3;
    let (adaptive, simulation) = extensions(setup, &TIMES);
    println!("{} adaptive steps, error {:.1e}", simulation.step_count(), worst(&adaptive, &fine));
    assert!(worst(&adaptive, &fine) < 5e-3 && simulation.step_count() < 400);
}

#[test]
fn implicit_steps_balance_momentum_and_work() {
    let mut setup = cube(Scheme::Sdirk2, TimeStep::Fixed(0.01));
    setup.integration.tolerance = 1e-8;
    let (_, mut simulation) = extensions(setup, &[1.0]);
    let c = simulation.conservation();
    assert!(c.momentum_error < 1e-6, "{}", c.momentum_error);
    // At rest half of the work is stored and half dissipated.
    assert!((c.elastic_energy / c.external_work - 0.5).abs() < 0.01);
    assert!((c.reaction.z + 1.0).abs() < 0.01);
}

#[test]
fn statics_is_where_motion_ends() {
    let mut simulation = Simulation::new(cube(Scheme::Auto, TimeStep::Auto)).unwrap();
    let found = simulation.solve_static(1.0, &mut |_, _| true).unwrap();
    // nu = 0: the bar's extension is exact.
    assert!((simulation.readings()[0].value - 0.01).abs() < 1e-7);
    // The shares of the load on the layers add up to 1 within 1e-4.
    assert!((found.compliance - 0.01).abs() < 1e-6 && found.iterations <= 20, "{found:?}");
    assert!((found.reaction + found.load).norm() < 1e-5 && found.residual < 2e-6);
    let c = simulation.conservation();
    assert!((c.elastic_energy - 0.005).abs() < 1e-7);
    // It goes on from there and stays.
    simulation.advance_to(1.05, &mut |_| true).unwrap();
    assert!((simulation.readings()[0].value - 0.01).abs() < 1e-6);
}

#[test]
fn a_loose_body_has_no_equilibrium_and_says_so() {
    let mut setup = cube(Scheme::Auto, TimeStep::Auto);
    setup.mechanics.boundaries.clear();
    let mut simulation = Simulation::new(setup).unwrap();
    let failure = simulation.solve_static(1.0, &mut |_, _| true).unwrap_err();
    assert!(failure.what.contains("held by nothing"), "{failure}");
}

#[test]
fn schemes_that_do_not_fit_are_refused() {
    let mut setup = cube(Scheme::Sdirk2, TimeStep::Auto);
    setup.solver.formulation = rsph_core::setup::Formulation::Paper;
    assert_eq!(Simulation::new(setup).unwrap_err().key, "time.integrator");
    let mut setup = cube(Scheme::Rkc2, TimeStep::Auto);
    setup.mechanics.material = Arc::new(KelvinVoigt::new(1.0, 100.0, 0.0, 0.0).unwrap());
    assert_eq!(Simulation::new(setup).unwrap_err().key, "time.integrator");
    let e = Simulation::new(cube(Scheme::Sdirk2, TimeStep::Fixed(f64::NAN))).unwrap_err();
    assert_eq!(e.key, "time.dt");
}

#[test]
fn a_clamp_through_a_body_acts_at_its_plane() {
    // The cube stands on a held part; the plane does not lie on the lattice of its corner.
    let mut setup = cube(Scheme::Auto, TimeStep::Auto);
    setup.shape = Arc::new(BoxShape::new(Vec3::new(1.0, 1.0, 1.33), Vec3::new(0.0, 0.0, -0.33)).unwrap());
    setup.resolution = Resolution::Spacing(1.0 / 7.0);
    setup.solver = Solver::ACCURATE;
    let mut simulation = Simulation::new(setup).unwrap();
    simulation.solve_static(1.0, &mut |_, _| true).unwrap();
    let extension = simulation.readings()[0].value;
    assert!((extension / 0.01 - 1.0).abs() < 0.002, "{extension}");
}

/// Two blocks, one held, joined by a square neck of that width; particles are 0.1 apart.
fn dumbbell(neck: f64) -> Setup<SolidSetup> {
    let block = |x: &Vec3, centre: f64, half: Vec3| {
        let q = (x - Vec3::new(0.0, 0.0, centre)).abs() - half;
        q.sup(&Vec3::zeros()).norm() + q.max().min(0.0)
    };
    let cells = [52, 52, 60];
    let grid = Grid { origin: Vec3::new(-0.52, -0.52, -0.6), spacing: 0.02, cells };
    let phi: Vec<f64> = (0..grid.len())
        .map(|q| grid.centre([q % 52, q / 52 % 52, q / 52 / 52]))
        .map(|x| {
            let ends =
                block(&x, -0.35, Vec3::new(0.4, 0.4, 0.2)).min(block(&x, 0.35, Vec3::new(0.4, 0.4, 0.2)));
            ends.min(block(&x, 0.0, Vec3::new(0.5 * neck, 0.5 * neck, 0.3)))
        })
        .collect();
    let (shape, _) = MeshShape::new(&zero_level_set(&grid, &phi), "dumbbell").unwrap();
    let mut setup = cube(Scheme::Auto, TimeStep::Auto);
    setup.shape = Arc::new(shape);
    setup.resolution = Resolution::Spacing(0.1);
    setup.mechanics.boundaries =
        vec![Boundary { name: None, region: plane(-0.4, Side::Below), fix: Fix::ALL, motion: None }];
    setup.mechanics.loads = vec![Load {
        kind: LoadKind::BodyForce { region: Region::All, acceleration: Vec3::new(0.1, 0.0, -0.3) },
        curve: Curve::default(),
    }];
    setup.probes.clear();
    setup.solver = Solver::ACCURATE;
    setup
}

#[test]
fn a_body_that_hangs_by_a_thin_piece_comes_to_rest_or_is_told_of() {
    for neck in [0.3, 0.14, 0.1] {
        let mut simulation = Simulation::new(dumbbell(neck)).unwrap();
        match simulation.solve_static(1.0, &mut |_, _| true) {
            Ok(found) => assert!(found.residual < 2e-6 && found.iterations < 1000, "{neck}: {found:?}"),
            Err(failure) => {
                assert!(neck < 0.2, "{neck}: {failure}");
                let told = ["too thin", "held by nothing", "not held enough"];
                assert!(told.iter().any(|t| failure.what.contains(t)), "{neck}: {failure}");
            }
        }
    }
}

#[test]
fn loads_can_be_replaced_between_steps() {
    let mut simulation = Simulation::new(cube(Scheme::Sdirk2, TimeStep::Fixed(0.05))).unwrap();
    simulation.advance_to(0.5, &mut |_| true).unwrap();
    let pulled = simulation.readings()[0].value;
    let none = Region::Ball { centre: Vec3::repeat(9.0), radius: 0.1 };
    let nowhere = LoadKind::Traction { region: none, traction: Vec3::z() };
    let refused = simulation.set_loads(vec![Load { kind: nowhere, curve: Curve::default() }]);
    assert_eq!(refused.unwrap_err().key, "load[0]");
    assert!((simulation.evaluate().load.z - 1.0).abs() < 1e-3, "a refused load changes nothing");
    simulation.set_loads(Vec::new()).unwrap();
    assert!(simulation.evaluate().load.norm() == 0.0);
    simulation.advance_to(3.0, &mut |_| true).unwrap();
    assert!(simulation.readings()[0].value.abs() < 1e-3 * pulled);
}

/// A soft block that falls onto its clamp: steps as long as the accuracy of slow motion allows meet states that Newton's method does not
/// solve.
#[test]
fn a_step_that_is_not_solved_is_taken_again_shorter() {
    let mut setup = cube(Scheme::Sdirk2, TimeStep::Auto);
    setup.integration.tolerance = 0.1;
    setup.mechanics.material = Arc::new(NeoHookean::new(1.0, 100.0, 0.45, 0.02).unwrap());
    setup.mechanics.loads = vec![Load {
        kind: LoadKind::BodyForce { region: Region::All, acceleration: Vec3::new(30.0, 0.0, -30.0) },
        curve: Curve::default(),
    }];
    let (found, simulation) = extensions(setup, &[0.05, 0.1, 0.3, 2.0]);
    println!("{found:?} in {} steps", simulation.step_count());
}
