//! Equations of the paper that no other test looks at one by one, against values by hand.

mod common;

use approx::assert_relative_eq;
use rsph_core::boundary::fixed::Fixed;
use rsph_core::boundary::traction_free::penalty_force;
use rsph_core::dynamics::Dynamics;
use rsph_core::dynamics::paper::Paper;
use rsph_core::kernel::QuarticSpline;
use rsph_core::material::{KelvinVoigt, Material};
use rsph_core::mls::{Cloud, PointWeights};
use rsph_core::particles::{Column, Field, Particles};
use rsph_core::region::Region;
use rsph_core::sample::Resolution;
use rsph_core::setup::{Curve, Initial, Load, LoadKind, Setup, SolidSetup, Units, VectorField};
use rsph_core::shape::BoxShape;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::{Mat3, SymTensor, Vec3};
use std::sync::Arc;

/// A free cube of 6^3 particles, density 2, E = 100, nu = 0.3, T = 0.2.
fn free_cube(initial: Initial, loads: Vec<Load>) -> Simulation {
    Simulation::new(Setup {
        units: Units::Normalised,
        initial,
        ..Setup::new(
            Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap()),
            Resolution::Particles(216),
            SolidSetup {
                foundations: Vec::new(),
                material: Arc::new(KelvinVoigt::new(2.0, 100.0, 0.3, 0.2).unwrap()),
                boundaries: Vec::new(),
                loads,
            },
        )
    })
    .unwrap()
}

#[test]
fn density_falls_as_the_volume_grows() {
    // Eq. (1) with a uniform rate of stretch: d(ln rho)/dt = -tr(de/dt), so rho = rho_0 exp(-tr e).
    let gradient = Mat3::from_diagonal(&Vec3::new(0.02, -0.01, 0.03));
    let displacement = VectorField::Affine { constant: Vec3::zeros(), gradient };
    let mut cube = free_cube(Initial { displacement, ..Initial::default() }, Vec::new());
    let snapshot = cube.snapshot();
    for rho in snapshot.column(Field::Density).values() {
        assert_relative_eq!(*rho, 2.0 * (-0.04_f64).exp(), max_relative = 1e-12);
    }
}

#[test]
fn a_free_body_falls_as_a_point_does() {
    // Eqs. (2), (3), (4): v = v_0 + g t, u = v_0 t + g t^2/2 for every particle, mass and strain as
    // they were.
    let (v_0, g) = (Vec3::new(0.3, 0.0, -0.1), Vec3::new(0.0, -9.81, 2.0));
    let velocity = VectorField::Constant(v_0);
    let gravity =
        Load { kind: LoadKind::BodyForce { region: Region::All, acceleration: g }, curve: Curve::default() };
    let mut cube = free_cube(Initial { velocity, ..Initial::default() }, vec![gravity]);
    let t = 0.05;
    cube.advance_to(t, &mut |_| true).unwrap();
    let snapshot = cube.snapshot();
    for a in 0..snapshot.len() {
        let (u, v) =
            (snapshot.column(Field::Displacement).vector(a), snapshot.column(Field::Velocity).vector(a));
        assert!((u - (v_0 * t + 0.5 * t * t * g)).norm() < 1e-12);
        assert!((v - (v_0 + t * g)).norm() < 1e-11);
    }
    assert!(snapshot.column(Field::Strain).values().iter().all(|e| e.abs() < 1e-12));
    assert!(cube.conservation().mass_error < 1e-15);
}

#[test]
fn kelvin_voigt_stress_by_hand() {
    // Eq. (6): E = 10, nu = 0.25 give mu = lambda = 4. Eq. (5) at e + T de/dt = this tensor.
    let material = KelvinVoigt::new(1.0, 10.0, 0.25, 0.2).unwrap();
    let (mu, lambda) = material.lame();
    assert_relative_eq!(mu, 4.0, max_relative = 1e-15);
    assert_relative_eq!(lambda, 4.0, max_relative = 1e-15);
    let sigma = material.stiffness().stress(SymTensor([1.0, 0.5, -0.25, 0.5, 0.0, -1.0]));
    let expected = [13.0, 9.0, 3.0, 4.0, 0.0, -8.0];
    for (s, e) in sigma.0.iter().zip(expected) {
        assert_relative_eq!(*s, e, epsilon = 1e-14);
    }
}

#[test]
fn interpolation_is_the_plain_sum_inside_and_exact_at_the_surface() {
    let n = 11;
    let body = common::clamped_cube(n, 1.25, 0.3);
    let field = |x: &Vec3| 1.5 - 0.4 * x.x + 0.9 * x.y + 2.0 * x.z;
    let values: Vec<f64> = body.positions.iter().map(field).collect();
    let column = Column::from_vec(values.clone(), values.len());
    let points = [Vec3::new(0.47, 0.52, 0.5), Vec3::new(0.0, 0.3, 1.0), Vec3::repeat(1.0)];
    let lattice = &body.solid.lattice;
    let volume = vec![body.spacing.powi(3); values.len()];
    let weights = PointWeights::new(&Cloud::new(&body.positions, &volume, lattice.spacing), &points);
    for (i, x) in points.iter().enumerate() {
        assert_relative_eq!(weights.value(&column, 0, i), field(x), max_relative = 1e-10);
    }
    // Eq. (8) to the letter, where the support is full.
    let kernel = QuarticSpline::<3>::new(lattice.spacing);
    let volume = body.spacing.powi(3);
    let sum: f64 = body
        .positions
        .iter()
        .zip(&values)
        .map(|(b, a)| a * volume * kernel.value((points[0] - b).norm()))
        .sum();
    assert_relative_eq!(weights.value(&column, 0, 0), sum, max_relative = 2e-3);
}

