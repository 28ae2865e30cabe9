//! Kelvin-Voigt damping for any deformation, and F^-T.

use super::{KelvinVoigt, Material};
use crate::tensor::{Mat3, SymTensor};

/// First Piola-Kirchhoff stress of the damping that acts on the rate of strain in space, d = sym(grad v): its Kirchhoff stress
/// is J sigma_v = T (2 mu d + lambda tr d I), the viscous part of Eq. (5) per undeformed volume.
///
/// It does not feel rotations, and its power T (2 mu d:d + lambda (tr d)^2) is never negative for nu >= 0.
pub(super) fn spatial(solid: &KelvinVoigt, f: &Mat3, f_rate: &Mat3) -> Mat3 {
    let (inverse_transpose, _) = inverse_transpose(f);
    // grad v = (dF/dt) F^-1; P = J sigma_v F^-T.
    let d = SymTensor::symmetric_part(&(f_rate * inverse_transpose.transpose())).to_matrix();
    let (mu, lambda) = solid.lame();
    (d * (2.0 * mu) + Mat3::identity() * (lambda * d.trace())) * inverse_transpose * solid.relaxation_time()
}

/// F^-T by cofactors, and det F.
pub(super) fn inverse_transpose(f: &Mat3) -> (Mat3, f64) {
    let (a, b, c) = (f.column(0), f.column(1), f.column(2));
    let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
    let j = a.dot(&bc);
    (Mat3::from_columns(&[bc, ca, ab]) / j, j)
}
