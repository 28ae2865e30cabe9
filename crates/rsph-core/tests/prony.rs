//! Materials that relax by Prony series, against hereditary integrals.

mod common;

use common::{Made, Noise, clamp, cube, face, remeshed_body};
use rsph_core::dynamics::{Dynamics, Scales};
use rsph_core::material::{KelvinVoigt, Law, Material, NeoHookean, PronyTerm, Relaxing, model};
use rsph_core::particles::{Column, Field, Particles, RELAXED_STRESSES};
use rsph_core::region::{Axis, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Between, Boundary, Curve, Fix, Integration, Load, LoadKind, MaterialPart, Motion, Remesh, RemeshTrigger,
    Scheme, Setup, SolidSetup, Solver, TimeStep, Units,
};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// So small that inertia does not count.
const DENSITY: f64 = 1e-4;

/// Two terms, one of which has relaxed before the tests end.
const SERIES: [(f64, f64); 2] = [(1.5, 0.2), (0.5, 2.0)];

fn relaxing(material: impl Material + 'static, series: &[(f64, f64)]) -> Arc<dyn Material> {
    let terms = series.iter().map(|&(share, time)| PronyTerm { share, time }).collect();
    Arc::new(Relaxing::new(Arc::new(material), terms).unwrap())
}

fn linear() -> KelvinVoigt {
    KelvinVoigt::new(DENSITY, 10.0, 0.3, 0.0).unwrap()
}

fn rubber() -> NeoHookean {
    NeoHookean::new(DENSITY, 10.0, 0.3, 0.0).unwrap()
}

/// A cube on planes of symmetry whose top moves along z.
fn pulled(material: Arc<dyn Material>, motion: Motion, scheme: Scheme, step: TimeStep) -> Setup<SolidSetup> {
    let roller = |axis, at, side, motion| Boundary {
        name: None,
        region: face(axis, at, side),
        fix: Fix::Normal,
        motion,
    };
    let boundaries = vec![
        roller(Axis::X, 0.0, Side::Below, None),
        roller(Axis::Y, 0.0, Side::Below, None),
        roller(Axis::Z, 0.0, Side::Below, None),
        roller(Axis::Z, 1.0, Side::Above, Some(motion)),
    ];
    Setup {
        units: Units::Normalised,
        solver: Solver::ACCURATE,
        time_step: step,
        integration: Integration { scheme, tolerance: 1e-6 },
        ..Setup::new(
            cube(),
            Resolution::Spacing(0.25),
            SolidSetup { boundaries, ..SolidSetup::new(material) },
        )
    }
}

/// Time and force on the top after each of so many steps to time `end`.
fn forces(setup: Setup<SolidSetup>, end: f64, samples: usize) -> Vec<(f64, f64)> {
    let mut body = Simulation::new(setup).unwrap();
    let at = |k: usize| end * k as f64 / samples as f64;
    (1..=samples)
        .map(|k| {
            body.advance_to(at(k), &mut |_| true).unwrap();
            (at(k), body.reactions()[3].force.z)
        })
        .collect()
}

/// S(t) = S^e(t) + sum gamma int exp(-(t - s)/tau) dS^e at some times, by a fine sum.
fn hereditary(elastic: impl Fn(f64) -> f64, series: &[(f64, f64)], times: &[f64]) -> Vec<f64> {
    let of = |&t: &f64| {
        let parts = 200_000_u32;
        let (mut sum, mut before) = (0.0, elastic(0.0));
        for k in 0..parts {
            let (middle, end) =
                (t * (f64::from(k) + 0.5) / f64::from(parts), t * f64::from(k + 1) / f64::from(parts));
            let now = elastic(end);
            let kernel: f64 = series.iter().map(|(share, time)| share * (-(t - middle) / time).exp()).sum();
            sum += kernel * (now - before);
            before = now;
        }
        before + sum
    };
    times.iter().map(of).collect()
}

