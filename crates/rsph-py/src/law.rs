//! The stress of a material as a function of the deformation gradient.

use crate::errors::input_error;
use crate::scenario;
use numpy::ndarray::{Array3, ArrayView2};
use numpy::{PyArray3, PyReadonlyArray3, ToPyArray};
use pyo3::prelude::*;
use rsph_core::material::{Law as Stress, Material};
use rsph_core::tensor::{Mat3, SymTensor};
use std::sync::Arc;

/// The law of a material.
#[pyclass(frozen, module = "rsph._rsph")]
pub struct Law {
    material: Arc<dyn Material>,
}

#[pymethods]
impl Law {
    /// The law of the material of the scenario `text`.
    #[new]
    fn new(text: String) -> PyResult<Self> {
        Ok(Self { material: scenario::material(text)? })
    }

    /// First Piola-Kirchhoff stress at rest (Pa) of deformation gradients, both (N, 3, 3).
    fn first_piola<'py>(
        &self,
        py: Python<'py>,
        f: PyReadonlyArray3<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let f = f.as_array();
        if f.shape()[1..] != [3, 3] {
            let value = format!("an array of shape {:?}", f.shape());
            let message = format!("`f` is {value}, but every deformation gradient has three rows of three");
            return Err(input_error(&message, "f", Some(&value), "give an array of shape (N, 3, 3)"));
        }
        let mut piola = Array3::zeros(f.raw_dim());
        for (f, mut piola) in f.outer_iter().zip(piola.outer_iter_mut()) {
            let stress = self.stress(&f);
            piola.indexed_iter_mut().for_each(|(ij, p)| *p = stress[ij]);
        }
        Ok(piola.to_pyarray(py))
    }
}

impl Law {
    fn stress(&self, f: &ArrayView2<'_, f64>) -> Mat3 {
        let f = Mat3::from_fn(|i, j| f[(i, j)]);
        match self.material.law() {
            Stress::Linear(stiffness) => {
                stiffness.stress(SymTensor::symmetric_part(&(f - Mat3::identity()))).to_matrix()
            }
            Stress::FiniteStrain(law) => law.first_piola(&f),
        }
    }
}
