//! What moves the particles, and remeshing, as a scenario file writes them.

use super::values::EveryValue;
use schemars::JsonSchema;
use serde::Deserialize;

/// What moves the particles: the forces of a solid, a given velocity field, or those of a fluid beside a
/// solid.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = [
    {"if": {"properties": {"kind": {"const": "prescribed"}}, "required": ["kind"]},
     "then": {"required": ["velocity"]}},
    {"if": {"properties": {"kind": {"const": "fsi_1d"}}, "required": ["kind"]},
     "then": {"required": ["fluid", "solid", "interface"]}},
]))]
pub struct DynamicsTable {
    /// Default: "solid".
    #[serde(default)]
    pub kind: DynamicsKind,
    /// The velocity that the particles follow; for kind "prescribed".
    pub velocity: Option<VelocityTable>,
    /// P (s): the velocity is multiplied by cos(pi t / P), so that everything is back at t = P; for kind
    /// "prescribed". Default: it is steady.
    pub reversal: Option<f64>,
    /// Half width, in spacings, of the band across the surface in which the colour falls from 1 to 0;
    /// for kind "prescribed". Default: 0, a jump.
    #[schemars(range(min = 0, max = 8))]
    pub band: Option<f64>,
    /// Colour C(x), Eq. (8), that makes the surface, between 0 and 1; for kind "prescribed".
    /// Default: 0.5.
    pub iso: Option<f64>,
    /// The fluid, left of the interface; for kind "fsi_1d".
    pub fluid: Option<FluidTable>,
    /// The elastic solid, right of the interface; for kind "fsi_1d".
    pub solid: Option<ElasticTable>,
    /// Where fluid and solid meet at rest, x (m); for kind "fsi_1d".
    pub interface: Option<f64>,
}

/// Kind of dynamics: what moves the particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DynamicsKind {
    /// Stresses, loads and clamps.
    #[default]
    Solid,
    /// A given velocity field: the deformation test.
    Prescribed,
    /// A fluid beside an elastic solid along x, Eqs. (19) to (21).
    #[serde(rename = "fsi_1d")]
    Interaction,
}

/// A fluid in one dimension.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FluidTable {
    /// The viscous fluid of Eq. (19), with density 1.
    Burgers {
        /// Kinematic viscosity nu (m^2/s), positive.
        viscosity: f64,
    },
    /// A fluid that carries sound.
    Acoustic {
        /// Density (kg/m^3), positive.
        density: f64,
        /// Speed of sound (m/s), positive.
        sound_speed: f64,
    },
}

/// An elastic solid in one dimension.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElasticTable {
    /// Elasticity mu: stress per strain (Pa), positive.
    pub elasticity: f64,
    /// Density (kg/m^3), positive. Default: 1.
    #[serde(default = "one")]
    pub density: f64,
}

fn one() -> f64 {
    1.0
}

/// A velocity field.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum VelocityTable {
    /// The deformation of LeVeque and Enright in the unit cube, Eq. (18).
    Leveque,
    /// One velocity everywhere (m/s).
    Constant([f64; 3]),
    /// `constant + gradient x`.
    Affine {
        /// Value at the origin (m/s).
        #[serde(default)]
        constant: [f64; 3],
        /// Gradient matrix (1/s); row i is the gradient of component i.
        gradient: [[f64; 3]; 3],
    },
    /// `rate x (x - centre)`.
    Rotation {
        /// Rotation vector (rad/s).
        rate: [f64; 3],
        /// A point of the axis (m). Default: the origin.
        #[serde(default)]
        centre: [f64; 3],
    },
}

/// Remeshing: particles are replaced by those of a regular lattice. At most one of `every` and `interval`.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RemeshTable {
    /// Steps between remeshings; 0: never; "auto": when the strain asks for it. Default: 0.
    pub every: EveryValue,
    /// Time between remeshings (s), positive, instead of `every`: at the first step that reaches it.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
    /// Interpolation kernel. Default: "m4-prime" for a solid, else "lambda-4-2".
    pub kernel: Option<RemeshKernelName>,
    /// Whether the level set of a solid becomes the distance from its present surface at each remeshing.
    /// Default: false, particles keep theirs from the undeformed body.
    pub restore_level_set: Option<bool>,
}

/// A kernel of remeshing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
pub enum RemeshKernelName {
    /// M4' of Eq. (16): second order, 64 weights.
    #[serde(rename = "m4-prime")]
    M4Prime,
    /// Lambda_4,2: fourth order, 216 weights.
    #[serde(rename = "lambda-4-2")]
    Lambda42,
    /// Lambda_6,4: sixth order, 512 weights.
    #[serde(rename = "lambda-6-4")]
    Lambda64,
}
