//! Cuts of whole bodies: volume, closedness, caps.

use proptest::collection::vec;
use proptest::prelude::*;
use rsph_core::mesh::{CutMesh, TriangleMesh};
use rsph_core::shape::{BoxShape, Shape, SphereShape, organ};
use rsph_core::tensor::Vec3;
use std::f64::consts::TAU;
use std::sync::LazyLock;

const SPAN: std::ops::Range<f64> = -1.0..1.0;

fn cube(corner: Vec3) -> TriangleMesh {
    BoxShape::new(Vec3::repeat(1.0), corner).unwrap().surface().clone()
}

fn ball(radius: f64) -> TriangleMesh {
    SphereShape::new(radius, Vec3::zeros()).unwrap().surface().clone()
}

fn torus() -> TriangleMesh {
    let n = 40;
    let angle = |i: u32| TAU * f64::from(i) / f64::from(n);
    let mut m = TriangleMesh::default();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let r = 2.0 + angle(j).cos();
        m.vertices.push(Vec3::new(r * angle(i).cos(), r * angle(i).sin(), angle(j).sin()));
        let at = |a: u32, b: u32| (a % n) * n + b % n;
        m.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        m.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    m
}

fn both(mut a: TriangleMesh, b: &TriangleMesh) -> TriangleMesh {
    let n = a.vertices.len() as u32;
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + n)));
    a.vertices.extend(&b.vertices);
    a
}

/// The cut, once it is known to be closed by a flat cap that faces down. `simple`: without overlaps.
fn checked_cut(whole: &TriangleMesh, point: &Vec3, normal: &Vec3, tolerance: f64, simple: bool) -> CutMesh {
    let cut = whole.cut(point, normal, tolerance);
    let size = whole.bounds().unwrap().size().norm();
    let n = normal.normalize();
    assert_eq!(cut.mesh.open_edges(), Vec::<[u32; 2]>::new());
    let (mut vector, mut area, mut rest) = (Vec3::zeros(), 0.0, Vec3::zeros());
    for (t, &on_plane) in cut.on_plane.iter().enumerate() {
        let heights = cut.mesh.corners(t).map(|x| (x - point).dot(&n));
        assert!(heights.iter().all(|&h| h > -1e-13 * size));
        assert_eq!(on_plane, heights.iter().all(|h| h.abs() < 1e-13 * size));
        if on_plane {
            vector += cut.mesh.area_vector(t);
            area += cut.mesh.triangle_area(t);
        } else {
            rest += cut.mesh.area_vector(t);
        }
    }
    assert!((vector + rest).norm() < 1e-12 * size * size);
    if simple {
        assert!((vector + n * area).norm() < 1e-12 * size * size, "area {area}, vector {vector}");
    }
    cut
}

/// Cuts on both sides and compares the volumes; returns the cut on the side of `normal`.
fn checked(whole: &TriangleMesh, point: &Vec3, normal: &Vec3, simple: bool) -> CutMesh {
    let upper = checked_cut(whole, point, normal, 0.0, simple);
    let lower = checked_cut(whole, point, &-normal, 0.0, simple);
    let (sum, volume) = (upper.mesh.volume() + lower.mesh.volume(), whole.volume());
    assert!((sum - volume).abs() < 1e-12 * volume, "{sum} instead of {volume}");
    upper
}

static BODIES: LazyLock<Vec<TriangleMesh>> = LazyLock::new(|| {
    let liver = organ("liver").unwrap().surface().clone();
    let shell = both(ball(1.0), &ball(0.6).flipped());
    let apart = both(cube(Vec3::repeat(-1.0)), &torus());
    vec![cube(Vec3::repeat(-0.5)), ball(1.0), torus(), liver, shell, apart]
});

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn the_two_sides_of_a_cut_make_up_the_whole(n in [SPAN, SPAN, SPAN], at in [SPAN, SPAN, SPAN]) {
        for body in BODIES.iter() {
            let bounds = body.bounds().unwrap();
            let point = 0.5 * (bounds.min + bounds.max) + 0.5 * bounds.size().component_mul(&Vec3::from(at));
            checked(body, &point, &Vec3::from(n), true);
        }
    }

    #[test]
    fn bodies_that_overlap_are_capped_each_for_itself(n in [SPAN, SPAN, SPAN], at in [SPAN, SPAN, SPAN]) {
        let bodies = both(both(cube(Vec3::zeros()), &cube(Vec3::new(0.3, 0.4, 0.2))), &ball(0.7));
        checked(&bodies, &Vec3::from(at), &Vec3::from(n), false);
    }

    #[test]
    fn a_soup_of_triangles_is_cut_somehow(
        points in vec([-2..3_i32, -2..3, -2..3], 1..12), soup in vec([0..12_u32, 0..12, 0..12], 0..30),
        n in [-1..2_i32, -1..2, -1..2], scale in 0..5_usize, tolerance in 0.0..1.0, odd in 0..40_usize,
    ) {
        let scale = [1.0, 1e-160, 1e150, 1e-30, f64::MAX][scale];
        let mut vertices: Vec<_> = points.iter().map(|p| Vec3::from(p.map(f64::from)) * scale).collect();
        if let Some(v) = vertices.get_mut(odd) {
            v.y = f64::NAN;
        }
        let mesh = TriangleMesh { vertices, triangles: soup };
        let cut = mesh.cut(&Vec3::zeros(), &Vec3::from(n.map(f64::from)), tolerance * scale);
        prop_assert_eq!(cut.mesh.first_bad_triangle(), None);
        prop_assert_eq!(cut.mesh.triangles.len(), cut.on_plane.len());
    }
}