/// Stretch across a bar of a law that is pulled, and its second Piola-Kirchhoff stress along it, at that stretch.
fn uniaxial(material: &dyn Material, stretch: f64) -> f64 {
    let stress = |side: f64| match material.law() {
        Law::Linear(stiffness) => {
            let strain = Mat3::from_diagonal(&Vec3::new(side - 1.0, side - 1.0, stretch - 1.0));
            stiffness.stress(rsph_core::tensor::SymTensor::symmetric_part(&strain)).to_matrix()
        }
        Law::FiniteStrain(law) => {
            let f = Mat3::from_diagonal(&Vec3::new(side, side, stretch));
            f.try_inverse().unwrap() * law.first_piola(&f)
        }
    };
    let (mut low, mut high) = (0.3, 3.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if stress(middle)[(0, 0)] > 0.0 { high = middle } else { low = middle }
    }
    stress(low)[(2, 2)]
}

/// Largest difference, as a share of the largest exact value.
fn off(found: &[(f64, f64)], exact: &[f64]) -> f64 {
    let size = exact.iter().map(|e| e.abs()).fold(0.0, f64::max);
    found.iter().zip(exact).map(|(f, e)| (f.1 - e).abs()).fold(0.0, f64::max) / size
}

/// Pulled, and held from then on. Across the bar no component of S acts at any time, so that it is as wide as a bar of the law.
#[test]
fn the_stress_of_a_strain_that_is_held_relaxes_along_the_exact_curve() {
    let ramp = Curve::new(&[0.0, 0.3], &[0.0, 1.0], Between::Smooth, false).unwrap();
    let yeoh = model("yeoh").unwrap();
    let yeoh = yeoh.make(|key| {
        Some(vec![match key {
            "density" => DENSITY,
            "c1" => 2.0,
            "c2" | "c3" => 1.0,
            "poisson_ratio" => 0.45,
            _ => return None,
        }])
    });
    let laws: [(Arc<dyn Material>, f64); 4] = [
        (Arc::new(linear()), 0.01),
        (Arc::new(rubber()), 0.3),
        (Arc::new(rubber()), -0.25),
        (yeoh.unwrap(), 0.3),
    ];
    for (law, by) in laws {
        for trigger in [RemeshTrigger::Never, RemeshTrigger::Steps(15)] {
            let terms = SERIES.map(|(share, time)| PronyTerm { share, time }).to_vec();
            let material = Arc::new(Relaxing::new(Arc::clone(&law), terms).unwrap());
            let motion = Motion::Curve { displacement: Vec3::z() * by, curve: ramp.clone() };
            let mut setup = pulled(material, motion, Scheme::Sdirk2, TimeStep::Fixed(0.02));
            setup.remesh = Remesh { trigger, ..Remesh::default() };
            let found = forces(setup, 2.0, 20);
            let times: Vec<f64> = found.iter().map(|f| f.0).collect();
            let is_linear = law.law().finite_strain().is_none();
            // The curve is flat after .3: a table of the law on the way there.
            let table: Vec<f64> =
                (0..=2000).map(|k| uniaxial(&*law, 1.0 + by * f64::from(k) / 2000.0)).collect();
            let elastic = |t: f64| {
                let x = ramp.at(t) * 2000.0;
                let k = (x as usize).min(1999);
                table[k] + (table[k + 1] - table[k]) * (x - k as f64)
            };
            let mut exact = hereditary(elastic, &SERIES, &times);
            if !is_linear {
                exact.iter_mut().zip(&times).for_each(|(s, t)| *s *= 1.0 + by * ramp.at(*t));
            }
            let worst = off(&found, &exact);
            println!("{} by {by}, {trigger:?}: {worst:.1e} of {:.3}", law.name(), exact[2]);

            assert!(worst < 2e-3 && exact[19] / exact[2] < 0.7, "{} {by} {trigger:?}: {worst}", law.name());
        }
    }
}

