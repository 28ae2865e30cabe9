//! The two sweeps of the adjoint formulation: gradient and stress, then the adjoint of the gradient.

use super::{Elastic, Workspace};
use crate::boundary::mirror::{Ghost, Mirror};
use crate::moments::Moments;
use crate::ops::{self, PAIR_COMPONENTS, PerParticle};
use crate::tensor::{Mat3, SymTensor, Vec3};
use rayon::prelude::*;

impl Elastic {
    /// Prepares V_b z_b of the field z = u + T v, whose gradient is the effective strain of Eq. (5).
    pub(super) fn spread(&mut self, u: &[f64], v: Option<(&[f64], f64)>) {
        let n = self.len();
        match v {
            Some((v, relaxation_time)) => self
                .work
                .effective
                .par_iter_mut()
                .zip(u.par_iter().zip(v))
                .for_each(|(z, (u, v))| *z = u + relaxation_time * v),
            None => self.work.effective.copy_from_slice(u),
        }
        let (z, moments) = (&self.work.effective, &self.moments);
        ops::scatter(&self.lattice, &mut self.work.q, |a| vector(z, n, a) * moments[a].volume);
    }

    /// Displacement (or effective displacement) of a ghost.
    #[inline(always)]
    pub(super) fn ghost_value(ghost: &Ghost, z: &[f64], n: usize, offset: &[Vec3]) -> Vec3 {
        ghost.sign.component_mul(&vector(z, n, ghost.partner as usize)) + offset[ghost.group as usize]
    }

    /// Completes the lattice sums of particle a to G_a = sum V_b w (z_b - z_a) (x) L_a X, Eqs. (10),
    /// (13), and to the Laplacian sum V_b w (z_b - z_a).
    #[inline(always)]
    pub(super) fn complete(
        moments: &[Moments],
        mirror: &Mirror,
        offset: &[Vec3],
        z: &[f64],
        a: usize,
        h: &Mat3,
        q: &Vec3,
    ) -> (Mat3, Vec3) {
        let n = moments.len();
        let m = &moments[a];
        let z_a = vector(z, n, a);
        let (mut h, mut q) = (h - z_a * m.first.transpose(), q - z_a * m.zeroth);
        for ghost in mirror.ghosts_of(a) {
            let vw_z =
                Self::ghost_value(ghost, z, n, offset) * (moments[ghost.partner as usize].volume * ghost.w);
            h += vw_z * ghost.x.transpose();
            q += vw_z;
        }
        (h * m.correction, q)
    }

    /// Gradient in the undeformed body of the field that was spread, through `visit(gradient) -> values`,
    /// which end up in the box field `pair`.
    pub(super) fn visit_gradient(&mut self, visit: impl Fn(&Mat3) -> [f64; PAIR_COMPONENTS] + Sync) {
        let Workspace { q, pair, effective, offset, .. } = &mut self.work;
        let (moments, mirror, stretch) = (&self.moments, &self.mirror, &self.stretch);
        let function = |a: usize, h: &Mat3, q: &Vec3| {
            let (g, _) = Self::complete(moments, mirror, offset, effective, a, h, q);
            visit(&undeformed(stretch, a, &g))
        };
        ops::gradient_sums(&self.lattice, q, pair, &PerParticle { lattice: &self.lattice, function });
    }

    /// From the field that was spread to T_a and the part of the force that needs no neighbour's T:
    /// T_a = V_a (sigma_a F_a^T L_a - alpha (lambda + 2 mu) G_a), with F = d xi / d X and G on the lattice.
    pub(super) fn stress_sweep(&mut self) {
        match self.tangent {
            Some(tangent) if self.stretch.is_empty() => self.linear_stress_sweep(&tangent),
            _ => self.general_stress_sweep(),
        }
    }

