//! The block Jacobi iteration on the particles.

use super::level::inverse_of_diagonal;
use crate::tensor::Mat3;
use rayon::prelude::*;

/// Particles that one task works on.
const PARTICLES_PER_TASK: usize = 1024;
/// Place of (i, j) among the six of a symmetric matrix.
const SYM: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// Inverses of the 3 x 3 diagonal blocks of m M + c K, in single precision.
#[derive(Clone, Debug)]
pub struct Jacobi {
    inverse: Vec<[f32; 6]>,
    /// The last step.
    direction: Vec<f64>,
}

impl Jacobi {
    /// Of the diagonal blocks of K and the masses, at `scales` (m, c).
    pub fn new(diagonal: &[Mat3], mass: &[f64], scales: (f64, f64)) -> Self {
        let inverse = (diagonal, mass)
            .into_par_iter()
            .map(|(block, m)| {
                let mut d = scales.1 * block;
                for i in (0..3).filter(|&i| block[(i, i)] > 0.0) {
                    d[(i, i)] += scales.0 * m;
                }
                let inverse = inverse_of_diagonal(d);
                let mut six = [0.0; 6];
                for i in 0..3 {
                    for j in 0..3 {
                        six[SYM[i][j]] = inverse[(i, j)] as f32;
                    }
                }
                six
            })
            .collect();
        Self { inverse, direction: vec![0.0; 3 * diagonal.len()] }
    }

    /// Whether component `i` of particle `a` has stiffness.
    #[inline(always)]
    pub fn is_free(&self, a: usize, i: usize) -> bool {
        self.inverse[a][i] != 0.0
    }

    /// d = keep d + length D^-1 (r - y), then z += d; without y it starts from z = 0 and d = 0. What is not kept may be anything.
    pub fn step(&mut self, keep: f64, length: f64, r: &[f64], y: Option<&[f64]>, z: &mut [f64]) {
        let (n, chunk) = (self.inverse.len(), PARTICLES_PER_TASK);
        let (zx, zyz) = z.split_at_mut(n);
        let (zy, zz) = zyz.split_at_mut(n);
        let (dx, dyz) = self.direction.split_at_mut(n);
        let (dy, dz) = dyz.split_at_mut(n);
        let chunks = (
            self.inverse.par_chunks(chunk),
            zx.par_chunks_mut(chunk),
            zy.par_chunks_mut(chunk),
            zz.par_chunks_mut(chunk),
            dx.par_chunks_mut(chunk),
            dy.par_chunks_mut(chunk),
            dz.par_chunks_mut(chunk),
        );
        chunks.into_par_iter().enumerate().for_each(|(k, (inverse, zx, zy, zz, dx, dy, dz))| {
            let first = k * chunk;
            let len = inverse.len();
            let part = |i: usize| i * n + first..i * n + first + len;
            let r: [&[f64]; 3] = std::array::from_fn(|i| &r[part(i)]);
            let y: Option<[&[f64]; 3]> = y.map(|y| std::array::from_fn(|i| &y[part(i)]));
            for a in 0..len {
                let mut rest = [r[0][a], r[1][a], r[2][a]];
                if let Some(y) = y {
                    rest = [rest[0] - y[0][a], rest[1] - y[1][a], rest[2] - y[2][a]];
                }
                let m = inverse[a].map(f64::from);
                let step = [
                    length * (m[0] * rest[0] + m[3] * rest[1] + m[5] * rest[2]),
                    length * (m[3] * rest[0] + m[1] * rest[1] + m[4] * rest[2]),
                    length * (m[5] * rest[0] + m[4] * rest[1] + m[2] * rest[2]),
                ];
                if y.is_some() {
                    let before = if keep == 0.0 { [0.0; 3] } else { [dx[a], dy[a], dz[a]] };
                    (dx[a], dy[a], dz[a]) =
                        (keep * before[0] + step[0], keep * before[1] + step[1], keep * before[2] + step[2]);
                    (zx[a], zy[a], zz[a]) = (zx[a] + dx[a], zy[a] + dy[a], zz[a] + dz[a]);
                } else {
                    (dx[a], dy[a], dz[a]) = (step[0], step[1], step[2]);
                    (zx[a], zy[a], zz[a]) = (step[0], step[1], step[2]);
                }
            }
        });
    }
}
