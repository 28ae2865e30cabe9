//! The operator under laws for any deformation: derivative of its energy, symmetric tangent, objective, exact for uniform
//! deformation, right at rest.

mod common;

use common::{Noise, TestBody, every_law, face, remeshed_body};
use nalgebra::Rotation3;
use rsph_core::boundary::surface_load::{SurfacePoint, Traction};
use rsph_core::dynamics::{Dynamics, Scales};
use rsph_core::material::{Law, Material};
use rsph_core::particles::{Column, Field, Particles};
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Boundary, Fix};
use rsph_core::shape::{BoxShape, DiscShape, RectangleShape, Shape, cut};
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A block with an oblique face, or a disc in the plane, with cut cells, and the outward normal of a plane that cuts it.
fn whole(dimension: usize) -> (Arc<dyn Shape>, Vec3) {
    if dimension == 2 {
        return (Arc::new(DiscShape::new(0.47, [0.55; 2]).unwrap()), -Vec3::new(1.0, 2.0, 0.0).normalize());
    }
    let block: Arc<dyn Shape> = Arc::new(BoxShape::new(Vec3::repeat(0.8), Vec3::repeat(0.15)).unwrap());
    let (point, normal) = (Vec3::new(0.8, 0.7, 0.75), Vec3::new(1.0, -0.4, 0.7).normalize());
    (cut(&block, &point, &normal, 1e-9).unwrap(), -Vec3::new(1.0, 2.0, 0.5).normalize())
}

/// A point of the plane that cuts the bodies.
fn point(dimension: usize) -> Vec3 {
    Vec3::new(0.4, 0.4, if dimension == 2 { 0.0 } else { 0.4 })
}

/// A displacement with gradients up to a quarter that vanishes on that plane.
fn bent(dimension: usize, x: &Vec3) -> Vec3 {
    let d = -whole(dimension).1.dot(&(x - point(dimension)));
    let u = Vec3::new(0.05 * d * x.y, 0.25 * d + 0.1 * d * x.z, -0.15 * d - 0.2 * d * d) * 0.8;
    if dimension == 2 { Vec3::new(u.x - 0.7 * u.z, u.y, 0.0) } else { u }
}

/// A body that is cut and clamped by an oblique plane, in space or in the plane, undeformed or remeshed where it was bent.
fn cut_body(material: &Arc<dyn Material>, smoothing: f64, dimension: usize, remeshed: bool) -> TestBody {
    let (shape, normal) = whole(dimension);
    let point = point(dimension);
    let shape = cut(&shape, &point, &normal, 1e-9).unwrap();
    let plane = Region::HalfSpace { point, normal: -normal };
    let boundaries = [Boundary { name: None, region: plane, fix: Fix::ALL, motion: None }];
    let spacing = Resolution::Spacing(if dimension == 2 { 0.1 } else { 0.15 });
    let moved = |x: &Vec3| bent(dimension, x);
    let moved = remeshed.then_some(&moved as &dyn Fn(&Vec3) -> Vec3);
    remeshed_body(Arc::clone(material), shape, spacing, (smoothing, 1.0), &boundaries, moved)
}

/// A block, or a rectangle, clamped below and on rollers at its side, both between layers of cells.
fn folded_body(material: &Arc<dyn Material>, smoothing: f64, dimension: usize, remeshed: bool) -> TestBody {
    let shape: Arc<dyn Shape> = match dimension {
        2 => Arc::new(RectangleShape::new([0.7; 2], [0.0; 2]).unwrap()),
        _ => Arc::new(BoxShape::new(Vec3::repeat(0.7), Vec3::zeros()).unwrap()),
    };
    let below = if dimension == 2 { Axis::Y } else { Axis::Z };
    let hold = |axis, fix| Boundary { name: None, region: face(axis, 0.0, Side::Below), fix, motion: None };
    let boundaries = [hold(below, Fix::ALL), hold(Axis::X, Fix::Normal)];
    let moved = |x: &Vec3| {
        let d = x[below as usize];
        let u = Vec3::new(0.3 * d * x.x, 0.2 * d - 0.2 * d * x.x, -0.1 * d + 0.1 * d * d);
        if dimension == 2 { Vec3::new(u.x, u.y, 0.0) } else { u }
    };
    let moved = remeshed.then_some(&moved as &dyn Fn(&Vec3) -> Vec3);
    let spacing = Resolution::Spacing(0.15);
    let body = remeshed_body(Arc::clone(material), shape, spacing, (smoothing, 1.0), &boundaries, moved);
    assert_eq!(body.solid.lift.folds.mirrors().len(), 2);
    body
}

/// How a body is held, its dimension, and whether it was remeshed.
type Kind = (fn(&Arc<dyn Material>, f64, usize, bool) -> TestBody, usize, bool);

fn held_block(material: &Arc<dyn Material>, smoothing: f64) -> TestBody {
    cut_body(material, smoothing, 3, false)
}

