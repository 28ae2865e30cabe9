//! The solid at large strain: its force is the derivative of its energy, also after a remesh, and rotations
//! are free.

mod common;

use common::Noise;
use rsph_core::boundary::mirror::MirrorPlane;
use rsph_core::dynamics::large_strain::LargeStrain;
use rsph_core::dynamics::large_strain::configuration::Configuration;
use rsph_core::dynamics::large_strain::ghosts::Ghosts;
use rsph_core::material::NeoHookean;
use rsph_core::setup::{Motion, Ramp};
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// n^D particles of the unit cube with their volumes, the reference positions given by a map.
fn body<const D: usize>(
    n: usize,
    planes: &[MirrorPlane],
    reference: impl Fn(&Vec3) -> Vec3,
) -> LargeStrain<D> {
    let dx = 1.0 / n as f64;
    let centre = |i: usize| (i as f64 + 0.5) * dx;
    let layers = if D == 2 { 1 } else { n };
    let nodes: Vec<Vec3> = (0..layers * n * n)
        .map(|q| {
            let z = if D == 2 { 0.0 } else { centre(q / n / n) };
            Vec3::new(centre(q % n), centre(q / n % n), z)
        })
        .collect();
    let mut noise = Noise(5);
    let volume = nodes.iter().map(|_| (1.0 + 0.5 * noise.next()) * dx.powi(D as i32)).collect();
    let x0 = nodes.iter().map(reference).collect();
    let h = 1.25 * dx;
    let ghosts = Ghosts::new(planes, 0.5, &nodes, 2.5 * h);
    let configuration = Configuration::<D>::new(nodes, x0, volume, ghosts, h);
    LargeStrain::new(configuration, Arc::new(NeoHookean::new(1.0, 10.0, 0.3, 0.2).unwrap()), 0.2).unwrap()
}

/// A smooth strain as a remesh would leave it; zero at the clamp of the last axis.
fn strained<const D: usize>(x: &Vec3) -> Vec3 {
    let s = x[D - 1];
    let mut y = *x;
    y[0] += 0.15 * s * (2.0 * x[1]).sin();
    y[1] -= 0.1 * s * x[0];
    y[D - 1] *= 0.8 + 0.1 * x[0];
    y
}

fn clamp<const D: usize>() -> MirrorPlane {
    MirrorPlane { axis: D - 1, at: 0.0, fix: [true; 3], motion: None }
}

fn plate<const D: usize>() -> MirrorPlane {
    let mut displacement = Vec3::zeros();
    displacement[0] = 0.1;
    displacement[D - 1] = 0.2;
    let motion = Motion::Ramp { displacement, ramp: Ramp { from: 0.0, to: 0.5 } };
    // The lattice ends at 1, so the plate has come from 0.8.
    MirrorPlane { axis: D - 1, at: 0.8, fix: [true; 3], motion: Some(motion) }
}

fn disturbed<const D: usize>(body: &LargeStrain<D>, size: f64, noise: &mut Noise) -> Vec<Vec3> {
    let mut field = |scale: f64| Vec3::from_fn(|i, _| if i < D { scale * noise.next() } else { 0.0 });
    body.configuration.nodes[..body.len()].iter().map(|xi| xi + field(size)).collect()
}

fn force_is_the_derivative<const D: usize>(planes: &[MirrorPlane], n: usize) {
    let mut body = body::<D>(n, planes, strained::<D>);
    let mut noise = Noise(11);
    let x = disturbed(&body, 0.1 / n as f64, &mut noise);
    let d: Vec<Vec3> = disturbed(&body, 1.0, &mut noise)
        .iter()
        .zip(&body.configuration.nodes)
        .map(|(x, xi)| x - xi)
        .collect();
    let mut force = vec![Vec3::zeros(); x.len()];
    let mut scratch = force.clone();
    let t = 0.45;
    // A difference of fourth order: the step is large enough for rounding not to matter.
    let e = 2e-4 / n as f64;
    let mut at = |k: f64| {
        let moved: Vec<Vec3> = x.iter().zip(&d).map(|(x, d)| x + k * e * d).collect();
        body.elastic_force(t, &moved, &mut scratch)
    };
    let slope = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * e);
    let energy = body.elastic_force(t, &x, &mut force);
    assert!(energy.is_finite() && energy > 0.0);
    let work: f64 = force.iter().zip(&d).map(|(f, d)| f.dot(d)).sum();
    let scale: f64 = force.iter().map(Vec3::norm).sum();
    assert!((slope + work).abs() < 1e-9 * scale, "{} {}", slope + work, scale);
    // The tangent is the derivative of the force.
    let mut tangent = vec![Vec3::zeros(); x.len()];
    body.tangent_force(&d, &mut tangent);
    let (mut up, mut down) = (force.clone(), force.clone());
    let moved = |k: f64| x.iter().zip(&d).map(|(x, d)| x + k * e * d).collect::<Vec<_>>();
    body.elastic_force(t, &moved(1.0), &mut up);
    body.elastic_force(t, &moved(-1.0), &mut down);
    let largest = tangent.iter().map(Vec3::norm).fold(0.0, f64::max);
    for a in 0..x.len() {
        assert!(((up[a] - down[a]) / (2.0 * e) - tangent[a]).norm() < 1e-5 * largest);
    }
}

