//! The tables of a scenario file. Doc comments are the descriptions of the JSON Schema.

use super::dynamics::{DynamicsTable, RemeshTable};
use super::label_map::LabelMapValue;
use super::loads::{BoundaryTable, FoundationTable, LoadTable};
use super::material::MaterialTables;
use super::region::{AxisName, RegionTable};
use super::values::TimeStepValue;
use rsph_core::measures::MEASURES;
use rsph_core::shape::organ_names;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use std::borrow::Cow;

/// A scenario of rsph: a body, its material, what holds and moves it, and how long.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "rsph scenario")]
pub struct Scenario {
    /// What this is, for plots and reports.
    #[serde(default)]
    pub title: String,
    /// Unit system of every quantity; labels plots and messages. Default: "SI".
    #[serde(default)]
    pub units: UnitsName,
    /// The body: its shape and how finely it is sampled.
    pub body: BodyTable,
    /// What the body is made of, one material or several by place; a prescribed motion can do without (its density is then 1).
    pub material: Option<MaterialTables>,
    /// What moves the particles. Default: the forces of a solid.
    #[serde(default)]
    pub dynamics: DynamicsTable,
    /// Initial displacement and velocity. Default: at rest, undeformed.
    #[serde(default)]
    pub initial: InitialTable,
    /// Parts of the body that are held or moved.
    #[serde(default)]
    pub boundary: Vec<BoundaryTable>,
    /// Springs between parts of the surface and the surroundings.
    #[serde(default)]
    pub foundation: Vec<FoundationTable>,
    /// What pushes or pulls the body.
    #[serde(default)]
    pub load: Vec<LoadTable>,
    /// Settings of the spatial discretisation.
    #[serde(default)]
    pub solver: SolverTable,
    /// How time advances.
    #[serde(default)]
    pub time: TimeTable,
    /// Remeshing: particles are replaced by those of a regular lattice.
    #[serde(default)]
    pub remesh: RemeshTable,
    /// What is written, and how often.
    #[serde(default)]
    pub output: OutputTable,
    /// Named readings, columns of probes.csv.
    #[serde(default)]
    pub probe: Vec<ProbeTable>,
    /// Strain gauges, columns of probes.csv.
    #[serde(default)]
    pub gauge: Vec<GaugeTable>,
}

/// A consistent system of units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
pub enum UnitsName {
    /// Metre, kilogram, second, pascal.
    #[default]
    #[serde(rename = "SI")]
    Si,
    /// Divided by characteristic values.
    #[serde(rename = "normalised")]
    Normalised,
}

/// The body. Exactly one of `shape` and `labelmap` says what it is, one of `spacing` and `particles` how fine.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = [
    {"oneOf": [{"required": ["spacing"]}, {"required": ["particles"]}]},
    {"oneOf": [{"required": ["shape"]}, {"required": ["labelmap"]}]}
]))]
pub struct BodyTable {
    /// Its shape in the undeformed state.
    pub shape: Option<ShapeTable>,
    /// Instead of a shape: an organ in a CT or MR segmentation.
    pub labelmap: Option<LabelMapValue>,
    /// Distance dx between particles (m), positive.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub spacing: Option<f64>,
    /// Number of particles (about); the spacing is found from it.
    #[schemars(range(min = 1))]
    pub particles: Option<usize>,
}

