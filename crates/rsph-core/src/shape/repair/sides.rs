//! Which side of each part is outward.
//!
//! A closed part knows by its own volume. An open one is taken as it is given unless straight lines through it say twice
//! that it is turned round: behind it, where the body should be, they pass through *fewer* triangles on their way to infinity
//! than in front, and through an *even* number more often. Either may err alone (the first in a cleft between lobes, the second
//! where solids overlap). Numbers know no orientation, so that it does not matter how the other parts are turned; sheets that lie
//! on each other count once.

use super::lines::Probe;
use super::parts::Parts;
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use rayon::prelude::*;

/// Lines through a part, least and most, and through all parts.
const LINES: (usize, usize) = (8, 256);
const ALL_LINES: usize = 100_000;
/// A part is inside of others if so much of what leaves it meets them.
const ENCLOSED: f64 = 0.9;

/// For each part, whether it is to be turned round. Sheets nearer than `reach` lie on each other. A surface of which
/// most is wrong is taken to be inside out as a whole, so that its cavities stay cavities.
pub(super) fn wrong_parts(parts: &Parts, reach: f64) -> Vec<bool> {
    let members = members(parts);
    let area: Vec<f64> = members.iter().map(|m| m.last().map_or(0.0, |last| last.1)).collect();
    let volume: Vec<f64> = members.iter().map(|m| volume(&parts.mesh, m)).collect();
    if (0..parts.count()).all(|p| parts.closed[p] && volume[p] >= 0.0) {
        return vec![false; parts.count()];
    }
    let mut order: Vec<usize> = (0..parts.count()).collect();
    order.sort_by(|&a, &b| area[b].total_cmp(&area[a]).then(a.cmp(&b)));
    let lines = (ALL_LINES / parts.count()).clamp(LINES.0, LINES.1);
    let probe = Probe::new(parts, reach, lines);
    // Whether part p is wrong, when all have been turned or not.
    let is_wrong = |p: usize, turned: bool| {
        let side = if turned { -1.0 } else { 1.0 };
        if parts.closed[p] {
            // Inside of another, a surface turned inward is a cavity.
            return side * volume[p] < 0.0 && {
                let found = probe.lines(&members[p], side);
                found.meeting < ENCLOSED * found.count.max(1.0)
            };
        }
        let found = probe.lines(&members[p], side);
        found.count > 1.0 && found.passages.is_negative(found.count) && found.parity.is_negative(found.count)
    };
    let judged = &order[..order.len().min(ALL_LINES / lines)];
    let judge = |turned: bool| judged.par_iter().map(|&p| is_wrong(p, turned)).collect::<Vec<_>>();
    let found = judge(false);
    let area_of = |which: bool| -> f64 {
        (0..judged.len()).filter(|&i| found[i] == which).map(|i| area[judged[i]]).sum()
    };
    let all = area_of(true) > area_of(false);
    let found = if all { judge(true) } else { found };
    let mut wrong = vec![all; parts.count()];
    for (&p, other) in judged.iter().zip(found) {
        wrong[p] = all != other;
    }
    wrong
}

/// The triangles of each part, each with the area up to its end.
fn members(parts: &Parts) -> Vec<Vec<(usize, f64)>> {
    let mut members: Vec<Vec<(usize, f64)>> = vec![Vec::new(); parts.count()];
    for (t, &p) in parts.of.iter().enumerate() {
        let before = members[p].last().map_or(0.0, |m| m.1);
        members[p].push((t, before + parts.mesh.triangle_area(t)));
    }
    members
}

