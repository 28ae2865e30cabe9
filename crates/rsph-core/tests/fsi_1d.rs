//! A fluid beside a solid on a line: identities of the discrete equations and of the remeshing, and whole
//! simulations.

use proptest::prelude::*;
use rsph_core::dynamics::Dynamics;
use rsph_core::dynamics::fsi_1d::FluidStructure;
use rsph_core::error::FailureKind;
use rsph_core::fluid::{Acoustic, Burgers, FluidLaw};
use rsph_core::integrate::{Integrator, RungeKutta4};
use rsph_core::kernel::RemeshKernel;
use rsph_core::particles::{Column, Field, Particles};
use rsph_core::region::Region;
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Initial, Interaction, InteractionSetting, Mechanics, Probe, Quantity, Remesh, RemeshTrigger, Setup,
    Solver, TimeStep, Units, VectorField,
};
use rsph_core::shape::BoxShape;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

fn interaction(fluid: Arc<dyn FluidLaw>, elements: [usize; 2]) -> Interaction {
    Interaction {
        fluid,
        elasticity: 1.0,
        solid_density: 1.0,
        left: -0.5,
        interface: 0.0,
        right: 0.5,
        elements,
    }
}

fn burgers() -> Arc<dyn FluidLaw> {
    Arc::new(Burgers::new(0.001).unwrap())
}

fn along(f: impl Fn(f64) -> f64 + Copy) -> impl Fn(&[Vec3]) -> Vec<Vec3> + Copy {
    move |x| x.iter().map(|x| Vec3::new(f(x.x), 0.0, 0.0)).collect()
}

fn rates(dynamics: &mut FluidStructure, particles: &Particles) -> Vec<Column> {
    let zeros = |f: &Field| Column::zeros(f.spec().components, particles.len());
    let mut rates: Vec<Column> = dynamics.integrated().iter().map(zeros).collect();
    dynamics.rates(0.0, particles, &mut rates);
    rates
}

/// A fluid whose particles were moved off their nodes, by up to 0.4 of the spacing, with those velocities.
fn disturbed(i: &Interaction, dynamics: &FluidStructure, shift: &[f64], u: &[f64]) -> Particles {
    let mut particles = dynamics.particles(i, along(|_| 0.0));
    let (n, h) = (i.elements[0], i.spacings()[0]);
    let x: Vec<f64> =
        (0..=n).map(|a| i.left + h * (a as f64 + if a == 0 || a == n { 0.0 } else { shift[a] })).collect();
    let half = 0.5 * i.spacings()[1];
    for a in 0..=n {
        particles.column_mut(Field::Displacement).values_mut()[a] = x[a] - i.left - h * a as f64;
        particles.column_mut(Field::Velocity).values_mut()[a] = if a == 0 { 0.0 } else { u[a] };
        let cell = 0.5 * (x[(a + 1).min(n)] - x[a.saturating_sub(1)]);
        particles.column_mut(Field::Volume).values_mut()[a] = cell + if a == n { half } else { 0.0 };
    }
    dynamics.impose(0.0, &mut particles);
    particles
}

proptest! {
    #[test]
    fn remeshing_keeps_volume_and_inner_momentum(
        shift in prop::collection::vec(-0.4..0.4f64, 41), u in prop::collection::vec(-1.0..1.0f64, 41),
    ) {
        let i = interaction(burgers(), [40, 10]);
        // At rest near the ends, where mirror images give and take.
        let u: Vec<f64> =
            u.iter().enumerate().map(|(a, u)| if (7..34).contains(&a) { *u } else { 0.0 }).collect();
        for kernel in RemeshKernel::ALL {
            let mut dynamics = FluidStructure::new(&i, 0.9);
            let mut particles = disturbed(&i, &dynamics, &shift, &u);
            let done = dynamics.remesh(kernel, &mut particles).unwrap();
            prop_assert!((done.volume[1] - done.volume[0]).abs() < 1e-13, "{done:?}");
            prop_assert!((done.volume[1] - 0.5).abs() < 1e-13);
            prop_assert!((done.momentum[1] - done.momentum[0]).abs() < 1e-13, "{} {done:?}", kernel.name());
            let volume = particles.column(Field::Volume).values();
            prop_assert!(volume[1..40].iter().all(|v| (v - 0.0125).abs() < 1e-15));
        }
    }
}

proptest! {
    #[test]
    fn remeshing_keeps_a_constant_pressure(shift in prop::collection::vec(-0.4..0.4f64, 41), p in -9.0..9.0f64) {
        let i = interaction(Arc::new(Acoustic::new(1.0, 1.0).unwrap()), [40, 10]);
        let mut dynamics = FluidStructure::new(&i, 0.9);
        let mut particles = disturbed(&i, &dynamics, &shift, &[0.0; 41]);
        particles.column_mut(Field::Pressure).values_mut()[..=40].fill(p);
        dynamics.remesh(RemeshKernel::Lambda42, &mut particles).unwrap();
        prop_assert!(particles.column(Field::Pressure).values()[..=40].iter().all(|q| (q - p).abs() < 1e-11));
    }
}

