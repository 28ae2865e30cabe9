//! Tractions on the surface of a body: quadrature over its triangles, scattered to the particles.

use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;

/// A point of the quadrature over a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Place.
    pub x: Vec3,
    /// Outward unit normal of its triangle.
    pub normal: Vec3,
    /// Share of the area.
    pub area: f64,
}

/// Quadrature points of a surface, three to a triangle, after splitting triangles until no edge is
/// longer than `resolution`.
pub fn quadrature(mesh: &TriangleMesh, resolution: f64) -> Vec<SurfacePoint> {
    let mut points = Vec::new();
    for t in &mesh.triangles {
        let corners = t.map(|i| mesh.vertices[i as usize]);
        let cross = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let area = 0.5 * cross.norm();
        if area > 0.0 {
            split(corners, area, &(cross / (2.0 * area)), resolution, &mut points);
        }
    }
    points
}

fn split(c: [Vec3; 3], area: f64, normal: &Vec3, resolution: f64, points: &mut Vec<SurfacePoint>) {
    let edge = |i: usize| (c[(i + 1) % 3] - c[i]).norm();
    let longest = (0..3).max_by(|&i, &j| edge(i).total_cmp(&edge(j))).unwrap_or(0);
    if edge(longest) > resolution {
        let (a, b, d) = (c[longest], c[(longest + 1) % 3], c[(longest + 2) % 3]);
        let middle = 0.5 * (a + b);
        split([a, middle, d], 0.5 * area, normal, resolution, points);
        split([middle, b, d], 0.5 * area, normal, resolution, points);
    } else {
        let sum = c[0] + c[1] + c[2];
        // Exact for quadratic functions on the triangle.
        points.extend(c.map(|corner| SurfacePoint {
            x: (sum + 3.0 * corner) / 6.0,
            normal: *normal,
            area: area / 3.0,
        }));
    }
}
