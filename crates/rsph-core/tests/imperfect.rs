//! Winding numbers against exact ones, and bodies from surfaces that are none.

use proptest::prelude::*;
use rsph_core::grid::Grid;
use rsph_core::marching_cubes::zero_level_set;
use rsph_core::mesh::TriangleMesh;
use rsph_core::shape::{BoxShape, MeshShape, Repair, Shape, SphereShape, organ, winding_field};
use rsph_core::tensor::Vec3;
use rsph_core::winding::{WindingField, solid_angle};
use std::f64::consts::{PI, TAU};
use std::time::{Duration, Instant};

fn cube() -> TriangleMesh {
    BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap().surface().clone()
}

fn ball(centre: [f64; 3]) -> TriangleMesh {
    SphereShape::new(1.0, Vec3::from(centre)).unwrap().surface().clone()
}

fn without(mesh: &TriangleMesh, drop: impl Fn([Vec3; 3]) -> bool) -> TriangleMesh {
    let triangles =
        (0..mesh.triangles.len()).filter(|&t| !drop(mesh.corners(t))).map(|t| mesh.triangles[t]).collect();
    TriangleMesh { vertices: mesh.vertices.clone(), triangles }
}

fn together(meshes: &[TriangleMesh]) -> TriangleMesh {
    let mut all = TriangleMesh::default();
    for mesh in meshes {
        let first = all.vertices.len() as u32;
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
        all.vertices.extend(&mesh.vertices);
    }
    all
}

/// The upper half of the unit sphere from `n` rings of triangles, open below.
fn dome(n: u32) -> TriangleMesh {
    let around = 4 * n;
    let mut mesh = TriangleMesh::default();
    for ring in 0..=n {
        let polar = 0.5 * PI * f64::from(ring) / f64::from(n);
        for i in 0..around {
            let angle = TAU * f64::from(i) / f64::from(around);
            mesh.vertices.push(Vec3::new(polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos()));
        }
    }
    for ring in 0..n {
        for i in 0..around {
            let at = |r: u32, i: u32| r * around + i % around;
            mesh.triangles.push([at(ring, i), at(ring + 1, i), at(ring + 1, i + 1)]);
            mesh.triangles.push([at(ring, i), at(ring + 1, i + 1), at(ring, i + 1)]);
        }
    }
    mesh.merged()
}

fn repaired(mesh: &TriangleMesh) -> (MeshShape, Repair, Vec<String>) {
    let (shape, notes) = MeshShape::new(mesh, "mesh test").unwrap();
    assert!(shape.surface().is_closed());
    let repair = shape.repair().expect("it was repaired").clone();
    (shape, repair, notes)
}

fn field(mesh: &TriangleMesh) -> WindingField {
    WindingField::new(mesh, &vec![1.0; mesh.triangles.len()])
}

#[test]
fn a_closed_surface_winds_once_around_its_inside() {
    let mesh = cube();
    let seen: f64 = (0..12).map(|t| solid_angle(&mesh.corners(t), &Vec3::repeat(0.5))).sum();
    assert!((seen - 4.0 * PI).abs() < 1e-12, "{seen}");
    let kidney = organ("kidney").unwrap();
    let surface = field(kidney.surface());
    let (low, size) = (kidney.bounds().min, kidney.bounds().size());
    for q in 0..125 {
        let x = low + Vec3::from([q % 5, q / 5 % 5, q / 25].map(f64::from)).component_mul(&size) * 0.25;
        let distance = kidney.signed_distance(&x);
        if distance.abs() > 1e-6 {
            let exact = f64::from(u8::from(distance < 0.0));
            assert!((surface.at_by_all(&x) - exact).abs() < 1e-12, "{} at {x:?}", surface.at_by_all(&x));
        }
    }
}

#[test]
fn a_dome_winds_as_the_disc_that_it_lacks_says() {
    let dome = field(&dome(64));
    for height in [-2.0_f64, -0.5, -0.01, 0.01, 0.3, 0.8, 1.5_f64] {
        // Dome and disc together are closed: w = [inside] - (solid angle of the disc) / 4 pi.
        let disc = 0.5 * (1.0 - height.abs() / height.hypot(1.0)) * height.signum();
        let exact = f64::from(u8::from((0.0..1.0).contains(&height))) - disc;
        let x = Vec3::new(0.0, 0.0, height);
        assert!((dome.at_by_all(&x) - exact).abs() < 1e-3, "{} {exact}", dome.at_by_all(&x));
        assert!((dome.at(&x) - exact).abs() < 5e-3, "{} {exact}", dome.at(&x));
    }
}

