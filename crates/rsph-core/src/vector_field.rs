//! Vector fields over the undeformed body: initial values and given velocities.

mod free_beam;

pub use free_beam::FreeBeamMode;

use crate::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// From positions to as many vectors.
pub type PointwiseFunction = dyn Fn(&[Vec3]) -> Vec<Vec3> + Send + Sync;

/// A vector field over the undeformed body, for initial values.
#[derive(Clone)]
pub enum VectorField {
    /// The same vector everywhere.
    Constant(Vec3),
    /// `constant + gradient x`.
    Affine {
        /// Value at the origin.
        constant: Vec3,
        /// Gradient matrix, row i the gradient of component i.
        gradient: Mat3,
    },
    /// `rate x (x - centre)`: a rotation with that rate vector (an angle vector for displacements).
    Rotation {
        /// Rotation vector.
        rate: Vec3,
        /// A point of the axis.
        centre: Vec3,
    },
    /// `constant + amplitude cos(2 pi wave_number . x + phase)`.
    Wave {
        /// Mean value.
        constant: Vec3,
        /// Largest deviation from it.
        amplitude: Vec3,
        /// Waves per length along each axis.
        wave_number: Vec3,
        /// Phase (rad).
        phase: f64,
    },
    /// A bending mode of a beam with free ends.
    FreeBeam(FreeBeamMode),
    /// Any function of the reference positions, all of them at once: one vector for each.
    Function(Arc<PointwiseFunction>),
}

impl std::fmt::Debug for VectorField {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Constant(c) => write!(f, "Constant({c:?})"),
            Self::Affine { constant, gradient } => write!(f, "Affine({constant:?}, {gradient:?})"),
            Self::Rotation { rate, centre } => write!(f, "Rotation({rate:?}, {centre:?})"),
            Self::Wave { constant, amplitude, wave_number, phase } => {
                write!(f, "Wave({constant:?}, {amplitude:?}, {wave_number:?}, {phase})")
            }
            Self::FreeBeam(mode) => write!(f, "FreeBeam({mode:?})"),
            Self::Function(_) => write!(f, "Function"),
        }
    }
}

impl Default for VectorField {
    fn default() -> Self {
        Self::Constant(Vec3::zeros())
    }
}

impl VectorField {
    /// Whether it is the zero vector everywhere, as it is by default.
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Constant(c) if *c == Vec3::zeros())
    }

    /// The vector at the reference position `x`.
    pub fn at(&self, x: &Vec3) -> Vec3 {
        match self {
            Self::Constant(c) => *c,
            Self::Affine { constant, gradient } => constant + gradient * x,
            Self::Rotation { rate, centre } => rate.cross(&(x - centre)),
            Self::Wave { constant, amplitude, wave_number, phase } => {
                constant + amplitude * (std::f64::consts::TAU * wave_number.dot(x) + phase).cos()
            }
            Self::FreeBeam(mode) => mode.at(x),
            Self::Function(f) => f(&[*x]).first().copied().unwrap_or_else(Vec3::zeros),
        }
    }

    /// The vectors at the reference positions `points`.
    pub fn at_all(&self, points: &[Vec3]) -> Vec<Vec3> {
        match self {
            Self::Function(f) => f(points),
            _ => points.iter().map(|x| self.at(x)).collect(),
        }
    }
}
