//! A part of a surface, named or painted on a triangle mesh.

use crate::tensor::Vec3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::TriMesh;
use std::fmt;
use std::sync::Arc;

/// A surface farther than this share of the mesh's size from the part does not belong to it, nor one whose normal is off by more
/// than the angle of this cosine: the cut of a clamp is no part of the mesh.
const REACH: f64 = 0.02;
const FACING: f64 = 0.3;

/// The part of a surface that lies on some triangles of a mesh, which need not be the body's own: a body that was cut or repaired
/// has other triangles, and a painted mesh may be coarser.
#[derive(Clone)]
pub struct SurfacePart {
    name: String,
    /// Triangles of the part, and all others of the mesh if there are any.
    part: Arc<TriMesh>,
    others: Option<Arc<TriMesh>>,
    reach: f64,
}

impl SurfacePart {
    /// The triangles of a mesh for which `belongs` says so; `None` if there is none. Triangles name vertices that are there.
    pub fn new(
        name: &str,
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
        belongs: impl Fn(usize) -> bool,
    ) -> Option<Self> {
        let of = |wanted: bool| {
            let chosen = (0..triangles.len()).filter(|&t| belongs(t) == wanted);
            let chosen: Vec<_> = chosen.map(|t| triangles[t]).collect();
            let points = vertices.iter().map(|v| Vector::new(v.x, v.y, v.z)).collect();
            TriMesh::new(points, chosen).ok().map(Arc::new)
        };
        let used = || triangles.iter().flatten().filter_map(|&v| vertices.get(v as usize));
        let low = used().fold(Vec3::repeat(f64::INFINITY), |m, x| m.inf(x));
        let high = used().fold(Vec3::repeat(f64::NEG_INFINITY), |m, x| m.sup(x));
        Some(Self {
            name: name.into(),
            part: of(true)?,
            others: of(false),
            reach: REACH * (high - low).norm(),
        })
    }

    /// Name in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the surface point `x` with that unit normal lies on the part, enlarged by `tolerance`.
    pub fn contains(&self, x: &Vec3, n: &Vec3, tolerance: f64) -> bool {
        let (distance, normal) = nearest(&self.part, x);
        let other = self.others.as_ref().map_or(f64::INFINITY, |others| nearest(others, x).0);
        // A mesh may be turned inside out; bodies are not.
        distance <= self.reach && distance <= other + tolerance && normal.dot(n).abs() > FACING
    }
}

/// Distance of the nearest triangle, and its unit normal.
fn nearest(mesh: &TriMesh, x: &Vec3) -> (f64, Vec3) {
    let p = Vector::new(x.x, x.y, x.z);
    let (found, (triangle, _)) = mesh.project_local_point_and_get_location(p, false);
    let normal = mesh.triangle(triangle).normal().map_or_else(Vec3::zeros, |n| Vec3::new(n.x, n.y, n.z));
    ((found.point - p).length(), normal)
}

impl PartialEq for SurfacePart {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && Arc::ptr_eq(&self.part, &other.part)
    }
}

impl fmt::Debug for SurfacePart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the part {} of a mesh", self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::Region;

    /// A unit square at z = 0 of two triangles, and one at x = 1 that stands on its edge.
    fn corner() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let vertices = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [1., 0., 1.], [1., 1., 1.]];
        (vertices.map(Vec3::from).to_vec(), vec![[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]])
    }

    #[test]
    fn a_part_ends_where_other_triangles_are_nearer() {
        let (vertices, triangles) = corner();
        let part = SurfacePart::new("lower", &vertices, &triangles, |t| t == 0).unwrap();
        let region = Region::Part(part);
        let on = |x: [f64; 3], n: Vec3| region.contains_on_surface(&Vec3::from(x), &n, 1e-6);
        assert!(on([0.8, 0.2, 0.0], Vec3::z()) && on([0.8, 0.2, 0.01], -Vec3::z()));
        assert!(!on([0.2, 0.8, 0.0], Vec3::z()), "on the other triangle");
        assert!(!on([0.8, 0.2, 0.2], Vec3::z()), "far away");
        assert!(!on([1.0, 0.5, 0.01], Vec3::x()), "on the wall, near its edge");
        assert!(!on([0.8, 0.2, 0.0], Vec3::x()), "a cut across it");
        assert!(!region.contains(&Vec3::new(0.8, 0.2, 0.0), 1e-6), "no point inside the body");
        // What is not the part is the rest of the surface.
        let rest = Region::Not(Box::new(region));
        assert!(rest.contains_on_surface(&Vec3::new(0.2, 0.8, 0.0), &Vec3::z(), 1e-6));
    }

    #[test]
    fn no_triangle_is_no_part() {
        let (vertices, triangles) = corner();
        assert!(SurfacePart::new("none", &vertices, &triangles, |_| false).is_none());
        let all = SurfacePart::new("all", &vertices, &triangles, |_| true).unwrap();
        assert!(all.contains(&Vec3::new(1.0, 0.5, 0.5), &Vec3::x(), 0.0));
    }
}