proptest! {
    /// The tree keeps to the sum over all triangles, near the surface and far from it.
    #[test]
    fn the_tree_agrees_with_the_sum(at in prop::array::uniform3(-2.0..2.0_f64), turned in any::<u64>()) {
        let mesh = dome(16);
        let weight: Vec<f64> = (0..mesh.triangles.len()).map(|t| if turned >> (t % 64) & 1 == 0 { 1.0 } else { -0.5 }).collect();
        let field = WindingField::new(&mesh, &weight);
        let x = Vec3::from(at);
        prop_assert!((field.at(&x) - field.at_by_all(&x)).abs() < 0.01, "{} {}", field.at(&x), field.at_by_all(&x));
    }
}

#[test]
fn a_cube_without_a_face_is_a_cube() {
    let (shape, repair, notes) = repaired(&without(&cube(), |t| t.iter().all(|v| v.z > 0.99)));
    assert!((shape.volume() - 1.0).abs() < 2e-3, "{}", shape.volume());
    assert_eq!((repair.open_edges, repair.parts), (4, 1));
    // A sixth of its surface was missing, and the middle of the missing face is half an edge away from the others.
    assert!((repair.made_up - 1.0 / 6.0).abs() < 0.01, "{repair:?}");
    assert!(
        (repair.gap - 0.5).abs() < 0.01 && (repair.gap_at - Vec3::new(0.5, 0.5, 1.0)).norm() < 0.02,
        "{repair:?}"
    );
    assert!((0.15..0.3).contains(&repair.uncertain), "{repair:?}");
    assert!(repair.between[0] < shape.volume() && shape.volume() < repair.between[1] + 1e-3, "{repair:?}");
    assert!(notes[0].contains("guess"), "{notes:?}");
}

#[test]
fn half_a_sphere_leaves_too_much_open() {
    let error = MeshShape::new(&dome(24), "mesh dome").unwrap_err();
    assert!(error.problem.contains("96 open edges") && error.problem.contains("too wide"), "{error}");
    // With a lid nearly as wide, it is half a ball.
    let lid = |radius: f64| {
        let rim = (0..96)
            .map(|i| TAU * f64::from(i) / 96.0)
            .map(|a| Vec3::new(radius * a.cos(), radius * a.sin(), 0.0));
        let vertices = rim.chain([Vec3::zeros()]).collect();
        TriangleMesh { vertices, triangles: (0..96).map(|i| [96, (i + 1) % 96, i]).collect() }
    };
    let (shape, repair, _) = repaired(&together(&[dome(24), lid(0.9)]));
    assert!((shape.volume() / (2.0 / 3.0 * PI) - 1.0).abs() < 0.01, "{}", shape.volume());
    assert!(repair.uncertain < 0.1, "{repair:?}");
}

/// Volume of two unit balls at that distance.
fn union_of_balls(distance: f64) -> f64 {
    8.0 / 3.0 * PI - PI * (4.0 + distance) * (2.0 - distance).powi(2) / 12.0
}

#[test]
fn overlapping_balls_are_their_union_whatever_is_wrong_with_them() {
    let (a, b) = (ball([0.0; 3]), ball([1.0, 0.0, 0.0]));
    let exact = union_of_balls(1.0);
    let lens = 8.0 / 3.0 * PI - exact;
    let holed = without(&b, |t| t.iter().all(|v| v.z > 0.98));
    let turned = TriangleMesh {
        triangles: b
            .triangles
            .iter()
            .enumerate()
            .map(|(t, &[p, q, r])| if t % 3 == 0 { [p, r, q] } else { [p, q, r] })
            .collect(),
        ..b.clone()
    };
    let again = TriangleMesh { triangles: [&b.triangles[..], &b.triangles[..40]].concat(), ..b.clone() };
    for (what, other) in [
        ("closed", b.clone()),
        ("open", holed.clone()),
        ("inside out", b.flipped()),
        ("open and inside out", holed.flipped()),
        ("turned here and there", turned),
        ("in part twice", again),
    ] {
        let (shape, repair, notes) = repaired(&together(&[a.clone(), other]));
        assert!((shape.volume() / exact - 1.0).abs() < 4e-3, "{what}: {} {exact}", shape.volume());
        assert!((repair.overlapping - lens / exact).abs() < 2e-3, "{what}: {repair:?}");
        assert_eq!(shape.surface().components(), 1, "{what}");
        assert!(repair.made_up < 0.01 && repair.uncertain < 0.01, "{what}: {repair:?}");
        assert_eq!(
            notes.iter().any(|n| n.contains("inside out")),
            what.contains("inside out"),
            "{what}: {notes:?}"
        );
    }
}