/// The shape of the body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ShapeTable {
    /// An axis-aligned box.
    Box {
        /// Edge lengths along x, y, z (m).
        size: [f64; 3],
        /// Its lower corner (m). Default: the origin.
        #[serde(default)]
        corner: [f64; 3],
    },
    /// A sphere.
    Sphere {
        /// Radius (m).
        radius: f64,
        /// Centre (m). Default: the origin.
        #[serde(default)]
        centre: [f64; 3],
    },
    /// A circular cylinder.
    Cylinder {
        /// Radius (m).
        radius: f64,
        /// Height along its axis (m).
        height: f64,
        /// Direction of its axis. Default: "z".
        #[serde(default = "z")]
        axis: AxisName,
        /// Centre (m). Default: the origin.
        #[serde(default)]
        centre: [f64; 3],
    },
    /// A rectangle in the plane, for plane strain; forces are per metre of thickness.
    Rectangle {
        /// Edge lengths along x and y (m).
        size: [f64; 2],
        /// Its lower corner (m). Default: the origin.
        #[serde(default)]
        corner: [f64; 2],
    },
    /// A disc in the plane, for plane strain.
    Disc {
        /// Radius (m).
        radius: f64,
        /// Centre (m). Default: the origin.
        #[serde(default)]
        centre: [f64; 2],
    },
    /// A polygon in the plane, for plane strain.
    Polygon {
        /// Its corners (m), in order around it.
        points: Vec<[f64; 2]>,
    },
    /// An organ that the program builds itself: metres, x from its right end to its left, y up.
    Organ(OrganName),
    /// A triangle mesh.
    Mesh {
        /// STL, OBJ, PLY or GLB file; a relative path starts at the scenario file.
        path: String,
        /// Factor from the units of the mesh to those of the scenario (0.001 for a mesh in mm).
        #[serde(default = "one")]
        scale: f64,
        /// Whether a surface that is open or overlaps itself may become a body by its winding number, with notes that
        /// say how sure that is; false: it is refused. Default: true.
        #[serde(default = "yes")]
        repair: bool,
    },
}

fn yes() -> bool {
    true
}

fn z() -> AxisName {
    AxisName::Z
}

fn one() -> f64 {
    1.0
}

/// The name of a built-in organ, one of the core's.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(transparent)]
pub struct OrganName(pub String);

impl JsonSchema for OrganName {
    fn schema_name() -> Cow<'static, str> {
        "OrganName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"enum": organ_names().collect::<Vec<_>>()})
    }
}

/// Values at time 0.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InitialTable {
    /// Initial displacement u (m).
    pub displacement: Option<FieldTable>,
    /// Initial velocity v (m/s).
    pub velocity: Option<FieldTable>,
}

/// A vector field over the undeformed body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FieldTable {
    /// One vector everywhere.
    Constant([f64; 3]),
    /// `constant + gradient x`.
    Affine {
        /// Value at the origin.
        #[serde(default)]
        constant: [f64; 3],
        /// Gradient matrix; row i is the gradient of component i.
        gradient: [[f64; 3]; 3],
    },
    /// `rate x (x - centre)`: a rotation with that rate vector (an angle vector for displacements).
    Rotation {
        /// Rotation vector (rad/s, or rad for displacements).
        rate: [f64; 3],
        /// A point of the axis (m). Default: the origin.
        #[serde(default)]
        centre: [f64; 3],
    },
    /// `constant + amplitude cos(2 pi wave_number . x + phase)`.
    Wave {
        /// Mean value. Default: 0.
        #[serde(default)]
        constant: [f64; 3],
        /// Largest deviation from it.
        amplitude: [f64; 3],
        /// Waves per length along x, y, z (1/m).
        wave_number: [f64; 3],
        /// Phase (rad). Default: 0.
        #[serde(default)]
        phase: f64,
    },
    /// A bending mode of a slender beam with free ends; sections move across the beam and turn with it.
    FreeBeam {
        /// Centre of one end (m).
        start: [f64; 3],
        /// Centre of the other end (m).
        end: [f64; 3],
        /// Value at the start, the largest; perpendicular to the beam.
        amplitude: [f64; 3],
        /// Number of the mode, 1 to 20. Default: 1, the slowest.
        #[serde(default = "first_mode")]
        #[schemars(range(min = 1, max = 20))]
        number: usize,
    },
}

fn first_mode() -> usize {
    1
}

/// The spatial discretisation.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolverTable {
    /// Whether the body moves in time or goes straight to equilibrium. Default: "dynamic".
    pub mode: ModeName,
    /// Number of equilibria of mode "static", at as many moments up to `time.until`; loads without a curve
    /// grow with them. Default: 1.
    #[schemars(range(min = 1))]
    pub steps: usize,
    /// Form of the equations of motion. Default: "adjoint".
    pub formulation: FormulationName,
    /// Smoothing length h in spacings dx. Default: 0.8 for a solid in space in the formulation
    /// "adjoint", else 1.25 as in the paper.
    pub smoothing: Option<f64>,
    /// Modulus of the hourglass term, which suppresses zigzags of single particles, as a multiple of its default; 0 switches it
    /// off. Default: 1.
    pub hourglass: Option<f64>,
}

