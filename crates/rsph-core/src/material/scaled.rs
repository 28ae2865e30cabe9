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

/// A law whose moduli are multiplied by a factor, its viscosity with them, of a material that is turned by a rotation R in the
/// undeformed body: W(F R), P(F R) R^T.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scaled<'a> {
    pub(crate) law: &'a dyn FiniteStrain,
    pub(crate) factor: f64,
    /// R; `None`: the unit tensor.
    pub(crate) turn: Option<Mat3>,
}

impl Scaled<'_> {
    /// F R.
    fn in_material(&self, f: &Mat3) -> Mat3 {
        self.turn.map_or(*f, |turn| f * turn)
    }

    /// P R^T, times the factor.
    fn in_body(&self, piola: Mat3) -> Mat3 {
        self.turn.map_or(piola, |turn| piola * turn.transpose()) * self.factor
    }
}

impl FiniteStrain for Scaled<'_> {
    fn energy(&self, f: &Mat3) -> f64 {
        self.law.energy(&self.in_material(f)) * self.factor
    }

    fn first_piola(&self, f: &Mat3) -> Mat3 {
        self.in_body(self.law.first_piola(&self.in_material(f)))
    }

    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3 {
        self.in_body(self.law.tangent(&self.in_material(f), &self.in_material(df)))
    }

    fn viscous_piola(&self, f: &Mat3, f_rate: &Mat3) -> Mat3 {
        self.in_body(self.law.viscous_piola(&self.in_material(f), &self.in_material(f_rate)))
    }
}
