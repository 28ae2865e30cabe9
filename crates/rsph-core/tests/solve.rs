//! The linear solver: exact diagonal blocks, few iterations whatever the size and material, the same bits
//! for any number of threads; what is loose is named.

mod common;

use common::{Noise, TestBody, ball, body, clamped_cube, face, held_cube, solve};
use proptest::prelude::*;
use rsph_core::boundary::fixed::{Fixed, FixedParticle};
use rsph_core::dynamics::Scales;
use rsph_core::dynamics::solid::Solid;
use rsph_core::grid::Grid;
use rsph_core::lattice::Lattice;
use rsph_core::material::KelvinVoigt;
use rsph_core::region::{Axis, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Boundary, Fix};
use rsph_core::shape::{Shape, SphereShape, cut};
use rsph_core::solve::cg::{ConjugateGradients, Goal};
use rsph_core::solve::linear::LinearSolver;
use rsph_core::solve::multigrid::Multigrid;
use rsph_core::solve::operator::{Operator, Shifted};
use rsph_core::solve::rigid::loose_pieces;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

fn roller(axis: Axis) -> Boundary {
    Boundary { name: None, region: face(axis, 0.0, Side::Below), fix: Fix::Normal, motion: None }
}

/// A body with cut cells whose lower part is held particle by particle.
fn held_ball(smoothing: f64) -> TestBody {
    let mut held = ball(smoothing);
    for (particle, _) in held.positions.iter().enumerate().filter(|(_, x)| x.z < 0.35) {
        held.solid.fixed.particles.push(FixedParticle {
            particle,
            fix: [true; 3],
            motion: None,
            boundary: None,
        });
    }
    held
}

/// Iterations from zero to a relative residual of 1e-6, with the solution.
fn iterations(solid: &mut Solid, scales: Scales, load: &[f64]) -> (usize, Vec<f64>) {
    let mut solver = LinearSolver::new(solid);
    let mut x = vec![0.0; load.len()];
    let goal = Goal { residual: 1e-6 * solver.norm(load), iterations: 200 };
    let outcome = solver.solve(solid, scales, load, &mut x, goal, &mut |_, _| true);
    assert!(outcome.converged);
    (outcome.iterations, x)
}

fn smooth_load(body: &TestBody) -> Vec<f64> {
    let n = body.positions.len();
    let mut load = vec![0.0; 3 * n];
    for (a, x) in body.positions.iter().enumerate() {
        let m = body.solid.moments_of(a).volume;
        (load[a], load[n + a], load[2 * n + a]) = (0.3 * m, -m * (5.0 * x.x).sin(), m * x.z);
    }
    body.solid.fixed.zero(&mut load, n);
    load
}

#[test]
fn the_solution_is_that_of_plain_conjugate_gradients() {
    for mut body in [held_ball(0.8), clamped_cube(7, 1.25, 0.3)] {
        let load = smooth_load(&body);
        let exact = solve(&mut body.solid, &load);
        let (_, x) = iterations(&mut body.solid, Scales::STATIC, &load);
        let size = exact.iter().map(|x| x * x).sum::<f64>().sqrt();
        let error = x.iter().zip(&exact).map(|(x, e)| (x - e).powi(2)).sum::<f64>().sqrt();
        assert!(error < 1e-4 * size, "{}", error / size);
    }
}

#[test]
fn few_iterations_for_any_size_smoothing_and_material() {
    for (n, smoothing, nu) in [
        (8, 0.8, 0.3),
        (16, 0.8, 0.0),
        (16, 0.8, 0.3),
        (16, 0.8, 0.45),
        (16, 1.0, 0.3),
        (16, 1.25, 0.3),
        (13, 1.25, 0.45),
        (30, 0.8, 0.3),
    ] {
        let mut body = clamped_cube(n, smoothing, nu);
        let load = smooth_load(&body);
        let (static_one, _) = iterations(&mut body.solid, Scales::STATIC, &load);
        let (stage, _) =
            iterations(&mut body.solid, Scales { mass: 1.0, stiffness: 0.01, damping: 0.0 }, &load);
        println!("{n}^3, h = {smoothing} dx, nu = {nu}: {static_one}, in time {stage}");
        assert!(static_one <= 20 && stage <= 20, "{static_one} {stage}");
    }
    let mut held = held_ball(0.8);
    let load = smooth_load(&held);
    assert!(iterations(&mut held.solid, Scales::STATIC, &load).0 <= 20);
}

/// The lattice lies anywhere with respect to a clamp, along an axis or across them.
#[test]
fn iterations_do_not_depend_on_where_a_clamp_crosses_the_lattice() {
    for normal in [Vec3::z(), Vec3::new(1.0, 2.0, 0.5).normalize()] {
        let iterations: Vec<usize> = (0..5)
            .map(|k| {
                let ball: Arc<dyn Shape> = Arc::new(SphereShape::new(0.47, Vec3::zeros()).unwrap());
                let point = normal * (-0.3 + 0.011 * f64::from(k));
                let shape = cut(&ball, &point, &-normal, 1e-9).unwrap();
                let region = rsph_core::region::Region::HalfSpace { point, normal };
                let clamp = Boundary { name: None, region, fix: Fix::ALL, motion: None };
                let mut body = body(shape, Resolution::Spacing(1.0 / 18.0), 0.8, 1.0, 0.3, &[clamp]);
                let load = smooth_load(&body);
                iterations(&mut body.solid, Scales::STATIC, &load).0
            })
            .collect();
        println!("{iterations:?}");
        assert!(iterations.iter().all(|i| *i <= 16), "{iterations:?}");
    }
}

