//! Everything a simulation is made from, in the words of a scenario file.

mod curve;
mod interaction;
mod materials;
mod mechanics;

pub use curve::{Between, Curve};
pub use interaction::{Interaction, InteractionSetting};
pub use materials::{MaterialPart, ModulusField, Place, PointwiseModulus, Within};
pub use mechanics::{Mechanics, Prescription, Remesh, RemeshTrigger, STRAIN, SolidSetup};

use crate::particles::Field;
use crate::region::Region;
use crate::sample::Resolution;
use crate::shape::Shape;
use crate::tensor::Vec3;
pub use crate::vector_field::{PointwiseFunction, VectorField};
use std::sync::Arc;

/// The unit system that labels plots and messages; the numerics do not care.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Units {
    /// Metre, kilogram, second, pascal.
    #[default]
    Si,
    /// Divided by characteristic values, as in section 5.2 of the paper.
    Normalised,
}

/// Initial values.
#[derive(Clone, Debug, Default)]
pub struct Initial {
    /// Initial displacement u.
    pub displacement: VectorField,
    /// Initial velocity v.
    pub velocity: VectorField,
}

/// How a prescribed part moves.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Moves by `displacement` times a curve.
    Curve {
        /// Displacement where the curve is 1.
        displacement: Vec3,
        /// Its course in time.
        curve: Curve,
    },
    /// `amplitude sin(2 pi frequency t)`.
    Oscillation {
        /// Amplitude of the displacement.
        amplitude: Vec3,
        /// Frequency (Hz).
        frequency: f64,
    },
}

impl Motion {
    /// Displacement at time `t`.
    pub fn displacement(&self, t: f64) -> Vec3 {
        match self {
            Self::Curve { displacement, curve } => displacement * curve.at(t),
            Self::Oscillation { amplitude, frequency } => {
                amplitude * (std::f64::consts::TAU * frequency * t).sin()
            }
        }
    }

    /// The next moment after time `t` that a time step of about `dt` should not pass over.
    pub fn moment_after(&self, t: f64, dt: f64) -> Option<f64> {
        match self {
            Self::Curve { curve, .. } => curve.moment_after(t, dt),
            Self::Oscillation { frequency, .. } => {
                let quarter = 0.25 / frequency;
                (quarter < dt).then(|| ((t / quarter).floor() + 1.0) * quarter)
            }
        }
    }

    /// Whether it has a component along that axis.
    pub fn moves_along(&self, axis: usize) -> bool {
        match self {
            Self::Curve { displacement: by, .. } | Self::Oscillation { amplitude: by, .. } => by[axis] != 0.0,
        }
    }

    /// Velocity at time `t`.
    pub fn velocity(&self, t: f64) -> Vec3 {
        match self {
            Self::Curve { displacement, curve } => displacement * curve.rate(t),
            Self::Oscillation { amplitude, frequency } => {
                let omega = std::f64::consts::TAU * frequency;
                amplitude * (omega * (omega * t).cos())
            }
        }
    }
}

/// Which components of the displacement are held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fix {
    /// Those along the axes for which it is true.
    Components([bool; 3]),
    /// The one along the normal of the surface: a roller, or a plane of symmetry.
    Normal,
}

impl Fix {
    /// All components: a clamp.
    pub const ALL: Self = Self::Components([true; 3]);

    /// Those along the axes; none for the normal of a surface.
    pub fn components(self) -> [bool; 3] {
        match self {
            Self::Components(held) => held,
            Self::Normal => [false; 3],
        }
    }
}

/// Under which name, and about which point, the force and the moment of a boundary are read.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryName {
    /// Readings are called `<text>_force_x`, `<text>_moment_x` and so on.
    pub text: String,
    /// The point (m) that the moment is about; `None`: the centre of what is held, which goes with the boundary.
    pub moment_about: Option<Vec3>,
}

impl From<&str> for BoundaryName {
    fn from(text: &str) -> Self {
        Self { text: text.into(), moment_about: None }
    }
}