/// The work that is lost in a cycle of the steady state is pi E'' e^2 with E'' = E sum gamma w tau / (1 + w^2 tau^2).
#[test]
fn a_cycle_loses_what_the_loss_modulus_says() {
    for frequency in [0.3, 1.0, 3.0] {
        let (e, period) = (0.01, 1.0 / frequency);
        let motion = Motion::Oscillation { amplitude: Vec3::z() * e, frequency };
        let series = [(1.5, 0.2), (0.5, 0.05)];
        let steps = 80;
        let setup = pulled(
            relaxing(linear(), &series),
            motion.clone(),
            Scheme::Sdirk2,
            TimeStep::Fixed(period / f64::from(steps)),
        );
        let cycles = (2.0 / period).ceil() + 1.0;
        let found = forces(setup, cycles * period, cycles as usize * steps as usize);
        let last = &found[found.len() - steps as usize - 1..];
        // int F du by Simpson's rule would need the middles; the trapezoidal rule is exact to all orders for periodic functions.
        let w = std::f64::consts::TAU * frequency;
        let loss: f64 =
            last[1..].iter().map(|(t, f)| f * e * w * (w * t).cos()).sum::<f64>() * period / f64::from(steps);
        let modulus: f64 = series.iter().map(|(g, tau)| 10.0 * g * w * tau / (1.0 + (w * tau).powi(2))).sum();
        let exact = std::f64::consts::PI * modulus * e * e;
        println!("{frequency} Hz: {:.1e}", loss / exact - 1.0);
        assert!((loss / exact - 1.0).abs() < 2e-3, "{frequency}: {loss} {exact}");
    }
}

#[test]
fn all_schemes_agree() {
    // Slow beside the waves, which only the implicit schemes damp.
    let ramp = Curve::new(&[0.0, 0.2], &[0.0, 1.0], Between::Smooth, false).unwrap();
    for (material, by) in [(relaxing(linear(), &SERIES), 0.01), (relaxing(rubber(), &SERIES), 0.2)] {
        let run = |scheme, step| {
            let motion = Motion::Curve { displacement: Vec3::z() * by, curve: ramp.clone() };
            forces(pulled(Arc::clone(&material), motion, scheme, step), 0.3, 6)
        };
        let exact: Vec<f64> = run(Scheme::Rk4, TimeStep::Auto).iter().map(|f| f.1).collect();
        for (scheme, step) in [(Scheme::Sdirk2, 0.01), (Scheme::BackwardEuler, 0.002)] {
            let worst = off(&run(scheme, TimeStep::Fixed(step)), &exact);
            println!("{scheme:?} {by}: {worst:.1e}");
            assert!(worst < 5e-3, "{scheme:?} {by}: {worst}");
        }
    }
}

