//! A tree of boxes around triangles: nearby ones are found, far ones taken together.

use crate::grid::Bounds;
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;

/// How far, in parts of a triangle, an edge reaches beyond itself.
const EDGE: f64 = 1e-9;
/// Triangles of a leaf.
const LEAF: usize = 8;

/// A node: its triangles are `items.0..items.1` of the tree's order. A node's first child follows it; what
/// comes after all below it is `next`.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) bounds: Bounds,
    pub(super) items: (usize, usize),
    pub(super) next: usize,
    pub(super) is_leaf: bool,
}

/// Triangles in the order of a tree. Shared by everything that asks what is near.
#[derive(Clone, Debug)]
pub struct TriangleTree {
    pub(super) nodes: Vec<Node>,
    pub(super) corners: Vec<[Vec3; 3]>,
    /// Number in the mesh of each triangle of the tree.
    pub(super) number: Vec<usize>,
}

impl TriangleTree {
    /// A tree over all triangles of a mesh whose vertices are finite.
    ///
    /// # Panics
    /// When a triangle names a vertex that is not there.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let count = mesh.triangles.len();
        let middle = |t: usize| mesh.corners(t).iter().sum::<Vec3>();
        let middles: Vec<Vec3> = (0..count).map(middle).collect();
        let mut tree =
            Self { nodes: Vec::new(), corners: Vec::with_capacity(count), number: (0..count).collect() };
        if count > 0 {
            tree.divide(mesh, &middles, 0, count);
        }
        tree.corners = tree.number.iter().map(|&t| mesh.corners(t)).collect();
        tree
    }

    fn divide(&mut self, mesh: &TriangleMesh, middles: &[Vec3], from: usize, to: usize) {
        let items = &mut self.number[from..to];
        let bounds = around(items.iter().flat_map(|&t| mesh.corners(t)));
        let is_leaf = items.len() <= LEAF;
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, items: (from, to), next: 0, is_leaf });
        if !is_leaf {
            let spread = around(items.iter().map(|&t| middles[t])).size();
            let axis = spread.imax();
            let half = items.len() / 2;
            items.select_nth_unstable_by(half, |&a, &b| {
                middles[a][axis].total_cmp(&middles[b][axis]).then(a.cmp(&b))
            });
            self.divide(mesh, middles, from, from + half);
            self.divide(mesh, middles, from + half, to);
        }
        self.nodes[node].next = self.nodes.len();
    }

    /// Calls `found` with the number of each triangle that the segment from `start` to `start + along` passes through,
    /// and the place on it (0 to 1). Stops early, and returns false, when that takes more than `effort` looks at
    /// nodes and triangles.
    pub fn passages(
        &self,
        start: &Vec3,
        along: &Vec3,
        effort: usize,
        mut found: impl FnMut(usize, f64),
    ) -> bool {
        let inverse = along.map(|c| 1.0 / c);
        let (mut n, mut looks) = (0, 0);
        while let Some(node) = self.nodes.get(n) {
            looks += 1;
            if !meets(&node.bounds, start, &inverse) {
                n = node.next;
                continue;
            }
            n += 1;
            if node.is_leaf {
                looks += LEAF;
                for i in node.items.0..node.items.1 {
                    if let Some(at) = passage(&self.corners[i], start, along) {
                        found(self.number[i], at);
                    }
                }
            }
            if looks > effort {
                return false;
            }
        }
        true
    }
}

fn around(points: impl Iterator<Item = Vec3>) -> Bounds {
    let none = Bounds { min: Vec3::repeat(f64::INFINITY), max: Vec3::repeat(f64::NEG_INFINITY) };
    points.fold(none, |b, p| Bounds { min: b.min.inf(&p), max: b.max.sup(&p) })
}

/// Whether a segment meets a box, by its slabs; a NaN (a segment within the plane of a face) counts as meeting.
fn meets(b: &Bounds, start: &Vec3, inverse: &Vec3) -> bool {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for i in 0..3 {
        let (a, c) = ((b.min[i] - start[i]) * inverse[i], (b.max[i] - start[i]) * inverse[i]);
        // min and max of f64 ignore a NaN.
        from = from.max(a.min(c));
        to = to.min(a.max(c));
    }
    from <= to
}

/// Where a segment passes through a triangle (Moeller and Trumbore 1997). One through an edge that two triangles share passes through
/// both, whatever rounding does.
fn passage(corners: &[Vec3; 3], start: &Vec3, along: &Vec3) -> Option<f64> {
    let (e, f) = (corners[1] - corners[0], corners[2] - corners[0]);
    let p = along.cross(&f);
    let determinant = e.dot(&p);
    let s = start - corners[0];
    let q = s.cross(&e);
    let (u, v, at) = (s.dot(&p) / determinant, along.dot(&q) / determinant, f.dot(&q) / determinant);
    (u >= -EDGE && v >= -EDGE && u + v <= 1.0 + EDGE && (0.0..=1.0).contains(&at)).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::marching_cubes::zero_level_set;
    use proptest::prelude::*;

    fn ball() -> TriangleMesh {
        let grid = Grid { origin: Vec3::repeat(-1.5), spacing: 0.2, cells: [15; 3] };
        let phi: Vec<f64> =
            (0..grid.len()).map(|q| grid.centre([q % 15, q / 15 % 15, q / 225]).norm() - 1.0).collect();
        zero_level_set(&grid, &phi)
    }

    #[test]
    fn every_triangle_is_in_one_leaf_and_in_its_boxes() {
        let mesh = ball();
        let tree = TriangleTree::new(&mesh);
        let mut seen = vec![0; mesh.triangles.len()];
        for node in &tree.nodes {
            for i in node.items.0..node.items.1 {
                seen[tree.number[i]] += usize::from(node.is_leaf);
                for c in tree.corners[i] {
                    assert!(
                        c.inf(&node.bounds.min) == node.bounds.min
                            && c.sup(&node.bounds.max) == node.bounds.max
                    );
                }
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
        assert!(TriangleTree::new(&TriangleMesh::default()).nodes.is_empty());
    }

    proptest! {
        /// The tree finds what a look at every triangle finds.
        #[test]
        fn passages_are_those_of_all_triangles(a in prop::array::uniform3(-1.5..1.5_f64), b in prop::array::uniform3(-3.0..3.0_f64)) {
            let mesh = ball();
            let (start, along) = (Vec3::from(a), Vec3::from(b));
            let mut found = Vec::new();
            prop_assert!(TriangleTree::new(&mesh).passages(&start, &along, usize::MAX, |t, _| found.push(t)));
            found.sort_unstable();
            let all: Vec<usize> =
                (0..mesh.triangles.len()).filter(|&t| passage(&mesh.corners(t), &start, &along).is_some()).collect();
            prop_assert_eq!(found, all);
        }
    }

    #[test]
    fn a_search_ends_when_its_effort_is_spent() {
        let tree = TriangleTree::new(&ball());
        assert!(!tree.passages(&Vec3::repeat(-2.0), &Vec3::repeat(4.0), 3, |_, _| {}));
    }
}