/// A part of the body that is held or moved.
#[derive(Clone, Debug)]
pub struct Boundary {
    /// How the force and the moment that it carries are read; `None`: they are not.
    pub name: Option<BoundaryName>,
    /// Where. A half-space holds the face of the body on its plane; where it holds all components, or the normal one, a
    /// body that reaches beyond is cut there. A region that holds particles fixes them, any other one holds the part of the
    /// surface in it.
    pub region: Region,
    /// Which components.
    pub fix: Fix,
    /// How it moves; `None`: not at all.
    pub motion: Option<Motion>,
}

/// Springs between a part of the surface and surroundings that do not move: the force per area on the body is
/// -(normal n n^T + tangential (1 - n n^T)) u, with the normal n of the undeformed surface.
#[derive(Clone, Debug)]
pub struct Foundation {
    /// Where on the surface.
    pub region: Region,
    /// Stiffness along the normal (Pa/m).
    pub normal: f64,
    /// Stiffness across the normal (Pa/m).
    pub tangential: f64,
}

/// Where a patch load is centred.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PatchCentre {
    /// A point on or near the surface.
    At(Vec3),
    /// The topmost (y) surface vertex beyond 60 % of the extent in x, as in
    /// `liver_load.md`: the upper right part of an organ in the paper's Figs. 6 and 7.
    UpperRight,
}

/// What pushes or pulls.
#[derive(Clone, Debug)]
pub enum LoadKind {
    /// A force per area on the surface inside the region (Pa).
    Traction {
        /// Where on the surface.
        region: Region,
        /// Force per area.
        traction: Vec3,
    },
    /// A pressure (Pa) against the outward normal of the surface inside the region.
    Pressure {
        /// Where on the surface.
        region: Region,
        /// Pressure, positive pushes inward.
        pressure: f64,
    },
    /// A pressure (Pa) on the surface inside the region that follows its deformation: against the normal that it has, on the
    /// area that it has; for laws of any strain.
    FollowerPressure {
        /// Where on the undeformed surface.
        region: Region,
        /// Pressure, positive pushes inward.
        pressure: f64,
    },
    /// f_ext of Eq. (2) per mass: an acceleration such as gravity (m/s^2), of the particles inside
    /// the region.
    BodyForce {
        /// Which part of the body.
        region: Region,
        /// Force per mass.
        acceleration: Vec3,
    },
    /// The smeared local load of Figs. 6 and 7: traction `pressure exp(-d^2/radius^2) direction`
    /// on the surface that faces against `direction`.
    Patch {
        /// Peak pressure (Pa).
        pressure: f64,
        /// Centre.
        centre: PatchCentre,
        /// Radius of the Gaussian; `None`: 0.15 of the extent in x.
        radius: Option<f64>,
        /// Direction of the push; normalised.
        direction: Vec3,
    },
}

impl LoadKind {
    /// Whether it is a load of zero.
    pub fn is_zero(&self) -> bool {
        match self {
            Self::Traction { traction, .. } => traction.norm() == 0.0,
            Self::BodyForce { acceleration, .. } => acceleration.norm() == 0.0,
            Self::Pressure { pressure, .. }
            | Self::FollowerPressure { pressure, .. }
            | Self::Patch { pressure, .. } => *pressure == 0.0,
        }
    }
}

/// A load with its course in time.
#[derive(Clone, Debug)]
pub struct Load {
    /// What.
    pub kind: LoadKind,
    /// The factor that it has in time.
    pub curve: Curve,
}

/// Which form of the equations of motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Formulation {
    /// Corrected gradient and its exact adjoint on the lattice (the default; stable).
    #[default]
    Adjoint,
    /// Eqs. (10) to (14) to the letter, on updated positions. Unstable; here for the record.
    Paper,
}

/// Settings of the spatial discretisation. The default is that of the paper's figures;
/// [`Solver::ACCURATE`] is better and cheaper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solver {
    /// Form of the equations.
    pub formulation: Formulation,
    /// Smoothing length h in spacings.
    pub smoothing: f64,
    /// Modulus of the hourglass term as a multiple of its default (0: off).
    pub hourglass: f64,
}

