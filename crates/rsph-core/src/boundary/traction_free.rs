//! The stress-free boundary condition of section 2.3 as the paper does it: a body force on the
//! boundary particles that cancels the surface traction, Eq. (14). (The adjoint formulation needs
//! none.)

use crate::tensor::{SymTensor, Vec3};

/// Penalty force on a boundary particle: minus its surface traction t = sigma n, Eq. (14), times its
/// share of the surface.
pub fn penalty_force(stress: SymTensor, normal: &Vec3, area: f64) -> Vec3 {
    -area * stress.dot(normal)
}
