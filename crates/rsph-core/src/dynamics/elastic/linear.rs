//! The stress sweep of a linear material: as many particles at once as a vector register holds.

use super::Elastic;
use crate::boundary::mirror::Mirror;
use crate::lattice::{LANES, Lattice, NO_PARTICLE};
use crate::material::Tangent;
use crate::moments::Moments;
use crate::ops::{self, PAIR_COMPONENTS, Pointwise};
use crate::tensor::Vec3;
use pulp::Simd;

/// Numbers of a particle that the sweep needs: V, the six of L (VTK order),
/// sum V_b w X / V and sum V_b w / V.
const CONSTANTS: usize = 11;
/// Place of L_ij among the six of a symmetric tensor.
const SYM: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// Constants of the sweep, as a box field.
#[derive(Clone, Debug)]
pub(super) struct Constants {
    values: Vec<f64>,
    /// Rows in which a particle sees a mirror ghost.
    near_wall: Vec<bool>,
}

impl Constants {
    /// Of a body with these moments.
    pub(super) fn new(lattice: &Lattice, moments: &[Moments], mirror: &Mirror) -> Self {
        let mut values = ops::box_field(lattice, CONSTANTS);
        let mut near_wall = vec![false; lattice.spans.len()];
        for (a, m) in moments.iter().enumerate().filter(|(_, m)| m.volume > 0.0) {
            let (row, x) = lattice.row_and_x(a);
            let l = &m.correction;
            let of_q = m.first / m.volume;
            let constants = [
                m.volume,
                l[(0, 0)],
                l[(1, 1)],
                l[(2, 2)],
                l[(0, 1)],
                l[(1, 2)],
                l[(0, 2)],
                of_q.x,
                of_q.y,
                of_q.z,
                m.zeroth / m.volume,
            ];
            for (c, value) in constants.into_iter().enumerate() {
                values[(row * CONSTANTS + c) * lattice.stride + x] = value;
            }
            near_wall[row] |= !mirror.ghosts_of(a).is_empty();
        }
        Self { values, near_wall }
    }
}

/// From sums to T_a and the part of the force that needs no neighbour's T.
struct LinearStress<'a> {
    lattice: &'a Lattice,
    constants: &'a Constants,
    moments: &'a [Moments],
    mirror: &'a Mirror,
    tangent: &'a Tangent,
    kappa: f64,
    q: &'a [f64],
    z: &'a [f64],
    offset: &'a [Vec3],
}

impl LinearStress<'_> {
    /// Adds what the mirror ghosts of the particles at `x`, `x + 1`, ... of `row` put into their sums.
    fn add_ghosts<S: Simd>(&self, row: usize, x: usize, sums: &mut [S::f64s; PAIR_COMPONENTS]) {
        let first = row * self.lattice.stride + x;
        let cells = &self.lattice.particle_at[first..first + S::F64_LANES];
        let sees = |a: &u32| *a != NO_PARTICLE && !self.mirror.ghosts_of(*a as usize).is_empty();
        if !cells.iter().any(sees) {
            return;
        }
        let mut lanes = [[0.0; LANES]; PAIR_COMPONENTS];
        for (l, &a) in cells.iter().enumerate().filter(|(_, a)| sees(a)) {
            for ghost in self.mirror.ghosts_of(a as usize) {
                let z = Elastic::ghost_value(ghost, self.z, self.moments.len(), self.offset)
                    * (self.moments[ghost.partner as usize].volume * ghost.w);
                for i in 0..3 {
                    for j in 0..3 {
                        lanes[3 * i + j][l] += z[i] * ghost.x[j];
                    }
                    lanes[9 + i][l] += z[i];
                }
            }
        }
        for (sum, lanes) in sums.iter_mut().zip(&lanes) {
            let mut together = [0.0; LANES];
            S::as_mut_simd_f64s(&mut together[..S::F64_LANES]).0[0] = *sum;
            for (t, l) in together.iter_mut().zip(lanes) {
                *t += l;
            }
            *sum = S::as_simd_f64s(&together[..S::F64_LANES]).0[0];
        }
    }
}