impl Default for Solver {
    fn default() -> Self {
        Self { formulation: Formulation::Adjoint, smoothing: 1.25, hourglass: 1.0 }
    }
}

/// Modulus of the hourglass term in units of Young's modulus, at any smoothing length (`rsph validate surfaces` studies it).
const HOURGLASS: f64 = 0.4;

impl Solver {
    /// 26 neighbours: what measured best for its price.
    pub const ACCURATE: Self = Self { formulation: Formulation::Adjoint, smoothing: 0.8, hourglass: 1.0 };

    /// Modulus of the hourglass term (Pa). It goes with Young's modulus, not with that of pressure waves, so that nearly
    /// incompressible bodies do not lock. The paper's formulation has no such term.
    pub fn hourglass_modulus(&self, young_modulus: f64) -> f64 {
        match self.formulation {
            Formulation::Adjoint => self.hourglass * HOURGLASS * young_modulus,
            Formulation::Paper => 0.0,
        }
    }
}

/// The time step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum TimeStep {
    /// 0.9 of the stability limit.
    #[default]
    Auto,
    /// This many seconds.
    Fixed(f64),
}

/// A scheme of integration in time, as a user asks for it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scheme {
    /// RK4, or SDIRK2 where the viscosity makes RK4 more than a hundred times dearer than the waves do.
    #[default]
    Auto,
    /// The classical Runge-Kutta scheme of fourth order, as in the paper.
    Rk4,
    /// Implicit, two stages, second order, L-stable.
    Sdirk2,
    /// Implicit, first order.
    BackwardEuler,
    /// Explicit with many cheap stages, second order.
    Rkc2,
}

impl Scheme {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Auto, Self::Rk4, Self::Sdirk2, Self::BackwardEuler, Self::Rkc2];

    /// Its name in scenario files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Rk4 => "rk4",
            Self::Sdirk2 => "sdirk2",
            Self::BackwardEuler => "backward-euler",
            Self::Rkc2 => "rkc2",
        }
    }

    /// Whether no step is too long for it to be stable.
    pub fn is_implicit(self) -> bool {
        matches!(self, Self::Sdirk2 | Self::BackwardEuler)
    }
}

/// How time advances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integration {
    /// The scheme.
    pub scheme: Scheme,
    /// Error of a step of a scheme that chooses its steps, and fifty times the residual of the linear systems of
    /// implicit ones, as shares of the displacement and of the load.
    pub tolerance: f64,
}

impl Default for Integration {
    fn default() -> Self {
        Self { scheme: Scheme::Auto, tolerance: 0.02 }
    }
}

/// A quantity that a probe reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Which column.
    pub field: Field,
    /// Which component; `None`: all of them.
    pub component: Option<usize>,
}

impl Quantity {
    /// Parses `displacement`, `displacement.z`, `stress.xy`, `principal_strain.1`, `von_mises`.
    pub fn parse(text: &str) -> Option<Self> {
        let (name, suffix) = match text.split_once('.') {
            Some((n, s)) => (n, Some(s)),
            None => (text, None),
        };
        let field = Field::from_name(name)?;
        let component = match suffix {
            None => None,
            Some(s) => Some(field.spec().suffixes.iter().position(|x| *x == s)?),
        };
        Some(Self { field, component })
    }
}

/// A named reading: the mean of a quantity over the surface in a region, or over the particles in
/// it if it holds any, or at a point.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Column name in `probes.csv`.
    pub name: String,
    /// What.
    pub quantity: Quantity,
    /// Where.
    pub region: Region,
}

/// A strain gauge: how far two points of the undeformed body are apart.
///
/// It reads `<name>_strain`, the change of their distance over the undeformed one, and `<name>_length` (m).
#[derive(Clone, Debug, PartialEq)]
pub struct Gauge {
    /// What its readings are called by.
    pub name: String,
    /// One end (m).
    pub from: Vec3,
    /// The other end (m).
    pub to: Vec3,
}

