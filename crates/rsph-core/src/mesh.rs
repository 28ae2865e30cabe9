//! A triangle surface: what readers deliver, bodies expose and the zero level set becomes.

mod cut;
mod topology;

pub use cut::CutMesh;
pub(crate) use cut::filled;

use crate::grid::Bounds;
use crate::tensor::Vec3;
use std::collections::HashMap;

/// A triangle surface. Triangles turn counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions (length unit of the scenario; metres in SI).
    pub vertices: Vec<Vec3>,
    /// Three vertex indices a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// The three corners of triangle `t`.
    ///
    /// # Panics
    /// When `t` or one of its vertex indices is out of range.
    pub fn corners(&self, t: usize) -> [Vec3; 3] {
        self.triangles[t].map(|v| self.vertices[v as usize])
    }

    /// The centre of gravity of triangle `t`.
    pub fn centroid(&self, t: usize) -> Vec3 {
        self.corners(t).iter().sum::<Vec3>() / 3.0
    }

    /// Area vector of triangle `t`: along its outward normal, as long as its area.
    pub fn area_vector(&self, t: usize) -> Vec3 {
        let [a, b, c] = self.corners(t);
        0.5 * (b - a).cross(&(c - a))
    }

    /// Outward unit normal of triangle `t`; zero for a triangle without area.
    pub fn normal(&self, t: usize) -> Vec3 {
        self.area_vector(t).try_normalize(0.0).unwrap_or_else(Vec3::zeros)
    }

    /// Area of triangle `t`.
    pub fn triangle_area(&self, t: usize) -> f64 {
        self.area_vector(t).norm()
    }

    /// Area of the surface.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| self.triangle_area(t)).sum()
    }

    /// Volume enclosed by a closed surface (divergence theorem); negative when it is inside out.
    pub fn volume(&self) -> f64 {
        // Measured from a point nearby, so that a body far from the origin loses no digits.
        let origin = self.vertices.first().copied().unwrap_or_else(Vec3::zeros);
        (0..self.triangles.len()).map(|t| self.volume_below(t, &origin)).sum()
    }

    /// Volume of the tetrahedron from `origin` to triangle `t`, positive where that is seen from behind.
    pub(crate) fn volume_below(&self, t: usize, origin: &Vec3) -> f64 {
        let [a, b, c] = self.corners(t).map(|v| v - origin);
        a.dot(&b.cross(&c)) / 6.0
    }

    /// Tight bounding box of the vertices that triangles use; `None` for an empty mesh.
    pub fn bounds(&self) -> Option<Bounds> {
        let mut used = self.triangles.iter().flatten().map(|&v| self.vertices[v as usize]);
        let first = used.next()?;
        Some(used.fold(Bounds { min: first, max: first }, |b, v| Bounds {
            min: b.min.inf(&v),
            max: b.max.sup(&v),
        }))
    }

    /// The same surface with the other side outward.
    #[must_use]
    pub fn flipped(&self) -> Self {
        let triangles = self.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        Self { vertices: self.vertices.clone(), triangles }
    }

    /// The surface with vertices at equal positions made one, triangles that use a vertex twice
    /// dropped, and vertices that no triangle uses dropped.
    #[must_use]
    pub fn merged(&self) -> Self {
        let mut index_of = HashMap::new();
        let mut mesh = Self::default();
        for t in &self.triangles {
            let corners = t.map(|v| {
                let p = self.vertices[v as usize];
                // Adding zero turns -0 into 0, which has other bits.
                let key = [0, 1, 2].map(|i| (p[i] + 0.0).to_bits());
                *index_of.entry(key).or_insert_with(|| {
                    mesh.vertices.push(p);
                    mesh.vertices.len() as u32 - 1
                })
            });
            if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
                mesh.triangles.push(corners);
            }
        }
        mesh.without_unused_vertices()
    }

    /// Index of the first vertex with a coordinate that is not finite.
    pub fn first_not_finite(&self) -> Option<usize> {
        self.vertices.iter().position(|v| !v.iter().all(|c| c.is_finite()))
    }

    /// Index of the first triangle that names a vertex which is not there.
    pub fn first_bad_triangle(&self) -> Option<usize> {
        self.triangles.iter().position(|t| t.iter().any(|&v| v as usize >= self.vertices.len()))
    }

    /// Every triangle cut into four at the middles of its edges.
    pub(crate) fn divided(&self) -> Self {
        let mut new =
            Self { vertices: self.vertices.clone(), triangles: Vec::with_capacity(4 * self.triangles.len()) };
        let mut middles = HashMap::new();
        for &[a, b, c] in &self.triangles {
            let mut middle = |v: u32, w: u32| {
                *middles.entry([v.min(w), v.max(w)]).or_insert_with(|| {
                    new.vertices.push(0.5 * (self.vertices[v as usize] + self.vertices[w as usize]));
                    new.vertices.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            new.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        new
    }

    /// The triangles for which `keep` is true, with their vertices.
    #[must_use]
    pub(crate) fn retain(&self, keep: impl Fn(usize) -> bool) -> Self {
        let kept = (0..self.triangles.len()).filter(|&t| keep(t)).map(|t| self.triangles[t]).collect();
        Self { vertices: self.vertices.clone(), triangles: kept }.without_unused_vertices()
    }

    fn without_unused_vertices(self) -> Self {
        let mut new_index = vec![u32::MAX; self.vertices.len()];
        let mut vertices = Vec::new();
        let triangles = self
            .triangles
            .iter()
            .map(|t| {
                t.map(|v| {
                    let new = &mut new_index[v as usize];
                    if *new == u32::MAX {
                        *new = vertices.len() as u32;
                        vertices.push(self.vertices[v as usize]);
                    }
                    *new
                })
            })
            .collect();
        Self { vertices, triangles }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{BoxShape, Shape};
    use approx::assert_relative_eq;

    fn unit_cube() -> TriangleMesh {
        BoxShape::new(Vec3::new(1.0, 2.0, 3.0), Vec3::new(5.0, 5.0, 5.0)).unwrap().surface().clone()
    }

    #[test]
    fn a_box_has_its_volume_area_and_bounds() {
        let m = unit_cube();
        assert_relative_eq!(m.volume(), 6.0, epsilon = 1e-12);
        assert_relative_eq!(m.area(), 22.0, epsilon = 1e-12);
        assert_relative_eq!(m.flipped().volume(), -6.0, epsilon = 1e-12);
        assert_eq!(m.bounds().unwrap().size(), Vec3::new(1.0, 2.0, 3.0));
        assert_relative_eq!(m.normal(0).norm(), 1.0, epsilon = 1e-12);
        assert_relative_eq!(m.normal(0) * m.triangle_area(0), m.area_vector(0), epsilon = 1e-12);
    }

    #[test]
    fn triangle_soup_becomes_one_closed_surface() {
        let m = unit_cube();
        let soup = TriangleMesh {
            vertices: (0..m.triangles.len()).flat_map(|t| m.corners(t)).collect(),
            triangles: (0..m.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        };
        assert_eq!(soup.open_edges().len(), 36);
        let merged = soup.merged();
        assert_eq!(merged.vertices.len(), 8);
        assert!(merged.is_closed());
    }

    #[test]
    fn merging_drops_degenerate_triangles_and_stray_vertices() {
        let mut m = unit_cube();
        m.vertices.push(Vec3::zeros());
        m.vertices.push(m.vertices[0]);
        let twin = m.vertices.len() as u32 - 1;
        m.triangles.push([0, twin, 1]);
        let merged = m.merged();
        assert_eq!((merged.vertices.len(), merged.triangles.len()), (8, 12));
    }

    #[test]
    fn broken_meshes_are_recognised() {
        let mut m = unit_cube();
        assert_eq!((m.first_not_finite(), m.first_bad_triangle()), (None, None));
        m.vertices[3].y = f64::NAN;
        m.triangles[2][1] = 99;
        assert_eq!((m.first_not_finite(), m.first_bad_triangle()), (Some(3), Some(2)));
        assert!(TriangleMesh::default().bounds().is_none());
    }
}