/// Particles that a smooth motion has carried away from their nodes and strained by up to 0.2, with a velocity
/// that is odd at the wall. At a given strain the error is a share of the change over one spacing: of first order.
#[test]
fn a_smooth_velocity_is_kept() {
    for n in [40, 80] {
        let i = interaction(burgers(), [n, 10]);
        let h = i.spacings()[0];
        let place = |a: usize| h * a as f64;
        let moved = |a: usize| 0.03 * (12.0 * place(a)).sin() * (0.5 - place(a));
        let shift: Vec<f64> = (0..=n).map(|a| moved(a) / h).collect();
        let u: Vec<f64> = (0..=n).map(|a| (3.0 * (place(a) + moved(a))).sin()).collect();
        let mut dynamics = FluidStructure::new(&i, 0.9);
        let mut particles = disturbed(&i, &dynamics, &shift, &u);
        dynamics.remesh(RemeshKernel::Lambda42, &mut particles).unwrap();
        let u = particles.column(Field::Velocity).component(0);
        let error = (0..=n).map(|a| (u[a] - (3.0 * place(a)).sin()).abs()).fold(0.0, f64::max);
        assert!(error < 0.03 * 3.0 * h, "{n}: {error}");
    }
}

/// u = a (x + 1/2) beside a solid with the strain of equal stress: u_xx = 0, so that the fluid feels only the
/// source.
#[test]
fn linear_velocity_beside_equal_stress_feels_only_the_source() {
    let (a, viscosity) = (0.3, 0.02);
    let i = interaction(Arc::new(Burgers::new(viscosity).unwrap()), [20, 25]);
    let mut dynamics = FluidStructure::new(&i, 1.25);
    let mut particles = dynamics.particles(&i, along(|x| if x <= 0.0 { a * (x + 0.5) } else { 0.0 }));
    for j in 20..=45 {
        let xi = particles.column(Field::Reference).component(0)[j];
        particles.column_mut(Field::Displacement).values_mut()[j] = viscosity * a * xi;
    }
    let rates = rates(&mut dynamics, &particles);
    for b in 1..20 {
        let x = particles.column(Field::Reference).component(0)[b];
        let expected = -0.5 * a * a * (x + 0.5);
        assert!((rates[1].component(0)[b] - expected).abs() < 1e-11, "{b}");
        assert!((rates[2].values()[b] - 0.025 * a).abs() < 1e-13);
    }
    // Half a cell of fluid at half its source, and half a cell of solid.
    let [h, dxi] = i.spacings();
    let expected = -0.25 * h * (0.5 * a) * a / (0.5 * (h + dxi));
    assert!((rates[1].component(0)[20] - expected).abs() < 1e-12);
    assert!(rates[1].component(0)[21..].iter().all(|a| a.abs() < 1e-12));
}

#[test]
fn without_viscosity_and_source_energy_is_kept() {
    let fluid = Arc::new(Acoustic::new(2.0, 0.7).unwrap());
    let i = interaction(fluid, [60, 60]);
    let mut dynamics = FluidStructure::new(&i, 0.9);
    let mut particles = dynamics.particles(&i, along(|x| 1e-5 * (-(x * 12.0).powi(2)).exp()));
    let mut integrator = RungeKutta4::default();
    let before: f64 = dynamics.energy_of_each(&particles).iter().sum();
    let [waves, viscosity] = dynamics.step_limits(i.spacings()[0]);
    let (limit, viscous) = (waves.min(viscosity), viscosity < waves);
    assert!(!viscous);
    for k in 0..400 {
        integrator.step(&mut dynamics, &mut particles, f64::from(k) * 0.4 * limit, 0.4 * limit).unwrap();
    }
    let after: f64 = dynamics.energy_of_each(&particles).iter().sum();
    assert!((after / before - 1.0).abs() < 5e-3, "{before} {after}");
}