/// In the state of given relaxed stresses the tangent is the derivative of the force, for bodies of one material and of two.
#[test]
fn the_tangent_is_the_derivative_of_the_force() {
    let half = |x: &Vec3, _: f64| rsph_core::material::Composition::pure(u16::from(x.x > 0.4), 1.0);
    let [one, two] = [relaxing(linear(), &SERIES), relaxing(rubber(), &SERIES)];
    let bodies = [
        Made::from(Arc::clone(&one)),
        Made::from(Arc::clone(&two)),
        Made { materials: vec![Arc::clone(&two), one], cell: Some(half) },
        Made { materials: vec![Arc::new(rubber()), two], cell: Some(half) },
    ];
    for (k, made) in bodies.into_iter().enumerate() {
        let body = remeshed_body(made, cube(), Resolution::Spacing(0.2), (0.8, 1.0), &[clamp()], None);
        let mut solid = body.solid;
        let n = solid.len();
        let mut noise = Noise(5);
        let u: Vec<f64> = noise.column(3 * n).iter().map(|x| 0.02 * x).collect();
        let mut direction = noise.column(3 * n);
        solid.fixed.zero(&mut direction, n);
        let mut particles = Particles::new(n);
        particles.set(Field::Reference, Column::from_vectors(&body.positions));
        particles.set(Field::Velocity, Column::zeros(3, n));
        for field in &RELAXED_STRESSES[..2] {
            particles.set(*field, Column::from_vec(noise.column(6 * n), n));
        }
        let mut rates = vec![Column::zeros(3, n), Column::zeros(3, n)];
        let mut force = |solid: &mut rsph_core::dynamics::solid::Solid, s: f64| -> Vec<f64> {
            let moved = u.iter().zip(&direction).map(|(u, d)| u + s * d).collect();
            particles.set(Field::Displacement, Column::from_vec(moved, n));
            solid.rates(0.0, &particles, &mut rates);
            rates[1].values().iter().enumerate().map(|(i, a)| a * solid.mass[i % n]).collect()
        };
        let e = 1e-6;
        let (after, before) = (force(&mut solid, e), force(&mut solid, -e));
        solid.linearise(0.0, &u);
        let mut change = vec![0.0; 3 * n];
        solid.apply(Scales::STATIC, &direction, &mut change);
        let found = after.iter().zip(&before).map(|(a, b)| -(a - b) / (2.0 * e));
        let off = found.zip(&change).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let size = change.iter().map(|c| c.abs()).fold(0.0, f64::max);
        assert!(off < 1e-6 * size, "{k}: {off} {size}");
    }
}

/// A beam of two materials, one of which relaxes, under a load, over a remesh and by way of a state.
fn beam(scheme: Scheme, step: f64, remesh: RemeshTrigger, end: f64) -> Simulation {
    let mut body = Simulation::new(setup_beam(scheme, step, remesh)).unwrap();
    body.advance_to(end, &mut |_| true).unwrap();
    body
}

fn setup_beam(scheme: Scheme, step: f64, remesh: RemeshTrigger) -> Setup<SolidSetup> {
    let load = Load {
        kind: LoadKind::Traction { region: face(Axis::Z, 1.0, Side::Above), traction: Vec3::x() * 0.4 },
        curve: Curve::default(),
    };
    let part = MaterialPart {
        name: "core".into(),
        material: relaxing(rubber(), &SERIES[..1]),
        modulus: None,
        fibres: None,
        place: Arc::new(face(Axis::X, 0.5, Side::Above)),
    };
    let mut setup = Setup {
        units: Units::Normalised,
        time_step: TimeStep::Fixed(step),
        integration: Integration { scheme, tolerance: 1e-5 },
        remesh: Remesh { trigger: remesh, ..Remesh::default() },
        ..Setup::new(cube(), Resolution::Spacing(0.125), SolidSetup::new(relaxing(rubber(), &SERIES)))
    };
    setup.mechanics.boundaries.push(clamp());
    setup.mechanics.loads.push(load);
    setup.mechanics.parts.push(part);
    setup
}

fn tip(body: &Simulation) -> f64 {
    let particles = body.particles();
    let x = particles.column(Field::Reference);
    let top = (0..particles.len()).filter(|&a| x.vector(a).z > 0.9);
    let u: Vec<f64> = top.map(|a| particles.column(Field::Displacement).vector(a).x).collect();
    u.iter().sum::<f64>() / u.len() as f64
}

#[test]
fn a_remesh_carries_what_has_relaxed() {
    let at = |trigger, end| tip(&beam(Scheme::Sdirk2, 0.02, trigger, end));
    let [kept, remeshed] = [RemeshTrigger::Never, RemeshTrigger::Steps(4)].map(|trigger| {
        let of = [0.1, 0.6].map(|end| at(trigger, end));
        println!("{of:?}");
        of[1] / of[0]
    });
    assert!(kept > 1.4 && (remeshed / kept - 1.0).abs() < 0.02, "{kept} {remeshed}");
}

