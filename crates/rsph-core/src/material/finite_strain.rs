//! Laws for any deformation: energy and stress as functions of the deformation gradient.

use crate::tensor::Mat3;
use crate::tensor::lanes::Tensors;
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

    /// P(F, dF/dt), damping included if there is a rate, of the first `count` particles.
    fn stresses(&self, count: usize, f: &Tensors, f_rate: Option<&Tensors>, piola: &mut Tensors) {
        for lane in 0..count {
            let f = f.get(lane);
            let viscous = f_rate.map(|rate| self.viscous_piola(&f, &rate.get(lane)));
            piola.set(lane, &(self.first_piola(&f) + viscous.unwrap_or_default()));
        }
    }

    /// Change of P when F changes by `df` times the first of `shares` and dF/dt by `df` times the second, of the first `count`
    /// particles.
    fn tangents(&self, count: usize, f: &Tensors, df: &Tensors, shares: [f64; 2], change: &mut Tensors) {
        for lane in 0..count {
            let (f, df) = (f.get(lane), df.get(lane));
            let mut dp = self.tangent(&f, &df) * shares[0];
            if shares[1] > 0.0 {
                dp += self.viscous_piola(&f, &df) * shares[1];
            }
            change.set(lane, &dp);
        }
    }
}
