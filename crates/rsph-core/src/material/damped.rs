//! A law at any strain as a material: with its density, and Kelvin-Voigt damping.

use super::{FiniteStrain, Hyperelastic, KelvinVoigt, Law, Material, damping};
use crate::tensor::lanes::{Tensor, Tensors};
use crate::tensor::{Mat3, Vec3};

/// A material whose stress is that of `law`, with the damping of a Kelvin-Voigt solid of the same stiffness at small strain.
#[derive(Clone, Debug, PartialEq)]
pub struct Damped<L> {
    /// Its name in scenario files.
    pub(super) name: &'static str,
    /// Density, relaxation time, and the moduli at small strain that the damping goes by.
    pub(super) small: KelvinVoigt,
    /// The energy.
    pub(super) law: L,
}

impl<L: Hyperelastic> Material for Damped<L> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn density(&self) -> f64 {
        self.small.density()
    }

    fn relaxation_time(&self) -> f64 {
        self.small.relaxation_time()
    }

    fn law(&self) -> Law<'_> {
        Law::FiniteStrain(self)
    }

    fn fibre(&self) -> Option<Vec3> {
        self.law.fibre()
    }
}

impl<L: Hyperelastic> FiniteStrain for Damped<L> {
    fn energy(&self, f: &Mat3) -> f64 {
        self.law.energy(f)
    }

    fn first_piola(&self, f: &Mat3) -> Mat3 {
        self.law.first_piola(f)
    }

    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3 {
        self.law.tangent(f, df)
    }

    fn viscous_piola(&self, f: &Mat3, f_rate: &Mat3) -> Mat3 {
        damping::spatial(&self.small, &Tensor::from(f), &Tensor::from(f_rate)).into()
    }

    fn stresses(&self, count: usize, f: &Tensors, f_rate: Option<&Tensors>, piola: &mut Tensors) {
        self.law.stresses(count, f, piola);
        if let Some(f_rate) = f_rate {
            damping::add(&self.small, f, f_rate, 1.0, piola);
        }
    }

    fn tangents(&self, count: usize, f: &Tensors, df: &Tensors, shares: [f64; 2], change: &mut Tensors) {
        self.law.tangents(count, f, df, shares[0], change);
        if shares[1] > 0.0 {
            damping::add(&self.small, f, df, shares[1], change);
        }
    }
}