    /// [`Self::stress_sweep`] for any material.
    fn general_stress_sweep(&mut self) {
        let Workspace { q, pair, effective, offset, .. } = &mut self.work;
        let (moments, mirror, material, kappa) =
            (&self.moments, &self.mirror, &*self.material, self.hourglass);
        let stretch = &self.stretch;
        let function = |a: usize, h: &Mat3, q: &Vec3| {
            let (g, laplacian) = Self::complete(moments, mirror, offset, effective, a, h, q);
            let m = &moments[a];
            let strain = SymTensor::symmetric_part(&undeformed(stretch, a, &g));
            let mut sigma = material.stress(strain).to_matrix(); // Eq. (5)
            if let Some(f) = stretch.get(a) {
                sigma *= f.transpose();
            }
            let t = (sigma * m.correction - g * kappa) * m.volume;
            let own = t * m.first + laplacian * (2.0 * kappa * m.volume);
            let mut out = [0.0; PAIR_COMPONENTS];
            for i in 0..3 {
                for j in 0..3 {
                    out[3 * i + j] = t[(i, j)];
                }
                out[9 + i] = own[i];
            }
            out
        };
        ops::gradient_sums(&self.lattice, q, pair, &PerParticle { lattice: &self.lattice, function });
    }

    /// T of particle `a` after [`Self::stress_sweep`].
    #[inline(always)]
    fn pair_tensor(&self, a: usize) -> Mat3 {
        let (row, x) = self.lattice.row_and_x(a);
        let first = row * PAIR_COMPONENTS * self.lattice.stride + x;
        Mat3::from_fn(|i, j| self.work.pair[first + (3 * i + j) * self.lattice.stride])
    }

    /// Internal force on particle `a` after both sweeps, Eq. (12) in adjoint form, and the share of
    /// it that comes from the walls, with the power of moving walls.
    #[inline(always)]
    pub(super) fn internal_force(&self, a: usize) -> (Vec3, Vec3, f64) {
        let stride = self.lattice.stride;
        let (row, x) = self.lattice.row_and_x(a);
        let component =
            |field: &[f64], components: usize, c: usize| field[(row * components + c) * stride + x];
        let m = &self.moments[a];
        let mut f = Vec3::from_fn(|i, _| {
            component(&self.work.pair, PAIR_COMPONENTS, 9 + i)
                + m.volume * component(&self.work.adjoint, 3, i)
        });
        let ghosts = self.mirror.ghosts_of(a);
        if ghosts.is_empty() {
            return (f, Vec3::zeros(), 0.0);
        }
        let (n, z) = (self.len(), &self.work.effective);
        let (t_a, z_a) = (self.pair_tensor(a), vector(z, n, a));
        let (mut wall, mut power) = (Vec3::zeros(), 0.0);
        for ghost in ghosts {
            let v_b = self.moments[ghost.partner as usize].volume;
            // The partner's T, mirrored: what the images of a put on a.
            let t_b = self.pair_tensor(ghost.partner as usize);
            let t_b_x = ghost.sign.component_mul(&(t_b * ghost.reflection.component_mul(&ghost.x)));
            let image = t_b_x * (m.volume * ghost.w);
            let spring = (Self::ghost_value(ghost, z, n, &self.work.offset) - z_a)
                * (self.hourglass * m.volume * v_b * ghost.w);
            f += image;
            wall += image + t_a * ghost.x * (v_b * ghost.w) + spring * 2.0;
            // The wall holds against the force on the ghost, and works when the ghost moves.
            power -=
                ghost.sign.component_mul(&(image + spring)).dot(&self.work.offset_rate[ghost.group as usize]);
        }
        (f, wall, power)
    }

    /// The first `components` of the box field `pair`, component by component.
    pub(super) fn gather_pair(&self, components: usize) -> Vec<f64> {
        let (n, stride) = (self.len(), self.lattice.stride);
        let mut values = vec![0.0; components * n];
        for a in 0..n {
            let (row, x) = self.lattice.row_and_x(a);
            for c in 0..components {
                values[c * n + a] = self.work.pair[(row * PAIR_COMPONENTS + c) * stride + x];
            }
        }
        values
    }
}

/// A gradient on the lattice as one in the undeformed body, G F.
#[inline(always)]
pub(super) fn undeformed(stretch: &[Mat3], a: usize, g: &Mat3) -> Mat3 {
    stretch.get(a).map_or(*g, |f| g * f)
}

/// Vector `a` of a column of `n`.
#[inline(always)]
pub(super) fn vector(column: &[f64], n: usize, a: usize) -> Vec3 {
    Vec3::new(column[a], column[n + a], column[2 * n + a])
}
