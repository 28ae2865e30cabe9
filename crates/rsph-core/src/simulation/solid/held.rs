//! How a solid is held, by its formulation.

use crate::boundary::constraints::{Constraints, Hold, cuts};
use crate::boundary::fixed::Fixed;
use crate::boundary::tag::Holds;
use crate::error::InvalidInput;
use crate::setup::{Formulation, Setup, SolidSetup};
use crate::shape::cut;
use crate::tensor::Vec3;

/// What a body is held by.
#[derive(Clone, Debug)]
pub(super) enum Held {
    /// By its surface, and particles inside.
    Surface(Constraints),
    /// By layers of particles: the scheme of the paper.
    Layers(Holds),
}

impl Held {
    /// The held particles among those that were at `positions` in the undeformed body.
    ///
    /// # Errors
    /// A boundary that holds none of them.
    pub fn fixed(&self, positions: &[Vec3]) -> Result<Fixed, InvalidInput> {
        match self {
            Self::Surface(constraints) => constraints.fixed(positions),
            Self::Layers(holds) => holds.fixed(positions),
        }
    }

    /// The boundaries that hold the surface at a place with that normal, a bit each.
    pub fn held_at(&self, x: &Vec3, normal: &Vec3) -> Option<u32> {
        match self {
            Self::Surface(constraints) => constraints.held_at(x, normal),
            Self::Layers(_) => None,
        }
    }

    /// How each boundary holds the surface.
    pub fn holds(&self) -> &[Hold] {
        match self {
            Self::Surface(constraints) => &constraints.holds,
            Self::Layers(_) => &[],
        }
    }
}

/// `setup` with a shape that is cut where boundaries hold everything beyond a plane.
///
/// # Errors
/// `body.shape` when a plane leaves nothing of it.
pub(super) fn with_cut_shape(setup: &Setup<SolidSetup>) -> Result<Setup<SolidSetup>, InvalidInput> {
    let mut setup = setup.clone();
    if setup.solver.formulation == Formulation::Adjoint {
        let tolerance = 1e-9 * setup.shape.bounds().size().norm();
        for (i, boundary) in setup.mechanics.boundaries.iter().enumerate() {
            if let Some(plane) = cuts(boundary) {
                let key = |e: InvalidInput| InvalidInput { key: format!("boundary[{i}].region"), ..e };
                setup.shape = cut(&setup.shape, &plane.point, &plane.normal, tolerance).map_err(key)?;
            }
        }
    }
    Ok(setup)
}
