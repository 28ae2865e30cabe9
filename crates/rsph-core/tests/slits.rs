//! Parts of the surface that face each other across a gap: nothing acts across it, whatever its width.

mod common;

use common::{Noise, TestBody, body};
use rsph_core::dynamics::Dynamics;
use rsph_core::material::KelvinVoigt;
use rsph_core::mesh::TriangleMesh;
use rsph_core::particles::{Column, Field, Particles};
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Boundary, Curve, Fix, Load, LoadKind, Probe, Quantity, Setup, SolidSetup, Solver};
use rsph_core::shape::{BoxShape, MeshShape, Shape};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// Edge of the arms of a fork, in spacings, their length from its root on, and that of the root.
const EDGE: f64 = 6.0;
const ARM: f64 = 24.0;
const ROOT: f64 = 6.0;

/// Two arms along x, one above the other along y, joined at x < `ROOT`, with a slit of that width between them, moved by `shift`.
fn fork(slit: f64, shift: Vec3) -> MeshShape {
    let (length, height) = (ROOT + ARM, 2.0 * EDGE + slit);
    let outline = [
        [0.0, 0.0],
        [length, 0.0],
        [length, EDGE],
        [ROOT, EDGE],
        [ROOT, EDGE + slit],
        [length, EDGE + slit],
        [length, height],
        [0.0, height],
    ];
    let n = outline.len() as u32;
    let at = |z: f64| outline.map(|[x, y]| Vec3::new(x, y, z) + shift);
    let mut mesh = TriangleMesh { vertices: [at(0.0), at(EDGE)].concat(), triangles: Vec::new() };
    for i in 0..n {
        let j = (i + 1) % n;
        mesh.triangles.extend([[i, j, j + n], [i, j + n, i + n]]);
    }
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 7], [4, 5, 6], [4, 6, 7]] {
        mesh.triangles.extend([[a, c, b], [a + n, b + n, c + n]]);
    }
    MeshShape::new(&mesh, "fork").unwrap().0
}

/// The fork clamped at x = 0, the end of its upper arm pulled up: the displacements of the upper tip and of the lower one.
fn tips(slit: f64, shift: Vec3, spacing: f64) -> (f64, f64, usize) {
    let plane = |axis, at, side| Region::Plane { axis, at, side };
    let upper = Region::And(vec![
        plane(Axis::X, ROOT + ARM + shift.x, Side::Above),
        plane(Axis::Y, EDGE + 0.5 * slit + shift.y, Side::Above),
    ]);
    let probe = |y: f64| Probe {
        name: "tip".into(),
        quantity: Quantity { field: Field::Displacement, component: Some(1) },
        region: Region::Point(shift + Vec3::new(ROOT + ARM - 1.0, y, 0.5 * EDGE)),
    };
    let kind = LoadKind::Traction { region: upper, traction: Vec3::new(0.0, 1e-4, 0.0) };
    let mut simulation = Simulation::new(Setup {
        solver: Solver::ACCURATE,
        probes: vec![probe(EDGE + slit + 0.5 * EDGE), probe(0.5 * EDGE)],
        ..Setup::new(
            Arc::new(fork(slit, shift)),
            Resolution::Spacing(spacing),
            SolidSetup {
                boundaries: vec![Boundary {
                    name: None,
                    region: plane(Axis::X, shift.x, Side::Below),
                    fix: Fix::ALL,
                    motion: None,
                }],
                loads: vec![Load { kind, curve: Curve::ramp(0.0, 1.0) }],
                ..SolidSetup::new(Arc::new(KelvinVoigt::new(1.0, 1.0, 0.3, 0.0).unwrap()))
            },
        )
    })
    .unwrap();
    let found = simulation.solve_static(1.0, &mut |_, _| true).unwrap();
    let readings = simulation.readings();
    (readings[0].value, readings[1].value, found.iterations)
}

/// Five per cent: what the place of the lattice alone changes at six particles across an arm.
#[test]
fn a_fork_bends_one_arm_whatever_the_width_of_its_slit() {
    let (wide, _, _) = tips(3.0, Vec3::zeros(), 1.0);
    // Anywhere relative to the clusters of the surface, which do not lie where the body does.
    let shifts = [Vec3::new(0.1, 0.23, 0.4), Vec3::new(0.0, 0.5, 0.0)];
    let slits = [0.02, 0.1, 0.25, 0.4, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.25];
    for (slit, shift) in slits.into_iter().zip(shifts.into_iter().cycle()) {
        let (up, low, iterations) = tips(slit, shift, 1.0);
        println!("{slit}: {:.4} {:.4} {iterations}", up / wide - 1.0, low / wide);
        assert!((up / wide - 1.0).abs() < 0.05, "{slit}: {up}, {wide} with a wide slit");
        assert!((low / wide).abs() < 0.05, "{slit}: {low}, {wide} with a wide slit");
    }
}

