//! Laws as a body of several materials uses them: scaled to another modulus, and linear ones beside others.

use super::{FiniteStrain, Material, Stiffness};
use crate::tensor::{Mat3, SymTensor};
use std::sync::Arc;

/// A linear law as a function of the deformation gradient: P = C : sym(F - 1 + T dF/dt), which does not turn with the body.
#[derive(Clone, Copy, Debug)]
struct SmallStrain {
    stiffness: Stiffness,
    relaxation_time: f64,
}

impl FiniteStrain for SmallStrain {
    fn energy(&self, f: &Mat3) -> f64 {
        self.stiffness.energy_density(SymTensor::symmetric_part(&(f - Mat3::identity())))
    }

    fn first_piola(&self, f: &Mat3) -> Mat3 {
        self.tangent(f, &(f - Mat3::identity()))
    }

    fn tangent(&self, _: &Mat3, df: &Mat3) -> Mat3 {
        self.stiffness.stress(SymTensor::symmetric_part(df)).to_matrix()
    }

    fn viscous_piola(&self, f: &Mat3, f_rate: &Mat3) -> Mat3 {
        self.tangent(f, f_rate) * self.relaxation_time
    }
}

/// A material with its law as a function of the deformation gradient, whatever that is.
#[derive(Clone, Debug)]
pub(crate) struct AnyLaw {
    pub(crate) material: Arc<dyn Material>,
    small: SmallStrain,
}

impl AnyLaw {
    pub(crate) fn new(material: Arc<dyn Material>) -> Self {
        let small =
            SmallStrain { stiffness: material.stiffness(), relaxation_time: material.relaxation_time() };
        Self { material, small }
    }

    pub(crate) fn law(&self) -> &dyn FiniteStrain {
        self.material.law().finite_strain().unwrap_or(&self.small)
    }

    /// Stiffness in the undeformed state.
    pub(crate) fn stiffness(&self) -> &Stiffness {
        &self.small.stiffness
    }
}

/// A law whose moduli are multiplied by a factor, its viscosity with them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scaled<'a> {
    pub(crate) law: &'a dyn FiniteStrain,
    pub(crate) factor: f64,
}

impl FiniteStrain for Scaled<'_> {
    fn energy(&self, f: &Mat3) -> f64 {
        self.law.energy(f) * self.factor
    }

    fn first_piola(&self, f: &Mat3) -> Mat3 {
        self.law.first_piola(f) * self.factor
    }

    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3 {
        self.law.tangent(f, df) * self.factor
    }

    fn viscous_piola(&self, f: &Mat3, f_rate: &Mat3) -> Mat3 {
        self.law.viscous_piola(f, f_rate) * self.factor
    }
}
