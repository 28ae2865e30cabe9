//! Stress by the law of the material, in every particle: P(F, dF/dt), its tangent about a state, and where the body is turned
//! inside out.

use super::Elastic;
use super::correction::{GENERAL, SYMMETRIC};
use crate::boundary::force_sums::ForceSums;
use crate::dynamics::Scales;
use crate::material::Stiffness;
use crate::ops::PAIR_COMPONENTS;
use crate::tensor::{Mat3, SymTensor};
use crate::tiles::{Tile, Tiles};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering as Memory};

/// The matrix in the first nine components of a tiled field of [`PAIR_COMPONENTS`].
#[inline(always)]
fn matrix(field: &[Tile], (tile, lane): (usize, usize)) -> Mat3 {
    Mat3::from_fn(|i, j| field[tile * PAIR_COMPONENTS + 3 * i + j].0[lane])
}

/// F^-T C : sym(F^-1 dF).
fn positive_change(stiffness: &Stiffness, f: &Mat3, df: &Mat3) -> Mat3 {
    let inverse = f.try_inverse().unwrap_or_else(Mat3::identity);
    let strain = SymTensor::symmetric_part(&(inverse * df));
    inverse.transpose() * stiffness.stress(strain).to_matrix()
}

/// Component of the state of the tangent that multiplies F.
const FACTOR: usize = 9;

/// What multiplies F in the state of the tangent.
#[inline(always)]
fn factor(state: &[Tile], (tile, lane): (usize, usize)) -> f64 {
    state[tile * PAIR_COMPONENTS + FACTOR].0[lane]
}

/// The components of a matrix, row by row, as a result of a sweep.
fn components_of(m: &Mat3) -> [f64; PAIR_COMPONENTS] {
    std::array::from_fn(|c| if c < 9 { m[(c / 3, c % 3)] } else { 0.0 })
}

impl Elastic {
    /// Whether stress is a linear function of strain.
    pub fn is_linear(&self) -> bool {
        self.linear
    }

    /// Components of strain and stress near the surface: those of symmetric tensors where the law is linear.
    pub(super) fn components(&self) -> usize {
        if self.linear { SYMMETRIC } else { GENERAL }
    }

    /// Spreads u at time `t`, with held faces where they are.
    pub(super) fn spread_displacement(&mut self, t: f64, u: &[f64]) {
        self.spread_share(t, 1.0, u);
    }

    /// Spreads u at time `t`, with held faces as far as that share of their way.
    fn spread_share(&mut self, t: f64, share: f64, u: &[f64]) {
        self.lift.set_targets(|m| m.displacement(t) * share, |m| m.velocity(t));
        self.spread(u, None);
    }

    /// Leaves dF/dt = grad v at time `t` in the tiled field `rate`.
    fn take_rate(&mut self, t: f64, v: &[f64]) {
        self.lift.set_targets(|m| m.velocity(t), |m| m.velocity(t));
        self.spread(v, None);
        self.visit_sums(false, |_, _, sums, _| components_of(&sums.deformation));
        if self.work.rate.is_empty() {
            self.work.rate = self.lattice.tiles.field(PAIR_COMPONENTS);
        }
        std::mem::swap(&mut self.work.rate, &mut self.work.pair);
    }

