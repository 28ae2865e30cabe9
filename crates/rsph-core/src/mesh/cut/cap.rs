//! The cap on a cut: its edges chained to loops, loops with the holes in them, triangles.

use super::Plane;
use super::fill::filled;
use crate::tensor::Vec3;
use std::collections::{BTreeMap, HashMap};

/// Triangles that pass each of the directed `edges`, which lie on `plane`, once.
///
/// Loops that are passed counter-clockwise, seen from below the plane, enclose parts of the cap;
/// the others are holes in them. Open chains are closed by a straight segment.
pub(super) fn triangles(vertices: &[Vec3], plane: &Plane, edges: &[[u32; 2]]) -> Vec<[u32; 3]> {
    let axis = Vec3::ith(plane.normal.iamin(), 1.0);
    let right = plane.normal.cross(&axis).normalize();
    let up = right.cross(&plane.normal);
    let flat = |v: u32| {
        let x = vertices[v as usize] - plane.point;
        [x.dot(&right), x.dot(&up)]
    };
    let mut triangles = Vec::new();
    for group in groups(loops(edges), flat) {
        // Loops that meet or cross, as those of a surface that passes through itself, can not be filled
        // together, or not at all. A fan then overlaps itself, but closes the surface with the right volume.
        let mut fill = filled(&group, flat).unwrap_or_else(|| {
            let alone = |l: &Vec<u32>| filled(std::slice::from_ref(l), flat).unwrap_or_else(|| fan(l));
            group.iter().flat_map(alone).collect()
        });
        triangles.append(&mut fill);
    }
    triangles
}

/// The edges as loops that pass no vertex twice.
fn loops(edges: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let mut surplus: BTreeMap<u32, i32> = BTreeMap::new();
    for &[from, to] in edges {
        next.entry(from).or_default().push(to);
        *surplus.entry(from).or_default() += 1;
        *surplus.entry(to).or_default() -= 1;
    }
    // Open chains first, from their beginnings: once they are gone, every walk ends where it began.
    let open = surplus.iter().flat_map(|(&v, &n)| std::iter::repeat_n(v, n.max(0) as usize));
    let starts: Vec<u32> = open.chain(next.keys().copied()).collect();
    let mut loops = Vec::new();
    for start in starts {
        let mut path = vec![start];
        let mut place = HashMap::from([(start, 0)]);
        let mut last = start;
        while let Some(to) = next.get_mut(&last).and_then(Vec::pop) {
            if let Some(&i) = place.get(&to) {
                path[i + 1..].iter().for_each(|v| {
                    place.remove(v);
                });
                loops.push([to].into_iter().chain(path.drain(i + 1..)).collect());
            } else {
                place.insert(to, path.len());
                path.push(to);
            }
            last = to;
        }
        loops.push(path);
    }
    loops.retain(|l| l.len() > 2);
    loops
}

/// Each loop around a part of the cap together with the holes in it; holes in no part stand alone.
fn groups(loops: Vec<Vec<u32>>, flat: impl Fn(u32) -> [f64; 2]) -> Vec<Vec<Vec<u32>>> {
    let outline = |l: Vec<u32>| (l.iter().map(|&v| flat(v)).collect::<Vec<_>>(), l);
    let (mut outer, holes): (Vec<_>, Vec<_>) =
        loops.into_iter().map(outline).partition(|(points, _)| area(points) > 0.0);
    // The smallest loop around a hole is its own: between two loops of a kind lies one of the other.
    outer.sort_by(|(a, _), (b, _)| area(a).total_cmp(&area(b)));
    let mut alone = Vec::new();
    let (outlines, mut groups): (Vec<_>, Vec<_>) = outer.into_iter().map(|(p, l)| (p, vec![l])).unzip();
    for (points, hole) in holes {
        // Not a vertex, which the hole may share with the loop around it.
        let middle = [0, 1].map(|i| 0.5 * (points[0][i] + points[1][i]));
        let around = outlines.iter().position(|o| area(o) > -area(&points) && contains(o, middle));
        around.map_or(&mut alone, |i| &mut groups[i]).push(hole);
    }
    groups.extend(alone.into_iter().map(|hole| vec![hole]));
    groups
}

/// Area of a polygon, positive if it is passed counter-clockwise.
fn area(points: &[[f64; 2]]) -> f64 {
    let [x, y] = points[0];
    let twice = |w: &[[f64; 2]]| (w[0][0] - x) * (w[1][1] - y) - (w[1][0] - x) * (w[0][1] - y);
    0.5 * points.windows(2).map(twice).sum::<f64>()
}

/// Whether a ray from the point along x leaves the polygon.
fn contains(points: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let previous = points.iter().cycle().skip(points.len() - 1);
    let crossed = previous.zip(points).filter(|&(&[ax, ay], &[bx, by])| {
        (ay > y) != (by > y) && x < ax + (bx - ax) * ((y - ay) / (by - ay))
    });
    crossed.count() % 2 == 1
}

