//! The linear solver: exact diagonal blocks, few iterations whatever the size and material, the same bits
//! for any number of threads; what is loose is named.

mod common;

use common::{Noise, TestBody, ball, body, clamp, clamped_cube, solve};
use proptest::prelude::*;
use rsph_core::boundary::fixed::FixedParticle;
use rsph_core::boundary::mirror::MirrorPlane;
use rsph_core::dynamics::elastic::Elastic;
use rsph_core::solve::blocks::diagonal_blocks;
use rsph_core::solve::cg::Goal;
use rsph_core::solve::rigid::loose_pieces;
use rsph_core::solve::stiff::StiffSolver;
use rsph_core::tensor::Vec3;

fn roller(axis: usize) -> MirrorPlane {
    MirrorPlane { axis, at: 0.0, fix: std::array::from_fn(|i| i == axis), motion: None }
}

/// A body with cut cells whose lower part is held particle by particle.
fn held_ball(smoothing: f64) -> TestBody {
    let mut held = ball(smoothing);
    for (particle, _) in held.positions.iter().enumerate().filter(|(_, x)| x.z < 0.35) {
        held.elastic.fixed.particles.push(FixedParticle { particle, fix: [true; 3], motion: None });
    }
    held
}

/// Iterations from zero to a relative residual of 1e-6, with the solution.
fn iterations(elastic: &mut Elastic, scales: (f64, f64), load: &[f64]) -> (usize, Vec<f64>) {
    let mut solver = StiffSolver::new(elastic);
    let mut x = vec![0.0; load.len()];
    let goal = Goal { residual: 1e-6 * solver.norm(load), iterations: 200 };
    let outcome = solver.solve(elastic, scales, load, &mut x, goal, &mut |_, _| true);
    assert!(outcome.converged);
    (outcome.iterations, x)
}

fn smooth_load(body: &TestBody) -> Vec<f64> {
    let n = body.positions.len();
    let mut load = vec![0.0; 3 * n];
    for (a, x) in body.positions.iter().enumerate() {
        let m = body.elastic.moments_of(a).volume;
        (load[a], load[n + a], load[2 * n + a]) = (0.3 * m, -m * (5.0 * x.x).sin(), m * x.z);
    }
    body.elastic.fixed.zero(&mut load, n);
    load
}

#[test]
fn diagonal_blocks_are_those_of_the_operator() {
    let corner = body([5; 3], 0.2, 1.25, 0.1, 0.3, vec![roller(0), roller(1), clamp()], |_| 1.0);
    for mut body in [ball(0.8), ball(1.25), clamped_cube(6, 1.25, 0.1, 0.3), corner] {
        let n = body.positions.len();
        let blocks = diagonal_blocks(&body.elastic);
        let (mut x, mut y) = (vec![0.0; 3 * n], vec![0.0; 3 * n]);
        for a in (0..n).step_by(n / 12) {
            for j in 0..3 {
                x.fill(0.0);
                x[j * n + a] = 1.0;
                body.elastic.apply(0.0, 1.0, &x, &mut y);
                for i in 0..3 {
                    assert!((y[i * n + a] - blocks[a][(i, j)]).abs() < 1e-12 * blocks[a].norm());
                }
            }
        }
    }
}

#[test]
fn the_solution_is_that_of_plain_conjugate_gradients() {
    for mut body in [held_ball(0.8), clamped_cube(7, 1.25, 0.1, 0.3)] {
        let load = smooth_load(&body);
        let exact = solve(&mut body.elastic, &load);
        let (_, x) = iterations(&mut body.elastic, (0.0, 1.0), &load);
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
        let mut body = clamped_cube(n, smoothing, 0.4, nu);
        let load = smooth_load(&body);
        let (static_one, _) = iterations(&mut body.elastic, (0.0, 1.0), &load);
        let (stage, _) = iterations(&mut body.elastic, (1.0, 0.01), &load);
        println!("{n}^3, h = {smoothing} dx, nu = {nu}: {static_one}, in time {stage}");
        assert!(static_one <= 20 && stage <= 20);
    }
    let mut held = held_ball(0.8);
    let load = smooth_load(&held);
    assert!(iterations(&mut held.elastic, (0.0, 1.0), &load).0 <= 20);
}

/// The lattice starts anywhere with respect to a clamp: blocks of two cells must not be half clamped.
#[test]
fn iterations_do_not_depend_on_where_a_clamp_crosses_the_lattice() {
    let (n, dx) = (18, 1.0 / 18.0);
    let iterations: Vec<usize> = (2..8)
        .map(|cells| {
            let at = f64::from(cells) * dx;
            let clamp = MirrorPlane { at, ..clamp() };
            let ball = |x: &Vec3| {
                let depth = 0.47 - (x - Vec3::repeat(0.5)).norm();
                if x.z > at { (depth / dx + 0.5).clamp(0.0, 1.0) } else { 0.0 }
            };
            let mut body =
                body([n; 3], dx, 0.8, 0.4, 0.3, vec![clamp], |x| if ball(x) < 0.1 { 0.0 } else { ball(x) });
            let load = smooth_load(&body);
            iterations(&mut body.elastic, (0.0, 1.0), &load).0
        })
        .collect();
    assert!(iterations.iter().all(|i| *i <= 12), "{iterations:?}");
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut body = held_ball(0.8);
            let load = smooth_load(&body);
            iterations(&mut body.elastic, (1.0, 0.5), &load).1
        })
    };
    let (one, three) = (on(1), on(3));
    assert!(one.iter().zip(&three).all(|(a, b)| a.to_bits() == b.to_bits()));
}

#[test]
fn what_is_loose_is_named() {
    let free = loose_pieces(&ball(0.8).elastic);
    assert_eq!(free.len(), 1);
    assert!(free[0].free && free[0].motions.len() == 6, "{free:?}");

    let sliding = body([5; 3], 0.2, 0.8, 0.4, 0.3, vec![roller(0), roller(1)], |_| 1.0);
    let found = loose_pieces(&sliding.elastic);
    assert_eq!(found[0].motions, ["shifted along z"]);

    let hinged = body([5; 3], 0.2, 0.8, 0.4, 0.3, vec![roller(2)], |_| 1.0);
    let found = loose_pieces(&hinged.elastic);
    assert_eq!(found[0].motions.len(), 3, "{found:?}");
    assert!(found[0].motions[2].starts_with("turned about an axis along z"), "{found:?}");

    // Two pieces, of which the clamp holds the lower one.
    let two = body([4, 4, 12], 0.1, 0.8, 0.4, 0.3, vec![clamp()], |x| f64::from(x.z < 0.4 || x.z > 0.8));
    let found = loose_pieces(&two.elastic);
    assert_eq!((found.len(), found[0].particles, found[0].free), (1, 64, true));
    assert!((found[0].centre - Vec3::new(0.2, 0.2, 1.0)).norm() < 1e-12);

    assert!(loose_pieces(&clamped_cube(4, 0.8, 0.4, 0.3).elastic).is_empty());
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
        body.elastic.fixed.zero(&mut x, n / 3);
        body.elastic.fixed.zero(&mut y, n / 3);
        let (mut ax, mut ay) = (vec![0.0; n], vec![0.0; n]);
        body.elastic.apply(m, c, &x, &mut ax);
        body.elastic.apply(m, c, &y, &mut ay);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        prop_assert!((dot(&ax, &y) - dot(&ay, &x)).abs() < 1e-11 * dot(&ax, &x).max(dot(&ay, &y)));
        prop_assert!(dot(&ax, &x) > 0.0);
    }
}