/// Nearly incompressible tissue.
#[test]
fn iterations_towards_the_incompressible_limit() {
    for (nu, most) in [(0.45, 20), (0.49, 40), (0.499, 80)] {
        let mut body = clamped_cube(16, 0.8, nu);
        let load = smooth_load(&body);
        let (found, _) = iterations(&mut body.solid, Scales::STATIC, &load);
        println!("nu = {nu}: {found}");
        assert!(found <= most, "nu = {nu}: {found}");
    }
}

/// An operator about a state that is none.
struct Broken(usize);

impl Operator for Broken {
    fn len(&self) -> usize {
        self.0
    }

    fn apply(&mut self, _: &[f64], y: &mut [f64]) {
        y.fill(f64::NAN);
    }
}

#[test]
fn a_solve_that_went_wrong_leaves_nothing_behind() {
    let mut body = clamped_cube(13, 0.8, 0.45);
    let load = smooth_load(&body);
    let mut used = (Multigrid::new(&mut body.solid), ConjugateGradients::new(load.len()));
    let mut fresh = used.clone();
    let goal = Goal { residual: 1e-6, iterations: 200 };
    let mut solve = |(multigrid, gradients): &mut (Multigrid, ConjugateGradients), broken: bool| {
        let mut x = vec![0.0; load.len()];
        let (mut broken_one, mut good) =
            (Broken(load.len()), Shifted { solid: &mut body.solid, scales: Scales::STATIC });
        let operator: &mut dyn Operator = if broken { &mut broken_one } else { &mut good };
        let outcome = gradients.solve(operator, multigrid, &load, &mut x, goal, &mut |_, _| true);
        (outcome.converged, x)
    };
    assert!(!solve(&mut used, true).0);
    let again = solve(&mut used, false);
    assert!(again.0);
    assert_eq!(again, solve(&mut fresh, false));
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut body = held_ball(0.8);
            let load = smooth_load(&body);
            iterations(&mut body.solid, Scales { mass: 1.0, stiffness: 0.5, damping: 0.0 }, &load).1
        })
    };
    let (one, three) = (on(1), on(3));
    assert!(one.iter().zip(&three).all(|(a, b)| a.to_bits() == b.to_bits()));
}

#[test]
fn what_is_loose_is_named() {
    let free = loose_pieces(&ball(0.8).solid);
    assert_eq!(free.len(), 1);
    assert!(free[0].free && free[0].motions.len() == 6, "{free:?}");

    let sliding = held_cube(5, 0.8, 0.3, &[roller(Axis::X), roller(Axis::Y)]);
    let found = loose_pieces(&sliding.solid);
    assert_eq!(found[0].motions, ["shifted along z"]);

    let hinged = held_cube(5, 0.8, 0.3, &[roller(Axis::Z)]);
    let found = loose_pieces(&hinged.solid);
    assert_eq!(found[0].motions.len(), 3, "{found:?}");
    assert!(found[0].motions[2].starts_with("turned about an axis along z"), "{found:?}");

    // Two pieces, of which the clamp holds the lower one.
    let grid = Grid { origin: Vec3::zeros(), spacing: 0.1, cells: [4, 4, 12] };
    let cells: Vec<[usize; 3]> = (0..192).map(|a| [a % 4, a / 4 % 4, a / 16]).collect();
    let cells: Vec<[usize; 3]> = cells.into_iter().filter(|c| c[2] < 4 || c[2] >= 8).collect();
    let particles =
        (0..16).map(|particle| FixedParticle { particle, fix: [true; 3], motion: None, boundary: None });
    let fixed = Fixed { particles: particles.collect() };
    let lattice = Lattice::new(&grid, &cells, 0.8, 3);
    let material = Arc::new(KelvinVoigt::new(1.0, 100.0, 0.3, 0.2).unwrap());
    let two = Solid::new(lattice, &vec![1e-3; cells.len()], fixed, material, 40.0);
    let found = loose_pieces(&two);
    assert_eq!((found.len(), found[0].particles, found[0].free), (1, 64, true));
    assert!((found[0].centre - Vec3::new(0.2, 0.2, 1.0)).norm() < 1e-12);

    assert!(loose_pieces(&clamped_cube(4, 0.8, 0.3).solid).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// x . A y = y . A x and x . A x > 0 of m M + c K on held bodies.
    #[test]
    fn shifted_operators_are_symmetric_and_positive(seed in 1..1000_u64, m in 0.0..2.0f64, c in 0.01..2.0f64) {
        let mut body = held_ball(0.8);
        let n = 3 * body.positions.len();
        let mut noise = Noise(seed);
        let (mut x, mut y) = (noise.column(n), noise.column(n));
        body.solid.fixed.zero(&mut x, n / 3);
        body.solid.fixed.zero(&mut y, n / 3);
        let (mut ax, mut ay) = (vec![0.0; n], vec![0.0; n]);
        let scales = Scales { mass: m, stiffness: c, damping: 0.0 };
        body.solid.apply(scales, &x, &mut ax);
        body.solid.apply(scales, &y, &mut ay);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        prop_assert!((dot(&ax, &y) - dot(&ay, &x)).abs() < 1e-11 * dot(&ax, &x).max(dot(&ay, &y)));
        prop_assert!(dot(&ax, &x) > 0.0);
    }
}
