//! The kernel sums of Eqs. (10) and (12) on the lattice; no physics.

mod adjoint;
mod blocks;
mod fold;
mod gradient;
mod stencil;
mod sweep;

use crate::lattice::{Lattice, Weights};
use crate::tensor::{Mat3, Vec3};
use crate::tiles::{LANES, Tile, Tiles};
use adjoint::Adjoint;
use blocks::{Block, Sum, for_each_block};
pub use fold::{Fold, Folds};
use gradient::Gradient;
use pulp::Simd;
use rayon::prelude::*;
use stencil::Stencil;
use sweep::{Source, sweep};

/// Components that [`gradient_sums`] writes for each particle: nine of a matrix T (row by row) for
/// [`adjoint_sums`], and a vector.
pub const PAIR_COMPONENTS: usize = 12;

/// Tiles that one task of plain work takes.
const TILES_A_TASK: usize = 128;
/// What a sweep does at each particle with its sums: the nine of H = sum w q_b (x) X (row by row), then
/// Q = sum w q_b. It runs on several lanes of a tile at once, a particle a lane.
pub trait Pointwise: Sync {
    /// Replaces the sums in the lanes from `lane` on of `tile` by its results, zero where there is no
    /// particle.
    fn transform<S: Simd>(&self, simd: S, tile: usize, lane: usize, sums: &mut [S::f64s; PAIR_COMPONENTS]);
}

/// The sums as they are.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

impl Pointwise for Plain {
    #[inline(always)]
    fn transform<S: Simd>(&self, _: S, _: usize, _: usize, _: &mut [S::f64s; PAIR_COMPONENTS]) {}
}

/// For every particle a the sums over its neighbours b, with q_b = V_b A_b from a tiled field,
///
/// * H = sum_b w q_b (x) X (a matrix: Eq. (10) before the subtraction of A_a),
/// * Q = sum_b w q_b,
///
/// images at the folds included, handed to `pointwise`, whose twelve results go to the tiled field `out`.
pub fn gradient_sums(
    lattice: &Lattice,
    folds: &Folds,
    q: &[Tile],
    out: &mut [Tile],
    pointwise: &impl Pointwise,
) {
    for_each_block(
        lattice,
        out,
        PAIR_COMPONENTS,
        &GradientSums { weights: &lattice.weights, folds, q, pointwise },
    );
}

/// Replaces the twelve components of every particle, sums H and Q, by what `function` makes of
/// (particle, H, Q); zero where there is no particle.
pub fn per_particle(
    tiles: &Tiles,
    field: &mut [Tile],
    function: impl Fn(usize, &Mat3, &Vec3) -> [f64; PAIR_COMPONENTS] + Sync,
) {
    field.par_chunks_mut(PAIR_COMPONENTS).with_min_len(TILES_A_TASK).enumerate().for_each(|(t, tile)| {
        let (mut a, mask) = tiles.particles(t);
        for l in 0..LANES {
            let mut result = [0.0; PAIR_COMPONENTS];
            if mask >> l & 1 == 1 {
                let h = Mat3::from_fn(|i, j| tile[3 * i + j].0[l]);
                let q = Vec3::from_fn(|i, _| tile[9 + i].0[l]);
                result = function(a, &h, &q);
                a += 1;
            }
            for (tile, value) in tile.iter_mut().zip(result) {
                tile.0[l] = value;
            }
        }
    });
}

/// For every particle a the sum over its neighbours b of w T_b X, the adjoint of the gradient sum;
/// T is the matrix in the first nine components of `t`, those of images included. Results go to the tiled field `out`.
pub fn adjoint_sums(lattice: &Lattice, folds: &Folds, t: &[Tile], out: &mut [Tile]) {
    for_each_block(lattice, out, 3, &AdjointSums { weights: &lattice.weights, folds, t });
}

struct GradientSums<'a, P> {
    weights: &'a Weights,
    folds: &'a Folds,
    q: &'a [Tile],
    pointwise: &'a P,
}

impl<P: Pointwise> Sum for GradientSums<'_, P> {
    #[inline(always)]
    fn run<S: Simd, T: Stencil>(&self, simd: S, stencil: T, block: Block<'_>) {
        let first = block.first();
        let Block { tiles, column, planes, out } = block;
        let passes = Gradient { stencil, weights: self.weights, signs: self.folds.signs() };
        sweep(
            simd,
            &passes,
            Source { tiles, folds: self.folds, field: self.q },
            column,
            planes,
            #[inline(always)]
            |t, lane, sums| {
                self.pointwise.transform(simd, t, lane, sums);
                store::<S>(&mut out[(t - first) * PAIR_COMPONENTS..][..PAIR_COMPONENTS], lane, sums);
            },
        );
    }
}

struct AdjointSums<'a> {
    weights: &'a Weights,
    folds: &'a Folds,
    t: &'a [Tile],
}

impl Sum for AdjointSums<'_> {
    #[inline(always)]
    fn run<S: Simd, T: Stencil>(&self, simd: S, stencil: T, block: Block<'_>) {
        let first = block.first();
        let Block { tiles, column, planes, out } = block;
        let passes = Adjoint { stencil, weights: self.weights, signs: self.folds.signs() };
        sweep(
            simd,
            &passes,
            Source { tiles, folds: self.folds, field: self.t },
            column,
            planes,
            #[inline(always)]
            |t, lane, sums| {
                store::<S>(&mut out[(t - first) * 3..][..3], lane, sums);
            },
        );
    }
}

/// Puts the vectors of a tile's components into its lanes from `lane` on.
#[inline(always)]
fn store<S: Simd>(tiles: &mut [Tile], lane: usize, values: &[S::f64s]) {
    for (tile, value) in tiles.iter_mut().zip(values) {
        S::as_mut_simd_f64s(&mut tile.0[lane..lane + S::F64_LANES]).0[0] = *value;
    }
}

/// The vector at `d` of `line`.
#[inline(always)]
pub(crate) fn load<S: Simd>(_: S, line: &[f64], d: usize) -> S::f64s {
    S::as_simd_f64s(&line[d..d + S::F64_LANES]).0[0]
}