#[test]
fn a_plane_through_a_face_touches_or_takes_all() {
    let body = cube(Vec3::zeros());
    let (point, up) = (Vec3::zeros(), Vec3::new(0.0, 0.0, 2.0));
    let touching = body.cut(&point, &up, 1e-9);
    assert_eq!(touching.mesh, body);
    for (t, &on_plane) in touching.on_plane.iter().enumerate() {
        assert_eq!(on_plane, body.normal(t).z < -0.5);
    }
    assert_eq!(body.cut(&point, &-up, 1e-9), CutMesh::default());
    assert_eq!(body.cut(&Vec3::new(0.0, 0.0, 1.0 + 1e-10), &up, 1e-9), CutMesh::default());
    let clear = body.cut(&Vec3::new(0.0, 0.0, -0.1), &up, 1e-9);
    assert_eq!((clear.mesh, clear.on_plane), (body, vec![false; 12]));
}

#[test]
fn a_cube_is_cut_at_its_middle_and_through_its_edges() {
    let half = checked(&cube(Vec3::zeros()), &Vec3::repeat(0.5), &Vec3::z(), true);
    assert!((half.mesh.volume() - 0.5).abs() < 1e-15);
    assert_eq!((half.mesh.vertices.len(), half.mesh.genus()), (12, Some(0)));
    let wedge = checked(&cube(Vec3::zeros()), &Vec3::zeros(), &Vec3::new(1.0, -1.0, 0.0), true);
    assert!((wedge.mesh.volume() - 0.5).abs() < 1e-15);
    assert_eq!(wedge.mesh.genus(), Some(0));
}

#[test]
fn a_hollow_ball_has_an_annular_cap() {
    let shell = both(ball(1.0), &ball(0.5).flipped());
    let cut = checked(&shell, &Vec3::new(0.0, 0.0, 0.1), &Vec3::z(), true);
    let cap: f64 =
        (0..cut.on_plane.len()).filter(|&t| cut.on_plane[t]).map(|t| cut.mesh.triangle_area(t)).sum();
    assert!((cap / (0.375 * TAU) - 1.0).abs() < 1e-3);
    assert_eq!((cut.mesh.components(), cut.mesh.genus()), (1, Some(0)));
    let ring = torus().cut(&Vec3::zeros(), &Vec3::z(), 1e-9);
    assert_eq!((ring.mesh.components(), ring.mesh.genus()), (1, Some(1)));
}

#[test]
fn bodies_that_touch_and_bodies_within_bodies() {
    let touching = both(cube(Vec3::zeros()), &cube(Vec3::new(1.0, 0.0, 0.0)));
    let cut = checked(&touching, &Vec3::new(0.0, 0.0, 0.25), &Vec3::z(), true);
    assert!((cut.mesh.volume() - 1.5).abs() < 1e-14);
    let within = both(ball(1.0), &both(ball(0.8).flipped(), &ball(0.3)));
    assert_eq!(checked(&within, &Vec3::zeros(), &Vec3::x(), true).mesh.components(), 2);
    checked(&both(ball(1.0), &ball(0.5)), &Vec3::zeros(), &Vec3::x(), true);
}

#[test]
fn no_triangle_of_a_cut_is_without_area() {
    // Cut points lie at least `tolerance` from the vertices above, which gives triangles of the surface their
    // width; in the cap three neighbours on a rim that is nearly straight can make a narrower one.
    let tolerance = 1e-4;
    for body in [cube(Vec3::repeat(-0.5)), ball(1.0), torus()] {
        for i in 0..20 {
            let normal = Vec3::new(f64::from(i).cos(), f64::from(i).sin(), f64::from(i % 7) - 3.0);
            let point = normal * f64::from(i % 5) * 0.03;
            let cut = checked_cut(&body, &point, &normal, tolerance, true);
            for (t, &on_plane) in cut.on_plane.iter().enumerate() {
                let (area, least) = (cut.mesh.triangle_area(t), if on_plane { 1e-3 } else { 0.05 });
                assert!(area > least * tolerance * tolerance, "area {area}, on the plane: {on_plane}");
            }
        }
    }
}

#[test]
fn what_is_thinner_than_the_tolerance_is_pressed_flat() {
    // A step of a staircase as thin as the tolerance: its upright edges lose their length.
    let mut body = cube(Vec3::zeros());
    for v in body.vertices.iter_mut().filter(|v| v.z < 0.5 && v.x > 0.5) {
        v.z = -1e-5;
    }
    let plate = BoxShape::new(Vec3::new(1.0, 1.0, 1e-5), Vec3::zeros()).unwrap().surface().clone();
    assert_eq!(plate.cut(&Vec3::zeros(), &Vec3::z(), 1e-4), CutMesh::default());
    let cut = checked_cut(&both(plate, &body), &Vec3::zeros(), &Vec3::z(), 1e-4, true);
    assert_eq!(cut.mesh.vertices.len(), 8);
    assert!((cut.mesh.volume() - 1.0).abs() < 1e-14);
}

#[test]
fn an_open_surface_is_capped_as_if_it_were_closed() {
    let mut open = cube(Vec3::zeros());
    open.triangles.remove(
        open.triangles.iter().position(|t| t.iter().all(|&v| open.vertices[v as usize].x < 0.5)).unwrap(),
    );
    let cut = open.cut(&Vec3::repeat(0.5), &Vec3::z(), 0.0);
    let cap: f64 =
        (0..cut.on_plane.len()).filter(|&t| cut.on_plane[t]).map(|t| cut.mesh.triangle_area(t)).sum();
    assert!((cap - 1.0).abs() < 1e-14);
    let nowhere = open.cut(&Vec3::zeros(), &Vec3::zeros(), 0.0);
    assert_eq!(nowhere.mesh, open);
}