/// The literal scheme on a lattice of n^3 particles (dx = 1, rho = 2, E = 100, nu = 0.3, T = 0.2) with
/// velocity and strain given as functions of x; the rates of the particle in the middle, far from
/// any surface.
fn literal_rates(
    velocity: impl Fn(&Vec3) -> Vec3,
    strain: impl Fn(&Vec3) -> SymTensor,
) -> (Vec3, f64, SymTensor) {
    let n = 11;
    let count = n * n * n;
    let x: Vec<Vec3> =
        (0..count).map(|a| Vec3::new((a % n) as f64, (a / n % n) as f64, (a / n / n) as f64)).collect();
    let mut particles = Particles::new(count);
    particles.set(Field::Reference, Column::from_vectors(&x));
    particles.set(Field::Displacement, Column::zeros(3, count));
    particles.set(Field::Velocity, Column::from_vectors(&x.iter().map(&velocity).collect::<Vec<_>>()));
    particles.set(Field::Density, Column::from_vec(vec![2.0; count], count));
    particles.set(Field::LevelSet, Column::from_vec(vec![-10.0; count], count));
    let e: Vec<SymTensor> = x.iter().map(strain).collect();
    let components = (0..6).flat_map(|c| e.iter().map(move |e| e.0[c])).collect();
    particles.set(Field::Strain, Column::from_vec(components, count));
    let material = Arc::new(KelvinVoigt::new(2.0, 100.0, 0.3, 0.2).unwrap());
    let mut paper = Paper::new(material, vec![2.0; count], 1.0, 1.25, Fixed::default(), Vec::new());
    let mut rates: Vec<Column> =
        paper.integrated().iter().map(|f| Column::zeros(f.spec().components, count)).collect();
    paper.rates(0.0, &particles, &mut rates);
    let middle = count / 2;
    (rates[1].vector(middle), rates[2].values()[middle], rates[3].tensor(middle))
}

/// sum_b V_b w X_x^2 of a full neighbourhood at h = 1.25 dx: what the uncorrected gradient of Eq. (10)
/// makes of a gradient of one.
fn full_moment() -> f64 {
    let kernel = QuarticSpline::<3>::new(1.25);
    let mut sum = 0.0;
    for k in -4..=4 {
        for j in -4..=4 {
            for i in -4..=4 {
                let x = Vec3::new(f64::from(i), f64::from(j), f64::from(k));
                if x.norm() > 0.0 {
                    sum += kernel.gradient_weight(x.norm()) * x.x * x.x;
                }
            }
        }
    }
    sum
}

#[test]
fn literal_rates_of_density_and_strain() {
    let g = Mat3::new(0.1, -0.3, 0.2, 0.05, 0.2, -0.1, 0.4, 0.15, -0.25);
    let (_, density_rate, strain_rate) = literal_rates(|x| g * x, |_| SymTensor::ZERO);
    let m = full_moment();
    assert!((m - 1.0).abs() < 0.02, "moment {m}");
    assert_relative_eq!(density_rate, -2.0 * m * g.trace(), max_relative = 1e-12); // Eq. (11)
    for (e, expected) in strain_rate.0.iter().zip(SymTensor::symmetric_part(&g).0) {
        assert_relative_eq!(*e, m * expected, epsilon = 1e-13); // Eqs. (7), (13)
    }
}

#[test]
fn literal_acceleration_is_the_divergence_of_the_stress() {
    // e_xx = c x: div sigma = ((lambda + 2 mu) c, 0, 0). e_xy = c y: div sigma = (2 mu c, 0, 0).
    let c = 1e-3;
    let (lambda, mu) = (100.0 * 0.3 / (0.4 * 1.3), 100.0 / 2.6);
    let m = full_moment();
    let (a, _, _) = literal_rates(|_| Vec3::zeros(), |x| SymTensor([c * x.x, 0.0, 0.0, 0.0, 0.0, 0.0]));
    assert!((a - Vec3::new(m * (lambda + 2.0 * mu) * c / 2.0, 0.0, 0.0)).norm() < 1e-12); // Eq. (12)
    let (a, _, _) = literal_rates(|_| Vec3::zeros(), |x| SymTensor([0.0, 0.0, 0.0, c * x.y, 0.0, 0.0]));
    assert!((a - Vec3::new(m * 2.0 * mu * c / 2.0, 0.0, 0.0)).norm() < 1e-12); // Eq. (12)
}

#[test]
fn penalty_force_cancels_the_surface_traction() {
    let sigma = SymTensor([3.0, -1.0, 2.0, 0.5, -0.25, 1.0]);
    let (n, area) = (Vec3::new(2.0, -1.0, 2.0) / 3.0, 0.01);
    let traction = sigma.to_matrix() * n;
    assert!((penalty_force(sigma, &n, area) + area * traction).norm() < 1e-16); // Eq. (14)
}
