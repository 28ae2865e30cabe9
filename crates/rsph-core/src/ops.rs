//! The kernel sums of Eqs. (10) and (12) on the lattice; no physics.
//!
//! A *box field* of C components spreads values over the padded box of the lattice, row by row, the
//! components of a row one after the other: value (c, x) of row r stands at `(r C + c) stride + x`.
//! Cells without a particle hold zero.

use crate::lattice::{LANES, Lattice, NO_PARTICLE, Span};
use crate::tensor::{Mat3, Vec3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Components that [`gradient_sums`] writes for each particle: nine of a matrix T (row by row) for
/// [`adjoint_sums`], and a vector.
pub const PAIR_COMPONENTS: usize = 12;

/// Rows of a box field that one task works on.
const ROWS_A_TASK: usize = 8;

/// A box field of `components` zeros.
pub fn box_field(lattice: &Lattice, components: usize) -> Vec<f64> {
    vec![0.0; components * lattice.box_len()]
}

/// Writes `value(a)` of every particle into a box field of three components.
pub fn scatter(lattice: &Lattice, field: &mut [f64], value: impl Fn(usize) -> Vec3 + Sync) {
    let stride = lattice.stride;
    field.par_chunks_mut(3 * stride).with_min_len(ROWS_A_TASK).enumerate().for_each(|(row, out)| {
        let Span { start, end } = lattice.spans[row];
        let (x, yz) = out.split_at_mut(stride);
        let (y, z) = yz.split_at_mut(stride);
        for (i, &a) in (start..end).zip(&lattice.particle_at[row * stride + start..row * stride + end]) {
            if a != NO_PARTICLE {
                let v = value(a as usize);
                x[i] = v.x;
                y[i] = v.y;
                z[i] = v.z;
            }
        }
    });
}

/// What a sweep does at each particle with its sums: the nine of H = sum w q_b (x) X (row by row), then
/// Q = sum w q_b. It runs on a stretch of a row at once, a particle a lane.
pub trait Pointwise: Sync {
    /// Replaces the sums at `x`, `x + 1`, ... of `row` by its results, zero where there is no particle.
    fn transform<S: Simd>(&self, simd: S, row: usize, x: usize, sums: &mut [S::f64s; PAIR_COMPONENTS]);
}

/// A function of (particle, H, Q), called for one particle after the other.
#[derive(Clone, Copy, Debug)]
pub struct PerParticle<'a, F> {
    /// The lattice.
    pub lattice: &'a Lattice,
    /// The function.
    pub function: F,
}

impl<F> Pointwise for PerParticle<'_, F>
where
    F: Fn(usize, &Mat3, &Vec3) -> [f64; PAIR_COMPONENTS] + Sync,
{
    #[inline(always)]
    fn transform<S: Simd>(&self, _: S, row: usize, x: usize, sums: &mut [S::f64s; PAIR_COMPONENTS]) {
        let mut lanes = [[0.0; LANES]; PAIR_COMPONENTS];
        for (to, from) in lanes.iter_mut().zip(&*sums) {
            S::as_mut_simd_f64s(&mut to[..S::F64_LANES]).0[0] = *from;
        }
        let first = row * self.lattice.stride + x;
        for (l, &a) in self.lattice.particle_at[first..first + S::F64_LANES].iter().enumerate() {
            let mut result = [0.0; PAIR_COMPONENTS];
            if a != NO_PARTICLE {
                let h = Mat3::from_fn(|i, j| lanes[3 * i + j][l]);
                let laplacian = Vec3::from_fn(|i, _| lanes[9 + i][l]);
                result = (self.function)(a as usize, &h, &laplacian);
            }
            for (lanes, value) in lanes.iter_mut().zip(result) {
                lanes[l] = value;
            }
        }
        for (from, to) in lanes.iter().zip(sums) {
            *to = S::as_simd_f64s(&from[..S::F64_LANES]).0[0];
        }
    }
}

/// For every particle a the sums over its neighbours b, with q_b = V_b A_b from a box field,
///
/// * H = sum_b w q_b (x) X (a matrix: Eq. (10) before the subtraction of A_a),
/// * Q = sum_b w q_b,
///
/// handed to `pointwise`, whose twelve results go to the box field `out`.
pub fn gradient_sums(lattice: &Lattice, q: &[f64], out: &mut [f64], pointwise: &impl Pointwise) {
    let arch = Arch::new();
    out.par_chunks_mut(PAIR_COMPONENTS * lattice.stride).with_min_len(ROWS_A_TASK).enumerate().for_each(
        |(row, out)| {
            if lattice.spans[row].end > 0 {
                arch.dispatch(GradientRow { lattice, row, q, out, pointwise });
            }
        },
    );
}

struct GradientRow<'a, P> {
    lattice: &'a Lattice,
    row: usize,
    q: &'a [f64],
    out: &'a mut [f64],
    pointwise: &'a P,
}

