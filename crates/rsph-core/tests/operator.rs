//! Identities of the discrete operator: exact for linear fields, adjoint, symmetric, positive, the
//! derivative of its energy.

mod common;

use approx::assert_relative_eq;
use common::{Noise, TestBody, ball, body, clamp, clamped_cube, solve};
use nalgebra::DMatrix;
use rsph_core::boundary::mirror::MirrorPlane;
use rsph_core::dynamics::Dynamics;
use rsph_core::moments::area_vectors;
use rsph_core::particles::{Column, Field, Particles};
use rsph_core::tensor::{Mat3, SymTensor, Vec3};

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
        let strain = body.elastic.strain(0.0, &u);
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
    assert!(body.elastic.strain(0.0, &u).iter().all(|e| e.abs() < 1e-12));
    let mut force = vec![0.0; 3 * n];
    body.elastic.force_of(&u, &mut force);
    assert!(force.iter().all(|f| f.abs() < 1e-12));
}

#[test]
fn uniform_strain_next_to_a_clamp_and_a_roller_is_exact() {
    // Clamp: u = z c vanishes on the plane. Roller at x = 0: u_x = x, the rest free.
    for (plane, g) in [
        (clamp(), Mat3::new(0.0, 0.0, 0.3, 0.0, 0.0, -0.2, 0.0, 0.0, 0.5)),
        (
            MirrorPlane { axis: 0, at: 0.0, fix: [true, false, false], motion: None },
            Mat3::new(0.4, 0.0, 0.0, 0.0, -0.2, 0.1, 0.0, 0.3, 0.25),
        ),
    ] {
        let mut body = body([7; 3], 1.0 / 7.0, 1.25, 0.1, 0.3, vec![plane], |_| 1.0);
        let n = body.positions.len();
        let u = linear_field(&body, &g);
        let strain = body.elastic.strain(0.0, &u);
        let expected = SymTensor::symmetric_part(&g);
        for a in 0..n {
            for c in 0..6 {
                assert!((strain[c * n + a] - expected.0[c]).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn stiffness_is_symmetric() {
    for mut body in [ball(1.25), ball(0.8), clamped_cube(7, 1.25, 0.1, 0.3), clamped_cube(6, 0.8, 0.2, 0.45)]
    {
        let n = 3 * body.positions.len();
        let mut noise = Noise(7);
        let (x, y) = (noise.column(n), noise.column(n));
        let (mut kx, mut ky) = (vec![0.0; n], vec![0.0; n]);
        body.elastic.force_of(&x, &mut kx);
        body.elastic.force_of(&y, &mut ky);
        let scale = dot(&kx, &kx).sqrt() * dot(&y, &y).sqrt();
        assert!((dot(&kx, &y) - dot(&ky, &x)).abs() < 1e-12 * scale);
    }
}

#[test]
fn corner_of_three_rollers_is_symmetric_too() {
    let roller =
        |axis: usize| MirrorPlane { axis, at: 0.0, fix: std::array::from_fn(|i| i == axis), motion: None };
    let mut body = body([5; 3], 0.2, 1.25, 0.1, 0.3, vec![roller(0), roller(1), roller(2)], |_| 1.0);
    let n = 3 * body.positions.len();
    let mut noise = Noise(3);
    let (x, y) = (noise.column(n), noise.column(n));
    let (mut kx, mut ky) = (vec![0.0; n], vec![0.0; n]);
    body.elastic.force_of(&x, &mut kx);
    body.elastic.force_of(&y, &mut ky);
    let scale = dot(&kx, &kx).sqrt() * dot(&y, &y).sqrt();
    assert!((dot(&kx, &y) - dot(&ky, &x)).abs() < 1e-12 * scale);
}

#[test]
fn force_is_minus_the_derivative_of_the_energy() {
    for mut body in [ball(1.25), clamped_cube(5, 1.25, 0.1, 0.3)] {
        let n = 3 * body.positions.len();
        let mut noise = Noise(11);
        let (u, direction) = (noise.column(n), noise.column(n));
        let mut force = vec![0.0; n];
        body.elastic.force_of(&u, &mut force);
        let mut energy = |s: f64| {
            let moved = u.iter().zip(&direction).map(|(u, d)| u + s * d).collect();
            let p = particles(&body, moved);
            body.elastic.energy(0.0, &p).elastic
        };
        // The energy is quadratic: central differences are exact.
        let derivative = (energy(0.5) - energy(-0.5)) / 1.0;
        assert_relative_eq!(derivative, -dot(&force, &direction), max_relative = 1e-11);
    }
}

#[test]
fn no_negative_eigenvalue_on_the_clamped_cube() {
    let mut body = clamped_cube(7, 1.25, 0.1, 0.3);
    let n = 3 * body.positions.len();
    let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
    let mut k = DMatrix::zeros(n, n);
    for j in 0..n {
        unit[j] = 1.0;
        body.elastic.force_of(&unit, &mut column);
        unit[j] = 0.0;
        for i in 0..n {
            k[(i, j)] = -column[i];
        }
    }
    let asymmetry = (&k - k.transpose()).amax() / k.amax();
    assert!(asymmetry < 1e-13, "asymmetry {asymmetry}");
    let eigenvalues = k.symmetric_eigenvalues();
    assert!(eigenvalues.min() > 0.0, "smallest eigenvalue {}", eigenvalues.min());
    // kappa dx^2 / c_p^2 of the prototype, numerics: 2.08.
    let mass = 1.0 / 343.0;
    let c2 = 100.0 * 0.7 / (1.3 * 0.4);
    let measured = eigenvalues.max() / mass / 49.0 / c2;
    assert!((measured - 2.08).abs() < 0.01, "K = {measured}");
    let lanczos = rsph_core::stability::largest_eigenvalue(&mut body.elastic) / 49.0 / c2;
    assert!((lanczos / measured - 1.0).abs() < 2e-3, "Lanczos {lanczos} for {measured}");
}

#[test]
fn internal_forces_of_a_free_body_have_no_resultant_and_no_moment() {
    let mut body = ball(1.25);
    let n = body.positions.len();
    let u = Noise(5).column(3 * n);
    let mut force = vec![0.0; 3 * n];
    body.elastic.force_of(&u, &mut force);
    let f = Column::from_vec(force, n);
    let scale: f64 = (0..n).map(|a| f.vector(a).norm()).sum();
    let total: Vec3 = (0..n).map(|a| f.vector(a)).sum();
    let moment: Vec3 = (0..n).map(|a| body.positions[a].cross(&f.vector(a))).sum();
    assert!(total.norm() < 1e-14 * scale);
    assert!(moment.norm() < 1e-13 * scale, "moment {} of {scale}", moment.norm());
}

#[test]
fn area_vectors_sum_to_the_area_of_a_face_and_vanish_inside() {
    let n = 15;
    let body = body([n; 3], 1.0 / n as f64, 1.25, 0.1, 0.3, vec![clamp()], |_| 1.0);
    let e = &body.elastic;
    let area = area_vectors(&e.lattice, &e.moments(), &e.mirror, &e.stretch);
    let column = |k: usize| area[(k * n + 7) * n + 7].z * (n * n) as f64;
    // Layers below a flat face at h = 1.25 dx: the prototype's 1.356, -.222, -.124, -.010.
    for (depth, expected) in [1.356, -0.222, -0.124, -0.010].into_iter().enumerate() {
        let measured = column(n - 1 - depth);
        assert!((measured - expected).abs() < 1e-3, "layer {depth}: {measured}");
    }
    // Six layers away from any face, a neighbour's neighbourhood is full.
    assert!(column(7).abs() < 1e-12);
    let near_top = |a: &usize| body.positions[*a].z > 1.0 - 6.0 / n as f64;
    let top: f64 = (0..body.positions.len()).filter(near_top).map(|a| area[a].z).sum();
    assert!((top - 1.0).abs() < 1e-3, "area of the top face {top}");
}

/// Extension of a clamped cube with E = 1 under unit traction at the top.
fn static_extension(n: usize, smoothing: f64, hourglass: f64, nu: f64) -> f64 {
    let mut body = clamped_cube(n, smoothing, hourglass, nu);
    let count = body.positions.len();
    let e = &body.elastic;
    let area = area_vectors(&e.lattice, &e.moments(), &e.mirror, &e.stretch);
    let depth = 3.3 * smoothing / n as f64;
    let share = |a: usize| if body.positions[a].z > 1.0 - depth { area[a].z } else { 0.0 };
    let sum: f64 = (0..count).map(share).sum();
    let mut load = vec![0.0; 3 * count];
    for a in 0..count {
        load[2 * count + a] = share(a) / sum;
    }
    let u = solve(&mut body.elastic, &load);
    let strain = body.elastic.strain(0.0, &u);
    let top = count - n * n..count;
    let half = 0.5 / n as f64;
    let mean = top.map(|a| u[2 * count + a] + half * strain[2 * count + a]).sum::<f64>();
    100.0 * mean / (n * n) as f64
}

#[test]
fn clamped_cube_stretches_like_finite_elements() {
    // FEM hex27: E u = 0.97055 +- 3e-5 at nu = 0.3; exactly 1 at nu = 0.
    for (n, smoothing, bound) in [(7, 1.25, 0.0105), (13, 1.25, 0.0055), (7, 0.8, 0.011), (13, 0.8, 0.0052)] {
        let error = static_extension(n, smoothing, 0.1, 0.3) / 0.97055 - 1.0;
        println!("{n}^3, h = {smoothing} dx: {:+.2} %", 100.0 * error);
        assert!(error.abs() < bound, "{n}^3, h = {smoothing} dx: {error}");
    }
    let error = static_extension(7, 1.25, 0.1, 0.0) - 1.0;
    assert!(error.abs() < 1e-3, "nu = 0: {error}");
}