fn fan(polygon: &[u32]) -> Vec<[u32; 3]> {
    polygon[1..].windows(2).map(|w| [polygon[0], w[0], w[1]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen from below, x points to the right and y up.
    const PLANE: Plane = Plane { point: Vec3::new(0.0, 0.0, 0.0), normal: Vec3::new(0.0, 0.0, -1.0) };

    /// Area of a triangle, positive if it faces down.
    fn facing(vertices: &[Vec3], &[a, b, c]: &[u32; 3]) -> f64 {
        let [a, b, c] = [a, b, c].map(|v| vertices[v as usize]);
        0.5 * (b - a).cross(&(c - a)).z
    }

    /// Number of triangles and area of the cap of polygons, each with vertices of its own. Its rim is
    /// found to be their edges.
    fn cap(polygons: &[&[[i32; 2]]]) -> (usize, f64) {
        let (mut vertices, mut edges) = (Vec::new(), Vec::new());
        for polygon in polygons {
            let (first, n) = (vertices.len() as u32, polygon.len() as u32);
            edges.extend((0..n).map(|i| [first + i, first + (i + 1) % n]));
            vertices.extend(polygon.iter().map(|&[x, y]| Vec3::new(f64::from(x), f64::from(y), 0.0)));
        }
        let triangles = triangles(&vertices, &PLANE, &edges);
        let mut passed: BTreeMap<[u32; 2], i32> = BTreeMap::new();
        for &[a, b, c] in &triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *passed.entry([from, to]).or_default() += 1;
                *passed.entry([to, from]).or_default() -= 1;
            }
        }
        let rim: Vec<_> = passed.into_iter().filter(|(_, n)| *n > 0).map(|(e, _)| e).collect();
        edges.sort_unstable();
        assert_eq!(rim, edges);
        (triangles.len(), triangles.iter().map(|t| facing(&vertices, t)).sum())
    }

    const SQUARE: &[[i32; 2]] = &[[0, 0], [9, 0], [9, 9], [0, 9]];

    #[test]
    fn vertices_on_straight_stretches_are_used() {
        let (n, area) = cap(&[&[[0, 0], [1, 0], [2, 0], [9, 0], [9, 9], [3, 9], [0, 9], [0, 4]]]);
        assert_eq!((n, area), (6, 81.0));
    }

    #[test]
    fn parts_lie_in_holes_of_parts() {
        let hole = &[[1, 1], [1, 8], [8, 8], [8, 1]];
        let island = &[[2, 2], [7, 2], [7, 7], [2, 7]];
        let other = &[[20, 0], [21, 0], [20, 1]];
        let (n, area) = cap(&[hole, island, other, SQUARE, &[[3, 3], [3, 4], [4, 3]]]);
        assert_eq!((n, area), (8 + 7 + 1, 81.0 - 49.0 + 25.0 + 0.5 - 0.5));
    }

    #[test]
    fn a_hole_may_touch_the_loop_around_it() {
        let vertices: Vec<_> = [[0, 0], [9, 0], [9, 9], [0, 9], [2, 5], [5, 2]]
            .map(|[x, y]| Vec3::new(x.into(), y.into(), 0.0))
            .into();
        let edges = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [4, 5], [5, 0]];
        let cap = triangles(&vertices, &PLANE, &edges);
        assert_eq!(cap.len(), 5);
        assert!(cap.iter().all(|t| facing(&vertices, t) > 0.0));
    }

    #[test]
    fn loops_that_cross_or_coincide_keep_their_area_and_edges() {
        assert_eq!(cap(&[&[[0, 0], [9, 9], [9, 0], [0, 9]]]).1, 0.0);
        assert_eq!(cap(&[SQUARE, SQUARE]).1, 162.0);
        assert_eq!(cap(&[SQUARE, &[[4, 4], [4, 20], [5, 4]]]).1, 81.0 - 8.0);
        assert_eq!(cap(&[SQUARE, &[[0, 0], [2, 5], [5, 2]]]).1, 81.0 - 10.5);
        assert_eq!(cap(&[&[[0, 9], [9, 9], [9, 0], [0, 0]]]).1, -81.0);
        assert_eq!(cap(&[&[[0, 0], [3, 0], [5, 0]]]).1, 0.0);
    }

    #[test]
    fn open_chains_are_closed_by_a_straight_edge() {
        let closed = loops(&[[2, 3], [0, 1], [1, 2], [7, 8], [8, 9], [9, 7], [5, 6]]);
        assert_eq!(closed, [vec![0, 1, 2, 3], vec![7, 8, 9]]);
        // Two chains from one vertex, one of them with a loop on its way.
        let closed = loops(&[[0, 1], [1, 2], [0, 3], [3, 4], [4, 5], [5, 3], [3, 6]]);
        assert_eq!(closed.iter().map(Vec::len).sum::<usize>(), 3 + 3 + 3);
    }
}
