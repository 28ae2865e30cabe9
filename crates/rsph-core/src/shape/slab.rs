//! Surfaces of plane bodies: an outline, extruded to a slab of thickness one about z = 0.

use crate::mesh::{TriangleMesh, filled};
use crate::tensor::Vec3;

/// Rings of triangles between the middle and the outline, so that pictures can show fields on them.
const RINGS: usize = 24;

/// Longest edge of the triangles of a filled outline, as a share of its extent, and how often they may be divided by four.
const LONGEST: f64 = 1.0 / 24.0;
/// See [`LONGEST`].
const DIVISIONS: usize = 5;

/// The closed surface of a slab with any outline (counter-clockwise, z = 0); `None` if it meets itself.
pub(super) fn filled_slab(outline: &[Vec3]) -> Option<TriangleMesh> {
    let n = outline.len() as u32;
    let mut flat = TriangleMesh {
        vertices: outline.to_vec(),
        triangles: filled(&[(0..n).collect()], |v| [outline[v as usize].x, outline[v as usize].y])?,
    };
    if flat.area() <= 0.0 {
        return None;
    }
    let extent = flat.bounds()?.size().max();
    let is_long = |mesh: &TriangleMesh| {
        let longest = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
            (b - a).norm().max((c - b).norm()).max((a - c).norm())
        };
        mesh.triangles.iter().any(|t| longest(t) > LONGEST * extent)
    };
    for _ in 0..DIVISIONS {
        if !is_long(&flat) {
            break;
        }
        flat = flat.divided();
    }
    // The edges that one triangle alone has, in its direction.
    let mut rim: std::collections::BTreeSet<[u32; 2]> = std::collections::BTreeSet::new();
    for t in &flat.triangles {
        for edge in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            if !rim.remove(&[edge[1], edge[0]]) {
                rim.insert(edge);
            }
        }
    }
    let up = flat.vertices.len() as u32;
    let lifted = |z: f64| flat.vertices.iter().map(move |x| Vec3::new(x.x, x.y, z));
    let vertices = lifted(-0.5).chain(lifted(0.5)).collect();
    let caps = flat.triangles.iter().flat_map(|&[a, b, c]| [[a + up, b + up, c + up], [a, c, b]]);
    let sides = rim.iter().flat_map(|&[a, b]| [[a, b, b + up], [a, b + up, a + up]]);
    Some(TriangleMesh { vertices, triangles: caps.chain(sides).collect() })
}

/// The closed surface of a slab whose outline (counter-clockwise, z = 0) is star-shaped about `middle`.
pub(super) fn slab(middle: &Vec3, outline: &[Vec3]) -> TriangleMesh {
    let n = outline.len() as u32;
    let cap = 1 + RINGS as u32 * n;
    let mut mesh = TriangleMesh { vertices: Vec::new(), triangles: Vec::new() };
    for z in [-0.5, 0.5] {
        let lifted = |x: Vec3| Vec3::new(x.x, x.y, z);
        mesh.vertices.push(lifted(*middle));
        for ring in 1..=RINGS {
            let share = ring as f64 / RINGS as f64;
            let at = |x: &Vec3| if ring == RINGS { *x } else { middle + (x - middle) * share };
            mesh.vertices.extend(outline.iter().map(|x| lifted(at(x))));
        }
    }
    // Vertex i of a ring (1 to RINGS) of the lower cap; the upper one's come `cap` later.
    let vertex = |ring: usize, i: u32| 1 + (ring as u32 - 1) * n + i % n;
    for i in 0..n {
        let mut add = |a: u32, b: u32, c: u32| {
            // Seen from above counter-clockwise: outward on the upper cap.
            mesh.triangles.extend([[a + cap, b + cap, c + cap], [a, c, b]]);
        };
        add(0, vertex(1, i), vertex(1, i + 1));
        for ring in 1..RINGS {
            let (a, b) = (vertex(ring, i), vertex(ring, i + 1));
            let (c, d) = (vertex(ring + 1, i), vertex(ring + 1, i + 1));
            add(a, c, d);
            add(a, d, b);
        }
        let (a, b) = (vertex(RINGS, i), vertex(RINGS, i + 1));
        mesh.triangles.extend([[a, b, b + cap], [a, b + cap, a + cap]]);
    }
    mesh
}
