//! Which materials a cell of a body of several holds.

use super::laminate::{Interface, Laminate};
use super::scaled::{AnyLaw, Scaled};
use super::{FiniteStrain, Law, Material, Stiffness};
use crate::tensor::{Mat3, SymTensor};
use std::sync::Arc;

/// What a cell holds: one material, or two with a plane between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Composition {
    /// Numbers of the materials, that with the larger share first; twice the same if there is one.
    pub materials: [u16; 2],
    /// By how much their moduli are multiplied.
    pub factors: [f64; 2],
    /// Rotations by which they are turned in the undeformed body, those of fibres; `None`: they are not.
    pub turns: Option<[Mat3; 2]>,
    /// Where they meet; `None`: there is one.
    pub interface: Option<Interface>,
}

impl Composition {
    /// One material with moduli times `factor`.
    pub fn pure(material: u16, factor: f64) -> Self {
        Self { materials: [material; 2], factors: [factor; 2], turns: None, interface: None }
    }

    /// Whether it is one material that is not turned.
    pub(crate) fn is_plain(&self) -> bool {
        self.interface.is_none() && self.turns.is_none()
    }

    /// Volume fractions of the two materials.
    pub fn shares(&self) -> [f64; 2] {
        self.interface.map_or([1.0, 0.0], |i| [i.share, 1.0 - i.share])
    }
}

/// All materials of a body, and what cells make of them.
#[derive(Clone, Debug)]
pub(crate) struct MaterialSet(Vec<AnyLaw>);

impl MaterialSet {
    pub(crate) fn new(materials: impl Iterator<Item = Arc<dyn Material>>) -> Self {
        Self(materials.map(AnyLaw::new).collect())
    }

    pub(crate) fn materials(&self) -> impl Iterator<Item = &Arc<dyn Material>> {
        self.0.iter().map(|of| &of.material)
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    pub(crate) fn material(&self, material: u16) -> &dyn Material {
        &*self.0[usize::from(material)].material
    }

    pub(crate) fn law(&self, material: u16) -> &dyn FiniteStrain {
        self.0[usize::from(material)].law()
    }

    /// Stiffness of a material in the undeformed state.
    pub(crate) fn stiffness_of(&self, material: u16) -> &Stiffness {
        self.0[usize::from(material)].stiffness()
    }

    /// Stiffness of a cell in the undeformed state.
    pub(crate) fn stiffness(&self, cell: &Composition) -> Stiffness {
        let of = |k: usize| {
            let stiffness = *self.stiffness_of(cell.materials[k]) * cell.factors[k];
            cell.turns.map_or(stiffness, |turns| stiffness.turned(&turns[k]))
        };
        cell.interface.map_or_else(|| of(0), |interface| interface.stiffness([&of(0), &of(1)]))
    }

    /// C : e of a cell, with its stiffness C in the undeformed state.
    pub(crate) fn hooke(&self, cell: &Composition, strain: SymTensor) -> SymTensor {
        if cell.is_plain() {
            return self.stiffness_of(cell.materials[0]).stress(strain) * cell.factors[0];
        }
        self.stiffness(cell).stress(strain)
    }

    /// The smaller of the Young's moduli of a cell's materials (Pa).
    pub(crate) fn softest(&self, cell: &Composition) -> f64 {
        let of = |k: usize| self.stiffness_of(cell.materials[k]).young_modulus() * cell.factors[k];
        of(0).min(of(1))
    }

    /// Density of a cell (kg/m^3).
    pub(crate) fn density(&self, cell: &Composition) -> f64 {
        let of = |k: usize| self.material(cell.materials[k]).density();
        cell.shares().iter().enumerate().map(|(k, share)| share * of(k)).sum()
    }

    fn scaled(&self, cell: &Composition, k: usize) -> Scaled<'_> {
        let turn = cell.turns.map(|turns| turns[k]);
        Scaled { law: self.law(cell.materials[k]), factor: cell.factors[k], turn }
    }

    /// The laminate of a cell, if it is one.
    fn laminate(&self, cell: &Composition) -> Option<Laminate<'_>> {
        let shear = |k: usize| cell.factors[k] * self.stiffness_of(cell.materials[k]).shear_modulus();
        let layers = [self.scaled(cell, 0), self.scaled(cell, 1)];
        cell.interface.map(|interface| Laminate { interface, layers, shear_modulus: shear(0).min(shear(1)) })
    }

    /// Hands the law of a cell to `visit`.
    pub(crate) fn with_law<R>(&self, cell: &Composition, visit: impl FnOnce(&dyn FiniteStrain) -> R) -> R {
        match self.laminate(cell) {
            Some(laminate) => visit(&laminate),
            None => visit(&self.scaled(cell, 0)),
        }
    }

    /// dP/dF of a cell at F, column by column of its nine components row by row.
    pub(crate) fn tangents(&self, cell: &Composition, f: &Mat3) -> [Mat3; 9] {
        let columns = |change: &dyn Fn(&Mat3) -> Mat3| {
            std::array::from_fn(|c| {
                let mut df = Mat3::zeros();
                df[(c / 3, c % 3)] = 1.0;
                change(&df)
            })
        };
        match self.laminate(cell) {
            Some(laminate) => columns(&laminate.tangent_at(f)),
            None => columns(&|df| self.scaled(cell, 0).tangent(f, df)),
        }
    }

    /// The displacement gradient in the material with the larger share of a cell.
    pub(crate) fn larger_layer(&self, cell: &Composition, gradient: &Mat3) -> Mat3 {
        let Some(interface) = &cell.interface else { return *gradient };
        if matches!(self.material(cell.materials[0]).law(), Law::Linear(_)) {
            let of = [0, 1].map(|k| *self.stiffness_of(cell.materials[k]) * cell.factors[k]);
            return interface.first_linear_layer([&of[0], &of[1]], gradient);
        }
        let f = Mat3::identity() + gradient;
        self.laminate(cell).map_or(*gradient, |laminate| laminate.gradients(&f)[0] - Mat3::identity())
    }

    /// Strain and stress as results show them: of the material with the larger share of a cell, by its own measures.
    pub(crate) fn measures(&self, cell: &Composition, gradient: &Mat3, rate: &Mat3) -> [SymTensor; 2] {
        let (material, layer) = (self.material(cell.materials[0]), self.larger_layer(cell, gradient));
        let (strain, stress) = match material.law() {
            Law::Linear(stiffness) => {
                Law::Linear(stiffness * cell.factors[0]).measures(material.relaxation_time(), &layer, rate)
            }
            Law::FiniteStrain(_) => Law::FiniteStrain(&self.scaled(cell, 0)).measures(0.0, &layer, rate),
        };
        [strain, stress]
    }
}
