//! Bodies at rest under laws for any deformation.

use nalgebra::Rotation3;
use rsph_core::material::NeoHookean;
use rsph_core::particles::Field;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Boundary, Curve, Fix, Load, LoadKind, Probe, Quantity, Setup, SolidSetup, Solver, Units,
};
use rsph_core::shape::{BoxShape, MeshShape, Shape};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// The clamped cube of E = 10, turned by 30 degrees about y and shifted against its lattice, under a dead load at its head.
fn turned_cube(n: usize, nu: f64, load: f64) -> Simulation {
    let turn = Rotation3::from_axis_angle(&Vec3::y_axis(), 30.0_f64.to_radians());
    let shift = Vec3::new(0.13, 0.71, 0.37) / n as f64;
    let mut mesh = BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap().surface().clone();
    mesh.vertices.iter_mut().for_each(|x| *x = turn * *x + shift);
    let up = turn * Vec3::z();
    let beyond = |point: Vec3, out: Vec3| Region::HalfSpace { point, normal: -out };
    let kind = LoadKind::Traction { region: beyond(shift + up, up), traction: load * up };
    Simulation::new(Setup {
        units: Units::Normalised,
        solver: Solver::ACCURATE,
        ..Setup::new(
            Arc::new(MeshShape::new(&mesh, "turned").unwrap().0),
            Resolution::Spacing(1.0 / n as f64),
            SolidSetup {
                foundations: Vec::new(),
                material: Arc::new(NeoHookean::new(1.0, 10.0, nu, 0.0).unwrap()),
                boundaries: vec![Boundary {
                    name: None,
                    region: beyond(shift, -up),
                    fix: Fix::ALL,
                    motion: None,
                }],
                loads: vec![Load { kind, curve: Curve::ramp(0.0, 1.0) }],
            },
        )
    })
    .unwrap()
}

/// Extension at load 3, relative to mixed finite elements (validation/large_strain/cube_mixed.csv).
#[test]
fn a_nearly_incompressible_cube_stretches_like_finite_elements() {
    for (nu, extension) in [(0.3, 0.363180), (0.49, 0.363168), (0.499, 0.362924)] {
        let mut cube = turned_cube(7, nu, 3.0);
        let found = cube.solve_static(1.0, &mut |_, _| true).unwrap();
        let error = found.compliance / found.load.norm() / extension - 1.0;
        println!("nu = {nu}: {:.3} %, {} steps, {} iterations", 100.0 * error, found.steps, found.iterations);
        assert!(error.abs() < 7e-3, "nu = {nu}: {error}");
        assert!(found.residual < 2e-6 && (found.reaction + found.load).norm() < 1e-5);
    }
}

/// A slender cantilever under an end load P with P L^2 / (E I) = 2, under which an inextensible rod moves by 0.4935 L across and
/// its end by 0.1606 L back (Bisshopp and Drucker, Q. Appl. Math. 3, 1945).
#[test]
fn a_rod_bends_far_without_false_strain() {
    let (length, edge, young_modulus) = (10.0_f64, 1.0_f64, 1200.0);
    let force = 2.0 * young_modulus * edge.powi(4) / 12.0 / (length * length);
    let plane = |at: f64, side: Side| Region::Plane { axis: Axis::X, at, side };
    for model in ["corotated", "neo-hookean", "st-venant-kirchhoff"] {
        let value = |key: &str| {
            Some(vec![match key {
                "density" => 1.0,
                "young_modulus" => young_modulus,
                "poisson_ratio" => 0.3,
                _ => 0.0,
            }])
        };
        let material = rsph_core::material::model(model).unwrap().make(value);
        let end = plane(length, Side::Above);
        let kind = LoadKind::Traction { region: end.clone(), traction: force / (edge * edge) * Vec3::z() };
        let probe = Probe {
            name: "end".into(),
            quantity: Quantity { field: Field::Displacement, component: None },
            region: end,
        };
        let mut rod = Simulation::new(Setup {
            units: Units::Normalised,
            solver: Solver::ACCURATE,
            probes: vec![probe],
            ..Setup::new(
                Arc::new(BoxShape::new(Vec3::new(length, edge, edge), Vec3::zeros()).unwrap()),
                Resolution::Spacing(edge / 6.0),
                SolidSetup {
                    foundations: Vec::new(),
                    material: material.unwrap(),
                    boundaries: vec![Boundary {
                        name: None,
                        region: plane(0.0, Side::Below),
                        fix: Fix::ALL,
                        motion: None,
                    }],
                    loads: vec![Load { kind, curve: Curve::default() }],
                },
            )
        })
        .unwrap();
        rod.solve_static(1.0, &mut |_, _| true).unwrap();
        let end: Vec<f64> = rod.readings().iter().map(|r| r.value / length).collect();
        println!("{model}: {end:?}");
        assert!((end[2] / 0.4935 - 1.0).abs() < 0.03, "{model}: {end:?}");
        assert!((end[0] / -0.1606 - 1.0).abs() < 0.06, "{model}: {end:?}");
    }
}

/// The stiffness is that of the present state, whatever Newton's method went through on its way there.
#[test]
fn the_stiffness_is_the_tangent_of_the_moment() {
    let mut cube = turned_cube(5, 0.49, 3.0);
    let n = cube.particles().len();
    let x: Vec<f64> = (0..3 * n).map(|k| (k as f64).sin()).collect();
    let undeformed = cube.stiffness(&x).unwrap();
    cube.solve_static(1.0, &mut |_, _| true).unwrap();
    let mut other = turned_cube(5, 0.49, 3.0);
    other.set_state(&cube.state()).unwrap();
    let deformed = cube.stiffness(&x).unwrap();
    assert_eq!(deformed, other.stiffness(&x).unwrap());
    let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    let change: Vec<f64> = deformed.iter().zip(&undeformed).map(|(a, b)| a - b).collect();
    assert!(norm(&change) > 0.1 * norm(&undeformed));
}
