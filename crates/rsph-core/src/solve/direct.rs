//! The coarsest level: a dense Cholesky factorisation, kept as the inverse.

use super::level::Level;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};
use rayon::prelude::*;

/// Added to the diagonal, as a share of its mean: blocks are stored in single precision.
const SHIFT: f64 = 1e-6;

/// The inverse of a small matrix.
#[derive(Clone, Debug)]
pub struct Direct {
    size: usize,
    inverse: Vec<f64>,
}

impl Direct {
    /// The inverse of `level`'s matrix; `None` if that is not positive definite even after a shift that
    /// only rounding needs.
    pub fn new(level: &Level) -> Option<Self> {
        let size = 3 * level.len();
        let mut dense = Mat::<f64>::zeros(size, size);
        level.for_each_entry(|row, column, value| dense[(row, column)] += value);
        let mean = (0..size).map(|i| dense[(i, i)]).sum::<f64>() / size.max(1) as f64;
        for i in 0..size {
            // A component without stiffness is held.
            dense[(i, i)] = if dense[(i, i)] > 0.0 { dense[(i, i)] + SHIFT * mean } else { mean };
        }
        let inverse = dense.as_ref().llt(Side::Lower).ok()?.inverse();
        let values = (0..size).flat_map(|i| (0..size).map(move |j| (i, j)));
        Some(Self { size, inverse: values.map(|(i, j)| 0.5 * (inverse[(i, j)] + inverse[(j, i)])).collect() })
    }

    /// x = A^-1 b
    pub fn solve(&self, b: &[f64], x: &mut [f64]) {
        x.par_iter_mut().with_min_len(64).zip(self.inverse.par_chunks(self.size)).for_each(|(x, row)| {
            *x = row.iter().zip(b).map(|(a, b)| a * b).sum();
        });
    }
}