    /// From the displacement u and the velocity v at time `t` to T_a and the part of the force that needs no neighbour's T.
    pub(super) fn stress_sweep_at(&mut self, t: f64, u: &[f64], v: &[f64]) {
        let relaxation_time = self.material.relaxation_time();
        let is_damped = relaxation_time > 0.0 && !self.linear;
        if is_damped {
            self.take_rate(t, v);
        }
        // Held faces at this moment: u_D + T du_D/dt, like every other displacement.
        self.lift.set_targets(|m| m.displacement(t) + m.velocity(t) * relaxation_time, |m| m.velocity(t));
        self.spread(u, Some((v, relaxation_time)));
        let material = Arc::clone(&self.material);
        let Some(law) = material.law().finite_strain() else {
            self.stress_sweep();
            return;
        };
        let rate = std::mem::take(&mut self.work.rate);
        self.watched_stress_sweep(|tiles, a, g| {
            if !is_damped {
                let f = Mat3::identity() + g;
                return (f, law.first_piola(&f));
            }
            let f_rate = matrix(&rate, tiles.place(a));
            // The gradient is that of u + T v.
            let f = Mat3::identity() + g - f_rate * relaxation_time;
            (f, law.first_piola(&f) + law.viscous_piola(&f, &f_rate))
        });
        self.work.rate = rate;
    }

    /// Stress sweep with `stress` giving F and P of a particle from the gradient of the field that was spread. Remembers whether
    /// one is turned inside out.
    fn watched_stress_sweep(&mut self, stress: impl Fn(&Tiles, usize, &Mat3) -> (Mat3, Mat3) + Sync) {
        let inverted = AtomicUsize::new(usize::MAX);
        self.general_stress_sweep(|tiles, a, g| {
            let (f, piola) = stress(tiles, a, g);
            // What is not a number was turned inside out a stage before.
            if f.determinant().partial_cmp(&0.0) != Some(Ordering::Greater) {
                inverted.fetch_min(a, Memory::Relaxed);
            }
            piola
        });
        let first = inverted.into_inner();
        self.inverted = (first != usize::MAX).then_some(first);
    }

    /// A particle that was turned inside out, det F <= 0, at the last evaluation of the stress of a law for any deformation.
    pub fn inverted(&self) -> Option<usize> {
        self.inverted
    }

    /// Takes the displacement u at time `t` as the state about which [`Elastic::apply`] is the tangent.
    pub fn linearise(&mut self, t: f64, u: &[f64]) {
        self.linearise_for_newton(t, 1.0, u, None);
    }

    /// [`linearise`](Self::linearise) for Newton's method, when moved faces have gone that share of their way up to time `t`; `taken`
    /// is the part of the method's last step that was taken, from the state of the last call; nothing at the first step.
    ///
    /// The tangent is that at the volume ln J = ln J_k + F_k^-T : (F - F_k) which the last step meant to reach from F_k, not at the
    /// one that it reached. Under a nearly incompressible law the difference is a large pressure, by which the tangent would lead
    /// nowhere; so the method is that of mixed elements, whose pressure is an unknown of its own.
    pub fn linearise_for_newton(&mut self, t: f64, share: f64, u: &[f64], taken: Option<f64>) {
        if self.linear {
            return;
        }
        self.spread_share(t, share, u);
        let mut state = std::mem::take(&mut self.work.state);
        let taken = taken.filter(|_| !state.is_empty());
        self.visit_sums(false, |body, a, sums, _| {
            let f = Mat3::identity() + sums.deformation;
            let mut out = components_of(&f);
            out[FACTOR] = 1.0;
            let Some(taken) = taken else { return out };
            let at = body.spread.tiles.place(a);
            let before = matrix(&state, at);
            let Some(inverse) = before.try_inverse() else { return out };
            let reached = before.determinant().ln();
            let meant = reached + 3.0 * factor(&state, at).ln();
            let aim = taken * reached + (1.0 - taken) * meant + inverse.transpose().dot(&(f - before));
            let change = ((aim - f.determinant().ln()) / 3.0).exp();
            if change.is_finite() {
                out[FACTOR] = change;
            }
            out
        });
        if state.is_empty() {
            state = self.lattice.tiles.field(PAIR_COMPONENTS);
        }
        std::mem::swap(&mut state, &mut self.work.pair);
        self.work.state = state;
        self.positive = false;
    }