#[test]
fn the_last_digit_of_the_spacing_changes_nothing() {
    let exact = tips(2.0, Vec3::zeros(), 1.0);
    for spacing in [1.0 - 1e-7, 1.0 + 1e-7] {
        assert_eq!(tips(2.0, Vec3::zeros(), spacing), exact);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The fork with a narrow slit, at rest, anywhere on its lattice.
fn small_fork(smoothing: f64) -> TestBody {
    body(Arc::new(fork(0.3, Vec3::new(0.0, 0.21, 0.1))), Resolution::Spacing(1.37), smoothing, 1.0, 0.3, &[])
}

#[test]
fn pairs_across_a_slit_are_left_out_and_no_others() {
    for smoothing in [0.8, 1.25] {
        let body = small_fork(smoothing);
        let lattice = &body.solid.lattice;
        let middle = EDGE + 0.15 + 0.21;
        let (mut parted, mut joined) = (0, 0);
        for a in 0..lattice.len() {
            let x = lattice.position(a);
            for neighbour in &lattice.neighbours {
                let y = x + neighbour.x;
                let is_there = lattice
                    .particle(std::array::from_fn(|i| {
                        ((y - lattice.origin)[i] / lattice.spacing).floor() as isize
                    }))
                    .is_some();
                // Well beyond the end of the slit, on other sides of it and not beside it.
                let beside = (x.y - middle).abs().min((y.y - middle).abs()) < 0.5;
                if !is_there || beside || x.x.min(y.x) < ROOT + 1.4 * lattice.spacing {
                    joined += usize::from(
                        is_there && x.x.max(y.x) < ROOT && lattice.neighbour(a, neighbour).is_none(),
                    );
                    continue;
                }
                let is_across = (x.y - middle) * (y.y - middle) < 0.0;
                assert_eq!(lattice.neighbour(a, neighbour).is_none(), is_across, "{x:?} {y:?}");
                parted += usize::from(is_across);
            }
        }
        assert!(parted > 100 && joined == 0, "{parted} {joined}");
    }
}

#[test]
fn linear_fields_stay_exact_beside_a_slit() {
    let g = Mat3::new(0.1, -0.3, 0.2, 0.05, 0.2, -0.1, 0.4, 0.15, -0.25);
    for smoothing in [0.8, 1.25] {
        let mut body = small_fork(smoothing);
        let n = body.positions.len();
        let u: Vec<Vec3> = body.positions.iter().map(|x| g * x).collect();
        let strain = body.solid.strain(0.0, Column::from_vectors(&u).values());
        let expected = rsph_core::tensor::SymTensor::symmetric_part(&g);
        for a in 0..n {
            for c in 0..6 {
                assert!((strain[c * n + a] - expected.0[c]).abs() < 1e-11, "particle {a} component {c}");
            }
        }
    }
}

#[test]
fn the_force_of_a_body_with_a_slit_is_the_derivative_of_its_energy() {
    for smoothing in [0.8, 1.25] {
        let mut body = small_fork(smoothing);
        let n = body.positions.len();
        let mut noise = Noise(7);
        let (u, v) = (noise.column(3 * n), noise.column(3 * n));
        let (mut of_u, mut of_v) = (vec![0.0; 3 * n], vec![0.0; 3 * n]);
        body.solid.force_of(&u, &mut of_u);
        body.solid.force_of(&v, &mut of_v);
        let (uv, vu) = (dot(&u, &of_v), dot(&v, &of_u));
        assert!((uv - vu).abs() < 1e-10 * dot(&u, &of_u).abs(), "{uv} {vu}");
        let mut particles = Particles::new(n);
        particles.set(Field::Reference, Column::from_vectors(&body.positions));
        particles.set(Field::Displacement, Column::from_vec(u.clone(), n));
        particles.set(Field::Velocity, Column::zeros(3, n));
        let energy = body.solid.energy(0.0, &particles).elastic;
        assert!((energy / (-0.5 * dot(&u, &of_u)) - 1.0).abs() < 1e-10, "{energy}");
    }
}

#[test]
fn two_bodies_in_one_file_feel_nothing_of_each_other() {
    let mut mesh = BoxShape::new(Vec3::new(8.0, 6.0, 6.0), Vec3::zeros()).unwrap().surface().clone();
    let other = BoxShape::new(Vec3::new(7.0, 5.5, 6.2), Vec3::new(8.2, 0.3, 0.1)).unwrap();
    mesh.triangles.extend(other.surface().triangles.iter().map(|t| t.map(|v| v + 8)));
    mesh.vertices.extend(&other.surface().vertices);
    let shape: Arc<dyn Shape> = Arc::new(MeshShape::new(&mesh, "two").unwrap().0);
    for smoothing in [0.8, 1.25] {
        let mut body = body(Arc::clone(&shape), Resolution::Spacing(0.93), smoothing, 1.0, 0.3, &[]);
        let n = body.positions.len();
        let pieces = body.solid.lattice.pieces();
        assert_eq!(pieces.len(), 2);
        let mut noise = Noise(3);
        let mut u = vec![0.0; 3 * n];
        for &a in &pieces[0] {
            (0..3).for_each(|i| u[i * n + a] = noise.next());
        }
        let mut force = vec![0.0; 3 * n];
        body.solid.force_of(&u, &mut force);
        let largest = force.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        for &a in &pieces[1] {
            assert!((0..3).all(|i| force[i * n + a].abs() < 1e-13 * largest), "particle {a}");
        }
    }
}
