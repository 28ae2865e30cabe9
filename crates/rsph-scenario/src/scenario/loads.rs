//! Boundaries and loads, as a scenario file writes them.
//!
//! The entries of a list are told apart by their `kind`; which other keys belong to a kind is
//! checked when the tables are lowered, so that a message can name the key and its line.

use super::region::RegionTable;
use super::values::CentreValue;
use schemars::JsonSchema;
use serde::Deserialize;

/// A part of the body that is held or moved.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = [
    {"if": {"properties": {"kind": {"const": "prescribed"}}}, "then": {"required": ["motion"]}},
    {"if": {"properties": {"kind": {"const": "clamp"}}}, "then": {"properties": {"motion": false}}},
]))]
pub struct BoundaryTable {
    /// Name of what it carries: `probes.csv` gets the columns `<name>_force_x`, `_y` and `_z` (N), the force on the body,
    /// `<name>_moment_x` and so on (N m), and where it moves `<name>_displacement_x` and so on (m).
    pub name: Option<String>,
    /// The point that the moment is about (m), of a boundary with a name. Default: the centre of what it holds, which goes with it.
    pub moment_about: Option<[f64; 3]>,
    /// What happens there.
    pub kind: BoundaryKind,
    /// Where.
    pub region: RegionTable,
    /// Components that are held; `normal`, alone: the one along the normal of the surface, for rollers and planes of symmetry.
    /// Default: all.
    pub fix: Option<Vec<ComponentName>>,
    /// How it moves; for kind "prescribed".
    pub motion: Option<MotionTable>,
}

/// A component of the displacement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ComponentName {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
    /// Along the normal of the surface.
    Normal,
}

/// Kind of boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BoundaryKind {
    /// It does not move.
    Clamp,
    /// It moves as told.
    Prescribed,
}

/// Springs between a part of the surface and its surroundings.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoundationTable {
    /// Where on the surface.
    pub region: RegionTable,
    /// Stiffness along the normal of the undeformed surface (Pa/m). Default: 0.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub normal: f64,
    /// Stiffness across that normal (Pa/m). Default: 0.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub tangential: f64,
}

/// A motion in time.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MotionTable {
    /// Moves by `displacement` between two times, then rests.
    Ramp {
        /// Final displacement (m).
        displacement: [f64; 3],
        /// Start (s). Default: 0.
        #[serde(default)]
        from: f64,
        /// End (s), after `from`.
        to: f64,
    },
    /// Moves by `displacement` times a curve through points.
    Curve {
        /// Displacement where the curve is 1 (m).
        displacement: [f64; 3],
        /// Times of the points (s), ascending.
        time: Vec<f64>,
        /// Factors at these times.
        value: Vec<f64>,
        /// How it goes from one point to the next. Default: "linear".
        #[serde(default)]
        kind: CurveKindName,
        /// Whether what it does between the first and the last time repeats for ever. Default: it is constant outside.
        #[serde(default)]
        periodic: bool,
    },
    /// `amplitude sin(2 pi frequency t)`.
    Oscillation {
        /// Amplitude of the displacement (m).
        amplitude: [f64; 3],
        /// Frequency (Hz).
        frequency: f64,
    },
}

/// How a curve goes from one of its points to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CurveKindName {
    /// Along a straight line.
    #[default]
    Linear,
    /// Not at all: it keeps the value of a point until the time of the next one.
    Step,
    /// By monotone cubics, with a continuous rate.
    Smooth,
}

/// A factor in time by points; constant before the first and after the last of them, or periodic.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveTable {
    /// Times of the points (s), ascending.
    pub time: Vec<f64>,
    /// Factors at these times.
    pub value: Vec<f64>,
    /// How it goes from one point to the next. Default: "linear".
    #[serde(default)]
    pub kind: CurveKindName,
    /// Whether what it does between the first and the last time repeats for ever. Default: it is constant outside.
    #[serde(default)]
    pub periodic: bool,
}

/// A factor that grows linearly from 0 to 1 between two times; a step if they are equal.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RampTable {
    /// Start (s). Default: 0.
    #[serde(default)]
    pub from: f64,
    /// End (s), not before `from`.
    pub to: f64,
}

/// What pushes or pulls the body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = [
    {"if": {"properties": {"kind": {"const": "traction"}}}, "then": {"required": ["region", "traction"]}},
    {"if": {"properties": {"kind": {"enum": ["pressure", "follower_pressure"]}}}, "then": {"required": ["region", "pressure"]}},
    {"if": {"properties": {"kind": {"const": "body_force"}}}, "then": {"required": ["acceleration"]}},
    {"if": {"properties": {"kind": {"const": "patch"}}},
     "then": {"required": ["pressure", "centre", "direction"], "properties": {"region": false}}},
]))]
pub struct LoadTable {
    /// What kind of load.
    pub kind: LoadKindName,
    /// Where on the surface (traction, pressure, follower_pressure) or in the body (body_force; default: everywhere).
    pub region: Option<RegionTable>,
    /// Force per area (Pa), for kind "traction".
    pub traction: Option<[f64; 3]>,
    /// Pressure (Pa), positive pushes inward, for kinds "pressure" and "follower_pressure"; the peak, for kind "patch".
    pub pressure: Option<f64>,
    /// Force per mass (m/s^2), such as gravity, for kind "body_force".
    pub acceleration: Option<[f64; 3]>,
    /// Centre of the patch (m), or "upper-right" on an organ, for kind "patch".
    pub centre: Option<CentreValue>,
    /// Radius r of exp(-d^2/r^2) (m), for kind "patch". Default: 0.15 of the body's extent in x.
    pub radius: Option<f64>,
    /// Direction of the push, for kind "patch"; acts on the surface that faces against it.
    pub direction: Option<[f64; 3]>,
    /// Its course in time: it grows. Default: at full strength from the start.
    pub ramp: Option<RampTable>,
    /// Its course in time by points, in the place of `ramp`.
    pub curve: Option<CurveTable>,
}

/// A kind of load.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LoadKindName {
    /// A force per area on part of the surface.
    Traction,
    /// A pressure against the outward normal of part of the surface, as it is undeformed.
    Pressure,
    /// A pressure that follows the deformed surface: against the normal that it has, on the area that it has.
    FollowerPressure,
    /// A force per mass, such as gravity.
    BodyForce,
    /// A smeared local push: `pressure exp(-d^2/radius^2) direction`.
    Patch,
}
