//! The sums over neighbours: gradients, energy, and the exact adjoint of the gradient.

use super::configuration::{Configuration, out_of_plane};
use crate::material::FiniteStrain;
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;

/// Points that a thread takes at once.
const CHUNK: usize = 64;

/// Stress at the particles and the field whose hourglass residual pulls at them.
#[derive(Clone, Copy, Debug)]
pub struct Stressed<'a> {
    /// First Piola-Kirchhoff stress of each particle.
    pub piola: &'a [Mat3],
    /// alpha (lambda + 2 mu).
    pub hourglass: f64,
    /// The field z at all points whose residual z_ba - G_a X_ba the hourglass term resists.
    pub field: &'a [Vec3],
    /// Its gradient G at the particles.
    pub gradient: &'a [Mat3],
}

impl<const D: usize> Configuration<D> {
    /// Gradients of a field of points with respect to X at all particles.
    pub fn gradients(&self, z: &[Vec3], out: &mut [Mat3]) {
        let set = |(a, g): (usize, &mut Mat3)| *g = self.gradient(a, z);
        out.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(set);
    }

    /// Deformation gradients F of positions x of points.
    pub fn deformation(&self, x: &[Vec3], out: &mut [Mat3]) {
        let set = |(a, g): (usize, &mut Mat3)| *g = self.gradient(a, x) + out_of_plane::<D>();
        out.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(set);
    }

    /// Energy of each particle, that of the hourglass term included: m/rho_0 W(F) +
    /// 1/2 sum k_ab |x_ba - F_a X_ba|^2, k_ab = alpha (lambda + 2 mu) V_a V_b w. As F_a X_ba =
    /// F_inc F_0 X_ba, the term remembers what it held before a remesh.
    pub fn energies(
        &self,
        material: &dyn FiniteStrain,
        hourglass: f64,
        x: &[Vec3],
        f: &[Mat3],
        out: &mut [f64],
    ) {
        out.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(a, e)| {
            let mut springs = 0.0;
            for q in self.pairs.numbers(a) {
                let b = self.pairs.neighbour(q);
                let residual = x[b] - x[a] - f[a] * (self.reference[b] - self.reference[a]);
                springs += self.volume[b] * self.weight[q] * residual.norm_squared();
            }
            *e = self.reference_volume[a] * material.energy(&f[a])
                + 0.5 * hourglass * self.volume[a] * springs;
        });
    }

    /// A_a = (m/rho_0 P - sum k_ab (z_ba - G_a X_ba) (x) X_ba) F_0^T L_a, which the adjoint of the gradient
    /// takes.
    pub fn pair_tensors(&self, s: &Stressed<'_>, out: &mut [Mat3]) {
        out.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(a, t)| {
            let mut springs = Mat3::zeros();
            if s.hourglass > 0.0 {
                let (z_a, x_a, g) = (s.field[a], self.reference[a], &s.gradient[a]);
                for q in self.pairs.numbers(a) {
                    let b = self.pairs.neighbour(q);
                    let x = self.reference[b] - x_a;
                    let residual = s.field[b] - z_a - g * x;
                    springs += residual * (self.volume[b] * self.weight[q] * x).transpose();
                }
                springs *= s.hourglass * self.volume[a];
            }
            let stress = s.piola[a] * self.reference_volume[a] - springs;
            *t = stress * self.first_gradient[a].transpose() * self.correction[a];
        });
    }

    /// Internal force on all points, Eq. (12) in adjoint form: minus the derivative of the energy for
    /// P = dW/dF. `tensors` are those of [`Self::pair_tensors`].
    pub fn forces(&self, s: &Stressed<'_>, tensors: &[Mat3], out: &mut [Vec3]) {
        let n = self.len;
        out.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(p, force)| {
            let (xi, v) = (self.nodes[p], self.volume[p]);
            let mut f = Vec3::zeros();
            for q in self.pairs.numbers(p) {
                let b = self.pairs.neighbour(q);
                // Ghosts have no energy: two of them do not meet.
                if p >= n && b >= n {
                    continue;
                }
                let mut pull = Vec3::zeros();
                let (mut residuals, mut shared) = (0.0, Mat3::zeros());
                let mut tensor = Mat3::zeros();
                if p < n {
                    tensor += tensors[p] * self.volume[b];
                    shared += s.gradient[p];
                    residuals += 1.0;
                }
                if b < n {
                    tensor += tensors[b] * v;
                    shared += s.gradient[b];
                    residuals += 1.0;
                }
                pull += tensor * (self.nodes[b] - xi);
                if s.hourglass > 0.0 {
                    let of_field = (s.field[b] - s.field[p]) * residuals;
                    let residual = of_field - shared * (self.reference[b] - self.reference[p]);
                    pull += residual * (s.hourglass * v * self.volume[b]);
                }
                f += pull * self.weight[q];
            }
            *force = f;
        });
    }
}
