//! The operator under laws for any deformation: derivative of its energy, symmetric tangent, objective, exact for uniform
//! deformation, right at rest.

mod common;

use common::{Noise, TestBody, body_of, every_law};
use nalgebra::Rotation3;
use rsph_core::boundary::surface_load::{SurfacePoint, Traction};
use rsph_core::dynamics::{Dynamics, Scales};
use rsph_core::material::{Law, Material};
use rsph_core::particles::{Column, Field, Particles};
use rsph_core::region::Region;
use rsph_core::sample::Resolution;
use rsph_core::setup::{Boundary, Fix};
use rsph_core::shape::{Shape, SphereShape, cut};
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A ball that is cut and clamped by an oblique plane.
fn held_ball(material: &Arc<dyn Material>, smoothing: f64) -> TestBody {
    let ball: Arc<dyn Shape> = Arc::new(SphereShape::new(0.47, Vec3::repeat(0.55)).unwrap());
    let (point, normal) = (Vec3::repeat(0.4), -Vec3::new(1.0, 2.0, 0.5).normalize());
    let shape = cut(&ball, &point, &normal, 1e-9).unwrap();
    let plane = Region::HalfSpace { point, normal: -normal };
    let boundaries = [Boundary { region: plane, fix: Fix::ALL, motion: None }];
    body_of(Some(Arc::clone(material)), shape, Resolution::Spacing(0.15), smoothing, 1.0, 0.3, &boundaries)
}

fn free_ball(material: &Arc<dyn Material>) -> TestBody {
    let ball = Arc::new(SphereShape::new(0.47, Vec3::repeat(0.55)).unwrap());
    body_of(Some(Arc::clone(material)), ball, Resolution::Spacing(0.15), 0.8, 1.0, 0.3, &[])
}

/// A displacement with gradients up to a quarter, and noise, which vanishes on the clamp of [`held_ball`].
fn deformed(body: &TestBody, seed: u64) -> Vec<f64> {
    let mut noise = Noise(seed);
    let normal = Vec3::new(1.0, 2.0, 0.5).normalize();
    let mut u: Vec<Vec3> = body
        .positions
        .iter()
        .map(|x| {
            let d = normal.dot(&(x - Vec3::repeat(0.4)));
            Vec3::new(0.05 * d * x.y, 0.25 * d + 0.1 * d * x.z, -0.15 * d - 0.2 * d * d) * 0.8
        })
        .collect();
    for u in &mut u {
        *u += 0.02 * body.spacing * Vec3::from_fn(|_, _| noise.next());
    }
    Column::from_vectors(&u).values().to_vec()
}

#[test]
fn the_force_is_minus_the_derivative_of_the_energy() {
    for material in every_law(100.0) {
        for smoothing in [0.8, 1.25] {
            let mut body = held_ball(&material, smoothing);
            let n = 3 * body.positions.len();
            let u = deformed(&body, 3);
            let direction = Noise(5).column(n);
            let mut force = vec![0.0; n];
            body.elastic.force_at_rest(0.0, 1.0, &u, &mut force);
            assert!(body.elastic.inverted().is_none());
            let mut energy = |s: f64| {
                let moved: Vec<f64> = u.iter().zip(&direction).map(|(u, d)| u + s * d).collect();
                body.elastic.elastic_energy(0.0, 1.0, &moved)
            };
            // Fourth order.
            let e = 2e-4;
            let slope = (8.0 * (energy(e) - energy(-e)) - (energy(2.0 * e) - energy(-2.0 * e))) / (12.0 * e);
            let work = -dot(&force, &direction);
            assert!((slope - work).abs() < 1e-8 * work.abs().max(1.0), "{}: {slope} {work}", material.name());
        }
    }
}

#[test]
fn the_tangent_is_the_derivative_of_the_force_and_symmetric() {
    for material in every_law(100.0) {
        let mut body = held_ball(&material, 0.8);
        let n = 3 * body.positions.len();
        let u = deformed(&body, 3);
        let (mut x, mut y) = (Noise(7).column(n), Noise(11).column(n));
        for p in &body.elastic.fixed.particles.clone() {
            for i in 0..3 {
                (x[i * n / 3 + p.particle], y[i * n / 3 + p.particle]) = (0.0, 0.0);
            }
        }
        body.elastic.linearise(0.0, &u);
        let (mut kx, mut ky) = (vec![0.0; n], vec![0.0; n]);
        body.elastic.apply(Scales::STATIC, &x, &mut kx);
        body.elastic.apply(Scales::STATIC, &y, &mut ky);
        let (xy, yx) = (dot(&kx, &y), dot(&ky, &x));
        assert!((xy - yx).abs() < 1e-12 * dot(&kx, &kx).sqrt() * dot(&y, &y).sqrt(), "{}", material.name());
        let mut force = |s: f64| {
            let moved: Vec<f64> = u.iter().zip(&x).map(|(u, d)| u + s * d).collect();
            let mut force = vec![0.0; n];
            body.elastic.force_at_rest(0.0, 1.0, &moved, &mut force);
            force
        };
        let e = 1e-5;
        let (plus, minus) = (force(e), force(-e));
        let change: Vec<f64> = plus.iter().zip(&minus).map(|(p, m)| (m - p) / (2.0 * e)).collect();
        let error: Vec<f64> = change.iter().zip(&kx).map(|(c, k)| c - k).collect();
        assert!(dot(&error, &error).sqrt() < 1e-6 * dot(&kx, &kx).sqrt(), "{}", material.name());
    }
}

