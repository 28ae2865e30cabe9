//! How the triangles of a surface hang together.

use super::TriangleMesh;
use crate::tensor::Vec3;
use std::collections::HashMap;

impl TriangleMesh {
    /// Edges that are not shared by exactly two triangles passing them in opposite directions, as
    /// pairs of vertex indices, smaller one first. None: the surface is closed and consistently
    /// turned.
    pub fn open_edges(&self) -> Vec<[u32; 2]> {
        let mut open: Vec<_> = self
            .edge_uses()
            .into_iter()
            .filter_map(|(edge, uses)| (uses != [1, 1]).then_some(edge))
            .collect();
        open.sort_unstable();
        open
    }

    /// Whether the surface has triangles and no open edge.
    pub fn is_closed(&self) -> bool {
        !self.triangles.is_empty() && self.edge_uses().values().all(|&uses| uses == [1, 1])
    }

    /// Number of pieces that share no vertex with each other.
    pub fn components(&self) -> usize {
        self.component_of_triangles().1
    }

    /// The piece each triangle belongs to, numbered from 0 in the order of their first triangles,
    /// and the number of pieces.
    pub(crate) fn component_of_triangles(&self) -> (Vec<usize>, usize) {
        let mut parent: Vec<u32> = (0..self.vertices.len() as u32).collect();
        for &[a, b, c] in &self.triangles {
            let root = find(&mut parent, a);
            for v in [b, c] {
                let other = find(&mut parent, v);
                parent[other as usize] = root;
            }
        }
        let mut number_of = HashMap::new();
        let pieces = self
            .triangles
            .iter()
            .map(|t| {
                let next = number_of.len();
                *number_of.entry(find(&mut parent, t[0])).or_insert(next)
            })
            .collect();
        (pieces, number_of.len())
    }

    /// The piece each triangle of a closed surface belongs to, and the volume that each piece encloses; a cavity's is negative.
    pub fn component_volumes(&self) -> (Vec<usize>, Vec<f64>) {
        let (piece_of, count) = self.component_of_triangles();
        let origin = self.vertices.first().copied().unwrap_or_else(Vec3::zeros);
        let mut volumes = vec![0.0; count];
        for (t, &piece) in piece_of.iter().enumerate() {
            volumes[piece] += self.volume_below(t, &origin);
        }
        (piece_of, volumes)
    }

    /// Euler characteristic: used vertices - edges + triangles (2 for a closed surface without
    /// handles, 0 for a torus; pieces add up).
    pub fn euler_characteristic(&self) -> i64 {
        let mut used = vec![false; self.vertices.len()];
        for &v in self.triangles.iter().flatten() {
            used[v as usize] = true;
        }
        let vertices = used.iter().filter(|&&u| u).count();
        vertices as i64 - self.edge_uses().len() as i64 + self.triangles.len() as i64
    }

    /// Number of handles of a closed surface, all pieces together; `None` if it is not closed.
    pub fn genus(&self) -> Option<usize> {
        if !self.is_closed() {
            return None;
        }
        usize::try_from(self.components() as i64 - self.euler_characteristic() / 2).ok()
    }

    /// How often each edge is passed from the smaller to the larger vertex index and back.
    fn edge_uses(&self) -> HashMap<[u32; 2], [u32; 2]> {
        let mut uses = HashMap::with_capacity(3 * self.triangles.len() / 2);
        for &[a, b, c] in &self.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let edge: &mut [u32; 2] = uses.entry([from.min(to), from.max(to)]).or_default();
                edge[usize::from(from > to)] += 1;
            }
        }
        uses
    }
}

/// Root of `v` in a forest of parents, shortening the way on the way.
fn find(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        let grandparent = parent[parent[v as usize] as usize];
        parent[v as usize] = grandparent;
        v = grandparent;
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{BoxShape, Shape};

    fn cube_at(corner: f64) -> TriangleMesh {
        BoxShape::new(Vec3::repeat(1.0), Vec3::repeat(corner)).unwrap().surface().clone()
    }

    /// A torus of n x n quads.
    fn torus(n: u32) -> TriangleMesh {
        let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let mut m = TriangleMesh::default();
        for i in 0..n {
            for j in 0..n {
                let r = 2.0 + angle(j).cos();
                m.vertices.push(Vec3::new(r * angle(i).cos(), r * angle(i).sin(), angle(j).sin()));
                let at = |a: u32, b: u32| (a % n) * n + b % n;
                m.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                m.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        m
    }

    #[test]
    fn cube_and_torus_have_their_genus() {
        let cube = cube_at(0.0);
        assert!(cube.is_closed());
        assert_eq!((cube.components(), cube.euler_characteristic(), cube.genus()), (1, 2, Some(0)));
        let torus = torus(12);
        assert_eq!((torus.components(), torus.euler_characteristic(), torus.genus()), (1, 0, Some(1)));
        assert!(torus.volume() > 0.0);
    }

    #[test]
    fn two_cubes_are_two_pieces() {
        let (mut both, other) = (cube_at(0.0), cube_at(3.0));
        both.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + 8)));
        both.vertices.extend(other.vertices);
        assert_eq!((both.components(), both.euler_characteristic(), both.genus()), (2, 4, Some(0)));
    }

    #[test]
    fn a_missing_or_turned_triangle_opens_three_edges() {
        let mut hole = cube_at(0.0);
        hole.triangles.pop();
        assert_eq!(hole.open_edges().len(), 3);
        assert_eq!(hole.genus(), None);
        let mut turned = cube_at(0.0);
        turned.triangles[4].swap(0, 1);
        assert_eq!(turned.open_edges().len(), 3);
        assert!(!TriangleMesh::default().is_closed());
    }
}
