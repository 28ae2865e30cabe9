//! Tractions on the surface of a body: quadrature over its triangles, scattered to the particles.

use crate::mesh::TriangleMesh;
use crate::mls::PointWeights;
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

/// The quadrature of a whole surface with the particles' weights at its points, kept where loads change
/// often.
#[derive(Clone, Debug)]
pub struct Skin {
    /// Longest edge of its triangles.
    pub edge: f64,
    /// Points.
    pub points: Vec<SurfacePoint>,
    /// Weights at the points.
    pub weights: PointWeights,
}

impl Skin {
    /// Forces on `particles` particles by a traction.
    pub fn force(&self, particles: usize, traction: &dyn Fn(&SurfacePoint) -> Vec3) -> Vec<f64> {
        let forces: Vec<Vec3> = self.points.iter().map(|p| traction(p) * p.area).collect();
        let mut force = vec![0.0; 3 * particles];
        self.weights.spread(&forces, &mut force);
        force
    }
}

/// Longest edge allowed in the triangle of these corners with this outward normal.
type Resolution<'a> = dyn Fn(&[Vec3; 3], &Vec3) -> f64 + 'a;

/// Quadrature points of a surface, three to a triangle, after splitting triangles until no edge is
/// longer than `resolution`.
pub fn quadrature(mesh: &TriangleMesh, resolution: f64) -> Vec<SurfacePoint> {
    graded_quadrature(mesh, &|_, _| resolution)
}

/// The same where the longest edge allowed in the triangle of these corners, with this outward normal,
/// is `resolution(corners, normal)`.
pub fn graded_quadrature(mesh: &TriangleMesh, resolution: &Resolution<'_>) -> Vec<SurfacePoint> {
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

fn split(
    c: [Vec3; 3],
    area: f64,
    normal: &Vec3,
    resolution: &Resolution<'_>,
    points: &mut Vec<SurfacePoint>,
) {
    let edge = |i: usize| (c[(i + 1) % 3] - c[i]).norm();
    let longest = (0..3).max_by(|&i, &j| edge(i).total_cmp(&edge(j))).unwrap_or(0);
    if edge(longest) > resolution(&c, normal) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::patch::Patch;
    use crate::setup::PatchCentre;

    #[test]
    fn a_patch_smaller_than_the_particles_has_its_whole_force() {
        let corner = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let square = TriangleMesh {
            vertices: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let radius = 0.01;
        let centre = PatchCentre::At(corner(0.301, -0.217));
        let patch = Patch::on(&square, 1.0, &centre, Some(radius), &-Vec3::z());
        let points = graded_quadrature(&square, &|corners, _| patch.resolution(0.25, corners));
        let force: f64 = points.iter().map(|p| patch.traction(p).norm() * p.area).sum();
        // The integral of exp(-d^2/r^2) over the plane is pi r^2.
        let exact = std::f64::consts::PI * radius * radius;
        assert!((force / exact - 1.0).abs() < 1e-4, "{force} {exact}");
        assert!(points.len() < 50_000, "{}", points.len());
    }
}