#[test]
fn damping_is_the_derivative_of_the_force_by_the_velocity() {
    for material in every_law(100.0) {
        let mut body = held_ball(&material, 0.8);
        let n = body.positions.len();
        let u = deformed(&body, 3);
        let v = Noise(13).column(3 * n);
        let mut acceleration = |s: f64| {
            let mut p = Particles::new(n);
            p.set(Field::Displacement, Column::from_vec(u.clone(), n));
            p.set(Field::Velocity, Column::from_vec(v.iter().map(|v| v * s).collect(), n));
            let mut rates = [Column::zeros(3, n), Column::zeros(3, n)];
            body.elastic.rates(0.0, &p, &mut rates);
            rates[1].values().to_vec()
        };
        let (moving, still) = (acceleration(1.0), acceleration(0.0));
        body.elastic.linearise(0.0, &u);
        let mut damping = vec![0.0; 3 * n];
        body.elastic.apply(Scales { damping: 1.0, ..Scales::default() }, &v, &mut damping);
        let mass = &body.elastic.mass;
        let error: f64 =
            (0..3 * n).map(|k| ((moving[k] - still[k]) * mass[k % n] + damping[k]).powi(2)).sum();
        assert!(error.sqrt() < 1e-9 * dot(&damping, &damping).sqrt(), "{}: {error}", material.name());
    }
}

#[test]
fn a_turned_body_is_free_of_force_and_strain() {
    let turn = *Rotation3::new(Vec3::new(0.3, -1.2, 2.0)).matrix();
    for material in every_law(100.0).into_iter().filter(|m| m.law().finite_strain().is_some()) {
        let mut body = free_ball(&material);
        let n = body.positions.len();
        let u: Vec<Vec3> = body.positions.iter().map(|x| turn * x + Vec3::x() - x).collect();
        let u = Column::from_vectors(&u);
        let mut force = vec![0.0; 3 * n];
        body.elastic.force_at_rest(0.0, 1.0, u.values(), &mut force);
        assert!(force.iter().all(|f| f.abs() < 1e-11), "{}", material.name());
        assert!(body.elastic.elastic_energy(0.0, 1.0, u.values()).abs() < 1e-11);
        let mut p = Particles::new(n);
        p.set(Field::Displacement, u);
        p.set(Field::Velocity, Column::zeros(3, n));
        p.set(Field::Volume, Column::from_vec(vec![1.0; n], n));
        body.elastic.derive(0.0, &mut p);
        assert!(p.column(Field::Strain).values().iter().all(|e| e.abs() < 1e-11));
    }
}

#[test]
fn a_uniform_deformation_balances_its_nominal_tractions() {
    let f = Mat3::new(1.3, 0.2, -0.1, 0.05, 0.85, 0.15, -0.2, 0.1, 1.1);
    for material in every_law(100.0) {
        let Law::FiniteStrain(law) = material.law() else { continue };
        let mut body = free_ball(&material);
        let n = body.positions.len();
        let u: Vec<Vec3> = body.positions.iter().map(|x| f * x - x).collect();
        let mut force = vec![0.0; 3 * n];
        body.elastic.force_at_rest(0.0, 1.0, Column::from_vectors(&u).values(), &mut force);
        let piola = law.first_piola(&f);
        let traction = |p: &SurfacePoint| piola * p.normal;
        let traction =
            Traction { at: &traction, reaches: &|_| true, resolution: &|_, _| f64::INFINITY, smooth: 0.0 };
        let load = body.surface.force(n, &traction).unwrap();
        let error: f64 = (0..3 * n).map(|k| (force[k] + load[k]).powi(2)).sum();
        let size = dot(&load, &load).sqrt();
        assert!(error.sqrt() < 2e-4 * size, "{}: {}", material.name(), error.sqrt() / size);
    }
}