fn setup(spacing: f64, trigger: RemeshTrigger) -> Setup {
    let size = Vec3::new(1.0, 0.1, 0.1);
    let shape = Arc::new(BoxShape::new(size, Vec3::new(-0.5, 0.0, 0.0)).unwrap());
    let mechanics = Mechanics::Interaction(InteractionSetting {
        fluid: burgers(),
        elasticity: 1.0,
        solid_density: 1.0,
        interface: 0.0,
    });
    let velocity = VectorField::Wave {
        constant: Vec3::new(-0.1, 0.0, 0.0),
        amplitude: Vec3::new(-0.1, 0.0, 0.0),
        wave_number: Vec3::new(1.0, 0.0, 0.0),
        phase: 0.0,
    };
    Setup {
        units: Units::Normalised,
        initial: Initial { velocity, ..Initial::default() },
        remesh: Remesh { trigger, kernel: RemeshKernel::Lambda42, ..Remesh::default() },
        solver: Solver { smoothing: 0.85, ..Solver::default() },
        ..Setup::new(shape, Resolution::Spacing(spacing), mechanics)
    }
}

#[test]
fn particles_that_pass_each_other_end_the_run_with_a_good_state() {
    let mut sim = Simulation::new(setup(0.01, RemeshTrigger::Never)).unwrap();
    let failure = sim.advance_to(2.0, &mut |_| true).unwrap_err();
    assert_eq!(failure.kind, FailureKind::Crossed);
    assert!((failure.time - 1.1).abs() < 0.1 && failure.place.is_some(), "{failure}");
    assert!(failure.remedy.contains("remesh.every"));
    assert!(sim.time() < failure.time);
    let x: Vec<f64> = sim.snapshot().positions().iter().map(|x| x[0]).collect();
    assert!(x.windows(2).all(|x| x[1] > x[0]));
    let mass = sim.particles().column(Field::Mass).values();
    assert_eq!(mass[..50], sim.particles().column(Field::Volume).values()[..50]);
}

#[test]
fn remeshing_by_time_does_not_depend_on_the_step() {
    let counts = [0.008, 0.004].map(|dt| {
        let setup = Setup { time_step: TimeStep::Fixed(dt), ..setup(0.01, RemeshTrigger::Interval(0.04)) };
        let mut sim = Simulation::new(setup).unwrap();
        sim.advance_to(1.0, &mut |_| true).unwrap();
        sim.remesh_log().unwrap().count
    });
    assert_eq!(counts, [25, 25]);
}

#[test]
fn energy_and_momentum_are_accounted_for() {
    let mut sim = Simulation::new(setup(0.0025, RemeshTrigger::Strain)).unwrap();
    sim.advance_to(1.0, &mut |_| true).unwrap();
    let c = sim.conservation();
    // Second order: 1.6e-3 of the energy is off at 100 elements, 1e-4 at 400.
    assert!(c.energy_error.unwrap() < 1.5e-3, "{c:?}");
    assert!(c.dissipated > 3e-4 && c.mass_error == 0.0, "{c:?}");
    assert!(c.momentum_error < 2e-3, "{c:?}");
    let readings = sim.readings();
    let names: Vec<&str> = readings.iter().map(|r| r.name.as_str()).collect();
    assert_eq!(names, ["interface_position", "interface_velocity", "fluid_energy", "solid_energy"]);
    let energy = readings[2].value + readings[3].value;
    assert!((energy - c.kinetic_energy - c.elastic_energy).abs() < 1e-15);
}

#[test]
fn bad_input_is_refused_by_its_key() {
    let key = |change: &dyn Fn(&mut Setup)| {
        let mut setup = setup(0.01, RemeshTrigger::Never);
        change(&mut setup);
        Simulation::new(setup).unwrap_err().key
    };
    let setting = |change: &dyn Fn(&mut InteractionSetting)| {
        key(&|s| {
            if let Mechanics::Interaction(i) = &mut s.mechanics {
                change(i);
            }
        })
    };
    assert_eq!(setting(&|i| i.interface = 0.7), "dynamics.interface");
    assert_eq!(setting(&|i| i.elasticity = f64::NAN), "dynamics.solid.elasticity");
    assert_eq!(setting(&|i| i.solid_density = 0.0), "dynamics.solid.density");
    assert_eq!(key(&|s| s.resolution = Resolution::Spacing(0.1)), "body.spacing");
    assert_eq!(key(&|s| s.resolution = Resolution::Particles(3)), "body.particles");
    assert_eq!(key(&|s| s.solver.smoothing = 0.8), "solver.smoothing");
    assert_eq!(key(&|s| s.time_step = TimeStep::Fixed(0.1)), "time.dt");
    let probe = |quantity: &str| Probe {
        name: "p".into(),
        quantity: Quantity::parse(quantity).unwrap(),
        region: Region::All,
    };
    assert_eq!(key(&|s| s.probes = vec![probe("velocity.x"), probe("pressure")]), "probe[1].quantity");
    assert_eq!(Burgers::new(0.0).unwrap_err().key, "dynamics.fluid.burgers.viscosity");
    assert_eq!(Acoustic::new(1.0, -1.0).unwrap_err().key, "dynamics.fluid.acoustic.sound_speed");
}
