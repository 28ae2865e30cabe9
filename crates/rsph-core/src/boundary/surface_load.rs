//! Tractions on the surface of a body: quadrature over its triangles, scattered to the particles.

use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use std::fmt;

/// A point of the quadrature over a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Place.
    pub x: Vec3,
    /// Outward unit normal of its triangle.
    pub normal: Vec3,
    /// Share of the area.
    pub area: f64,
}

/// A traction, and how fine a quadrature it wants.
#[derive(Clone, Copy)]
pub struct Traction<'a> {
    /// Traction at a point of the surface (Pa).
    pub at: &'a (dyn Fn(&SurfacePoint) -> Vec3 + Sync),
    /// Whether it may act on a panel.
    pub reaches: &'a (dyn Fn(&Panel) -> bool + Sync),
    /// Longest edge allowed in the triangle of these corners with this outward normal.
    pub resolution: &'a (dyn Fn(&[Vec3; 3], &Vec3) -> f64 + Sync),
    /// Longest edge of a triangle whose centre alone says enough.
    pub smooth: f64,
}

impl Traction<'_> {
    /// Calls `visit` with place and force of the quadrature points of a panel.
    pub fn on(&self, panel: &Panel, corners: &[Vec3; 3], mut visit: impl FnMut(&Vec3, &Vec3)) {
        if !(self.reaches)(panel) {
            return;
        }
        let mut at = |p: &SurfacePoint| {
            let traction = (self.at)(p);
            if traction.norm_squared() > 0.0 {
                visit(&p.x, &(traction * p.area));
            }
        };
        if panel.edge <= self.smooth {
            at(&panel.centre);
        } else {
            let normal = &panel.centre.normal;
            let allowed = |corners: &[Vec3; 3]| (self.resolution)(corners, normal);
            split(corners, panel.centre.area, &allowed, &mut |corners, area, _| {
                three_points(corners, normal, area, &mut at);
            });
        }
    }
}

impl fmt::Debug for Traction<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Traction").field("smooth", &self.smooth).finish_non_exhaustive()
    }
}

/// A small flat piece of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Panel {
    /// Its centre of gravity, normal and area.
    pub centre: SurfacePoint,
    /// Its longest edge.
    pub edge: f64,
}

/// Calls `visit` with the triangles of a surface and their corners, split until no edge is longer than
/// `longest` says of their corners and outward normal.
pub fn for_each_panel(
    mesh: &TriangleMesh,
    longest: impl Fn(&[Vec3; 3], &Vec3) -> f64,
    mut visit: impl FnMut(Panel, &[Vec3; 3]),
) {
    for t in &mesh.triangles {
        let corners = t.map(|i| mesh.vertices[i as usize]);
        let cross = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let area = 0.5 * cross.norm();
        if area > 0.0 {
            let normal = cross / (2.0 * area);
            split(&corners, area, &|corners| longest(corners, &normal), &mut |corners, area, edge| {
                let x = (corners[0] + corners[1] + corners[2]) / 3.0;
                visit(Panel { centre: SurfacePoint { x, normal, area }, edge }, corners);
            });
        }
    }
}

/// Quadrature points of a surface, three to a triangle, after splitting triangles until no edge is
/// longer than `resolution`.
pub fn quadrature(mesh: &TriangleMesh, resolution: f64) -> Vec<SurfacePoint> {
    let mut points = Vec::new();
    for_each_panel(
        mesh,
        |_, _| resolution,
        |panel, corners| {
            three_points(corners, &panel.centre.normal, panel.centre.area, &mut |p| points.push(*p));
        },
    );
    points
}

/// Exact for quadratic functions on the triangle.
pub(super) fn three_points(
    corners: &[Vec3; 3],
    normal: &Vec3,
    area: f64,
    visit: &mut impl FnMut(&SurfacePoint),
) {
    let sum = corners[0] + corners[1] + corners[2];
    for corner in corners {
        visit(&SurfacePoint { x: (sum + 3.0 * corner) / 6.0, normal: *normal, area: area / 3.0 });
    }
}

/// Halves a triangle across its longest edge until no edge of a piece is longer than `longest` says of its
/// corners; `visit` sees corners, area and longest edge of the pieces.
fn split(
    c: &[Vec3; 3],
    area: f64,
    longest: &impl Fn(&[Vec3; 3]) -> f64,
    visit: &mut impl FnMut(&[Vec3; 3], f64, f64),
) {
    let edges: [f64; 3] = std::array::from_fn(|i| (c[(i + 1) % 3] - c[i]).norm());
    let i = (0..3).max_by(|&i, &j| edges[i].total_cmp(&edges[j])).unwrap_or(0);
    if edges[i] > longest(c) {
        let (a, b, d) = (c[i], c[(i + 1) % 3], c[(i + 2) % 3]);
        let middle = 0.5 * (a + b);
        split(&[a, middle, d], 0.5 * area, longest, visit);
        split(&[middle, b, d], 0.5 * area, longest, visit);
    } else {
        visit(c, area, edges[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::patch::Patch;
    use crate::setup::PatchCentre;

    #[test]
    fn a_patch_has_its_whole_force_however_small_or_large() {
        let corner = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let square = |half: f64| TriangleMesh {
            vertices: vec![
                corner(-half, -half),
                corner(half, -half),
                corner(half, half),
                corner(-half, half),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        // From a patch that panels of 0.25 resolve by their centres to one much smaller than they are.
        for radius in [2.6_f64, 0.5, 0.1, 0.01] {
            let surface = square((6.5 * radius).max(1.0));
            let centre = PatchCentre::At(corner(0.301, -0.217));
            let patch = Patch::on(&surface, 1.0, &centre, Some(radius), &-Vec3::z());
            let (mut force, mut points) = (Vec3::zeros(), 0);
            patch.with_traction(|traction| {
                for_each_panel(
                    &surface,
                    |_, _| 0.25,
                    |panel, corners| {
                        traction.on(&panel, corners, |_, f| {
                            force += f;
                            points += 1;
                        });
                    },
                );
            });
            // The integral of exp(-d^2/r^2) over the plane is pi r^2.
            let exact = std::f64::consts::PI * radius * radius;
            assert!((force.z / -exact - 1.0).abs() < 1e-4, "{radius}: {force:?} {exact}");
            assert!(points < 100_000, "{radius}: {points}");
        }
    }
}
