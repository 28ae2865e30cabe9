//! Springs between a part of the surface and the surroundings.

use rsph_core::material::{KelvinVoigt, Material, NeoHookean};
use rsph_core::particles::Field;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Boundary, Curve, Fix, Foundation, Integration, Load, LoadKind, RemeshTrigger, Scheme, Setup, SolidSetup,
    Solver, TimeStep, Units,
};
use rsph_core::shape::BoxShape;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// Gravity, and the size of the block.
const G: f64 = 0.3;
const SIZE: [f64; 3] = [1.0, 0.8, 1.2];

/// A block with nothing but springs at its foot, under gravity.
fn setup(material: Arc<dyn Material>, gravity: Vec3, normal: f64, tangential: f64) -> Setup<SolidSetup> {
    let foot = Region::Plane { axis: Axis::Z, at: 0.0, side: Side::Below };
    Setup {
        units: Units::Normalised,
        solver: Solver::ACCURATE,
        ..Setup::new(
            Arc::new(BoxShape::new(Vec3::from(SIZE), Vec3::zeros()).unwrap()),
            Resolution::Spacing(0.2),
            SolidSetup {
                loads: vec![Load {
                    kind: LoadKind::BodyForce { region: Region::All, acceleration: gravity },
                    curve: Curve::default(),
                }],
                foundations: vec![Foundation { region: foot, normal, tangential }],
                ..SolidSetup::new(material)
            },
        )
    }
}

fn laws(young_modulus: f64) -> [Arc<dyn Material>; 2] {
    [
        Arc::new(KelvinVoigt::new(2.0, young_modulus, 0.3, 0.05).unwrap()),
        Arc::new(NeoHookean::new(2.0, young_modulus, 0.3, 0.05).unwrap()),
    ]
}

/// Mean displacement of the foot, as the springs' force over their stiffness has it.
fn mean(simulation: &Simulation) -> Vec3 {
    let particles = simulation.particles();
    let (u, volume) = (particles.column(Field::Displacement), particles.column(Field::Volume).values());
    let total: f64 = volume.iter().sum();
    (0..particles.len()).map(|a| u.vector(a) * volume[a]).sum::<Vec3>() / total
}

/// Under gravity along the springs it sinks by rho g H / k, whatever its own stiffness, and shrinks by rho g H^2 / (3 E) above.
#[test]
fn a_block_sinks_by_its_weight_over_the_stiffness() {
    let (density, k, young_modulus) = (2.0, 5.0, 1e5);
    for material in laws(young_modulus) {
        let mut block = Simulation::new(setup(material, -G * Vec3::z(), k, 1.0)).unwrap();
        let found = block.solve_static(0.0, &mut |_, _| true).unwrap();
        let sunk = -density * G * SIZE[2] / k;
        let weight = density * G * SIZE.iter().product::<f64>();
        println!("{:?} {sunk} {found:?}", mean(&block));
        // The block is stiff: what it shrinks by is 1e-5 of that.
        assert!((mean(&block) - sunk * Vec3::z()).norm() < 1e-4 * sunk.abs());
        assert!((found.reaction - weight * Vec3::z()).norm() < 1e-5 * weight, "{found:?}");
        // What is left of the work is in the springs.
        let energy = block.conservation().elastic_energy;
        assert!((energy / (0.5 * weight * sunk.abs()) - 1.0).abs() < 1e-4, "{energy}");
    }
}

/// Springs across the normal alone are no hold: the motion that is left is named.
#[test]
fn springs_in_one_direction_leave_the_others_free() {
    let [material, _] = laws(100.0);
    let mut block = Simulation::new(setup(material, Vec3::zeros(), 5.0, 0.0)).unwrap();
    let error = block.solve_static(0.0, &mut |_, _| true).unwrap_err();
    assert!(error.what.contains("shifted along x and shifted along y"), "{}", error.what);
}

/// It moves in time as it does at rest: implicit and explicit, remeshed or not.
#[test]
fn it_comes_to_rest_in_time_where_it_rests() {
    // Implicit steps balance momentum as well as their systems are solved.
    for (scheme, remesh, balanced) in [(Scheme::Sdirk2, true, 1e-6), (Scheme::Rk4, false, 1e-11)] {
        let (k, t) = (20.0, 12.0);
        let material = Arc::new(NeoHookean::new(2.0, 40.0, 0.3, 0.4).unwrap());
        let mut setup = setup(material, -G * Vec3::z(), k, 20.0);
        let mut still = Simulation::new(setup.clone()).unwrap();
        still.solve_static(0.0, &mut |_, _| true).unwrap();
        setup.integration = Integration { scheme, ..Integration::default() };
        if scheme == Scheme::Sdirk2 {
            setup.time_step = TimeStep::Fixed(0.1);
        }
        if remesh {
            setup.remesh.trigger = RemeshTrigger::Interval(2.5);
        }
        let mut moving = Simulation::new(setup).unwrap();
        moving.advance_to(t, &mut |_| true).unwrap();
        let off = (mean(&moving) - mean(&still)).norm() / mean(&still).norm();
        println!("{scheme:?}: {off:.1e}, {:?}", moving.conservation());
        assert!(off < 0.01, "{scheme:?}: {off}");
        assert!(moving.conservation().momentum_error < balanced);
    }
}

#[test]
fn what_holds_nothing_is_refused() {
    let [material, _] = laws(100.0);
    let key = |normal: f64, tangential: f64, at: f64, clamped: bool| {
        let mut setup = setup(Arc::clone(&material), Vec3::zeros(), normal, tangential);
        let region = Region::Plane { axis: Axis::Z, at, side: Side::Below };
        if clamped {
            let boundary = Boundary { name: None, region: region.clone(), fix: Fix::ALL, motion: None };
            setup.mechanics.boundaries.push(boundary);
        }
        setup.mechanics.foundations[0].region = region;
        Simulation::new(setup).unwrap_err().key
    };
    assert_eq!(key(-1.0, 0.0, 0.0, false), "foundation[0].normal");
    assert_eq!(key(0.0, 0.0, 0.0, false), "foundation[0].normal");
    assert_eq!(key(1.0, f64::NAN, 0.0, false), "foundation[0].tangential");
    assert_eq!(key(1.0, 1.0, -1.0, false), "foundation[0].region");
    assert_eq!(key(1.0, 1.0, 0.0, true), "foundation[0].region");
}
