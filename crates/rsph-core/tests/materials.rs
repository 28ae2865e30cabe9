//! Bodies of several materials: force and tangent as derivatives of the energy, and bars whose solution is exact.

mod common;

use common::{Made, Noise, TestBody, face, remeshed_body};
use rsph_core::dynamics::Scales;
use rsph_core::material::{Composition, Interface, KelvinVoigt, Material, NeoHookean};
use rsph_core::particles::Field;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Boundary, Curve, Fix, Load, LoadKind, MaterialPart, ModulusField, Motion, Probe, Quantity, Setup,
    SolidSetup, Units, VectorField,
};
use rsph_core::shape::BoxShape;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn linear(e: f64, nu: f64, t: f64) -> Arc<dyn Material> {
    Arc::new(KelvinVoigt::new(1.0, e, nu, t).unwrap())
}

fn rubber(e: f64, nu: f64) -> Arc<dyn Material> {
    Arc::new(NeoHookean::new(1.0, e, nu, 0.1).unwrap())
}

/// Two materials on the two sides of an oblique plane, their moduli growing along x.
fn oblique(x: &Vec3, spacing: f64) -> Composition {
    let turn = |angle: f64| *nalgebra::Rotation3::from_axis_angle(&Vec3::z_axis(), angle).matrix();
    let turns = Some([turn(x.y), turn(2.0 * x.x)]);
    let normal = Vec3::new(1.0, 0.5, -0.7).normalize();
    let share = 0.5 - (x - Vec3::repeat(0.37)).dot(&normal) / spacing;
    let factors = [1.0 + x.x; 2];
    match share {
        s if s >= 1.0 => Composition { factors, turns, ..Composition::pure(0, 1.0) },
        s if s <= 0.0 => Composition { factors, turns, ..Composition::pure(1, 1.0) },
        s if s >= 0.5 => Composition {
            materials: [0, 1],
            factors,
            turns: None,
            interface: Some(Interface { share: s, normal }),
        },
        s => {
            let interface = Interface { share: 1.0 - s, normal: -normal };
            Composition { materials: [1, 0], factors, turns, interface: Some(interface) }
        }
    }
}

/// A block on a clamp with a roller at its side, both between layers of cells or cut by them, undeformed or remeshed where it was bent.
fn body(materials: Vec<Arc<dyn Material>>, at: f64, remeshed: bool) -> TestBody {
    let shape = Arc::new(BoxShape::new(Vec3::repeat(0.7), Vec3::repeat(at)).unwrap());
    let hold = |axis, fix| Boundary { name: None, region: face(axis, at, Side::Below), fix, motion: None };
    let boundaries = [hold(Axis::Z, Fix::ALL), hold(Axis::X, Fix::Normal)];
    let moved = |x: &Vec3| {
        let (d, x) = (x.z - at, x.x - at);
        Vec3::new(0.3 * d * x, 0.2 * d - 0.2 * d * x, -0.1 * d + 0.1 * d * d)
    };
    let moved = remeshed.then_some(&moved as &dyn Fn(&Vec3) -> Vec3);
    let made = Made { materials, cell: Some(oblique) };
    remeshed_body(made, shape, Resolution::Spacing(0.15), (0.8, 1.0), &boundaries, moved)
}

/// The pair of laws with fibres.
const FIBRES: usize = 0;

fn pairs() -> [Vec<Arc<dyn Material>>; 4] {
    [
        vec![with_fibres([1.0, 0.0, 0.0]), with_fibres([0.0, 1.0, 0.0])],
        vec![linear(100.0, 0.3, 0.1), linear(1000.0, 0.45, 0.1)],
        vec![rubber(100.0, 0.45), rubber(1000.0, 0.3)],
        vec![rubber(100.0, 0.3), linear(1000.0, 0.3, 0.3)],
    ]
}

