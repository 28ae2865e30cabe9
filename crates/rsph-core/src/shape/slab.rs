//! Surfaces of plane bodies: an outline, extruded to a slab of thickness one about z = 0.

use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;

/// Rings of triangles between the middle and the outline, so that pictures can show fields on them.
const RINGS: usize = 24;

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
