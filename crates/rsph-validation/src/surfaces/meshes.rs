//! Closed surfaces of the bodies of the case, fine enough not to count.

use rsph_core::error::InvalidInput;
use rsph_core::mesh::TriangleMesh;
use rsph_core::shape::{MeshShape, Shape};
use rsph_core::tensor::{Mat3, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// `mesh` turned by 30 degrees about an axis, with where its axes point.
pub fn turned(mesh: &TriangleMesh, axis: Option<[f64; 3]>) -> (TriangleMesh, [Vec3; 3]) {
    let turn = axis.map_or_else(Mat3::identity, |axis| {
        let (a, angle) = (Vec3::from(axis).normalize(), 30.0_f64.to_radians());
        Mat3::identity() * angle.cos()
            + a.cross_matrix() * angle.sin()
            + a * a.transpose() * (1.0 - angle.cos())
    });
    let mut mesh = mesh.clone();
    mesh.vertices.iter_mut().for_each(|x| *x = turn * *x);
    (mesh, [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| turn * axis))
}

/// A sphere of triangles, an octahedron refined by two that often, with the volume of the exact one.
pub fn ball(radius: f64, refinements: usize) -> TriangleMesh {
    let mut mesh = TriangleMesh {
        vertices: vec![Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()],
        triangles: vec![
            [0, 2, 4],
            [2, 1, 4],
            [1, 3, 4],
            [3, 0, 4],
            [2, 0, 5],
            [1, 2, 5],
            [3, 1, 5],
            [0, 3, 5],
        ],
    };
    for _ in 0..refinements {
        let TriangleMesh { mut vertices, triangles } = mesh;
        let mut between = HashMap::new();
        let mut middle = |i: u32, j: u32| {
            *between.entry((i.min(j), i.max(j))).or_insert_with(|| {
                vertices.push((vertices[i as usize] + vertices[j as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        let triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
        mesh = TriangleMesh { vertices, triangles };
    }
    let factor = radius * (4.0 / 3.0 * std::f64::consts::PI / mesh.volume()).cbrt();
    mesh.vertices.iter_mut().for_each(|x| *x *= factor);
    mesh
}

/// A hollow sphere.
pub fn hollow(inner: f64, outer: f64, refinements: usize) -> TriangleMesh {
    let (mut mesh, hole) = (ball(outer, refinements + 1), ball(inner, refinements).flipped());
    let n = mesh.vertices.len() as u32;
    mesh.triangles.extend(hole.triangles.iter().map(|t| t.map(|v| v + n)));
    mesh.vertices.extend(hole.vertices);
    mesh
}

/// A tube about z from z = 0 to `height` between two closed curves, of so many flat sides: where the curves are at an angle.
pub fn tube(
    inner: impl Fn(f64) -> [f64; 2],
    outer: impl Fn(f64) -> [f64; 2],
    height: f64,
    sides: u32,
) -> TriangleMesh {
    let step = std::f64::consts::TAU / f64::from(sides);
    let mut mesh = TriangleMesh { vertices: Vec::new(), triangles: Vec::new() };
    for k in 0..sides {
        // No corner lies on an axis, where bodies are cut.
        let angle = (f64::from(k) + 0.5) * step;
        let (a, b) = (inner(angle), outer(angle));
        for ([x, y], z) in [(a, 0.0), (b, 0.0), (b, height), (a, height)] {
            mesh.vertices.push(Vec3::new(x, y, z));
        }
    }
    for k in 0..sides {
        for side in 0..4 {
            let at = |k: u32, side: u32| 4 * (k % sides) + side % 4;
            let (a, b, c, d) = (at(k, side), at(k, side + 1), at(k + 1, side + 1), at(k + 1, side));
            mesh.triangles.extend([[a, d, c], [a, c, b]]);
        }
    }
    if mesh.volume() < 0.0 { mesh.flipped() } else { mesh }
}

/// An ellipse with these half axes, as a polygon of so many sides with the area of the exact one.
pub fn ellipse(half: [f64; 2], sides: u32) -> impl Fn(f64) -> [f64; 2] {
    let step = std::f64::consts::TAU / f64::from(sides);
    let factor = (step / step.sin()).sqrt();
    move |angle| [factor * half[0] * angle.cos(), factor * half[1] * angle.sin()]
}

/// A shape of a mesh.
///
/// # Errors
/// A mesh that encloses nothing.
pub fn shape_of(mesh: &TriangleMesh) -> Result<Arc<dyn Shape>, InvalidInput> {
    Ok(Arc::new(MeshShape::new(mesh, "mesh")?.0))
}