const KINDS: [Kind; 8] = [
    (cut_body, 3, false),
    (cut_body, 3, true),
    (cut_body, 2, false),
    (cut_body, 2, true),
    (folded_body, 3, false),
    (folded_body, 3, true),
    (folded_body, 2, false),
    (folded_body, 2, true),
];

const FREE_KINDS: [(usize, bool); 4] = [(3, false), (3, true), (2, false), (2, true)];

fn free_body(material: &Arc<dyn Material>, dimension: usize, remeshed: bool) -> TestBody {
    let moved = |x: &Vec3| bent(dimension, x);
    let moved = remeshed.then_some(&moved as &dyn Fn(&Vec3) -> Vec3);
    let spacing = Resolution::Spacing(if dimension == 2 { 0.1 } else { 0.15 });
    remeshed_body(Arc::clone(material), whole(dimension).0, spacing, (0.8, 1.0), &[], moved)
}

/// A displacement of a body that is bent and disturbed.
fn deformed(body: &TestBody, dimension: usize, seed: u64) -> Vec<f64> {
    let mut noise = Noise(seed);
    let mut u: Vec<Vec3> = body.positions.iter().map(|x| bent(dimension, x)).collect();
    for u in &mut u {
        *u += 0.02 * body.spacing * Vec3::from_fn(|i, _| if i < dimension { noise.next() } else { 0.0 });
    }
    Column::from_vectors(&u).values().to_vec()
}

#[test]
fn the_force_is_minus_the_derivative_of_the_energy() {
    for material in every_law(100.0) {
        let wide = [KINDS[0], KINDS[3], KINDS[5]].map(|kind| (1.25, kind));
        for (smoothing, (held_body, dimension, remeshed)) in
            KINDS.map(|kind| (0.8, kind)).into_iter().chain(wide)
        {
            let mut body = held_body(&material, smoothing, dimension, remeshed);
            let n = 3 * body.positions.len();
            let u = deformed(&body, dimension, 3);
            let mut direction = Noise(5).column(n);
            body.solid.fixed.zero(&mut direction, n / 3);
            let mut force = vec![0.0; n];
            body.solid.force_at_rest(0.0, 1.0, &u, &mut force);
            assert!(body.solid.inverted().is_none());
            let mut energy = |s: f64| {
                let moved: Vec<f64> = u.iter().zip(&direction).map(|(u, d)| u + s * d).collect();
                body.solid.elastic_energy(0.0, 1.0, &moved)
            };
            // Fourth order.
            let e = 2e-4;
            let slope = (8.0 * (energy(e) - energy(-e)) - (energy(2.0 * e) - energy(-2.0 * e))) / (12.0 * e);
            let work = -dot(&force, &direction);
            let name = material.name();
            let kind = format!("{name}, h = {smoothing}, {dimension}D, remeshed: {remeshed}");
            assert!((slope - work).abs() < 1e-8 * work.abs().max(1.0), "{kind}: {slope} {work}");
        }
    }
}

#[test]
fn the_tangent_is_the_derivative_of_the_force_and_symmetric() {
    for (material, (held_body, dimension, remeshed)) in
        every_law(100.0).into_iter().flat_map(|m| KINDS.map(|k| (Arc::clone(&m), k)))
    {
        let mut body = held_body(&material, 0.8, dimension, remeshed);
        let n = 3 * body.positions.len();
        let u = deformed(&body, dimension, 3);
        let (mut x, mut y) = (Noise(7).column(n), Noise(11).column(n));
        body.solid.fixed.zero(&mut x, n / 3);
        body.solid.fixed.zero(&mut y, n / 3);
        body.solid.linearise(0.0, &u);
        let (mut kx, mut ky) = (vec![0.0; n], vec![0.0; n]);
        body.solid.apply(Scales::STATIC, &x, &mut kx);
        body.solid.apply(Scales::STATIC, &y, &mut ky);
        let (xy, yx) = (dot(&kx, &y), dot(&ky, &x));
        assert!((xy - yx).abs() < 1e-12 * dot(&kx, &kx).sqrt() * dot(&y, &y).sqrt(), "{}", material.name());
        let mut force = |s: f64| {
            let moved: Vec<f64> = u.iter().zip(&x).map(|(u, d)| u + s * d).collect();
            let mut force = vec![0.0; n];
            body.solid.force_at_rest(0.0, 1.0, &moved, &mut force);
            force
        };
        // So small that hardly a fibre gets slack on the way.
        let e = 1e-7;
        let (plus, minus) = (force(e), force(-e));
        let change: Vec<f64> = plus.iter().zip(&minus).map(|(p, m)| (m - p) / (2.0 * e)).collect();
        let error: Vec<f64> = change.iter().zip(&kx).map(|(c, k)| c - k).collect();
        let error = dot(&error, &error).sqrt() / dot(&kx, &kx).sqrt();
        assert!(error < 1e-6, "{}: {error}", material.name());
    }
}

