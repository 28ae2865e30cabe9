//! Lattice to points: interpolation of node values with the remeshing kernel.

use super::nodes::NodeValues;
use crate::kernel::RemeshKernel;
use crate::tensor::Vec3;
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
    let Some((node, fraction)) = field.lattice.locate(x) else { return };
    let first = 1 - kernel.reach() as i64;
    let count = |axis: usize| if axis < D { 2 * kernel.reach() } else { 1 };
    let start: [i64; 3] = std::array::from_fn(|i| if i < D { node[i] + first } else { 0 });
    let w: [_; 3] = std::array::from_fn(|i| if i < D { kernel.weights(fraction[i]) } else { [1.0; 8] });
    for (k, w_z) in w[2].iter().enumerate().take(count(2)) {
        for (j, w_y) in w[1].iter().enumerate().take(count(1)) {
            let Some(row) = field.row(start[2] + k as i64, start[1] + j as i64) else { continue };
            let from = (row.x - start[0]).max(0);
            let to = (row.x + row.len as i64 - start[0]).min(count(0) as i64);
            for i in from..to {
                let weight = w[0][i as usize] * w_y * w_z;
                let values = field.at(row.first + (start[0] + i - row.x) as usize);
                for (sum, value) in out.iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
        }
    }
}