    /// Replaces the tangent, until the next state, by the positive F^-T C : sym(F^-1 dF), C the stiffness of the undeformed
    /// material: it turns with the body, knows its volume, and leaves the stress out; or takes this back.
    pub fn make_tangent_positive(&mut self, positive: bool) {
        self.positive = positive;
    }

    /// Takes the undeformed body as the state about which [`Elastic::apply`] is the tangent.
    pub fn linearise_undeformed(&mut self) {
        self.work.state = Vec::new();
        self.positive = false;
    }

    /// Deformation gradient of particle `a` in the state of the tangent.
    pub(crate) fn state(&self, a: usize) -> Mat3 {
        if self.work.state.is_empty() {
            Mat3::identity()
        } else {
            let at = self.lattice.tiles.place(a);
            matrix(&self.work.state, at) * factor(&self.work.state, at)
        }
    }

    /// Change of P in particle `a` with the displacement gradient, about the state of the tangent.
    pub(crate) fn stress_change(&self, a: usize, gradient: &Mat3) -> Mat3 {
        match self.material.law().finite_strain() {
            None => self.stiffness.stress(SymTensor::symmetric_part(gradient)).to_matrix(),
            Some(_) if self.positive => positive_change(&self.stiffness, &self.state(a), gradient),
            Some(law) => law.tangent(&self.state(a), gradient),
        }
    }

    /// Stress sweep of the tangent of the field that was spread, for changes of F and dF/dt in these proportions.
    pub(super) fn tangent_sweep(&mut self, scales: Scales) {
        let material = Arc::clone(&self.material);
        let Some(law) = material.law().finite_strain() else {
            self.stress_sweep();
            return;
        };
        let total = scales.of_stiffness(material.relaxation_time());
        if total == 0.0 {
            self.general_stress_sweep(|_, _, _| Mat3::zeros());
            return;
        }
        let (stiffness, damping) = (scales.stiffness / total, scales.damping / total);
        let state = std::mem::take(&mut self.work.state);
        let (one, undeformed, is_positive) = (Mat3::identity(), self.stiffness, self.positive);
        self.general_stress_sweep(|tiles, a, g| {
            let at = tiles.place(a);
            let f = if state.is_empty() { one } else { matrix(&state, at) * factor(&state, at) };
            if is_positive {
                return positive_change(&undeformed, &f, g);
            }
            let elastic = law.tangent(&f, g) * stiffness;
            if damping > 0.0 { elastic + law.viscous_piola(&f, g) * damping } else { elastic }
        });
        self.work.state = state;
    }

    /// The smallest det F, and the particle that has it, at time `t` with the displacement `u`.
    pub fn smallest_jacobian(&mut self, t: f64, u: &[f64]) -> Option<(usize, f64)> {
        let is_linear = self.linear;
        self.spread_displacement(t, u);
        self.visit_sums(false, |body, a, sums, _| {
            let g =
                if is_linear { super::undeformed(body.stretch, a, &sums.gradient) } else { sums.deformation };
            let mut out = [0.0; PAIR_COMPONENTS];
            out[0] = (Mat3::identity() + g).determinant();
            out
        });
        let jacobian = |a: usize| {
            let (tile, lane) = self.lattice.tiles.place(a);
            self.work.pair[tile * PAIR_COMPONENTS].0[lane]
        };
        (0..self.len()).map(|a| (a, jacobian(a))).min_by(|p, q| p.1.total_cmp(&q.1))
    }