#[test]
fn damping_is_the_derivative_of_the_force_by_the_velocity() {
    for material in every_law(100.0) {
        let mut body = held_block(&material, 0.8);
        let n = body.positions.len();
        let u = deformed(&body, 3, 3);
        let v = Noise(13).column(3 * n);
        let mut acceleration = |s: f64| {
            let mut p = Particles::new(n);
            p.set(Field::Displacement, Column::from_vec(u.clone(), n));
            p.set(Field::Velocity, Column::from_vec(v.iter().map(|v| v * s).collect(), n));
            let mut rates = [Column::zeros(3, n), Column::zeros(3, n)];
            body.solid.rates(0.0, &p, &mut rates);
            rates[1].values().to_vec()
        };
        let (moving, still) = (acceleration(1.0), acceleration(0.0));
        body.solid.linearise(0.0, &u);
        let mut damping = vec![0.0; 3 * n];
        body.solid.apply(Scales { damping: 1.0, ..Scales::default() }, &v, &mut damping);
        let mass = &body.solid.mass;
        let error: f64 =
            (0..3 * n).map(|k| ((moving[k] - still[k]) * mass[k % n] + damping[k]).powi(2)).sum();
        assert!(error.sqrt() < 1e-9 * dot(&damping, &damping).sqrt(), "{}: {error}", material.name());
    }
}

#[test]
fn a_turned_body_is_free_of_force_and_strain() {
    let laws = || every_law(100.0).into_iter().filter(|m| m.law().finite_strain().is_some());
    for (material, (dimension, remeshed)) in laws().flat_map(|m| FREE_KINDS.map(|k| (Arc::clone(&m), k))) {
        let axis = if dimension == 2 { Vec3::new(0.0, 0.0, 2.0) } else { Vec3::new(0.3, -1.2, 2.0) };
        let turn = *Rotation3::new(axis).matrix();
        let mut body = free_body(&material, dimension, remeshed);
        let n = body.positions.len();
        let turned = |u: &[Vec3]| -> Vec<Vec3> {
            body.positions.iter().zip(u).map(|(x, u)| turn * (x + u) + Vec3::x() - x).collect()
        };
        let column = |u: &[Vec3]| Column::from_vectors(u);
        let still = column(&turned(&vec![Vec3::zeros(); n]));
        let u = deformed(&body, dimension, 17);
        let u: Vec<Vec3> = (0..n).map(|a| Vec3::new(u[a], u[n + a], u[2 * n + a])).collect();
        let (u, turned_u) = (column(&u), column(&turned(&u)));
        let kind = format!("{}, {dimension}D, remeshed: {remeshed}", material.name());

        let mut force = vec![0.0; 3 * n];
        body.solid.force_at_rest(0.0, 1.0, still.values(), &mut force);
        assert!(force.iter().all(|f| f.abs() < 1e-11), "{kind}");
        assert!(body.solid.elastic_energy(0.0, 1.0, still.values()).abs() < 1e-11, "{kind}");
        let mut p = Particles::new(n);
        p.set(Field::Displacement, still);
        p.set(Field::Velocity, Column::zeros(3, n));
        p.set(Field::Volume, Column::from_vec(vec![1.0; n], n));
        body.solid.derive(0.0, &mut p);
        assert!(p.column(Field::Strain).values().iter().all(|e| e.abs() < 1e-11), "{kind}");

        // Deformed as well: the same energy, turned forces, without a moment.
        let energy = body.solid.elastic_energy(0.0, 1.0, u.values());
        let again = body.solid.elastic_energy(0.0, 1.0, turned_u.values());
        assert!(energy > 1e-3 && (again - energy).abs() < 1e-11 * energy, "{kind}: {energy} {again}");
        let mut turned_force = force.clone();
        body.solid.force_at_rest(0.0, 1.0, u.values(), &mut force);
        body.solid.force_at_rest(0.0, 1.0, turned_u.values(), &mut turned_force);
        let at = |f: &[f64], a: usize| Vec3::new(f[a], f[n + a], f[2 * n + a]);
        let size = dot(&force, &force).sqrt();
        let (mut total, mut moment) = (Vec3::zeros(), Vec3::zeros());
        for a in 0..n {
            let f = at(&turned_force, a);
            assert!((turn * at(&force, a) - f).norm() < 1e-11 * size, "{kind}");
            total += f;
            moment += (body.positions[a] + turned_u.vector(a)).cross(&f);
        }
        assert!(total.norm() < 1e-11 * size && moment.norm() < 1e-11 * size, "{kind}: {total} {moment}");
    }
}

#[test]
fn a_uniform_deformation_balances_its_nominal_tractions() {
    let f = Mat3::new(1.3, 0.2, -0.1, 0.05, 0.85, 0.15, -0.2, 0.1, 1.1);
    for material in every_law(100.0) {
        let Law::FiniteStrain(law) = material.law() else { continue };
        let mut body = free_body(&material, 3, false);
        let n = body.positions.len();
        let u: Vec<Vec3> = body.positions.iter().map(|x| f * x - x).collect();
        let mut force = vec![0.0; 3 * n];
        body.solid.force_at_rest(0.0, 1.0, Column::from_vectors(&u).values(), &mut force);
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
