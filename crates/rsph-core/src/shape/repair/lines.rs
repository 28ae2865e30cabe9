//! Straight lines through the parts of a surface, and what they meet.

use super::parts::Parts;
use crate::mesh::TriangleMesh;
use crate::tensor::{Mat3, Vec3};
use crate::winding::TriangleTree;

/// Looks at nodes and triangles for one half of a line.
const EFFORT: usize = 20_000;
/// Two sides differ if they do by this much on average, and by twice the error of the mean.
const LEAST: f64 = 0.25;
/// Cosine of the angle within which two sheets are parallel.
const PARALLEL: f64 = 0.5;

/// A mean and its error, from sums.
#[derive(Clone, Copy, Default)]
pub(super) struct Mean {
    sum: f64,
    square: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.square += value * value;
    }

    /// Whether the mean of `count` values is below zero beyond doubt.
    pub fn is_negative(&self, count: f64) -> bool {
        let mean = self.sum / count;
        let error = ((self.square / count - mean * mean).max(0.0) / count).sqrt();
        mean < -LEAST.max(2.0 * error)
    }
}

/// What lines through a part meet.
#[derive(Clone, Copy, Default)]
pub(super) struct Lines {
    pub count: f64,
    /// Passages behind less those in front.
    pub passages: Mean,
    /// The same of their parity: 1 for an odd number.
    pub parity: Mean,
    /// Half-lines behind that meet another part.
    pub meeting: f64,
}

/// Sends lines through parts.
pub(super) struct Probe<'a> {
    parts: &'a Parts,
    tree: TriangleTree,
    normals: Vec<Vec3>,
    reach: f64,
    lines: usize,
}

impl<'a> Probe<'a> {
    /// `lines` of them through every part of which is asked. Sheets nearer than `reach` lie on each other.
    pub fn new(parts: &'a Parts, reach: f64, lines: usize) -> Self {
        let mesh = &parts.mesh;
        let normals = (0..mesh.triangles.len()).map(|t| mesh.normal(t)).collect();
        Self { parts, tree: TriangleTree::new(mesh), normals, reach, lines }
    }

    /// What lines through the triangles of a part meet; `side` is -1 for the part turned round.
    pub fn lines(&self, members: &[(usize, f64)], side: f64) -> Lines {
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
    use approx::assert_relative_eq;

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
