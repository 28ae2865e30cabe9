//! Laws for any deformation: energy and stress as functions of the deformation gradient.

use crate::tensor::Mat3;
use std::fmt::Debug;

/// A solid whose energy is a function of the deformation gradient F = dx/dX, with damping. Plane strain is
/// F with F_zz = 1 and no other z component.
pub trait FiniteStrain: Debug + Send + Sync {
    /// Energy W(F) per undeformed volume (J/m^3); infinite where det F <= 0.
    fn energy(&self, f: &Mat3) -> f64;

    /// First Piola-Kirchhoff stress P = dW/dF (Pa): force per undeformed area. Meaningless where
    /// det F <= 0.
    fn first_piola(&self, f: &Mat3) -> Mat3;

    /// Change of the first Piola-Kirchhoff stress when F changes by `df`: (d2W/dF2) dF.
    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3;

    /// Viscous part of the first Piola-Kirchhoff stress at the rate dF/dt; its power P : dF/dt is not
    /// negative.
    fn viscous_piola(&self, f: &Mat3, f_rate: &Mat3) -> Mat3;
}
