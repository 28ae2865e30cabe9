//! The coarsest level: a dense Cholesky factorisation, kept as the inverse in single precision.

use super::level::Level;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Added to the diagonal, as a share of its mean: blocks are stored in single precision.
const SHIFT: f64 = 1e-6;

/// Rows that one task multiplies.
const ROWS_PER_TASK: usize = 64;

/// The inverse of a small matrix.
#[derive(Clone, Debug)]
pub struct Direct {
    size: usize,
    inverse: Vec<f32>,
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
        Some(Self {
            size,
            inverse: values.map(|(i, j)| (0.5 * (inverse[(i, j)] + inverse[(j, i)])) as f32).collect(),
        })
    }

    /// x = A^-1 b
    pub fn solve(&self, b: &[f32], x: &mut [f32]) {
        let arch = Arch::new();
        x.par_chunks_mut(ROWS_PER_TASK)
            .zip(self.inverse.par_chunks(ROWS_PER_TASK * self.size))
            .for_each(|(x, rows)| arch.dispatch(Dots { rows, b, x }));
    }
}

/// Inner products of rows with b.
struct Dots<'a> {
    rows: &'a [f32],
    b: &'a [f32],
    x: &'a mut [f32],
}

impl WithSimd for Dots<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (b, b_rest) = S::as_simd_f32s(self.b);
        for (row, x) in self.rows.chunks_exact(self.b.len()).zip(self.x) {
            let (row, rest) = S::as_simd_f32s(row);
            let mut sum = simd.splat_f32s(0.0);
            for (a, b) in row.iter().zip(b) {
                sum = simd.mul_add_e_f32s(*a, *b, sum);
            }
            *x = simd.reduce_sum_f32s(sum);
            for (a, b) in rest.iter().zip(b_rest) {
                *x += a * b;
            }
        }
    }
}
