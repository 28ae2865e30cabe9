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
    /// Where they meet; `None`: there is one.
    pub interface: Option<Interface>,
}

impl Composition {
    /// One material with moduli times `factor`.
    pub fn pure(material: u16, factor: f64) -> Self {
        Self { materials: [material; 2], factors: [factor; 2], interface: None }
    }

    /// Volume fractions of the two materials.
    pub fn shares(&self) -> [f64; 2] {
        self.interface.map_or([1.0, 0.0], |i| [i.share, 1.0 - i.share])
    }
}

/// The materials of a body of several, as cells mix them.
#[derive(Clone, Debug)]
pub(crate) struct Palette {
    materials: Vec<Arc<dyn Material>>,
    laws: Vec<AnyLaw>,
    stiffness: Vec<Stiffness>,
}

impl Palette {
    pub(crate) fn new(materials: Vec<Arc<dyn Material>>) -> Self {
        Self {
            laws: materials.iter().map(AnyLaw::new).collect(),
            stiffness: materials.iter().map(|m| m.stiffness()).collect(),
            materials,
        }
    }

    pub(crate) fn materials(&self) -> &[Arc<dyn Material>] {
        &self.materials
    }

    pub(crate) fn law(&self, material: u16) -> &dyn FiniteStrain {
        self.laws[usize::from(material)].law()
    }

    /// Stiffness of a material in the undeformed state.
    pub(crate) fn stiffness_of(&self, material: u16) -> &Stiffness {
        &self.stiffness[usize::from(material)]
    }

    /// Stiffness of a cell in the undeformed state.
    pub(crate) fn stiffness(&self, cell: &Composition) -> Stiffness {
        let [first, second] = [0, 1].map(|k| *self.stiffness_of(cell.materials[k]) * cell.factors[k]);
        cell.interface.map_or(first, |interface| interface.stiffness([&first, &second]))
    }

    /// The smaller of the Young's moduli of a cell's materials (Pa).
    pub(crate) fn softest(&self, cell: &Composition) -> f64 {
        let of = |k: usize| self.stiffness_of(cell.materials[k]).young_modulus() * cell.factors[k];
        of(0).min(of(1))
    }

    /// Density of a cell (kg/m^3).
    pub(crate) fn density(&self, cell: &Composition) -> f64 {
        let of = |k: usize| self.materials[usize::from(cell.materials[k])].density();
        cell.shares().iter().enumerate().map(|(k, share)| share * of(k)).sum()
    }

    fn scaled(&self, cell: &Composition, k: usize) -> Scaled<'_> {
        Scaled { law: self.law(cell.materials[k]), factor: cell.factors[k] }
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

    /// dP/dF of the two materials of a cell at F, column by column of its nine components row by row.
    pub(crate) fn tangents(&self, cell: &Composition, f: &Mat3) -> [Mat3; 9] {
        self.with_law(cell, |law| {
            std::array::from_fn(|c| {
                let mut df = Mat3::zeros();
                df[(c / 3, c % 3)] = 1.0;
                law.tangent(f, &df)
            })
        })
    }

    /// Strain and stress as results show them: of the material with the larger share of a cell, by its own measures.
    pub(crate) fn measures(&self, cell: &Composition, gradient: &Mat3, rate: &Mat3) -> [SymTensor; 2] {
        let material = &self.materials[usize::from(cell.materials[0])];
        let (strain, stress) = match material.law() {
            Law::Linear(_) => {
                let of = [0, 1].map(|k| *self.stiffness_of(cell.materials[k]) * cell.factors[k]);
                let layer = |i: Interface| i.first_linear_layer([&of[0], &of[1]], gradient);
                let gradient = cell.interface.map_or(*gradient, layer);
                Law::Linear(of[0]).measures(material.relaxation_time(), &gradient, rate)
            }
            Law::FiniteStrain(_) => {
                let f = Mat3::identity() + gradient;
                let layer = self.laminate(cell).map_or(f, |laminate| laminate.gradients(&f)[0]);
                Law::FiniteStrain(&self.scaled(cell, 0)).measures(0.0, &(layer - Mat3::identity()), rate)
            }
        };
        [strain, stress]
    }
}
