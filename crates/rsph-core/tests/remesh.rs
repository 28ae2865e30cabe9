//! Remeshing of clouds of particles: what is conserved, in 1, 2 and 3 dimensions.

mod common;

use common::Noise;
use nalgebra::Rotation3;
use proptest::prelude::*;
use rsph_core::kernel::RemeshKernel;
use rsph_core::particles::{Column, Field, Particles};
use rsph_core::remesh::{Carried, NewVolume, NodeLattice, RemeshError, Remeshed, Remesher, gather, scatter};
use rsph_core::tensor::{Mat3, Vec3};

const FIELDS: [Field; 4] = [Field::Mass, Field::Volume, Field::Velocity, Field::Strain];

/// A random cloud of `n` particles in the first `dimensions` of a box of about 10 spacings.
fn cloud(n: usize, dimensions: usize, seed: u64) -> (Particles, Vec<Vec3>) {
    let mut noise = Noise(seed | 1);
    let positions: Vec<Vec3> = (0..n)
        .map(|_| Vec3::from_fn(|i, _| if i < dimensions { 10.0 * noise.next() } else { 0.0 }))
        .collect();
    let mut particles = Particles::new(n);
    for field in FIELDS {
        let positive = matches!(field, Field::Mass | Field::Volume);
        let values = noise.column(n * field.spec().components);
        let values = values.into_iter().map(|x| if positive { x + 1.0 } else { x }).collect();
        particles.set(field, Column::from_vec(values, n));
    }
    (particles, positions)
}

fn remesher<const D: usize>(kernel: RemeshKernel) -> Remesher<D> {
    let lattice = NodeLattice { origin: Vec3::new(0.3, -0.2, 0.1), spacing: 0.7 };
    Remesher { kernel, lattice, volume: NewVolume::Conserved }
}

/// Total, first and second moment of an extensive quantity.
fn moments(weight: impl Fn(usize) -> f64, x: &[Vec3]) -> (f64, Vec3, f64) {
    let mut sums = (0.0, Vec3::zeros(), 0.0);
    for (a, x) in x.iter().enumerate() {
        sums.0 += weight(a);
        sums.1 += weight(a) * x;
        sums.2 += weight(a) * x.norm_squared();
    }
    sums
}

fn check_conserved<const D: usize>(kernel: RemeshKernel, n: usize, seed: u64) {
    let (old, x) = cloud(n, D, seed);
    let new = remesher::<D>(kernel).remesh(&old, &x, &FIELDS, &|_, _| true).unwrap();
    let mass = |p: &Particles| p.column(Field::Mass).values().to_vec();
    let (m, m_new) = (mass(&old), mass(&new.particles));
    let (before, after) = (moments(|a| m[a], &x), moments(|a| m_new[a], &new.positions));
    assert!((after.0 / before.0 - 1.0).abs() < 1e-13, "mass {} {}", before.0, after.0);
    let scale = 10.0 * before.0;
    assert!((after.1 - before.1).norm() < 1e-13 * scale, "centre of mass");
    assert!((after.2 - before.2).abs() < 1e-12 * scale * 10.0, "inertia {} {}", before.2, after.2);
    // Momentum, and strain times volume, Eq. (17).
    let momentum = |p: &Particles| -> Vec3 {
        (0..p.len()).map(|a| p.column(Field::Velocity).vector(a) * p.column(Field::Mass).values()[a]).sum()
    };
    assert!((momentum(&new.particles) - momentum(&old)).norm() < 1e-12 * before.0);
    let strained = |p: &Particles, c: usize| -> f64 {
        let (e, v) = (p.column(Field::Strain).component(c), p.column(Field::Volume).values());
        e.iter().zip(v).map(|(e, v)| e * v).sum()
    };
    for c in 0..6 {
        assert!((strained(&new.particles, c) - strained(&old, c)).abs() < 1e-12 * before.0);
    }
    if D < 3 {
        assert!(new.positions.iter().all(|x| x.z == 0.0));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    #[test]
    fn mass_momentum_and_centre_are_conserved(n in 1..60_usize, seed in 1..u64::MAX, k in 0..3_usize) {
        let kernel = RemeshKernel::ALL[k];
        check_conserved::<1>(kernel, n, seed);
        check_conserved::<2>(kernel, n, seed);
        check_conserved::<3>(kernel, n, seed);
    }

    /// A polynomial of the kernel's order is interpolated exactly inside, in both directions.
    #[test]
    fn polynomials_are_reproduced(x in prop::array::uniform3(-1.0..1.0_f64), k in 0..3_usize) {
        let kernel = RemeshKernel::ALL[k];
        let lattice = NodeLattice::<3> { origin: Vec3::zeros(), spacing: 0.5 };
        let nodes: Vec<Vec3> = (0..1728)
            .map(|q| lattice.position([q % 12 - 6, q / 12 % 12 - 6, q / 144 - 6]))
            .collect();
        let order = kernel.order() as i32;
        let f = |x: &Vec3| (x.x - 0.3).powi(order) + x.y * x.z - 2.0 * x.z.powi(order - 1);
        // Particles at nodes stay as they are.
        let values: Vec<f64> = nodes.iter().map(f).collect();
        let field = scatter(kernel, lattice, &nodes, 1, &values).unwrap();
        let x = Vec3::from(x);
        let value = gather(kernel, &field, &[x])[0];
        prop_assert!((value - f(&x)).abs() < 1e-10, "{} {}", value, f(&x));
    }
}

fn bits(r: &Remeshed) -> Vec<u64> {
    let of = |f: Field| r.particles.column(f).values().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    FIELDS.iter().flat_map(|f| of(*f)).collect()
}

#[test]
fn one_and_two_threads_agree_bit_by_bit() {
    let (particles, x) = cloud(3000, 3, 77);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let keep = |_: &Vec3, v: &[f64]| v[0].abs() > 0.2;
        pool.install(|| remesher::<3>(RemeshKernel::Lambda42).remesh(&particles, &x, &FIELDS, &keep).unwrap())
    };
    let (one, two) = (run(1), run(2));
    assert_eq!(one.nodes, two.nodes);
    assert_eq!(bits(&one), bits(&two));
}