#[test]
fn a_surface_that_crosses_itself_is_filled_once() {
    // A prism over the loop r = 1/2 + cos(angle), which winds twice around its inner part.
    let n = 240_u32;
    let rim = |z: f64| {
        (0..n).map(move |i| {
            let angle = TAU * f64::from(i) / f64::from(n);
            let r = 0.5 + angle.cos();
            Vec3::new(r * angle.cos(), r * angle.sin(), z)
        })
    };
    let vertices =
        rim(0.0).chain(rim(1.0)).chain([Vec3::new(0.25, 0.0, 0.0), Vec3::new(0.25, 0.0, 1.0)]).collect();
    let triangles = (0..n)
        .flat_map(|i| {
            let j = (i + 1) % n;
            [[i, j, n + j], [i, n + j, n + i], [2 * n, j, i], [2 * n + 1, n + i, n + j]]
        })
        .collect();
    let (shape, repair, notes) = repaired(&TriangleMesh { vertices, triangles });
    let third = TAU / 3.0;
    let exact = 0.75 * third + third.sin() + 0.25 * (2.0 * third).sin();
    assert!((shape.volume() / exact - 1.0).abs() < 5e-3, "{} {exact}", shape.volume());
    assert_eq!(repair.open_edges, 0);
    assert!(notes[0].contains("overlaps itself"), "{notes:?}");
}

#[test]
fn a_second_layer_changes_nothing() {
    // A capsule, and over most of it sheets as published organs have them: a bowl, turned inside out, and patches.
    let grid = Grid { origin: Vec3::repeat(-1.3), spacing: 0.05, cells: [52; 3] };
    let phi = |centre: Vec3| -> Vec<f64> {
        (0..grid.len())
            .map(|q| (grid.centre([q % 52, q / 52 % 52, q / 2704]) - centre).norm() - 1.0)
            .collect()
    };
    let capsule = without(&zero_level_set(&grid, &phi(Vec3::zeros())), |t| t.iter().all(|v| v.x > 0.97));
    let bowl = without(&ball([0.0, 0.0, 0.003]), |t| t.iter().all(|v| v.z > 0.2));
    let patch = without(&ball([0.002, 0.0, 0.0]), |t| t.iter().any(|v| v.y < 0.3));
    let (shape, repair, notes) = repaired(&together(&[capsule, bowl.flipped(), patch]));
    assert!((shape.volume() / (4.0 / 3.0 * PI) - 1.0).abs() < 8e-3, "{}", shape.volume());
    assert!(repair.uncertain < 0.01 && repair.layered > 0.5, "{repair:?}");
    assert_eq!((shape.surface().components(), shape.surface().genus()), (1, Some(0)));
    assert!(notes[0].contains("1 of 3 parts"), "{notes:?}");
    let field = winding_field(&together(&[ball([0.0; 3]), bowl])).unwrap();
    for z in [-0.9, 0.0, 0.9] {
        assert!((field.at(&Vec3::new(0.1, 0.0, z)) - 1.0).abs() < 0.1);
        assert!(field.at(&Vec3::new(1.2, 0.0, z)).abs() < 0.1);
    }
}

#[test]
fn bodies_do_not_depend_on_the_number_of_threads() {
    let mesh = together(&[without(&ball([0.0; 3]), |t| t[0].z > 0.9), ball([0.7, 0.2, 0.0]).flipped()]);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| repaired(&mesh))
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one.0.surface(), three.0.surface());
    assert_eq!((one.1, one.2), (three.1, three.2));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]
    /// Any triangles become a closed body with a note, or are refused with a reason, in bounded time (seconds on a
    /// quiet machine).
    #[test]
    fn any_soup_becomes_a_body_or_is_refused(
        points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 3..60),
        choices in prop::collection::vec(prop::array::uniform3(any::<prop::sample::Index>()), 1..100),
        exponent in -40..40_i32,
    ) {
        let scale = 10_f64.powi(exponent);
        let triangles = choices.iter().map(|t| t.map(|i| i.index(points.len()) as u32)).collect();
        let mesh = TriangleMesh { vertices: points.iter().map(|p| Vec3::from(*p) * scale).collect(), triangles };
        let begun = Instant::now();
        match MeshShape::new(&mesh, "mesh soup") {
            Ok((shape, _)) => prop_assert!(shape.surface().is_closed() && shape.volume() > 0.0),
            Err(e) => prop_assert!(!e.problem.is_empty() && !e.remedy.is_empty()),
        }
        prop_assert!(begun.elapsed() < Duration::from_secs(300), "{:?}", begun.elapsed());
    }
}
