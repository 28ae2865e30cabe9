//! Which side of each part is outward.
//!
//! A closed part knows by its own volume. An open one is taken as it is given unless straight lines through it say twice
//! that it is turned round: behind it, where the body should be, they pass through *fewer* triangles on their way to infinity
//! than in front, and through an *even* number more often. Either may err alone (the first in a cleft between lobes, the second
//! where solids overlap). Numbers know no orientation, so that it does not matter how the other parts are turned; sheets that lie
//! on each other count once.

use super::parts::Parts;
use crate::mesh::TriangleMesh;
use crate::tensor::{Mat3, Vec3};
use crate::winding::TriangleTree;
use rayon::prelude::*;

/// Lines through a part, least and most, and through all parts.
const LINES: (usize, usize) = (8, 256);
const ALL_LINES: usize = 100_000;
/// Looks at nodes and triangles for one half of a line.
const EFFORT: usize = 20_000;
/// A part is turned only if its sides differ by this much on average, and by twice the error of the mean.
const LEAST: f64 = 0.25;
/// A part is inside of others if so much of what leaves it meets them.
const ENCLOSED: f64 = 0.9;
/// Cosine of the angle within which two sheets are parallel.
const PARALLEL: f64 = 0.5;

/// A mean and its error, from sums.
#[derive(Clone, Copy, Default)]
struct Mean {
    sum: f64,
    square: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.square += value * value;
    }

    /// Whether the mean of `count` values is below zero beyond doubt.
    fn is_negative(&self, count: f64) -> bool {
        let mean = self.sum / count;
        let error = ((self.square / count - mean * mean).max(0.0) / count).sqrt();
        mean < -LEAST.max(2.0 * error)
    }
}

/// What lines through a part meet.
#[derive(Clone, Copy, Default)]
struct Lines {
    count: f64,
    /// Passages behind less those in front.
    passages: Mean,
    /// The same of their parity: 1 for an odd number.
    parity: Mean,
    /// Half-lines behind that meet another part.
    meeting: f64,
}

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
    let probe =
        Probe { parts, tree: &TriangleTree::new(&parts.mesh), normals: normals(&parts.mesh), reach, lines };
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

fn normals(mesh: &TriangleMesh) -> Vec<Vec3> {
    (0..mesh.triangles.len()).map(|t| mesh.normal(t)).collect()
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

/// Sends lines through parts.
struct Probe<'a> {
    parts: &'a Parts,
    tree: &'a TriangleTree,
    normals: Vec<Vec3>,
    reach: f64,
    lines: usize,
}

impl Probe<'_> {
    /// What lines through the triangles of a part meet; `side` is -1 for the part turned round.
    fn lines(&self, members: &[(usize, f64)], side: f64) -> Lines {
        let mesh = &self.parts.mesh;
        let mut found = Lines::default();
        let (Some(&(_, area)), Some(bounds)) = (members.last(), mesh.bounds()) else { return found };
        let length = 2.0 * bounds.size().norm();
        let mut met = Vec::new();
        for line in 0..self.lines {
            let [u, a, b, c, d] = quasi_random(line);
            let t = members[members.partition_point(|m| m.1 < u * area).min(members.len() - 1)].0;
            let normal = side * self.normals[t];
            if normal == Vec3::zeros() {
                continue;
            }
            let start = point_in(mesh, t, a, b);
            let along = about(&normal, c, d);
            let Some(front) = self.passages(t, &start, &along, length, &mut met) else { continue };
            let Some(behind) = self.passages(t, &start, &-along, length, &mut met) else { continue };
            found.count += 1.0;
            found.passages.add(behind.0 as f64 - front.0 as f64);
            found.parity.add((behind.0 % 2) as f64 - (front.0 % 2) as f64);
            found.meeting += f64::from(u8::from(behind.1));
        }
        found
    }

    /// Sheets that a half-line from triangle `t` passes through, and whether any is of another part; nothing if that
    /// takes too long.
    fn passages(
        &self,
        t: usize,
        start: &Vec3,
        along: &Vec3,
        length: f64,
        met: &mut Vec<(f64, usize)>,
    ) -> Option<(usize, bool)> {
        met.clear();
        let all = self.tree.passages(start, &(length * along), EFFORT, |other, at| {
            if other != t {
                met.push((length * at, other));
            }
        });
        if !all {
            return None;
        }
        met.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let part = |t: usize| self.parts.of[t];
        let mut last = (0.0, t);
        let mut count = 0;
        for &(at, other) in &*met {
            let on_each_other = part(other) != part(last.1)
                && self.normals[other].dot(&self.normals[last.1]).abs() > PARALLEL
                && (at - last.0) * along.dot(&self.normals[other]).abs() < self.reach;
            count += usize::from(!on_each_other);
            last = (at, other);
        }
        Some((count, met.iter().any(|m| part(m.1) != part(t))))
    }
}

/// Volume inside of some of the triangles, from a corner of one of them.
fn volume(mesh: &TriangleMesh, members: &[(usize, f64)]) -> f64 {
    let origin = members.first().map_or_else(Vec3::zeros, |m| mesh.corners(m.0)[0]);
    members.iter().map(|m| mesh.volume_below(m.0, &origin)).sum()
}

/// Point `n` of the Kronecker sequence of the generalised golden ratio, which fills the unit cube of five dimensions evenly.
fn quasi_random(n: usize) -> [f64; 5] {
    /// The root of x^6 = x + 1.
    const RATIO: f64 = 1.134_724_138_401_519_5;
    std::array::from_fn(|i| (0.5 + (n as f64 + 1.0) * RATIO.powi(-(i as i32 + 1))).fract())
}

/// A point of triangle `t`, evenly spread.
fn point_in(mesh: &TriangleMesh, t: usize, a: f64, b: f64) -> Vec3 {
    let [p, q, r] = mesh.corners(t);
    let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
    p + (q - p) * a + (r - p) * b
}

/// A unit vector in front of a plane, spread as lines through it are: by the cosine.
fn about(normal: &Vec3, c: f64, d: f64) -> Vec3 {
    let aside = Vec3::from_fn(|i, _| f64::from(u8::from(i == normal.iamin())));
    let x = normal.cross(&aside).normalize();
    let frame = Mat3::from_columns(&[x, normal.cross(&x), *normal]);
    let angle = std::f64::consts::TAU * d;
    frame * Vec3::new(c.sqrt() * angle.cos(), c.sqrt() * angle.sin(), (1.0 - c).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::marching_cubes::zero_level_set;
    use crate::shape::{BoxShape, Shape, SphereShape};
    use approx::assert_relative_eq;

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

    #[test]
    fn lines_fill_the_half_space_by_the_cosine() {
        let normal = Vec3::new(1.0, -2.0, 0.5).normalize();
        let directions: Vec<Vec3> = (0..2000)
            .map(|n| {
                let [.., c, d] = quasi_random(n);
                about(&normal, c, d)
            })
            .collect();
        let mean = directions.iter().sum::<Vec3>() / 2000.0;
        assert!(directions.iter().all(|d| d.dot(&normal) > 0.0));
        // The mean cosine is 2/3, and no direction within the plane is preferred.
        assert_relative_eq!(mean, normal * (2.0 / 3.0), epsilon = 0.01);
    }
}
