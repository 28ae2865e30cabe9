//! NumPy arrays from the core's storage and back.

use crate::errors::input_error;
use numpy::ndarray::{Array2, ArrayView1, ArrayView2, ShapeBuilder};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use rsph_core::particles::Column;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// Owns the storage of a column for as long as an array looks at it.
#[pyclass(frozen, module = "rsph._rsph")]
struct Storage {
    data: Arc<Vec<f64>>,
}

/// A read-only array on the storage of `column`, without a copy: (N,) or (N, components).
pub fn column_view<'py>(py: Python<'py>, column: &Column) -> PyResult<Bound<'py, PyAny>> {
    let (n, components) = (column.len(), column.components());
    let owner = Bound::new(py, Storage { data: column.share() })?;
    let data = &owner.get().data;
    if components <= 1 {
        let view = ArrayView1::from(&data[..]);
        // SAFETY: the array points into the vector that `owner` keeps alive as the base of the array.
        // `Storage` is frozen, and a shared vector is never written to: the core copies a column before it
        // writes while anybody else holds it.
        let array = unsafe { PyArray1::borrow_from_array(&view, owner.clone().into_any()) };
        array.readwrite().make_nonwriteable();
        return Ok(array.into_any());
    }
    // Component by component in memory, particle by particle to the user.
    let view = ArrayView2::from_shape((n, components).strides((1, n)), data)
        .map_err(|e| crate::errors::plain(&e.to_string()))?;
    // SAFETY: as above; the strides stay within the vector, as `from_shape` has checked.
    let array = unsafe { PyArray2::borrow_from_array(&view, owner.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    Ok(array.into_any())
}

/// A new array (N, components), or (N,) for one component, of values that lie point by point.
pub fn point_by_point(py: Python<'_>, values: Vec<f64>, components: usize) -> PyResult<Bound<'_, PyAny>> {
    let n = values.len() / components.max(1);
    let flat = PyArray1::from_vec(py, values);
    if components == 1 { Ok(flat.into_any()) } else { Ok(flat.reshape([n, components])?.into_any()) }
}

/// A new array (N, 3) of positions.
pub fn positions(py: Python<'_>, points: impl ExactSizeIterator<Item = [f64; 3]>) -> Bound<'_, PyAny> {
    let n = points.len();
    let flat: Vec<f64> = points.flatten().collect();
    rows(n, flat).to_pyarray(py).into_any()
}

/// A new array (T, 3) of triangles.
pub fn triangles<'py>(py: Python<'py>, triangles: &[[u32; 3]]) -> Bound<'py, PyAny> {
    rows(triangles.len(), triangles.concat()).to_pyarray(py).into_any()
}

fn rows<T: Clone + Default>(n: usize, flat: Vec<T>) -> Array2<T> {
    Array2::from_shape_vec((n, 3), flat).unwrap_or_default()
}

/// The rows of an array (N, 3); `key` names it in messages.
pub fn vectors(array: &PyReadonlyArray2<'_, f64>, key: &str) -> PyResult<Vec<Vec3>> {
    let array = array.as_array();
    if array.ncols() != 3 {
        return Err(shape_error(key, array.shape()));
    }
    Ok(array.rows().into_iter().map(|r| Vec3::new(r[0], r[1], r[2])).collect())
}

/// An array is not of shape (N, 3).
pub fn shape_error(key: &str, shape: &[usize]) -> PyErr {
    let value = format!("an array of shape {shape:?}");
    let message = format!("`{key}` is {value}, but one row of three numbers is needed for each point");
    input_error(&message, key, Some(&value), "give an array of shape (N, 3)")
}