impl Default for SolverTable {
    fn default() -> Self {
        Self {
            mode: ModeName::default(),
            steps: 1,
            formulation: FormulationName::default(),
            smoothing: None,
            hourglass: None,
        }
    }
}

/// Motion or equilibrium.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ModeName {
    /// The motion in time.
    #[default]
    Dynamic,
    /// Equilibrium under the loads, without inertia and viscosity.
    Static,
}

/// Form of the equations of motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FormulationName {
    /// Corrected gradient and its exact adjoint: stable.
    #[default]
    Adjoint,
    /// Eqs. (10) to (14) of the paper to the letter: unstable, here for the record.
    Paper,
}

impl Scenario {
    /// The end of the simulation (s).
    pub fn until(&self) -> f64 {
        self.time.until.unwrap_or(STATIC_END)
    }
}

/// The moment of an equilibrium where the scenario names none (s).
const STATIC_END: f64 = 1.0;

/// How time advances.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeTable {
    /// Time integrator. Default: "auto".
    #[serde(default)]
    pub integrator: Integrator,
    /// Time step (s), or "auto": 0.9 of the stability limit of "rk4", or steps that keep the error of
    /// "sdirk2" below `tolerance`. Default: "auto".
    #[serde(default)]
    pub dt: TimeStepValue,
    /// Error of a step of "sdirk2" with dt "auto", estimated for a scheme of first order, as a share of the
    /// displacement; a fiftieth of it is the residual of implicit stages. Default: 0.02.
    pub tolerance: Option<f64>,
    /// End of the simulation (s), positive. Needed by a motion; in mode "static" the moment whose loads act. Default there: 1.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub until: Option<f64>,
    /// Run with a time step above the stability limit. Default: false.
    #[serde(default)]
    pub allow_unstable: bool,
}

/// A time integrator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// "rk4", or "sdirk2" where viscosity makes the steps of "rk4" more than 100 times shorter than waves do.
    #[default]
    Auto,
    /// The classical Runge-Kutta method of fourth order, as in the paper.
    Rk4,
    /// Implicit, second order: for stiff viscosity.
    Sdirk2,
    /// Implicit, first order: the cheapest step.
    BackwardEuler,
    /// Explicit with many stages (Runge-Kutta-Chebyshev), second order.
    Rkc2,
}

/// Output: what is written, and how often.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputTable {
    /// Time between frames (s), positive. Default: a fiftieth of `time.until`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub every: Option<f64>,
    /// Measures of deformation and stress that frames have beside the fields of every run, on particles and surface. Default: none.
    #[serde(default)]
    pub fields: Vec<MeasureName>,
    /// How often the run is stored so that `rsph run --resume` can go on with it. Default: every 5 minutes.
    #[serde(default)]
    pub checkpoint: CheckpointTable,
}

/// The name of a measure of deformation or stress, one of the core's.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(transparent)]
pub struct MeasureName(pub String);

impl JsonSchema for MeasureName {
    fn schema_name() -> Cow<'static, str> {
        "MeasureName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"enum": MEASURES.iter().map(|field| field.spec().name).collect::<Vec<_>>()})
    }
}

/// How often a run is stored; with both keys, whichever comes first.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckpointTable {
    /// Minutes of wall time, positive. Default: 5, if `frames` is not given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub minutes: Option<f64>,
    /// Frames, at least 1.
    #[schemars(range(min = 1))]
    pub frames: Option<u64>,
}

/// A strain gauge between two points of a solid: probes.csv gets the columns `<name>_strain`, the change of their distance over the
/// undeformed one, and `<name>_length` (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GaugeTable {
    /// What its readings are called by; unique, without commas.
    pub name: String,
    /// One end, on the undeformed body or in it (m).
    pub from: [f64; 3],
    /// The other end (m).
    pub to: [f64; 3],
}

/// A named reading: the mean of a quantity over a region, or its value at a point.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbeTable {
    /// Column name in probes.csv; unique, without commas.
    pub name: String,
    /// A field or a component of it: "displacement.z", "velocity", "stress.xy", "principal_strain.1", "von_mises".
    pub quantity: String,
    /// Where.
    pub region: RegionTable,
}