#[test]
fn what_is_not_kept_goes_to_the_nearest_or_is_counted() {
    let (particles, x) = cloud(500, 3, 5);
    let total = |p: &Particles, f: Field| p.column(f).values().iter().sum::<f64>();
    let r = remesher::<3>(RemeshKernel::M4Prime);
    let folded = r.remesh(&particles, &x, &FIELDS, &|_, v| v[0] > 0.3).unwrap();
    let all = r.remesh(&particles, &x, &FIELDS, &|_, _| true).unwrap();
    assert!(folded.nodes.len() < all.nodes.len() / 2);
    assert!(folded.report.folded_mass > 0.0 && folded.report.dropped_mass.abs() < 1e-15);
    let (before, after) = (total(&particles, Field::Mass), total(&folded.particles, Field::Mass));
    assert!((after / before - 1.0).abs() < 1e-13);

    // Two pieces, one of which is not kept at all and too far from the other: its mass is counted.
    let far: Vec<Vec3> =
        x.iter().map(|x| if x.x > 0.0 { x + Vec3::new(500.0, 0.0, 0.0) } else { *x }).collect();
    let lost = r.remesh(&particles, &far, &FIELDS, &|x, _| x.x < 100.0).unwrap();
    let kept = total(&lost.particles, Field::Mass);
    assert!(lost.report.dropped_mass > 1.0);
    assert!((kept + lost.report.dropped_mass - before).abs() < 1e-12 * before);
    // Both are kept: nothing happens to either, however far the lattice has to reach.
    let both = r.remesh(&particles, &far, &FIELDS, &|_, _| true).unwrap();
    assert!((total(&both.particles, Field::Mass) / before - 1.0).abs() < 1e-13);
}

#[test]
fn what_no_lattice_holds_is_an_error() {
    let (particles, mut x) = cloud(10, 3, 9);
    let r = remesher::<3>(RemeshKernel::M4Prime);
    let keep = |_: &Vec3, _: &[f64]| true;
    x[3].y = f64::NAN;
    assert!(matches!(r.remesh(&particles, &x, &FIELDS, &keep), Err(RemeshError::Lost { particle: 3, .. })));
    x[3].y = 1e30;
    let error = r.remesh(&particles, &x, &FIELDS, &keep).unwrap_err().to_string();
    assert!(error.contains("particle 3") && error.contains("no lattice"), "{error}");
    x[3] = x[2] + Vec3::new(1e8, 0.0, 0.0);
    assert!(matches!(r.remesh(&particles, &x, &FIELDS, &keep), Err(RemeshError::TooFar(_))));
    // Along y and z rows are sparse.
    x[3] = x[2] + Vec3::new(0.0, 1e8, 1e8);
    assert!(r.remesh(&particles, &x, &FIELDS, &keep).is_ok());

    let mut massless = Particles::new(1);
    massless.set(Field::Velocity, Column::zeros(3, 1));
    let error = r.remesh(&massless, &[Vec3::zeros()], &[Field::Velocity], &keep).unwrap_err().to_string();
    assert!(error.contains("velocity") && error.contains("mass"), "{error}");
    let nothing = r.remesh(&Particles::new(0), &[], &FIELDS, &keep).unwrap();
    assert!(nothing.nodes.is_empty());
}