/// Volume inside of some of the triangles, from a corner of one of them.
fn volume(mesh: &TriangleMesh, members: &[(usize, f64)]) -> f64 {
    let origin = members.first().map_or_else(Vec3::zeros, |m| mesh.corners(m.0)[0]);
    members.iter().map(|m| mesh.volume_below(m.0, &origin)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::marching_cubes::zero_level_set;
    use crate::shape::{BoxShape, Shape, SphereShape};

    fn ball(radius: f64) -> TriangleMesh {
        SphereShape::new(radius, Vec3::zeros()).unwrap().surface().clone()
    }

    fn both(mut mesh: TriangleMesh, other: &TriangleMesh) -> TriangleMesh {
        let first = mesh.vertices.len() as u32;
        mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
        mesh.vertices.extend(&other.vertices);
        mesh
    }

    fn wrong(mesh: &TriangleMesh) -> Vec<bool> {
        wrong_parts(&Parts::of(mesh), 0.02)
    }

    #[test]
    fn a_cavity_stays_and_a_body_beside_is_turned() {
        let inner = ball(0.5).flipped();
        assert_eq!(wrong(&both(ball(1.0), &inner)), [false, false]);
        // As a whole inside out: both are turned, and the cavity stays one.
        assert_eq!(wrong(&both(ball(1.0), &inner).flipped()), [true, true]);
        let beside = BoxShape::new(Vec3::repeat(0.5), Vec3::repeat(2.0)).unwrap().surface().flipped();
        assert_eq!(wrong(&both(ball(1.0), &beside)), [false, true]);
    }

    #[test]
    fn an_open_layer_below_the_surface_is_turned() {
        let upper = |radius: f64| {
            let mesh = ball(radius);
            mesh.retain(|t| mesh.corners(t).iter().all(|v| v.z > -0.2 * radius))
        };
        assert_eq!(wrong(&both(ball(1.0), &upper(0.99))), [false, false]);
        assert_eq!(wrong(&both(ball(1.0), &upper(0.99).flipped())), [false, true]);
        assert_eq!(wrong(&both(ball(1.0), &upper(1.01).flipped())), [false, true]);
    }

    #[test]
    fn a_flat_wall_within_stays_as_it_is() {
        let wall = TriangleMesh {
            vertices: [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.0, 0.6, 0.0]].map(Vec3::from).to_vec(),
            triangles: vec![[0, 1, 2]],
        };
        assert_eq!(wrong(&both(ball(1.0), &wall)), [false, false]);
        assert_eq!(wrong(&both(ball(1.0), &wall.flipped())), [false, false]);
    }

    #[test]
    fn every_triangle_of_a_loose_soup_is_turned_outward() {
        let grid = Grid { origin: Vec3::repeat(-1.2), spacing: 0.2, cells: [12; 3] };
        let phi: Vec<f64> =
            (0..grid.len()).map(|q| grid.centre([q % 12, q / 12 % 12, q / 144]).norm() - 1.0).collect();
        let mesh = zero_level_set(&grid, &phi);
        let loose =
            TriangleMesh {
                vertices: (0..mesh.triangles.len())
                    .flat_map(|t| mesh.corners(t).map(|v| v * (1.0 + 1e-6 * t as f64)))
                    .collect(),
                triangles: (0..mesh.triangles.len() as u32)
                    .map(|t| {
                        if t % 3 == 0 { [3 * t, 3 * t + 2, 3 * t + 1] } else { [3 * t, 3 * t + 1, 3 * t + 2] }
                    })
                    .collect(),
            };
        let wrong = wrong(&loose);
        assert_eq!(wrong.len(), mesh.triangles.len());
        assert!(wrong.iter().enumerate().all(|(t, wrong)| *wrong == (t % 3 == 0)));
    }

    #[test]
    fn a_wall_in_a_cleft_stays_as_it_is() {
        // A bowl between two long boxes: in front of it, lines pass through both walls of a box.
        let slab = |x: f64| {
            BoxShape::new(Vec3::new(0.4, 4.0, 4.0), Vec3::new(x, -2.0, 0.0)).unwrap().surface().clone()
        };
        let floor =
            BoxShape::new(Vec3::new(2.0, 4.0, 1.0), Vec3::new(-1.0, -2.0, -1.0)).unwrap().surface().clone();
        let lid = TriangleMesh {
            vertices: [[-0.4, -2.0, 0.01], [0.4, -2.0, 0.01], [0.4, 2.0, 0.01], [-0.4, 2.0, 0.01]]
                .map(Vec3::from)
                .to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let all = both(both(both(floor, &slab(-0.9)), &slab(0.5)), &lid);
        assert_eq!(wrong(&all), [false; 4]);
    }
}
