//! What the analytic organs share: smooth implicit solids and their surface.
//!
//! A solid is a function that is negative inside, about a distance near its surface. Its zero
//! level set on a fixed fine grid becomes a closed surface, and the surface a [`MeshShape`]: that
//! gives exact distances, fractions and volume, all of the same surface that loads act on.

use super::{Bounds, MeshShape};
use crate::marching_cubes::zero_level_set;
use crate::sample::Grid;
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;

/// An ellipsoid, its axes turned by `degrees` in the x-y plane.
pub(super) struct Ellipsoid {
    centre: Vec3,
    radii: Vec3,
    to_axes: Mat3,
}

impl Ellipsoid {
    pub(super) fn new(centre: [f64; 3], radii: [f64; 3], degrees: f64) -> Self {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let to_axes = Mat3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
        Self { centre: centre.into(), radii: radii.into(), to_axes }
    }

    /// Negative inside; a distance to first order near the surface.
    pub(super) fn at(&self, x: &Vec3) -> f64 {
        let q = (self.to_axes * (x - self.centre)).component_div(&self.radii);
        let norm = q.norm();
        let slope = q.component_div(&self.radii).norm();
        norm * (norm - 1.0) / slope.max(f64::MIN_POSITIVE)
    }
}

/// Union of two solids with a fillet of about the width `blend`.
pub(super) fn union(a: f64, b: f64, blend: f64) -> f64 {
    let h = (blend - (a - b).abs()).max(0.0);
    a.min(b) - h * h / (4.0 * blend)
}

/// What is left of the first solid outside of the second, with edges rounded over about `blend`.
pub(super) fn difference(a: f64, b: f64, blend: f64) -> f64 {
    -union(-a, b, blend)
}

/// The body inside the zero level set of `solid`, taken on a grid of that spacing over `within`.
pub(super) fn body(
    name: &str,
    within: &Bounds,
    spacing: f64,
    solid: impl Fn(&Vec3) -> f64 + Sync,
) -> MeshShape {
    let cells: Vec<usize> = within.size().iter().map(|s| (s / spacing).ceil() as usize).collect();
    let grid = Grid { origin: within.min, spacing, cells: [cells[0], cells[1], cells[2]] };
    let [nx, ny, _] = grid.cells;
    let mut phi = vec![0.0; grid.len()];
    phi.par_chunks_mut(nx).enumerate().for_each(|(row, values)| {
        for (i, value) in values.iter_mut().enumerate() {
            *value = solid(&grid.centre([i, row % ny, row / ny]));
        }
    });
    MeshShape::from_closed(zero_level_set(&grid, &phi), name)
        .expect("an analytic organ has a surface: its solid and bounds are constants under test")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;
    use approx::assert_relative_eq;

    #[test]
    fn an_ellipsoid_has_its_volume() {
        let e = Ellipsoid::new([0.1, 0.0, 0.0], [0.3, 0.5, 0.4], 30.0);
        let within = Bounds { min: Vec3::repeat(-0.7), max: Vec3::repeat(0.7) };
        let body = body("organ test", &within, 0.02, |x| e.at(x));
        let exact = 4.0 / 3.0 * std::f64::consts::PI * 0.06;
        assert_relative_eq!(body.volume(), exact, max_relative = 2e-3);
        assert_eq!(body.surface().genus(), Some(0));
    }

    #[test]
    fn blends_only_add_at_a_union_and_only_take_at_a_difference() {
        assert_relative_eq!(union(-1.0, 3.0, 0.5), -1.0);
        assert!(union(0.1, 0.1, 0.5) < 0.1);
        assert_relative_eq!(difference(-1.0, 3.0, 0.5), -1.0);
        assert_relative_eq!(difference(-1.0, -3.0, 0.5), 3.0);
        assert!(difference(0.0, 0.0, 0.5) > 0.0);
    }
}
