//! The smeared local load of Figs. 6 and 7: a Gaussian pressure on the part of the surface that faces
//! the push.

use crate::boundary::surface_load::{Panel, SurfacePoint, Traction};
use crate::mesh::TriangleMesh;
use crate::setup::PatchCentre;
use crate::tensor::Vec3;

/// Share of the extent in x that the radius takes by default.
const DEFAULT_RADIUS: f64 = 0.15;
/// Where the upper right part of an organ begins, as a share of the extent in x.
const RIGHT_PART: f64 = 0.6;
/// Beyond this many radii nothing is left of the Gaussian (exp(-36) = 2e-16).
const CUTOFF: f64 = 6.0;
/// Cosine of the angle to the direction up to which a surface lies along it: it is not pushed, whatever rounding makes of a
/// right angle.
const ALONG: f64 = 1e-3;
/// Longest triangle edge of the quadrature, in radii: the total force is then exact to 1e-4.
const RESOLUTION: f64 = 0.25;
/// The same where one point in the middle of each triangle does.
const RESOLUTION_OF_CENTRES: f64 = 0.1;

/// A patch load whose centre and radius are known.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Peak pressure (Pa).
    pub pressure: f64,
    /// Centre.
    pub centre: Vec3,
    /// Radius of the Gaussian.
    pub radius: f64,
    /// Unit direction of the push.
    pub direction: Vec3,
}

impl Patch {
    /// Finds centre and radius on the body's surface.
    pub fn on(
        surface: &TriangleMesh,
        pressure: f64,
        centre: &PatchCentre,
        radius: Option<f64>,
        direction: &Vec3,
    ) -> Self {
        let x = || surface.vertices.iter().map(|v| v.x);
        let low = x().fold(f64::INFINITY, f64::min);
        let extent = x().fold(f64::NEG_INFINITY, f64::max) - low;
        let centre = match centre {
            PatchCentre::At(c) => *c,
            PatchCentre::UpperRight => surface
                .vertices
                .iter()
                .filter(|v| v.x > low + RIGHT_PART * extent)
                .max_by(|a, b| a.y.total_cmp(&b.y))
                .copied()
                .unwrap_or_else(Vec3::zeros),
        };
        Self {
            pressure,
            centre,
            radius: radius.unwrap_or(DEFAULT_RADIUS * extent),
            direction: direction.normalize(),
        }
    }

    /// Calls `act` with this load as a traction and the quadrature that it wants.
    pub fn with_traction<T>(&self, act: impl FnOnce(&Traction<'_>) -> T) -> T {
        act(&Traction {
            at: &|p| self.traction(p),
            reaches: &|panel| {
                let Panel { centre, edge } = panel;
                let reach = CUTOFF * self.radius + edge;
                self.pushes(&centre.normal) && (centre.x - self.centre).norm_squared() < reach * reach
            },
            resolution: &|_, _| RESOLUTION * self.radius,
            smooth: RESOLUTION_OF_CENTRES * self.radius,
        })
    }

    /// Whether a surface with that outward normal faces the push.
    fn pushes(&self, normal: &Vec3) -> bool {
        normal.dot(&self.direction) < -ALONG
    }

    /// Traction at a surface point: p exp(-d^2/r^2) on the side that faces against the direction.
    pub fn traction(&self, point: &SurfacePoint) -> Vec3 {
        let square = (point.x - self.centre).norm_squared() / (self.radius * self.radius);
        if self.pushes(&point.normal) && square < CUTOFF * CUTOFF {
            self.direction * (self.pressure * (-square).exp())
        } else {
            Vec3::zeros()
        }
    }
}
