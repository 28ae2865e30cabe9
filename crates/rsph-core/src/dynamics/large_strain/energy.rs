//! The energy whose derivative the force is.

use super::configuration::Configuration;
use super::points::{Points, lanes, vectors, vectors_mut};
use crate::material::FiniteStrain;
use crate::tensor::{Mat3, Vec3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Particles that a thread takes at once.
const CHUNK: usize = 64;

/// The hourglass term of some particles: sum c_ab |x_ba - F_a X_ba|^2, from differences of near numbers.
struct Chunk<'a, const D: usize> {
    configuration: &'a Configuration<D>,
    points: &'a Points,
    f: &'a [Mat3],
    first: usize,
    out: &'a mut [f64],
}

impl<const D: usize> Chunk<'_, D> {
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, a: usize) -> f64 {
        let here = &self.points.list[a];
        let columns: [_; 3] = std::array::from_fn(|j| lanes(&self.f[a].column(j).into(), &Vec3::zeros()));
        let (neighbours, shares) = self.configuration.row(a);
        let mut squares = [0.0; 8];
        // The companion of x in the other lanes is left out at the end, or not computed.
        for part in 0..(4 / S::F64_LANES).max(1) {
            let x = vectors::<S>(&here.moving)[part];
            let mut sum = simd.splat_f64s(0.0);
            for (b, share) in neighbours.iter().zip(shares) {
                let there = &self.points.list[*b as usize];
                let mut residual = simd.sub_f64s(vectors::<S>(&there.moving)[part], x);
                for (j, column) in columns.iter().enumerate() {
                    let apart = simd.splat_f64s(here.place[4 + j] - there.place[4 + j]);
                    residual = simd.mul_add_e_f64s(apart, vectors::<S>(column)[part], residual);
                }
                let weighted = simd.mul_f64s(residual, simd.splat_f64s(*share));
                sum = simd.mul_add_e_f64s(weighted, residual, sum);
            }
            vectors_mut::<S>(&mut squares)[part] = sum;
        }
        squares[0] + squares[1] + squares[2]
    }
}

impl<const D: usize> WithSimd for Chunk<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for k in 0..self.out.len() {
            self.out[k] = self.at(simd, self.first + k);
        }
    }
}

impl Points {
    /// Energy of each particle at gradients `f`, that of the hourglass term of stiffness k included:
    /// m/rho_0 W(F) + 1/2 sum k_ab |x_ba - F_a X_ba|^2, k_ab = k V_a V_b w. As F_a X_ba = F_inc F_0 X_ba, the
    /// term remembers what it held before a remesh.
    pub fn energies<const D: usize>(
        &self,
        c: &Configuration<D>,
        material: &dyn FiniteStrain,
        stiffness: f64,
        f: &[Mat3],
        out: &mut [f64],
    ) {
        let arch = Arch::new();
        out.par_chunks_mut(CHUNK).enumerate().for_each(|(i, out)| {
            let first = i * CHUNK;
            arch.dispatch(Chunk { configuration: c, points: self, f, first, out: &mut *out });
            for (a, e) in (first..).zip(out) {
                *e = c.reference_volume[a] * material.energy(&f[a]) + 0.5 * stiffness * c.volume[a] * *e;
            }
        });
    }
}
