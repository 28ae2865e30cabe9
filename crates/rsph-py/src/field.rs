//! Initial values and moduli computed by a Python function.

use crate::arrays::{positions, shape_error, vectors};
use crate::errors::input_error;
use numpy::{PyArrayLike2, PyUntypedArrayMethods, TypeMustMatch};
use pyo3::prelude::*;
use rsph_core::setup::{ModulusField, VectorField};
use rsph_core::tensor::Vec3;
use std::sync::{Arc, Mutex};

/// What went wrong inside a Python function while the core was calling it.
#[derive(Clone, Default)]
pub struct Trouble(Arc<Mutex<Option<PyErr>>>);

impl Trouble {
    /// The error, if there was one.
    pub fn check(&self) -> PyResult<()> {
        let stored = self.0.lock().ok().and_then(|mut e| e.take());
        stored.map_or(Ok(()), Err)
    }

    fn keep(&self, error: PyErr) {
        if let Ok(mut kept) = self.0.lock() {
            kept.get_or_insert(error);
        }
    }
}

/// The field that the Python function `f` computes from an array (N, 3) of reference positions. An
/// error of the function goes to `trouble`, and the field is zero.
pub fn python_field(key: &'static str, f: Py<PyAny>, trouble: Trouble) -> VectorField {
    VectorField::Function(Arc::new(move |points: &[Vec3]| {
        Python::attach(|py| evaluate(py, key, &f, points)).unwrap_or_else(|e| {
            trouble.keep(e);
            vec![Vec3::zeros(); points.len()]
        })
    }))
}

/// The moduli (Pa) that the Python function `f` computes from an array (N, 3) of reference positions. An error of the function goes
/// to `trouble`, and the moduli are no numbers.
pub fn python_modulus(f: Py<PyAny>, trouble: Trouble) -> ModulusField {
    let numbers = move |py: Python<'_>, points: &[Vec3]| -> PyResult<Vec<f64>> {
        let result = f.bind(py).call1((positions(py, points.iter().map(|p| (*p).into())),))?;
        let numbers = py.import("numpy")?.call_method1("asarray", (result, "float64"))?;
        numbers.call_method0("tolist")?.extract().map_err(|_| {
            let message = format!("`modulus` did not return {} numbers", points.len());
            input_error(&message, "modulus", None, "return one number (Pa) for each row of the positions")
        })
    };
    ModulusField(Arc::new(move |points: &[Vec3]| {
        Python::attach(|py| numbers(py, points)).unwrap_or_else(|e| {
            trouble.keep(e);
            vec![f64::NAN; points.len()]
        })
    }))
}

fn evaluate(py: Python<'_>, key: &str, f: &Py<PyAny>, points: &[Vec3]) -> PyResult<Vec<Vec3>> {
    let result = f.bind(py).call1((positions(py, points.iter().map(|p| (*p).into())),))?;
    let numbers = py.import("numpy")?.call_method1("asarray", (result, "float64"))?;
    let array: PyArrayLike2<'_, f64, TypeMustMatch> = numbers.extract().map_err(|_| {
        let shape = numbers.getattr("shape").map_or_else(|_| "?".into(), |s| s.to_string());
        let value = format!("an array of shape {shape}");
        let message = format!("`{key}` returned {value}, but ({}, 3) is needed", points.len());
        input_error(&message, key, Some(&value), "return one vector for each row of the positions")
    })?;
    if array.shape()[0] != points.len() {
        return Err(shape_error(key, array.shape()));
    }
    let field = vectors(&array, key)?;
    match field.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
        None => Ok(field),
        Some(a) => {
            let [x, y, z] = points[a].into();
            let message = format!("`{key}` is not finite at the position ({x}, {y}, {z})");
            Err(input_error(&message, key, None, "return finite numbers everywhere in the body"))
        }
    }
}
