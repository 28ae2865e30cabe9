//! What is left of a surface above a plane, as it grows triangle by triangle.

use super::{CutMesh, Plane, Side};
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use std::collections::{BTreeMap, HashMap};

/// The kept part as it grows.
pub(super) struct Part {
    pub cut: CutMesh,
    /// Whether each vertex lies on the plane.
    on: Vec<bool>,
    /// The vertex at which each edge that crosses the plane is cut.
    cut_vertices: HashMap<[u32; 2], u32>,
}

impl Part {
    /// No triangles yet, of these vertices; `on` says which lie on the plane.
    pub fn new(vertices: Vec<Vec3>, on: Vec<bool>) -> Self {
        let mesh = TriangleMesh { vertices, triangles: Vec::new() };
        Self { cut: CutMesh { mesh, on_plane: Vec::new() }, on, cut_vertices: HashMap::new() }
    }

    pub fn push(&mut self, triangle: [u32; 3], on_plane: bool) {
        self.cut.mesh.triangles.push(triangle);
        self.cut.on_plane.push(on_plane);
    }

    /// Adds what is left of a triangle that crosses the plane.
    pub fn push_cut(&mut self, corners: [u32; 3], sides: [Side; 3], plane: &Plane, heights: &[f64]) {
        let mut polygon = Vec::with_capacity(4);
        for i in 0..3 {
            let j = (i + 1) % 3;
            if sides[i] != Side::Beyond {
                polygon.push(corners[i]);
            }
            if sides[i] != sides[j] && sides[i] != Side::On && sides[j] != Side::On {
                polygon.push(self.cut_vertex(corners[i], corners[j], plane, heights));
            }
        }
        let length = |a: usize, b: usize| {
            let at = |i: usize| self.cut.mesh.vertices[polygon[i] as usize];
            (at(a) - at(b)).norm_squared()
        };
        if polygon.len() == 4 && length(1, 3) < length(0, 2) {
            polygon.rotate_left(1);
        }
        for i in 2..polygon.len() {
            self.push([polygon[0], polygon[i - 1], polygon[i]], false);
        }
    }

    /// The vertex where the edge from `a` to `b` meets the plane, the same for both its triangles.
    fn cut_vertex(&mut self, a: u32, b: u32, plane: &Plane, heights: &[f64]) -> u32 {
        let ends = [a.min(b), a.max(b)];
        *self.cut_vertices.entry(ends).or_insert_with(|| {
            let vertices = &mut self.cut.mesh.vertices;
            let [p, q] = ends.map(|v| vertices[v as usize]);
            let [above, below] = ends.map(|v| heights[v as usize]);
            let x = p + (q - p) * (above / (above - below));
            vertices.push(plane.foot(&x));
            self.on.push(true);
            vertices.len() as u32 - 1
        })
    }

    /// Makes vertices on the plane one that share an edge of no length: an edge along the normal may
    /// have been pressed flat, or a narrow triangle cut near its tip.
    pub fn collapse(&mut self, length: f64) {
        let CutMesh { mesh, on_plane } = &mut self.cut;
        let mut same_as: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
        let root = |same_as: &mut [u32], mut v: u32| {
            while same_as[v as usize] != v {
                same_as[v as usize] = same_as[same_as[v as usize] as usize];
                v = same_as[v as usize];
            }
            v
        };
        for &[a, b, c] in &mesh.triangles {
            for (a, b) in [(a, b), (b, c), (c, a)].map(|(a, b)| (a as usize, b as usize)) {
                if self.on[a] && self.on[b] && (mesh.vertices[a] - mesh.vertices[b]).norm() <= length {
                    let (a, b) = (root(&mut same_as, a as u32), root(&mut same_as, b as u32));
                    same_as[a.max(b) as usize] = a.min(b);
                }
            }
        }
        mesh.triangles.iter_mut().flatten().for_each(|v| *v = root(&mut same_as, *v));
        let keep = |[a, b, c]: [u32; 3]| a != b && b != c && c != a;
        let mut kept = mesh.triangles.iter().map(|&t| keep(t));
        on_plane.retain(|_| kept.next() == Some(true));
        mesh.triangles.retain(|&t| keep(t));
    }

    /// The edges on the plane that lack a triangle, in the direction in which it has to pass them.
    pub fn rim(&self) -> Vec<[u32; 2]> {
        // Sorted, so that the cap is the same in every run.
        let mut missing: BTreeMap<[u32; 2], i32> = BTreeMap::new();
        for &[a, b, c] in &self.cut.mesh.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                if self.on[from as usize] && self.on[to as usize] {
                    *missing.entry([from.min(to), from.max(to)]).or_default() +=
                        if from < to { -1 } else { 1 };
                }
            }
        }
        let directed = |([a, b], n): ([u32; 2], i32)| {
            std::iter::repeat_n(if n > 0 { [a, b] } else { [b, a] }, n.unsigned_abs() as usize)
        };
        missing.into_iter().flat_map(directed).collect()
    }
}