#[test]
fn force_is_minus_the_derivative_of_the_energy() {
    force_is_the_derivative::<2>(&[], 8);
    force_is_the_derivative::<2>(&[clamp::<2>(), plate::<2>()], 8);
    force_is_the_derivative::<3>(&[clamp::<3>()], 6);
    force_is_the_derivative::<3>(&[clamp::<3>(), plate::<3>()], 6);
}

#[test]
fn affine_deformation_is_exact_and_a_rotation_is_free() {
    let turn = nalgebra::Rotation3::new(Vec3::new(0.3, -0.4, 1.0));
    let stretch = Mat3::new(1.3, 0.2, 0.0, 0.0, 0.9, -0.1, 0.1, 0.0, 0.8);
    let affine = Mat3::new(1.1, 0.1, 0.0, -0.2, 0.8, 0.0, 0.0, 0.1, 1.2);
    let inverse = affine.try_inverse().unwrap();
    let mut body = body::<3>(5, &[], |x| inverse * x);
    // Stretched since then: F is the product, whatever the volumes.
    let x: Vec<Vec3> = body.configuration.nodes.iter().map(|xi| stretch * xi).collect();
    let mut force = vec![Vec3::zeros(); x.len()];
    let energy = body.elastic_force(0.0, &x, &mut force);
    for f in body.deformation() {
        assert!((f - stretch * affine).norm() < 1e-11);
    }
    // Turned: the same energy, turned forces, none of them in sum nor in moment.
    let turned: Vec<Vec3> = x.iter().map(|x| turn * x).collect();
    let mut turned_force = force.clone();
    let again = body.elastic_force(0.0, &turned, &mut turned_force);
    assert!((again - energy).abs() < 1e-11 * energy);
    for (f, g) in force.iter().zip(&turned_force) {
        assert!((turn * f - g).norm() < 1e-11);
    }
    let moment: Vec3 = turned.iter().zip(&turned_force).map(|(x, f)| x.cross(f)).sum();
    assert!(turned_force.iter().sum::<Vec3>().norm() < 1e-11 && moment.norm() < 1e-11);
    // Back where it was before the deformation: no force at all.
    let back: Vec<Vec3> = body.configuration.reference.iter().map(|x0| turn * x0).collect();
    assert!(body.elastic_force(0.0, &back, &mut force).abs() < 1e-13);
    assert!(force.iter().all(|f| f.norm() < 1e-11));
}

#[test]
fn far_from_the_origin_forces_stay_and_still_sum_up_to_nothing() {
    let mut body = body::<3>(6, &[], strained::<3>);
    let x = disturbed(&body, 0.02, &mut Noise(7));
    let mut near = vec![Vec3::zeros(); x.len()];
    body.elastic_force(0.0, &x, &mut near);
    let scale: f64 = near.iter().map(Vec3::norm).sum();
    // A place 10^4 away has lost four digits, and a stiffness over a spacing two or three more; but what a pair
    // does to one particle it does to the other.
    let away: Vec<Vec3> = x.iter().map(|x| x + Vec3::new(1e4, -2e4, 3e4)).collect();
    let mut far = near.clone();
    body.elastic_force(0.0, &away, &mut far);
    let change: f64 = near.iter().zip(&far).map(|(f, g)| (f - g).norm()).sum();
    assert!(change < 1e-8 * scale, "{:.1e}", change / scale);
    for force in [&near, &far] {
        let sum = force.iter().sum::<Vec3>().norm();
        assert!(sum < 1e-13 * scale, "{:.1e}", sum / scale);
    }
}
