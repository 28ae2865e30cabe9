//! Regions of space, as a scenario file writes them.

use super::part::PartValue;
use rsph_core::region::{Axis, Side};
use schemars::JsonSchema;
use serde::Deserialize;

/// A part of space or of a surface.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RegionTable {
    /// Everything.
    All,
    /// The half-space on one side of an axis-aligned plane.
    Plane {
        /// Normal of the plane.
        axis: AxisName,
        /// Coordinate of the plane on that axis (m).
        at: f64,
        /// Which side belongs to the region.
        side: SideName,
    },
    /// The half-space behind a plane: `(x - point).normal <= 0`.
    HalfSpace {
        /// A point of the bounding plane (m).
        point: [f64; 3],
        /// Normal that points out of the region; of any length but zero.
        normal: [f64; 3],
    },
    /// An axis-aligned box.
    Box {
        /// Lower corner (m).
        min: [f64; 3],
        /// Upper corner (m).
        max: [f64; 3],
    },
    /// A ball.
    Ball {
        /// Centre (m).
        centre: [f64; 3],
        /// Radius (m).
        radius: f64,
    },
    /// The part of the surface inside a ball whose outward normal is within 90 degrees of `facing`.
    SurfacePatch {
        /// Centre of the ball (m).
        centre: [f64; 3],
        /// Radius of the ball (m).
        radius: f64,
        /// Direction that the outward normal must face.
        facing: [f64; 3],
    },
    /// Named or painted parts of a mesh; holds surface alone.
    Part(PartValue),
    /// A single point (m), for probes.
    Point([f64; 3]),
    /// Points in all of the regions.
    And(Vec<RegionTable>),
    /// Points in any of the regions.
    Or(Vec<RegionTable>),
    /// Points outside of the region.
    Not(Box<RegionTable>),
}

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AxisName {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
}

impl AxisName {
    /// The axis in the words of the core.
    pub fn axis(self) -> Axis {
        match self {
            Self::X => Axis::X,
            Self::Y => Axis::Y,
            Self::Z => Axis::Z,
        }
    }
}

/// Which side of a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SideName {
    /// Coordinates at or below the plane.
    Below,
    /// Coordinates at or above the plane.
    Above,
}

impl SideName {
    /// The side in the words of the core.
    pub fn side(self) -> Side {
        match self {
            Self::Below => Side::Below,
            Self::Above => Side::Above,
        }
    }
}