#[test]
fn force_is_minus_the_derivative_of_the_energy_and_the_tangent_that_of_the_force() {
    for (k, materials) in pairs().into_iter().enumerate() {
        for (at, remeshed) in [(0.0, false), (0.05, false), (0.0, true)] {
            let mut body = body(materials.clone(), at, remeshed);
            let n = 3 * body.positions.len();
            let mut noise = Noise(3);
            let mut u: Vec<f64> = noise.column(n).iter().map(|x| 0.03 * body.spacing * x).collect();
            for (a, x) in body.positions.iter().enumerate() {
                u[2 * n / 3 + a] += 0.1 * (x.z - at) * x.x;
                if k == FIBRES {
                    // Stretched everywhere: a fibre that gives way has a kink.
                    (u[a], u[n / 3 + a]) = (u[a] + 0.4 * x.x, u[n / 3 + a] + 0.4 * x.y);
                }
            }
            let mut direction = noise.column(n);
            body.solid.fixed.zero(&mut direction, n / 3);
            let mut force = vec![0.0; n];
            body.solid.force_at_rest(0.0, 1.0, &u, &mut force);
            let along = |s: f64| -> Vec<f64> { u.iter().zip(&direction).map(|(u, d)| u + s * d).collect() };
            let e = 2e-4;
            let mut energy = |s: f64| body.solid.elastic_energy(0.0, 1.0, &along(s));
            let slope = (8.0 * (energy(e) - energy(-e)) - (energy(2.0 * e) - energy(-2.0 * e))) / (12.0 * e);
            let work = -dot(&force, &direction);
            assert!((slope / work - 1.0).abs() < 1e-8, "{k} {at} {remeshed}: {slope} {work}");

            body.solid.linearise(0.0, &u);
            let (mut change, mut after, mut before) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
            body.solid.apply(Scales::STATIC, &direction, &mut change);
            let e = 1e-6;
            body.solid.force_at_rest(0.0, 1.0, &along(e), &mut after);
            body.solid.force_at_rest(0.0, 1.0, &along(-e), &mut before);
            let mut found: Vec<f64> = after.iter().zip(&before).map(|(a, b)| -(a - b) / (2.0 * e)).collect();
            body.solid.fixed.zero(&mut found, n / 3);
            let off = found.iter().zip(&change).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let size = change.iter().map(|c| c.abs()).fold(0.0, f64::max);
            assert!(off < 1e-6 * size, "{k} {at} {remeshed}: {off} {size}");
        }
    }
}

#[test]
fn the_same_material_twice_is_that_material() {
    let shape = Arc::new(BoxShape::new(Vec3::repeat(0.7), Vec3::zeros()).unwrap());
    let clamp =
        [Boundary { name: None, region: face(Axis::Z, 0.0, Side::Below), fix: Fix::ALL, motion: None }];
    let half: fn(&Vec3, f64) -> Composition =
        |x, spacing| Composition { factors: [1.0; 2], turns: None, ..oblique(x, spacing) };
    for material in [linear(100.0, 0.3, 0.1), rubber(100.0, 0.45)] {
        let of = |made: Made| {
            remeshed_body(made, shape.clone(), Resolution::Spacing(0.1), (0.8, 1.0), &clamp, None).solid
        };
        let mut one = of(Arc::clone(&material).into());
        let mut two = of(Made { materials: vec![Arc::clone(&material), material], cell: Some(half) });
        let n = 3 * one.len();
        let (u, v) = (Noise(1).column(n), Noise(2).column(n));
        let u: Vec<f64> = u.iter().map(|u| 2e-3 * u).collect();
        let mut forces = [vec![0.0; n], vec![0.0; n]];
        for (solid, force) in [&mut one, &mut two].into_iter().zip(&mut forces) {
            solid.linearise(0.0, &u);
            solid.apply(Scales { mass: 1.0, stiffness: 0.3, damping: 0.2 }, &v, force);
        }
        let off = forces[0].iter().zip(&forces[1]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-7 * forces[0].iter().map(|f| f.abs()).fold(0.0, f64::max), "{off}");
    }
}