/// Everything a simulation is made from: what every kind of body has, and what only a body with the mechanics `M` has.
///
/// ```
/// use rsph_core::material::KelvinVoigt;
/// use rsph_core::sample::Resolution;
/// use rsph_core::setup::{Boundary, Setup, SolidSetup, Units};
/// use rsph_core::simulation::Simulation;
/// # use rsph_core::region::{Axis, Region, Side};
/// # use rsph_core::setup::Fix;
/// # use rsph_core::shape::BoxShape;
/// # use rsph_core::tensor::Vec3;
/// use std::sync::Arc;
///
/// let cube = Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros())?);
/// let material = Arc::new(KelvinVoigt::new(1.0, 100.0, 0.3, 0.2)?);
/// let mut setup = Setup::new(cube, Resolution::Particles(216), SolidSetup::new(material));
/// setup.units = Units::Normalised;
/// # let region = Region::Plane { axis: Axis::Z, at: 0.0, side: Side::Below };
/// setup.mechanics.boundaries.push(Boundary { name: None, region, fix: Fix::ALL, motion: None });
/// Simulation::new(setup)?.step()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Setup<M = Mechanics> {
    /// Labels only.
    pub units: Units,
    /// The body.
    pub shape: Arc<dyn Shape>,
    /// How fine.
    pub resolution: Resolution,
    /// Initial values.
    pub initial: Initial,
    /// What moves the particles.
    pub mechanics: M,
    /// Whether, when and how particles are remeshed.
    pub remesh: Remesh,
    /// Discretisation.
    pub solver: Solver,
    /// Time step.
    pub time_step: TimeStep,
    /// The scheme of integration.
    pub integration: Integration,
    /// Whether a time step above the stability limit is allowed.
    pub allow_unstable: bool,
    /// What is recorded.
    pub probes: Vec<Probe>,
    /// Strain gauges on a solid or in it.
    pub gauges: Vec<Gauge>,
    /// Fields that snapshots have beside those of every kind of body: [measures](crate::measures::MEASURES) of a solid.
    pub fields: Vec<Field>,
    /// Which pieces of the body are simulated.
    pub pieces: Pieces,
}

/// Which pieces of a shape are simulated that hang together by nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pieces {
    /// All of them.
    #[default]
    All,
    /// Those that a boundary holds, if it holds any: the others have no equilibrium.
    Held,
}

impl<M> Setup<M> {
    /// A body at rest, with the default of everything else.
    pub fn new(shape: Arc<dyn Shape>, resolution: Resolution, mechanics: M) -> Self {
        Self {
            units: Units::default(),
            shape,
            resolution,
            initial: Initial::default(),
            mechanics,
            remesh: Remesh::default(),
            solver: Solver::default(),
            time_step: TimeStep::default(),
            integration: Integration::default(),
            allow_unstable: false,
            probes: Vec::new(),
            gauges: Vec::new(),
            fields: Vec::new(),
            pieces: Pieces::default(),
        }
    }

    /// The same with other mechanics.
    pub fn with_mechanics<N>(self, mechanics: N) -> Setup<N> {
        let Self { units, shape, resolution, initial, remesh, solver, .. } = self;
        let Self { time_step, integration, allow_unstable, probes, gauges, fields, pieces, .. } = self;
        Setup {
            units,
            shape,
            resolution,
            initial,
            mechanics,
            remesh,
            solver,
            time_step,
            integration,
            allow_unstable,
            probes,
            gauges,
            fields,
            pieces,
        }
    }
}

impl Setup {
    /// What a solid has; `None` for any other kind of body.
    pub fn solid(&self) -> Option<&SolidSetup> {
        if let Mechanics::Solid(solid) = &self.mechanics { Some(solid) } else { None }
    }

    /// The same, to change it.
    pub fn solid_mut(&mut self) -> Option<&mut SolidSetup> {
        if let Mechanics::Solid(solid) = &mut self.mechanics { Some(solid) } else { None }
    }
}

impl From<Setup<SolidSetup>> for Setup {
    fn from(setup: Setup<SolidSetup>) -> Self {
        let solid = setup.mechanics.clone();
        setup.with_mechanics(Mechanics::Solid(solid))
    }
}