#[test]
fn a_colour_has_the_volume_of_its_cell() {
    let mut particles = Particles::new(1);
    particles.set(Field::Volume, Column::from_vec(vec![0.343], 1));
    particles.set(Field::Colour, Column::from_vec(vec![1.0], 1));
    let r = Remesher::<3> { volume: NewVolume::Cell, ..remesher(RemeshKernel::M4Prime) };
    let at_node = r.lattice.position([2, -1, 3]);
    let new = r.remesh(&particles, &[at_node], &[Field::Colour], &|_, v| v[0].abs() > 1e-9).unwrap();
    assert_eq!(new.nodes, [[2, -1, 3]]);
    assert!((new.particles.column(Field::Colour).values()[0] - 1.0).abs() < 1e-12);
    assert!((new.particles.column(Field::Volume).values()[0] - 0.343).abs() < 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    /// A body that was moved, turned and strained uniformly: what it carries is found where it is now, exactly if
    /// it is linear, with its gradient, and the nodes in it are all there.
    #[test]
    fn linear_fields_are_followed_exactly(
        shift in prop::array::uniform3(-30.0..30.0_f64),
        strain in prop::array::uniform9(-0.1..0.1_f64),
        turn in prop::array::uniform3(-1.8..1.8_f64),
        k in 0..3_usize,
    ) {
        let lattice = NodeLattice::<3> { origin: Vec3::new(0.1, 0.2, -0.3), spacing: 0.5 };
        let n = 7;
        let nodes: Vec<[i64; 3]> = (0..n * n * n).map(|q| [q % n, q / n % n, q / n / n]).collect();
        let turn = *Rotation3::new(Vec3::from(turn)).matrix();
        let gradient = turn * (Mat3::identity() + Mat3::from_row_slice(&strain)) - Mat3::identity();
        let shift: Vec<Vec3> =
            nodes.iter().map(|q| Vec3::from(shift) + gradient * lattice.position(*q)).collect();
        let slope = Mat3::new(2.0, -1.0, 0.3, 0.5, 0.1, -0.7, 0.0, 1.0, 0.2);
        let f = |xi: &Vec3| slope * xi + Vec3::x();
        let values: Vec<f64> = nodes.iter().flat_map(|q| <[f64; 3]>::from(f(&lattice.position(*q)))).collect();
        let carried = Carried { lattice, nodes: &nodes, shift: &shift, columns: 3, values: &values };
        let arrived = carried.follow(RemeshKernel::ALL[k]).unwrap();
        let back = (Mat3::identity() + gradient).try_inverse().unwrap();
        let xi = |q: &[i64; 3]| back * (lattice.position(*q) - (shift[0] - gradient * lattice.position(nodes[0])));
        for ((node, value), g) in arrived.nodes.iter().zip(arrived.values.chunks(3)).zip(&arrived.gradients) {
            let error = Vec3::from_column_slice(value) - f(&xi(node));
            prop_assert!(error.norm() < 1e-9, "{}", error);
            prop_assert!((g - slope * back).norm() < 1e-7, "{}", g);
        }
        // Every node that lies in the body was reached.
        let inside = arrived.nodes.iter().filter(|q| {
            let c = (xi(q) - lattice.position([0; 3])) / lattice.spacing;
            c.iter().all(|c| (-0.4..6.4).contains(c))
        });
        let volume = 6.8_f64.powi(3) * (Mat3::identity() + gradient).determinant();
        prop_assert!((inside.count() as f64 / volume - 1.0).abs() < 0.35);
    }
}

#[test]
fn what_has_not_moved_is_followed_without_any_change() {
    let lattice = NodeLattice::<2> { origin: Vec3::zeros(), spacing: 0.1 };
    let nodes: Vec<[i64; 3]> = (0..25).map(|q| [q % 5, q / 5, 0]).collect();
    let mut noise = Noise(3);
    let values = noise.column(3 * nodes.len());
    let shift = vec![Vec3::zeros(); nodes.len()];
    let carried = Carried { lattice, nodes: &nodes, shift: &shift, columns: 3, values: &values };
    let arrived = carried.follow(RemeshKernel::M4Prime).unwrap();
    for (node, value) in nodes.iter().zip(values.chunks(3)) {
        let k = arrived.nodes.iter().position(|n| n == node).unwrap();
        assert!(arrived.values[3 * k..][..3].iter().zip(value).all(|(a, v)| (a - v).abs() < 1e-15));
    }
}
