//! What a body in the plane can not do: it is in plane strain, and nothing moves or pushes across its plane.

use crate::error::InvalidInput;
use crate::material::Material;
use crate::region::{Axis, Region};
use crate::setup::{Formulation, LoadKind, Setup, SolidSetup};
use std::sync::Arc;

/// Share of the stiffness that rounding makes of a zero.
const SYMMETRIC: f64 = 1e-9;

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
    let leaves = |material: &&Arc<dyn Material>| {
        let c = material.stiffness().0;
        // Shear across the plane, yz and xz, from what happens in it.
        let mut across_plane = (0..4).flat_map(|i| [c[i][4], c[i][5], c[4][i], c[5][i]]);
        across_plane.any(|c_ij| c_ij.abs() > SYMMETRIC * c[0][0])
    };
    if let Some(material) = setup.mechanics.materials().find(leaves) {
        return Err(InvalidInput::new(
            "material",
            material.name(),
            "is not symmetric about the plane of a plane body, which would leave it",
            "let fibres lie in the plane or along z",
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
        if boundary.motion.as_ref().is_some_and(|motion| motion.moves_along(2)) {
            return Err(across(format!("boundary[{i}].motion")));
        }
    }
    for (i, load) in setup.mechanics.loads.iter().enumerate() {
        let (key, vector) = match &load.kind {
            LoadKind::Traction { traction, .. } => ("traction", traction),
            LoadKind::BodyForce { acceleration, .. } => ("acceleration", acceleration),
            LoadKind::Patch { direction, .. } => ("direction", direction),
            LoadKind::Pressure { .. } | LoadKind::FollowerPressure { .. } => continue,
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
