//! Identities of the discrete operator: exact for linear fields, adjoint, symmetric, positive, the
//! derivative of its energy.

mod common;

use approx::assert_relative_eq;
use common::{Noise, TestBody, ball, body, body_of, clamp, clamped_cube, cube, face, held_cube, solve};
use nalgebra::DMatrix;
use rsph_core::boundary::surface_load::{SurfacePoint, Traction};
use rsph_core::dynamics::Dynamics;
use rsph_core::material::{KelvinVoigt, Material};
use rsph_core::particles::{Column, Field, Particles};
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Boundary, Curve, Fix, Motion};
use rsph_core::shape::{MeshShape, Shape, SphereShape, cut};
use rsph_core::tensor::{Mat3, SymTensor, Vec3};
use std::sync::Arc;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn particles(body: &TestBody, u: Vec<f64>) -> Particles {
    let n = body.positions.len();
    let mut p = Particles::new(n);
    p.set(Field::Reference, Column::from_vectors(&body.positions));
    p.set(Field::Displacement, Column::from_vec(u, n));
    p.set(Field::Velocity, Column::zeros(3, n));
    p
}

fn linear_field(body: &TestBody, g: &Mat3) -> Vec<f64> {
    let u: Vec<Vec3> = body.positions.iter().map(|x| g * x).collect();
    Column::from_vectors(&u).values().to_vec()
}

#[test]
fn patch_test_linear_displacement_gives_its_strain_everywhere() {
    let g = Mat3::new(0.1, -0.3, 0.2, 0.05, 0.2, -0.1, 0.4, 0.15, -0.25);
    let expected = SymTensor::symmetric_part(&g);
    for smoothing in [0.8, 1.0, 1.25, 1.6] {
        let mut body = ball(smoothing);
        let n = body.positions.len();
        let u = linear_field(&body, &g);
        let strain = body.solid.strain(0.0, &u);
        for a in 0..n {
            for c in 0..6 {
                assert!((strain[c * n + a] - expected.0[c]).abs() < 1e-11, "particle {a} component {c}");
            }
        }
    }
}

#[test]
fn translation_and_small_rotation_are_strain_and_force_free() {
    let mut body = ball(1.25);
    let spin = Mat3::new(0.0, -0.3, 0.2, 0.3, 0.0, -0.1, -0.2, 0.1, 0.0);
    let n = body.positions.len();
    let mut u = linear_field(&body, &spin);
    for u in &mut u {
        *u += 0.7;
    }
    assert!(body.solid.strain(0.0, &u).iter().all(|e| e.abs() < 1e-12));
    let mut force = vec![0.0; 3 * n];
    body.solid.force_of(&u, &mut force);
    assert!(force.iter().all(|f| f.abs() < 1e-12));
}

fn roller(axis: Axis) -> Boundary {
    Boundary { name: None, region: face(axis, 0.0, Side::Below), fix: Fix::Normal, motion: None }
}

#[test]
fn uniform_strain_next_to_a_clamp_and_a_roller_is_exact() {
    // Clamp: u = z c vanishes on the plane. Roller at x = 0: u_x = x, the rest free.
    for smoothing in [0.8, 1.25] {
        for (boundary, g) in [
            (clamp(), Mat3::new(0.0, 0.0, 0.3, 0.0, 0.0, -0.2, 0.0, 0.0, 0.5)),
            (roller(Axis::X), Mat3::new(0.4, 0.0, 0.0, 0.0, -0.2, 0.1, 0.0, 0.3, 0.25)),
        ] {
            let mut body = held_cube(7, smoothing, 0.3, &[boundary]);
            let n = body.positions.len();
            let u = linear_field(&body, &g);
            let strain = body.solid.strain(0.0, &u);
            let expected = SymTensor::symmetric_part(&g);
            for a in 0..n {
                for c in 0..6 {
                    assert!((strain[c * n + a] - expected.0[c]).abs() < 1e-11);
                }
            }
        }
    }
}

