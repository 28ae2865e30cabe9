//! Where a boundary, a load or a probe applies: regions of space, never particle indices.

mod part;

pub use part::SurfacePart;

use crate::tensor::Vec3;

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
}

/// Which side of a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Coordinates at or below the plane.
    Below,
    /// Coordinates at or above the plane.
    Above,
}

/// A part of space or of a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// Everything.
    All,
    /// The half-space on one side of an axis-aligned plane.
    Plane {
        /// Normal of the plane.
        axis: Axis,
        /// Coordinate of the plane on that axis.
        at: f64,
        /// Which side belongs to the region.
        side: Side,
    },
    /// The half-space `(x - point).normal <= 0`.
    HalfSpace {
        /// A point of the bounding plane.
        point: Vec3,
        /// Normal that points out of the region; need not be of unit length.
        normal: Vec3,
    },
    /// An axis-aligned box.
    Box {
        /// Lower corner.
        min: Vec3,
        /// Upper corner.
        max: Vec3,
    },
    /// A ball.
    Ball {
        /// Centre.
        centre: Vec3,
        /// Radius.
        radius: f64,
    },
    /// The part of the surface inside a ball whose outward normal is within 90 degrees of
    /// `facing`; it holds no point of the interior.
    SurfacePatch {
        /// Centre of the ball.
        centre: Vec3,
        /// Radius of the ball.
        radius: f64,
        /// Direction that the outward normal must face.
        facing: Vec3,
    },
    /// The part of the surface on named or painted triangles; it holds no point of the interior.
    Part(SurfacePart),
    /// A single point, for probes.
    Point(Vec3),
    /// Points in all of the regions.
    And(Vec<Region>),
    /// Points in any of the regions.
    Or(Vec<Region>),
    /// Points outside of the region.
    Not(std::boxed::Box<Region>),
}

impl Region {
    /// Whether the interior point `x` lies in the region, enlarged by `tolerance` (a length).
    pub fn contains(&self, x: &Vec3, tolerance: f64) -> bool {
        self.test(x, None, tolerance)
    }

    /// Whether the surface point `x` with outward unit normal `n` lies in the region, enlarged by
    /// `tolerance` (a length).
    pub fn contains_on_surface(&self, x: &Vec3, n: &Vec3, tolerance: f64) -> bool {
        self.test(x, Some(n), tolerance)
    }

    fn test(&self, x: &Vec3, n: Option<&Vec3>, tol: f64) -> bool {
        match self {
            Region::All => true,
            Region::Plane { axis, at, side } => match side {
                Side::Below => x[*axis as usize] <= at + tol,
                Side::Above => x[*axis as usize] >= at - tol,
            },
            Region::HalfSpace { point, normal } => (x - point).dot(normal) <= tol * normal.norm(),
            Region::Box { min, max } => (0..3).all(|i| x[i] >= min[i] - tol && x[i] <= max[i] + tol),
            Region::Ball { centre, radius } => (x - centre).norm() <= radius + tol,
            Region::SurfacePatch { centre, radius, facing } => {
                n.is_some_and(|n| n.dot(facing) > 0.0) && (x - centre).norm() <= radius + tol
            }
            Region::Part(part) => n.is_some_and(|n| part.contains(x, n, tol)),
            Region::Point(p) => (x - p).norm() <= tol,
            Region::And(all) => all.iter().all(|r| r.test(x, n, tol)),
            Region::Or(any) => any.iter().any(|r| r.test(x, n, tol)),
            Region::Not(r) => !r.test(x, n, -tol),
        }
    }
}