    /// Strain and Cauchy stress (Pa) of every particle, component by component (6 n values each), at time `t`; without v the stress
    /// lacks its viscous part.
    pub(super) fn strain_and_stress(&mut self, t: f64, u: &[f64], v: Option<&[f64]>) -> [Vec<f64>; 2] {
        let relaxation_time = self.material.relaxation_time();
        let v = v.filter(|_| relaxation_time > 0.0);
        if let Some(v) = v {
            self.take_rate(t, v);
        }
        let is_damped = v.is_some();
        self.spread_displacement(t, u);
        let (material, rate) = (Arc::clone(&self.material), std::mem::take(&mut self.work.rate));
        let law = material.law();
        self.visit_sums(false, |body, a, sums, _| {
            let none = Mat3::zeros();
            let f_rate = if is_damped { matrix(&rate, body.spread.tiles.place(a)) } else { none };
            let (strain, stress) = law.measures(relaxation_time, &sums.deformation, &f_rate);
            std::array::from_fn(|c| if c < 6 { strain.0[c] } else { stress.0[c - 6] })
        });
        self.work.rate = if self.linear { Vec::new() } else { rate };
        [self.gather_pair(0..6), self.gather_pair(6..12)]
    }

    /// Internal forces, component by component, at rest with the displacement u, when moved faces have gone that share of their
    /// way up to time `t`.
    pub fn force_at_rest(&mut self, t: f64, share: f64, u: &[f64], force: &mut [f64]) {
        self.spread_share(t, share, u);
        let material = Arc::clone(&self.material);
        match material.law().finite_strain() {
            None => self.stress_sweep(),
            Some(law) => self.watched_stress_sweep(|_, _, g| {
                let f = Mat3::identity() + g;
                (f, law.first_piola(&f))
            }),
        }
        self.adjoint_sweep();
        let n = self.len();
        let (fx, fyz) = force.split_at_mut(n);
        let (fy, fz) = fyz.split_at_mut(n);
        let chunk = super::PARTICLES_A_SUM;
        (fx.par_chunks_mut(chunk), fy.par_chunks_mut(chunk), fz.par_chunks_mut(chunk))
            .into_par_iter()
            .enumerate()
            .for_each(|(k, (fx, fy, fz))| self.internal_forces(k * chunk, [fx, fy, fz]));
    }

    /// What acts on the body at rest under `load` with the internal forces of the last [`Elastic::force_at_rest`].
    pub fn sums_at_rest(&self, load: &[f64], force: &[f64]) -> ForceSums {
        let n = self.len();
        let mut sums = ForceSums { reaction: self.lift.reaction().0, ..ForceSums::default() };
        for (i, load) in load.chunks(n.max(1)).enumerate() {
            sums.load[i] = load.iter().sum();
        }
        let mut held = vec![0.0; 3 * n];
        for p in &self.fixed.particles {
            for i in (0..3).filter(|&i| p.fix[i]) {
                let at = i * n + p.particle;
                held[at] = -(force[at] + load[at]);
            }
        }
        for (i, held) in held.chunks(n.max(1)).enumerate() {
            sums.reaction[i] += held.iter().sum::<f64>();
        }
        sums
    }

    /// Elastic energy with the displacement u, that of hourglass term and held faces included, when moved faces have gone that
    /// share of their way up to time `t`; infinite where the body is turned inside out.
    pub fn elastic_energy(&mut self, t: f64, share: f64, u: &[f64]) -> f64 {
        self.spread_share(t, share, u);
        let (material, kappa) = (Arc::clone(&self.material), self.hourglass);
        let law = material.law();
        self.visit_sums(true, |_, _, sums, _| {
            // Energy of the one-sided residual u_b - u_a - G_a X; pairs of particles count from both sides.
            // G M G^T = G H^T for H = G M, where L is the (pseudo-)inverse of M.
            let residual = -2.0 * sums.value.dot(&sums.laplacian) - sums.smooth[1].dot(&sums.smooth[0]);
            let mut out = [0.0; PAIR_COMPONENTS];
            out[0] = sums.moments.volume * (law.energy_density(&sums.deformation) + 0.5 * kappa * residual);
            out
        });
        let of_particles: f64 = (0..self.len())
            .map(|a| {
                let (t, lane) = self.lattice.tiles.place(a);
                self.work.pair[t * PAIR_COMPONENTS].0[lane]
            })
            .sum();
        of_particles + self.lift.energy()
    }
}