/// A ball that is cut and clamped by an oblique plane, with one patch of its surface on rollers.
fn held_ball(smoothing: f64) -> TestBody {
    let ball: Arc<dyn Shape> = Arc::new(SphereShape::new(0.47, Vec3::repeat(0.55)).unwrap());
    let (point, normal) = (Vec3::repeat(0.4), -Vec3::new(1.0, 2.0, 0.5).normalize());
    let shape = cut(&ball, &point, &normal, 1e-9).unwrap();
    let plane = Region::HalfSpace { point, normal: -normal };
    let patch = Region::SurfacePatch { centre: Vec3::new(0.9, 0.8, 0.6), radius: 0.25, facing: Vec3::x() };
    let boundaries = [
        Boundary { name: None, region: plane, fix: Fix::ALL, motion: None },
        Boundary { name: None, region: patch, fix: Fix::Normal, motion: None },
    ];
    body(shape, Resolution::Spacing(0.1), smoothing, 1.0, 0.3, &boundaries)
}

#[test]
fn stiffness_is_symmetric() {
    let corner = [roller(Axis::X), roller(Axis::Y), roller(Axis::Z)];
    let balls = [ball(1.25), ball(0.8), held_ball(0.8), held_ball(1.25)];
    let cubes = [
        clamped_cube(7, 1.25, 0.3),
        clamped_cube(6, 0.8, 0.45),
        held_cube(5, 1.25, 0.3, &corner),
        held_cube(5, 0.8, 0.499, &corner),
    ];
    for mut body in balls.into_iter().chain(cubes) {
        let n = 3 * body.positions.len();
        let mut noise = Noise(7);
        let (x, y) = (noise.column(n), noise.column(n));
        let (mut kx, mut ky) = (vec![0.0; n], vec![0.0; n]);
        body.solid.force_of(&x, &mut kx);
        body.solid.force_of(&y, &mut ky);
        let scale = dot(&kx, &kx).sqrt() * dot(&y, &y).sqrt();
        assert!((dot(&kx, &y) - dot(&ky, &x)).abs() < 1e-12 * scale);
    }
}

#[test]
fn force_is_minus_the_derivative_of_the_energy() {
    let corner = [roller(Axis::X), clamp(), roller(Axis::Y)];
    for mut body in [
        ball(1.25),
        ball(0.8),
        held_ball(0.8),
        clamped_cube(5, 1.25, 0.3),
        held_cube(5, 0.8, 0.3, &corner),
        held_cube(6, 1.25, 0.3, &corner),
    ] {
        let n = 3 * body.positions.len();
        let mut noise = Noise(11);
        let (u, direction) = (noise.column(n), noise.column(n));
        let mut force = vec![0.0; n];
        body.solid.force_of(&u, &mut force);
        let mut energy = |s: f64| {
            let moved = u.iter().zip(&direction).map(|(u, d)| u + s * d).collect();
            let p = particles(&body, moved);
            body.solid.energy(0.0, &p).elastic
        };
        // The energy is quadratic: central differences are exact.
        let derivative = (energy(0.5) - energy(-0.5)) / 1.0;
        assert_relative_eq!(derivative, -dot(&force, &direction), max_relative = 1e-11);
    }
}

/// Faces that move between layers of cells and across them, beside one at rest.
#[test]
fn the_power_of_moved_faces_is_the_rate_of_the_energy() {
    let displacement = Vec3::new(0.3, -0.2, 0.5);
    let motion = Some(Motion::Curve { displacement, curve: Curve::ramp(0.0, 1.0) });
    let moved = Boundary { name: None, motion, ..clamp() };
    let material: Arc<dyn Material> = Arc::new(KelvinVoigt::new(1.0, 100.0, 0.3, 0.0).unwrap());
    for (spacing, smoothing) in [(0.2, 0.8), (0.2, 1.25), (0.137, 0.8)] {
        let top = Boundary { name: None, region: face(Axis::Z, 1.0, Side::Above), ..moved.clone() };
        for boundaries in [vec![moved.clone(), roller(Axis::X)], vec![clamp(), top]] {
            let spacing = Resolution::Spacing(spacing);
            let mut body = body_of(Some(material.clone()), cube(), spacing, smoothing, 1.0, 0.3, &boundaries);
            let n = body.positions.len();
            let p = particles(&body, Noise(3).column(3 * n));
            let mut rates = [Column::zeros(3, n), Column::zeros(3, n)];
            let sums = body.solid.rates(0.4, &p, &mut rates);
            let internal: Vec3 = (0..n).map(|a| rates[1].vector(a) * body.solid.mass[a]).sum();
            // What the body exerts on all faces together; a roller at rest does no work.
            assert!((internal - sums.reaction).norm() < 1e-12 * body.solid.mass.len() as f64);
            let mut energy = |t: f64| body.solid.energy(t, &p).elastic;
            let rate = (energy(0.6) - energy(0.2)) / 0.4;
            assert_relative_eq!(rate, sums.power, max_relative = 1e-10);
        }
    }
}