fn with_fibres(fibre: [f64; 3]) -> Arc<dyn Material> {
    let model = rsph_core::material::model("holzapfel-gasser-ogden").unwrap();
    let value = |key: &str| {
        Some(match key {
            "density" | "k2" => vec![1.0],
            "shear_modulus" => vec![30.0],
            "k1" => vec![100.0],
            "dispersion" => vec![0.05],
            "fibre" => fibre.to_vec(),
            "poisson_ratio" => vec![0.4],
            _ => return None,
        })
    };
    model.make(value).unwrap()
}

/// A field of one direction is that direction, in force, tangent, stress and on the surface.
#[test]
fn fibres_along_a_field_are_those_of_a_material_turned() {
    let along = Vec3::new(-0.6, 0.48, 0.64);
    let run = |fibre: [f64; 3], fibres: Option<VectorField>| {
        let shape = Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap());
        let mut setup = Setup::new(shape, Resolution::Spacing(0.2), SolidSetup::new(with_fibres(fibre)));
        setup.units = Units::Normalised;
        setup.mechanics.fibres = fibres;
        setup.mechanics.boundaries.push(common::clamp());
        let traction = Vec3::new(5.0, 3.0, 20.0);
        let kind = LoadKind::Traction { region: face(Axis::Z, 1.0, Side::Above), traction };
        setup.mechanics.loads.push(Load { kind, curve: Curve::default() });
        let mut simulation = Simulation::new(setup).unwrap();
        simulation.solve_static(0.0, &mut |_, _| true).unwrap();
        let snapshot = simulation.snapshot();
        let surface = simulation.surface(&snapshot);
        let stress = surface.fields.iter().find(|field| field.name == "stress").unwrap().values.clone();
        (snapshot.column(Field::Displacement).values().to_vec(), stress)
    };
    let exact = run(along.into(), None);
    let field = VectorField::Function(Arc::new(move |x: &[Vec3]| vec![along * -3.0; x.len()]));
    for found in [run([1.0, 0.0, 0.0], Some(field.clone())), run([0.0, 0.0, 1.0], Some(field))] {
        for (found, exact) in [(found.0, &exact.0), (found.1, &exact.1)] {
            let off = found.iter().zip(exact).map(|(f, e)| (f - e).abs()).fold(0.0, f64::max);
            let size = exact.iter().map(|e| e.abs()).fold(0.0, f64::max);
            assert!(off < 1e-5 * size, "{off} {size}");
        }
    }
}

#[test]
fn a_field_of_fibres_needs_fibres_and_a_direction_everywhere() {
    let refused = |material: Arc<dyn Material>, field: VectorField| {
        let shape = Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap());
        let mut setup = Setup::new(shape, Resolution::Spacing(0.25), SolidSetup::new(material));
        setup.mechanics.fibres = Some(field);
        let error = Simulation::new(setup).unwrap_err();
        assert_eq!(error.key, "material.fibres");
        error.to_string()
    };
    let around = VectorField::Rotation { rate: Vec3::z(), centre: Vec3::new(0.375, 0.375, 0.0) };
    assert!(refused(rubber(10.0, 0.3), around.clone()).contains("has no fibres"));
    assert!(refused(with_fibres([1.0, 0.0, 0.0]), around).contains("no direction"));
}

