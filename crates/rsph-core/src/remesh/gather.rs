//! Lattice to points: interpolation of node values with the remeshing kernel.

use super::nodes::NodeValues;
use crate::kernel::{MAX_WEIGHTS, RemeshKernel};
use crate::tensor::Vec3;
use nalgebra::SVector;
use rayon::prelude::*;

/// Values at `points`, point by point: sums over the nodes within reach of value times kernel; a
/// node that is not there counts as zero, and so does everything around a point that is not finite.
pub fn gather<const D: usize>(kernel: RemeshKernel, field: &NodeValues<D>, points: &[Vec3]) -> Vec<f64> {
    let columns = field.columns;
    let mut values = vec![0.0; columns * points.len()];
    values.par_chunks_mut(columns.max(1)).zip(points).for_each(|(out, x)| gather_at(kernel, field, x, out));
    values
}

/// Adds the value at one point to `out`.
fn gather_at<const D: usize>(kernel: RemeshKernel, field: &NodeValues<D>, x: &Vec3, out: &mut [f64]) {
    for_each_node(kernel, field, x, |values, [x, y, z], _| {
        let weight = x * y * z;
        for (sum, value) in out.iter_mut().zip(values) {
            *sum += weight * value;
        }
    });
}

/// The first `N` values at one point and their slopes along the axes, of length.
pub(super) fn with_slopes<const D: usize, const N: usize>(
    kernel: RemeshKernel,
    field: &NodeValues<D>,
    x: &Vec3,
) -> (SVector<f64, N>, [SVector<f64, N>; 3]) {
    let (mut value, mut slopes) = (SVector::zeros(), [SVector::zeros(); 3]);
    for_each_node(kernel, field, x, |values, [x, y, z], [dx, dy, dz]| {
        let values = SVector::<f64, N>::from_column_slice(&values[..N]);
        value += values * (x * y * z);
        slopes[0] += values * (dx * y * z);
        slopes[1] += values * (x * dy * z);
        slopes[2] += values * (x * y * dz);
    });
    (value, slopes.map(|s| s / field.lattice.spacing))
}

/// Calls `visit` with the values of the nodes around a point, their weight along each axis and its derivative there.
#[inline(always)]
fn for_each_node<const D: usize>(
    kernel: RemeshKernel,
    field: &NodeValues<D>,
    x: &Vec3,
    mut visit: impl FnMut(&[f64], [f64; 3], [f64; 3]),
) {
    let Some((node, fraction)) = field.lattice.locate(x) else { return };
    let first = 1 - kernel.reach() as i64;
    let count = |axis: usize| if axis < D { 2 * kernel.reach() } else { 1 };
    let start: [i64; 3] = std::array::from_fn(|i| if i < D { node[i] + first } else { 0 });
    let w: [_; 3] =
        std::array::from_fn(|i| if i < D { kernel.weights(fraction[i]) } else { [1.0; MAX_WEIGHTS] });
    let slope: [_; 3] =
        std::array::from_fn(|i| if i < D { kernel.slopes(fraction[i]) } else { [0.0; MAX_WEIGHTS] });
    for k in 0..count(2) {
        for j in 0..count(1) {
            let Some(row) = field.row(start[2] + k as i64, start[1] + j as i64) else { continue };
            let from = (row.x - start[0]).max(0);
            let to = (row.x + row.len as i64 - start[0]).min(count(0) as i64);
            for i in from..to {
                let values = field.at(row.first + (start[0] + i - row.x) as usize);
                let i = i as usize;
                visit(values, [w[0][i], w[1][j], w[2][k]], [slope[0][i], slope[1][j], slope[2][k]]);
            }
        }
    }
}
