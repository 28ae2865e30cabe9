//! What a body in the plane can not do: it is in plane strain, and nothing moves or pushes across its plane.

use crate::error::InvalidInput;
use crate::region::{Axis, Region};
use crate::setup::{Formulation, LoadKind, Setup, SolidSetup};

/// Refuses what leaves the plane.
///
/// # Errors
/// The key of what does.
pub(super) fn check(setup: &Setup<SolidSetup>) -> Result<(), InvalidInput> {
    if setup.solver.formulation == Formulation::Paper {
        return Err(InvalidInput::new(
            "solver.formulation",
            "paper",
            "the scheme of the paper has bodies in space only",
            "take \"adjoint\", or a body in space such as a box",
        ));
    }
    for (i, boundary) in setup.mechanics.boundaries.iter().enumerate() {
        if matches!(boundary.region, Region::Plane { axis: Axis::Z, .. }) {
            return Err(InvalidInput::new(
                format!("boundary[{i}].region"),
                "plane across z",
                "a plane body has no extent in z",
                "hold it at a plane across x or y",
            ));
        }
        if boundary.motion.is_some_and(|motion| motion.moves_along(2)) {
            return Err(across(format!("boundary[{i}].motion")));
        }
    }
    for (i, load) in setup.mechanics.loads.iter().enumerate() {
        let (key, vector) = match &load.kind {
            LoadKind::Traction { traction, .. } => ("traction", traction),
            LoadKind::BodyForce { acceleration, .. } => ("acceleration", acceleration),
            LoadKind::Patch { direction, .. } => ("direction", direction),
            LoadKind::Pressure { .. } => continue,
        };
        if vector.z != 0.0 {
            return Err(across(format!("load[{i}].{key}")));
        }
    }
    Ok(())
}

/// The error for a vector that leaves the plane.
fn across(key: String) -> InvalidInput {
    InvalidInput::new(key, "", "has a z component, which leaves the plane of a plane body", "let it be 0")
}