#[test]
fn a_state_holds_what_has_relaxed() {
    for (scheme, step, end) in [(Scheme::Sdirk2, 0.02, 0.2), (Scheme::Rk4, 1e-4, 0.01)] {
        let mut first = beam(scheme, step, RemeshTrigger::Never, end);
        let state = first.state();
        let mut second = beam(scheme, step, RemeshTrigger::Never, 0.0);
        second.set_state(&state).unwrap();
        for body in [&mut first, &mut second] {
            body.advance_to(2.0 * end, &mut |_| true).unwrap();
        }
        for field in [Field::Displacement, Field::RelaxedStress1, Field::RelaxedStress2] {
            let [one, two] = [&first, &second].map(|body| body.particles().column(field).values());
            assert!(one.iter().zip(two).all(|(a, b)| a.to_bits() == b.to_bits()), "{scheme:?} {field:?}");
        }
    }
}

#[test]
fn at_rest_it_is_its_law_and_stays() {
    let mut body = beam(Scheme::Sdirk2, 0.02, RemeshTrigger::Never, 0.0);
    body.solve_static(0.0, &mut |_, _| true).unwrap();
    let mut law = {
        let mut setup = Setup::new(cube(), Resolution::Spacing(0.125), SolidSetup::new(Arc::new(rubber())));
        setup.units = Units::Normalised;
        setup.mechanics.boundaries.push(clamp());
        setup.mechanics.loads.push(Load {
            kind: LoadKind::Traction { region: face(Axis::Z, 1.0, Side::Above), traction: Vec3::x() * 0.4 },
            curve: Curve::default(),
        });
        Simulation::new(setup).unwrap()
    };
    law.solve_static(0.0, &mut |_, _| true).unwrap();
    let rest = tip(&body);
    assert!((rest / tip(&law) - 1.0).abs() < 1e-5);
    let energy = |body: &mut Simulation| body.conservation().elastic_energy;
    assert!((energy(&mut body) / energy(&mut law) - 1.0).abs() < 1e-5);
    body.advance_to(0.5, &mut |_| true).unwrap();
    assert!((tip(&body) / rest - 1.0).abs() < 1e-4, "{} {rest}", tip(&body));
}

/// A bar that is stretched and held: energy goes from the work into heat, none comes from nowhere.
#[test]
fn what_relaxes_is_lost_and_no_more() {
    let ramp = Curve::new(&[0.0, 0.1], &[0.0, 1.0], Between::Smooth, false).unwrap();
    let motion = Motion::Curve { displacement: Vec3::z() * 0.01, curve: ramp };
    let setup = pulled(relaxing(linear(), &SERIES), motion, Scheme::Sdirk2, TimeStep::Fixed(0.005));
    let mut body = Simulation::new(setup).unwrap();
    let mut before = 0.0;
    for k in 1..=20 {
        body.advance_to(0.3 * f64::from(k), &mut |_| true).unwrap();
        let c = body.conservation();
        let lost = c.external_work - c.elastic_energy - c.kinetic_energy;
        assert!(lost > before, "{k}: {lost} {before}");
        before = lost;
    }
    // The stress of the particles and on the surface is that of the force, S = E e (1 + sum).
    let snapshot = body.snapshot();
    let force = body.reactions()[3].force.z;
    let in_particles = snapshot.column(Field::Stress);
    let surface = body.surface(&snapshot);
    let on_surface = surface.fields.iter().find(|field| field.name == "stress").unwrap();
    for s in in_particles.component(2).iter().chain(on_surface.values.iter().skip(2).step_by(6)) {
        assert!((s / force - 1.0).abs() < 1e-3, "{s} {force}");
    }
    // W(e) is what stays: E e^2 / 2.
    let left = body.conservation().elastic_energy / (0.5 * 10.0 * 1e-4);
    let slow = 0.5 * (-2.0 * (6.0 - 0.05) / 2.0_f64).exp();
    assert!((left - 1.0 - slow).abs() < 2e-3, "{left} {slow}");
}