impl Pointwise for LinearStress<'_> {
    #[inline(always)]
    fn transform<S: Simd>(&self, simd: S, row: usize, x: usize, sums: &mut [S::f64s; PAIR_COMPONENTS]) {
        // No closures here: they would not inherit the instruction set.
        let stride = self.lattice.stride;
        let mut constant = [simd.splat_f64s(0.0); CONSTANTS];
        for (c, value) in constant.iter_mut().enumerate() {
            *value = ops::load(simd, &self.constants.values, (row * CONSTANTS + c) * stride + x);
        }
        let [volume, l0, l1, l2, l3, l4, l5, first_x, first_y, first_z, zeroth] = constant;
        let (l, first) = ([l0, l1, l2, l3, l4, l5], [first_x, first_y, first_z]);
        for i in 0..3 {
            let q = ops::load(simd, self.q, (row * 3 + i) * stride + x);
            for j in 0..3 {
                sums[3 * i + j] = simd.negate_mul_add_e_f64s(q, first[j], sums[3 * i + j]);
            }
            sums[9 + i] = simd.negate_mul_add_e_f64s(q, zeroth, sums[9 + i]);
        }
        if self.constants.near_wall[row] {
            self.add_ghosts::<S>(row, x, sums);
        }
        let mut g = [[volume; 3]; 3]; // G = H L
        for i in 0..3 {
            g[i] = times(simd, [sums[3 * i], sums[3 * i + 1], sums[3 * i + 2]], &l);
        }
        let half = simd.splat_f64s(0.5);
        let strain = [
            g[0][0],
            g[1][1],
            g[2][2],
            simd.mul_f64s(half, simd.add_f64s(g[0][1], g[1][0])),
            simd.mul_f64s(half, simd.add_f64s(g[1][2], g[2][1])),
            simd.mul_f64s(half, simd.add_f64s(g[0][2], g[2][0])),
        ];
        // Eq. (5), times the volume.
        let mut sigma = [simd.splat_f64s(0.0); 6];
        for (k, sigma) in sigma.iter_mut().enumerate() {
            for (j, e) in strain.into_iter().enumerate() {
                *sigma = simd.mul_add_e_f64s(simd.splat_f64s(self.tangent.0[k][j]), e, *sigma);
            }
            *sigma = simd.mul_f64s(*sigma, volume);
        }
        let stiff = simd.mul_f64s(simd.splat_f64s(self.kappa), volume);
        let twice = simd.add_f64s(stiff, stiff);
        for i in 0..3 {
            let t = times(simd, [sigma[SYM[i][0]], sigma[SYM[i][1]], sigma[SYM[i][2]]], &l);
            let mut own = simd.splat_f64s(0.0);
            for j in 0..3 {
                let t = simd.negate_mul_add_e_f64s(stiff, g[i][j], t[j]);
                sums[3 * i + j] = t;
                own = simd.mul_add_e_f64s(t, first[j], own);
            }
            sums[9 + i] = simd.mul_add_e_f64s(own, volume, simd.mul_f64s(twice, sums[9 + i]));
        }
    }
}

/// The row vector `a` times the symmetric tensor `l`.
#[inline(always)]
fn times<S: Simd>(simd: S, a: [S::f64s; 3], l: &[S::f64s; 6]) -> [S::f64s; 3] {
    let mut product = a;
    for (j, product) in product.iter_mut().enumerate() {
        let sum = simd.mul_f64s(a[0], l[SYM[0][j]]);
        let sum = simd.mul_add_e_f64s(a[1], l[SYM[1][j]], sum);
        *product = simd.mul_add_e_f64s(a[2], l[SYM[2][j]], sum);
    }
    product
}

impl Elastic {
    /// [`Elastic::stress_sweep`] for a linear material.
    pub(super) fn linear_stress_sweep(&mut self, tangent: &Tangent) {
        let work = &mut self.work;
        let pointwise = LinearStress {
            lattice: &self.lattice,
            constants: &self.constants,
            moments: &self.moments,
            mirror: &self.mirror,
            tangent,
            kappa: self.hourglass,
            q: &work.q,
            z: &work.effective,
            offset: &work.offset,
        };
        ops::gradient_sums(&self.lattice, &work.q, &mut work.pair, &pointwise);
    }
}
