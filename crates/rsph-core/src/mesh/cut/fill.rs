//! Triangles inside loops in a plane that do not meet.
//!
//! Clipping of ears, as libraries do it, drops vertices on straight stretches, where the cap would then not fit
//! the surface. A constrained Delaunay triangulation keeps every vertex, and its predicates are exact.

use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation, mitigate_underflow};
use std::collections::HashMap;

/// Triangles that fill what the loops enclose and pass each edge of a loop in its direction.
///
/// `None` if loops meet other than at common vertices, or enclose something twice.
pub(crate) fn filled(loops: &[Vec<u32>], flat: impl Fn(u32) -> [f64; 2]) -> Option<Vec<[u32; 3]>> {
    let mut triangulation = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut handles = HashMap::new();
    let mut vertices = Vec::new();
    for &v in loops.iter().flatten() {
        if handles.contains_key(&v) {
            continue;
        }
        let [x, y] = flat(v);
        let point = mitigate_underflow(Point2::new(x, y));
        let handle = match vertices.last().and_then(|last| handles.get(last)) {
            Some(&near) => triangulation.insert_with_hint(point, near),
            None => triangulation.insert(point),
        }
        .ok()?;
        if handle.index() < vertices.len() {
            return None; // another vertex lies there
        }
        handles.insert(v, handle);
        vertices.push(v);
    }
    // How often an edge is passed in this direction, less how often in the other.
    let mut passed: HashMap<[usize; 2], i32> = HashMap::new();
    let ends = loops.iter().flat_map(|l| l.iter().zip(l.iter().cycle().skip(1)));
    let edges: Vec<_> = ends.map(|(a, b)| (handles[a], handles[b])).collect();
    for &(a, b) in &edges {
        triangulation.try_add_constraint(a, b);
        *passed.entry([a.index(), b.index()]).or_default() += 1;
        *passed.entry([b.index(), a.index()]).or_default() -= 1;
    }
    // An edge that crosses another, or passes through a vertex, is not there.
    if edges.iter().any(|&(a, b)| triangulation.get_edge_from_neighbors(a, b).is_none()) {
        return None;
    }

    // How often the loops turn around a face, spread from the outer face inwards.
    let mut turns: Vec<Option<i32>> = vec![None; triangulation.num_all_faces()];
    turns[triangulation.outer_face().index()] = Some(0);
    let mut border: Vec<_> = triangulation.directed_edges().filter(|e| e.face().is_outer()).collect();
    while let Some(edge) = border.pop() {
        let there = edge.rev().face();
        if let (Some(here), None) = (turns[edge.face().index()], turns[there.index()]) {
            let crossed = passed.get(&[edge.from().index(), edge.to().index()]);
            turns[there.index()] = Some(here - crossed.copied().unwrap_or(0));
            if let Some(face) = there.as_inner() {
                border.extend(face.adjacent_edges());
            }
        }
    }
    let mut triangles = Vec::new();
    for face in triangulation.inner_faces() {
        let [a, b, c] = face.vertices().map(|v| vertices[v.index()]);
        match turns[face.index()]? {
            0 => {}
            1 => triangles.push([a, b, c]),
            -1 => triangles.push([a, c, b]),
            _ => return None,
        }
    }
    Some(triangles)
}