/// A bar of length 1 that is pulled along x, with rollers on the faces across y and z where the materials are in series.
fn bar(rest: Arc<dyn Material>, other: Arc<dyn Material>, place: Region, sides: bool) -> Setup<SolidSetup> {
    let shape = Arc::new(BoxShape::new(Vec3::new(1.0, 0.25, 0.25), Vec3::zeros()).unwrap());
    let mut setup = Setup::new(shape, Resolution::Spacing(0.05), SolidSetup::new(rest));
    setup.units = Units::Normalised;
    let mechanics = &mut setup.mechanics;
    mechanics.parts.push(MaterialPart {
        name: "other".into(),
        material: other,
        modulus: None,
        fibres: None,
        place: Arc::new(place),
    });
    let roller = |axis, at, side| Boundary {
        name: None,
        region: face(axis, at, side),
        fix: Fix::Normal,
        motion: None,
    };
    mechanics.boundaries.push(roller(Axis::X, 0.0, Side::Below));
    for axis in [Axis::Y, Axis::Z] {
        mechanics.boundaries.push(roller(axis, 0.0, Side::Below));
        if sides {
            mechanics.boundaries.push(roller(axis, 0.25, Side::Above));
        }
    }
    let kind = LoadKind::Traction { region: face(Axis::X, 1.0, Side::Above), traction: Vec3::x() };
    mechanics.loads.push(Load { kind, curve: Curve::default() });
    setup.probes.push(Probe {
        name: "end".into(),
        quantity: Quantity { field: Field::Displacement, component: Some(0) },
        region: face(Axis::X, 1.0, Side::Above),
    });
    setup
}

/// Displacement of the end at rest.
fn stretch(setup: Setup<SolidSetup>) -> f64 {
    let mut simulation = Simulation::new(setup).unwrap();
    simulation.solve_static(0.0, &mut |_, _| true).unwrap();
    simulation.readings()[0].value
}

#[test]
fn a_bar_of_two_materials_in_series_is_exact_wherever_they_meet() {
    for at in [0.5, 0.505, 0.5125, 0.525, 0.54] {
        let place = face(Axis::X, at, Side::Above);
        for (nu, sides) in [(0.0, false), (0.3, true), (0.45, true)] {
            let (soft, stiff) = (linear(100.0, nu, 0.0), linear(1000.0, nu, 0.0));
            // With its sides held the bar is strained along x alone.
            let modulus = |m: &Arc<dyn Material>| if sides { m.p_wave_modulus() } else { m.young_modulus() };
            let exact = at / modulus(&soft) + (1.0 - at) / modulus(&stiff);
            let found = stretch(bar(soft, stiff, place.clone(), sides));
            assert!((found / exact - 1.0).abs() < 0.01, "{at} {nu}: {found} {exact}");
        }
    }
}

#[test]
fn a_bar_of_two_materials_side_by_side_carries_the_sum_wherever_they_meet() {
    for at in [0.125, 0.13, 0.14, 0.15] {
        let place = face(Axis::Y, at, Side::Above);
        let mut setup = bar(linear(100.0, 0.0, 0.0), linear(1000.0, 0.0, 0.0), place, false);
        setup.mechanics.loads.clear();
        let motion = Motion::Curve { displacement: Vec3::x() * 0.01, curve: Curve::default() };
        let region = face(Axis::X, 1.0, Side::Above);
        let name = Some("grip".into());
        setup.mechanics.boundaries.push(Boundary { name, region, fix: Fix::Normal, motion: Some(motion) });
        let mut simulation = Simulation::new(setup).unwrap();
        simulation.solve_static(1.0, &mut |_, _| true).unwrap();
        let found = simulation.reactions()[3].force.x;
        let exact = 0.01 * 0.25 * (100.0 * at + 1000.0 * (0.25 - at));
        // Five particles across.
        assert!((found / exact - 1.0).abs() < 0.012, "{at}: {found} {exact}");
    }
}

#[test]
fn moduli_of_a_field_are_exact_in_a_bar() {
    let (soft, nowhere) = (linear(100.0, 0.0, 0.0), Region::Ball { centre: Vec3::repeat(9.0), radius: 0.1 });
    let mut setup = bar(Arc::clone(&soft), soft, nowhere, false);
    setup.mechanics.modulus =
        Some(ModulusField(Arc::new(|x: &[Vec3]| x.iter().map(|x| 100.0 * (2.0 * x.x).exp()).collect())));
    let exact = (1.0 - (-2.0_f64).exp()) / 200.0;
    let found = stretch(setup);
    assert!((found / exact - 1.0).abs() < 0.005, "{found} {exact}");
}