impl<P: Pointwise> WithSimd for GradientRow<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lattice, row, q, out, pointwise } = self;
        let stride = lattice.stride;
        let Span { start, end } = lattice.spans[row];
        let zero = simd.splat_f64s(0.0);
        let mut x = start;
        while x < end {
            // H row by row (i, x y z), then Q.
            let mut sum = [zero; PAIR_COMPONENTS];
            for offset in &lattice.offsets {
                let neighbour_row = row.wrapping_add_signed(offset.rows);
                let span = lattice.spans[neighbour_row];
                if span.end + offset.reach <= x || span.start >= x + S::F64_LANES + offset.reach {
                    continue;
                }
                let (y, z) = (simd.splat_f64s(offset.y), simd.splat_f64s(offset.z));
                let lines = lines::<S, 3>(q, neighbour_row * 3 * stride + x, stride, offset.reach);
                let (mut plain, mut times_x) = ([zero; 3], [zero; 3]);
                for (d, (&w, &wx)) in offset.weight.iter().zip(&offset.weight_x).enumerate() {
                    let (w, wx) = (simd.splat_f64s(w), simd.splat_f64s(wx));
                    for i in 0..3 {
                        let v = load(simd, lines[i], d);
                        plain[i] = simd.mul_add_e_f64s(w, v, plain[i]);
                        times_x[i] = simd.mul_add_e_f64s(wx, v, times_x[i]);
                    }
                }
                for i in 0..3 {
                    sum[3 * i] = simd.add_f64s(sum[3 * i], times_x[i]);
                    sum[3 * i + 1] = simd.mul_add_e_f64s(y, plain[i], sum[3 * i + 1]);
                    sum[3 * i + 2] = simd.mul_add_e_f64s(z, plain[i], sum[3 * i + 2]);
                    sum[9 + i] = simd.add_f64s(sum[9 + i], plain[i]);
                }
            }
            pointwise.transform(simd, row, x, &mut sum);
            for (c, value) in sum.into_iter().enumerate() {
                let first = c * stride + x;
                S::as_mut_simd_f64s(&mut out[first..first + S::F64_LANES]).0[0] = value;
            }
            x += S::F64_LANES;
        }
    }
}

/// For every particle a the sum over its neighbours b of w T_b X, the adjoint of the gradient sum;
/// T is the matrix in the first nine components of `t`. Results go to the box field `out`.
pub fn adjoint_sums(lattice: &Lattice, t: &[f64], out: &mut [f64]) {
    let arch = Arch::new();
    out.par_chunks_mut(3 * lattice.stride).with_min_len(ROWS_A_TASK).enumerate().for_each(|(row, out)| {
        if lattice.spans[row].end > 0 {
            arch.dispatch(AdjointRow { lattice, row, t, out });
        }
    });
}

struct AdjointRow<'a> {
    lattice: &'a Lattice,
    row: usize,
    t: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for AdjointRow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lattice, row, t, out } = self;
        let stride = lattice.stride;
        let Span { start, end } = lattice.spans[row];
        let zero = simd.splat_f64s(0.0);
        let mut x = start;
        while x < end {
            let mut sum = [zero; 3];
            for offset in &lattice.offsets {
                let neighbour_row = row.wrapping_add_signed(offset.rows);
                let span = lattice.spans[neighbour_row];
                if span.end + offset.reach <= x || span.start >= x + S::F64_LANES + offset.reach {
                    continue;
                }
                let (y, z) = (simd.splat_f64s(offset.y), simd.splat_f64s(offset.z));
                let first = neighbour_row * PAIR_COMPONENTS * stride + x;
                let lines = lines::<S, 9>(t, first, stride, offset.reach);
                let (mut along_y, mut along_z) = ([zero; 3], [zero; 3]);
                for (d, (&w, &wx)) in offset.weight.iter().zip(&offset.weight_x).enumerate() {
                    let (w, wx) = (simd.splat_f64s(w), simd.splat_f64s(wx));
                    for i in 0..3 {
                        sum[i] = simd.mul_add_e_f64s(wx, load(simd, lines[3 * i], d), sum[i]);
                        along_y[i] = simd.mul_add_e_f64s(w, load(simd, lines[3 * i + 1], d), along_y[i]);
                        along_z[i] = simd.mul_add_e_f64s(w, load(simd, lines[3 * i + 2], d), along_z[i]);
                    }
                }
                for i in 0..3 {
                    sum[i] = simd.mul_add_e_f64s(y, along_y[i], sum[i]);
                    sum[i] = simd.mul_add_e_f64s(z, along_z[i], sum[i]);
                }
            }
            for (i, value) in sum.into_iter().enumerate() {
                let first = i * stride + x;
                S::as_mut_simd_f64s(&mut out[first..first + S::F64_LANES]).0[0] = value;
            }
            x += S::F64_LANES;
        }
    }
}

/// The stretches of `C` components of a row that the taps of an offset read around the vector at
/// `first`, the place in component 0.
#[inline(always)]
fn lines<S: Simd, const C: usize>(field: &[f64], first: usize, stride: usize, reach: usize) -> [&[f64]; C] {
    std::array::from_fn(|c| {
        let start = first + c * stride - reach;
        &field[start..start + 2 * reach + S::F64_LANES]
    })
}

/// The vector at `d` of `line`.
#[inline(always)]
pub(crate) fn load<S: Simd>(_: S, line: &[f64], d: usize) -> S::f64s {
    S::as_simd_f64s(&line[d..d + S::F64_LANES]).0[0]
}