fn stiffness(body: &mut TestBody) -> DMatrix<f64> {
    let n = 3 * body.positions.len();
    let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
    let mut k = DMatrix::zeros(n, n);
    for j in 0..n {
        unit[j] = 1.0;
        body.solid.force_of(&unit, &mut column);
        unit[j] = 0.0;
        for i in 0..n {
            k[(i, j)] = -column[i];
        }
    }
    k
}

#[test]
fn no_negative_eigenvalue_on_held_bodies_and_six_zeros_on_a_free_one() {
    for (mut body, zeros) in [(clamped_cube(6, 1.25, 0.3), 0), (held_ball(0.8), 0), (ball(0.8), 6)] {
        let k = stiffness(&mut body);
        let asymmetry = (&k - k.transpose()).amax() / k.amax();
        assert!(asymmetry < 1e-13, "asymmetry {asymmetry}");
        let mut eigenvalues: Vec<f64> = k.clone().symmetric_eigenvalues().iter().copied().collect();
        eigenvalues.sort_by(f64::total_cmp);
        let largest = eigenvalues[eigenvalues.len() - 1];
        assert!(eigenvalues[..zeros].iter().all(|e| e.abs() < 1e-12 * largest), "{:?}", &eigenvalues[..7]);
        assert!(eigenvalues[zeros] > 1e-4 * largest, "{:?}", &eigenvalues[..7]);
        // Lanczos finds the largest one of M^-1 K.
        let root = |i: usize| body.solid.mass[i % body.positions.len()].sqrt();
        let scaled = DMatrix::from_fn(k.nrows(), k.ncols(), |i, j| k[(i, j)] / (root(i) * root(j)));
        let exact = scaled.symmetric_eigenvalues().max();
        let lanczos = rsph_core::stability::largest_eigenvalue(&mut body.solid);
        assert!((lanczos / exact - 1.0).abs() < 2e-3, "Lanczos {lanczos} for {exact}");
    }
}

#[test]
fn diagonal_blocks_are_those_of_the_stiffness() {
    let corner = [roller(Axis::X), clamp()];
    for mut body in [
        ball(0.8),
        held_ball(0.8),
        held_ball(1.25),
        clamped_cube(4, 0.8, 0.45),
        held_cube(4, 1.25, 0.3, &corner),
    ] {
        let k = stiffness(&mut body);
        let n = body.positions.len();
        for (a, block) in rsph_core::solve::blocks::diagonal_blocks(&body.solid).iter().enumerate() {
            for i in 0..3 {
                for j in 0..3 {
                    let error = block[(i, j)] - k[(i * n + a, j * n + a)];
                    assert!(error.abs() < 1e-11 * k.amax(), "particle {a}, ({i}, {j}): {error}");
                }
            }
        }
    }
}

#[test]
fn internal_forces_of_a_free_body_have_no_resultant_and_no_moment() {
    let mut body = ball(1.25);
    let n = body.positions.len();
    let u = Noise(5).column(3 * n);
    let mut force = vec![0.0; 3 * n];
    body.solid.force_of(&u, &mut force);
    let f = Column::from_vec(force, n);
    let scale: f64 = (0..n).map(|a| f.vector(a).norm()).sum();
    let total: Vec3 = (0..n).map(|a| f.vector(a)).sum();
    let moment: Vec3 = (0..n).map(|a| body.positions[a].cross(&f.vector(a))).sum();
    assert!(total.norm() < 1e-14 * scale);
    assert!(moment.norm() < 1e-13 * scale, "moment {} of {scale}", moment.norm());
}

/// Forces of a traction on the particles of a body.
fn load(body: &TestBody, traction: impl Fn(&SurfacePoint) -> Vec3 + Sync) -> Vec<f64> {
    let traction =
        Traction { at: &traction, reaches: &|_| true, resolution: &|_, _| f64::INFINITY, smooth: 0.0 };
    body.surface.force(body.positions.len(), &traction).unwrap()
}

/// A constant stress balances its tractions: the linear field that has it is an exact equilibrium, for a body of any shape
/// at any position of the lattice.
#[test]
fn a_constant_stress_balances_its_tractions() {
    let sigma = SymTensor([1.0, -0.4, 0.7, 0.3, -0.2, 0.5]);
    // E = 100, nu = 0.3.
    let strain =
        sigma * (1.3 / 100.0) + SymTensor([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]) * (-0.3 / 100.0 * sigma.trace());
    let turned = {
        let turn = nalgebra::Rotation3::from_axis_angle(
            &nalgebra::Unit::new_normalize(Vec3::new(1.0, 2.0, 0.5)),
            0.52,
        );
        let mut mesh = cube().surface().clone();
        mesh.vertices.iter_mut().for_each(|x| *x = turn * *x + Vec3::new(0.013, 0.027, -0.041));
        Arc::new(MeshShape::new(&mesh, "turned").unwrap().0)
    };
    for (mut body, tolerance) in [
        (ball(0.8), 2e-3),
        (ball(1.25), 2e-3),
        (body(turned.clone(), Resolution::Spacing(1.0 / 7.0), 0.8, 1.0, 0.3, &[]), 2e-3),
        (body(cube(), Resolution::Spacing(0.137), 0.8, 1.0, 0.3, &[]), 2e-3),
    ] {
        let n = 3 * body.positions.len();
        let load = load(&body, |p| sigma.dot(&p.normal));
        let u = linear_field(&body, &strain.to_matrix());
        let mut force = vec![0.0; n];
        body.solid.force_of(&u, &mut force);
        let residual: Vec<f64> = force.iter().zip(&load).map(|(f, l)| f + l).collect();
        let ratio = (dot(&residual, &residual) / dot(&load, &load)).sqrt();
        println!("out of balance: {ratio:.1e}");
        assert!(ratio < tolerance, "{ratio}");
    }
}

/// Extension of a clamped cube with E = 1 under unit traction at the top.
fn static_extension(n: usize, smoothing: f64, nu: f64) -> f64 {
    let mut body = clamped_cube(n, smoothing, nu);
    let count = body.positions.len();
    let load = load(&body, |p| if p.normal.z > 0.5 { Vec3::z() } else { Vec3::zeros() });
    let u = solve(&mut body.solid, &load);
    100.0 * load[2 * count..].iter().zip(&u[2 * count..]).map(|(f, u)| f * u).sum::<f64>()
}

#[test]
fn clamped_cube_stretches_like_finite_elements() {
    // Finite elements (validation/references/cube.py); exactly 1 at nu = 0.
    for (n, smoothing, nu, exact, bound) in [
        (7, 1.25, 0.3, 0.970546, 0.0105),
        (7, 0.8, 0.3, 0.970546, 0.005),
        (13, 0.8, 0.3, 0.970546, 0.0025),
        (7, 0.8, 0.45, 0.927758, 0.005),
        (7, 0.8, 0.49, 0.911656, 0.005),
        (7, 0.8, 0.499, 0.907685, 0.005),
        (13, 0.8, 0.499, 0.907685, 0.0025),
    ] {
        let error = static_extension(n, smoothing, nu) / exact - 1.0;
        println!("{n}^3, h = {smoothing} dx, nu = {nu}: {:+.2} %", 100.0 * error);
        assert!(error.abs() < bound, "{n}^3, h = {smoothing} dx, nu = {nu}: {error}");
    }
    let error = static_extension(7, 1.25, 0.0) - 1.0;
    assert!(error.abs() < 1e-3, "nu = 0: {error}");
}
