//! Stress by the law of the material, in every particle: P(F, dF/dt), its tangent about a state, and where the body is turned
//! inside out.

use super::Solid;
use super::contrast::Contrast;
use super::correction::{GENERAL, SYMMETRIC};
use super::materials::Materials;
use super::relaxation::{Relaxation, Relaxed};
use super::stress::{Change, Hooke, HookeByPlace, PositiveChange, State, Stress, Total};
use crate::boundary::force_sums::ForceSums;
use crate::boundary::nodal_load::NodalLoad;
use crate::dynamics::Scales;
use crate::material::Material;
use crate::ops::PAIR_COMPONENTS;
use crate::tensor::{Mat3, SymTensor};
use crate::tiles::Tile;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

/// The matrix in the first nine components of a tiled field of [`PAIR_COMPONENTS`].
fn matrix(field: &[Tile], (tile, lane): (usize, usize)) -> Mat3 {
    Mat3::from_fn(|i, j| field[tile * PAIR_COMPONENTS + 3 * i + j].0[lane])
}

impl Solid {
    /// Whether stress is a linear function of strain.
    pub fn is_linear(&self) -> bool {
        self.materials.is_linear()
    }

    /// The longest relaxation time of its materials (s).
    pub fn relaxation_time(&self) -> f64 {
        self.materials.relaxation_time()
    }

    /// Young's modulus of a particle over that of the first material.
    pub(crate) fn modulus(&self, a: usize) -> f64 {
        let (t, lane) = self.lattice.tiles.place(a);
        self.materials.modulus(t, lane)
    }

    /// E V/dx sqrt(3 n) (N): the norm of the forces between particles at a strain of one.
    pub(crate) fn force_scale(&self) -> f64 {
        let stiffest = (0..self.len()).map(|a| self.modulus(a)).fold(1.0, f64::max) * self.stiffening();
        let of_one = self.materials.young_modulus() * self.lattice.cell_volume() / self.lattice.spacing;
        stiffest * of_one * (3.0 * self.len() as f64).sqrt()
    }

    /// Number of the material that holds the larger share of a particle.
    pub fn material_of(&self, a: usize) -> usize {
        self.materials.number(a)
    }

    /// Goes on with another material in the place of number `k`, of the same density and linear if that is, and with `hourglass` as
    /// the modulus (Pa) of the hourglass term in the first one.
    pub fn set_material(&mut self, k: usize, material: &Arc<dyn Material>, hourglass: f64) {
        let materials = self.materials.with_material(k, material, &self.lattice.tiles);
        self.hourglass = hourglass;
        self.set_materials(materials);
        let tiles = &self.lattice.tiles;
        let modulus = |a: usize| self.materials.young_modulus_of(tiles.place(a));
        self.lift.set_young_modulus(modulus, self.lattice.spacing);
    }

    /// Takes these materials with the springs of the hourglass term between them, and the undeformed body as the state of the tangent.
    pub(super) fn set_materials(&mut self, materials: Materials) {
        self.relaxation = Relaxation::new(&materials, &self.lattice.tiles);
        self.contrast = materials
            .places()
            .and_then(|places| Contrast::new(&self.lattice, &self.constants, &places.modulus));
        self.materials = Arc::new(materials);
        self.linearise_undeformed();
    }

    /// Components of strain and stress near the surface: those of symmetric tensors where the law is linear.
    pub(super) fn components(&self) -> usize {
        if self.is_linear() { SYMMETRIC } else { GENERAL }
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
        self.gradient_sweep();
        if self.work.rate.is_empty() {
            self.work.rate = self.lattice.tiles.field(PAIR_COMPONENTS);
        }
        std::mem::swap(&mut self.work.rate, &mut self.work.pair);
    }

    /// From the displacement u and the velocity v at time `t` to T_a and the part of the force that needs no neighbour's T.
    pub(super) fn stress_sweep_at(&mut self, t: f64, u: &[f64], v: &[f64]) {
        let relaxation_time = self.relaxation_time();
        let is_damped = relaxation_time > 0.0 && !self.is_linear();
        if is_damped {
            self.take_rate(t, v);
        }
        // Held faces at this moment: u_D + T du_D/dt, like every other displacement.
        self.lift.set_targets(|m| m.displacement(t) + m.velocity(t) * relaxation_time, |m| m.velocity(t));
        self.spread(u, Some((v, relaxation_time)));
        if self.is_linear() {
            self.linear_stress_sweep(true);
            return;
        }
        let rate = std::mem::take(&mut self.work.rate);
        self.watched_stress_sweep(is_damped.then_some((&rate, relaxation_time)));
        self.work.rate = rate;
    }

    /// Stress sweep of laws for any deformation, with dF/dt and T if there is damping. Remembers whether a particle is turned
    /// inside out.
    fn watched_stress_sweep(&mut self, rate: Option<(&[Tile], f64)>) {
        let (inverted, materials) = (AtomicUsize::new(usize::MAX), Arc::clone(&self.materials));
        let (materials, of) = (&*materials, self.relaxation.take());
        let relaxation = of.as_ref();
        let stress =
            self.stress_sweep(materials, |tiles| Total { materials, tiles, rate, relaxation, inverted });
        self.inverted = stress.first_inverted();
        self.relaxation = of;
    }

    /// A particle that was turned inside out, det F <= 0, at the last evaluation of the stress of a law for any deformation.
    pub fn inverted(&self) -> Option<usize> {
        self.inverted
    }

    /// Takes the displacement u at time `t` as the state about which [`Solid::apply`] is the tangent.
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
        if self.is_linear() {
            return;
        }
        NodalLoad::linearise(&mut self.loads, t, share, Some(u));
        self.spread_share(t, share, u);
        let mut state = std::mem::take(&mut self.work.state);
        let taken = taken.filter(|_| !state.values.is_empty());
        self.visit_sums(false, |_, at, sums| {
            let g = &sums.deformation;
            let mut out = std::array::from_fn(|c| if c < 9 { g[(c / 3, c % 3)] } else { 0.0 });
            let Some(taken) = taken else { return out };
            let (f, (before, factor)) = (Mat3::identity() + g, state.get(at));
            let Some(inverse) = before.try_inverse() else { return out };
            let reached = before.determinant().ln();
            let meant = reached + 3.0 * factor.ln();
            let aim = taken * reached + (1.0 - taken) * meant + inverse.transpose().dot(&(f - before));
            let change = ((aim - f.determinant().ln()) / 3.0).exp_m1();
            if change.is_finite() {
                out[State::FACTOR] = change;
            }
            out
        });
        if state.values.is_empty() {
            state.values = self.lattice.tiles.field(PAIR_COMPONENTS);
        }
        std::mem::swap(&mut state.values, &mut self.work.pair);
        state.is_positive = false;
        state.mixed = self.materials.mixed_tangents(&self.lattice.tiles, |at| {
            let (f, factor) = state.get(at);
            f * factor
        });
        self.work.state = state;
    }

    /// Replaces the tangent, until the next state, by the positive F^-T C : sym(F^-1 dF), C the stiffness of the undeformed
    /// material: it turns with the body, knows its volume, and leaves the stress and loads that follow the surface out; or takes
    /// this back.
    pub fn make_tangent_positive(&mut self, positive: bool) {
        self.work.state.is_positive = positive;
    }

    /// Takes the undeformed body as the state about which [`Solid::apply`] is the tangent.
    pub fn linearise_undeformed(&mut self) {
        NodalLoad::linearise(&mut self.loads, 0.0, 1.0, None);
        let mixed = if self.is_linear() {
            Vec::new()
        } else {
            self.materials.mixed_tangents(&self.lattice.tiles, |_| Mat3::identity())
        };
        self.work.state = State { mixed, ..State::default() };
    }

    /// Deformation gradient of particle `a` in the state of the tangent.
    pub(crate) fn state(&self, a: usize) -> Mat3 {
        let (f, factor) = self.work.state.get(self.lattice.tiles.place(a));
        f * factor
    }

    /// Which particles are turned inside out in the state of the tangent; none under a linear law.
    pub(crate) fn inverted_in_state(&self) -> Vec<bool> {
        (0..self.len()).map(|a| self.state(a).determinant() <= 0.0).collect()
    }

    /// Change of P in particle `a` with the displacement gradient, about the state of the tangent.
    pub(crate) fn stress_change(&self, a: usize, gradient: &Mat3) -> Mat3 {
        let hooke = |g: &Mat3| self.materials.hooke(a, SymTensor::symmetric_part(g)).to_matrix();
        if self.is_linear() {
            return hooke(gradient);
        }
        let f = self.state(a);
        match f.try_inverse().filter(|_| self.work.state.is_positive) {
            Some(back) => back.transpose() * hooke(&(back * gradient)),
            None => self.materials.tangent(a, &f, gradient),
        }
    }

    /// Stress sweep of the tangent of the field that was spread, for changes of F and dF/dt in these proportions.
    pub(super) fn tangent_sweep(&mut self, scales: Scales) {
        if self.is_linear() {
            self.linear_stress_sweep(false);
            return;
        }
        let total = scales.of_stiffness(self.relaxation_time());
        let share = |x: f64| if total == 0.0 { 0.0 } else { x / total };
        let shares = [share(scales.stiffness), share(scales.damping)];
        let (state, materials) = (std::mem::take(&mut self.work.state), Arc::clone(&self.materials));
        let (state_now, materials) = (&state, &*materials);
        let of = self.relaxation.take();
        let relaxation = of.as_ref();
        match (materials.places(), state.is_positive) {
            (_, false) => {
                let state = state_now;
                self.stress_sweep(materials, |tiles| Change { materials, tiles, state, shares, relaxation });
            }
            (None, true) => {
                let hooke = Hooke::new(materials.first_stiffness());
                self.positive_sweep(materials, PositiveChange { hooke, state: state_now }, relaxation);
            }
            (Some(places), true) => {
                let hooke = HookeByPlace(places);
                self.positive_sweep(materials, PositiveChange { hooke, state: state_now }, relaxation);
            }
        }
        self.relaxation = of;
        self.work.state = state;
    }

    /// [`Self::stress_sweep`] of a positive tangent.
    fn positive_sweep(
        &mut self,
        materials: &Materials,
        stress: impl Stress,
        relaxation: Option<&Relaxation>,
    ) {
        match relaxation {
            None => drop(self.stress_sweep(materials, |_| stress)),
            Some(relaxation) => {
                drop(self.stress_sweep(materials, |_| Relaxed { stress, relaxation, whole: false }));
            }
        }
    }

    /// The smallest det F, and the particle that has it, at time `t` with the displacement `u`.
    pub fn smallest_jacobian(&mut self, t: f64, u: &[f64]) -> Option<(usize, f64)> {
        let is_linear = self.is_linear();
        self.spread_displacement(t, u);
        self.visit_sums(false, |_, _, sums| {
            let g = if is_linear { sums.gradient } else { sums.deformation };
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
        let relaxation_time = self.relaxation_time();
        let v = v.filter(|_| relaxation_time > 0.0);
        if let Some(v) = v {
            self.take_rate(t, v);
        }
        let is_damped = v.is_some();
        self.spread_displacement(t, u);
        let (materials, rate) = (Arc::clone(&self.materials), std::mem::take(&mut self.work.rate));
        let (is_linear, relaxation) = (self.is_linear(), self.relaxation.take());
        self.visit_sums(false, |a, at, sums| {
            let f_rate = if is_damped { matrix(&rate, at) } else { Mat3::zeros() };
            let [strain, mut stress] = materials.measures(a, &sums.deformation, &f_rate);
            if let Some(relaxation) = &relaxation {
                stress = relaxation.cauchy(at, stress, &sums.deformation, is_linear);
            }
            std::array::from_fn(|c| if c < 6 { strain.0[c] } else { stress.0[c - 6] })
        });
        self.relaxation = relaxation;
        self.work.rate = if self.is_linear() { Vec::new() } else { rate };
        [self.gather_pair(0..6), self.gather_pair(6..12)]
    }

    /// Internal forces, component by component, at rest with the displacement u, when moved faces have gone that share of their
    /// way up to time `t`.
    pub fn force_at_rest(&mut self, t: f64, share: f64, u: &[f64], force: &mut [f64]) {
        self.spread_share(t, share, u);
        if self.is_linear() {
            self.linear_stress_sweep(true);
        } else {
            self.watched_stress_sweep(None);
        }
        self.adjoint_sweep();
        self.take_forces(force);
    }

    /// Internal forces, component by component, after the adjoint sweep.
    pub(super) fn take_forces(&self, force: &mut [f64]) {
        let n = self.len();
        let (fx, fyz) = force.split_at_mut(n);
        let (fy, fz) = fyz.split_at_mut(n);
        let chunk = super::PARTICLES_PER_SUM;
        (fx.par_chunks_mut(chunk), fy.par_chunks_mut(chunk), fz.par_chunks_mut(chunk))
            .into_par_iter()
            .enumerate()
            .for_each(|(k, (fx, fy, fz))| self.internal_forces(k * chunk, [fx, fy, fz]));
    }

    /// What acts on the body at rest under `load` with the internal forces of the last [`Solid::force_at_rest`].
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

    /// The sum over particles of the first component of the tiled field `pair`.
    pub(super) fn sum_of_particles(&self) -> f64 {
        let of = |a: usize| {
            let (t, lane) = self.lattice.tiles.place(a);
            self.work.pair[t * PAIR_COMPONENTS].0[lane]
        };
        (0..self.len()).map(of).sum()
    }

    /// Solid energy with the displacement u, that of hourglass term and held faces included, when moved faces have gone that
    /// share of their way up to time `t`; infinite where the body is turned inside out.
    pub fn elastic_energy(&mut self, t: f64, share: f64, u: &[f64]) -> f64 {
        self.spread_share(t, share, u);
        let (materials, kappa) = (Arc::clone(&self.materials), self.hourglass);
        let contrast = self.contrast.take();
        self.visit_sums(true, |a, at, sums| {
            // Energy of the one-sided residual u_b - u_a - G_a X; pairs of particles count from both sides.
            // G M G^T = G H^T for H = G M, where L is the (pseudo-)inverse of M.
            let residual = -2.0 * sums.value.dot(&sums.laplacian) - sums.smooth[1].dot(&sums.smooth[0]);
            let own = residual * materials.modulus(at.0, at.1);
            let beside = contrast.as_ref().map_or(0.0, |c| sums.value.dot(&c.pull(at)));
            let springs = 0.5 * kappa * (own - beside);
            let mut out = [0.0; PAIR_COMPONENTS];
            out[0] = sums.volume * (materials.energy_density(a, &sums.deformation) + springs);
            out
        });
        self.contrast = contrast;
        self.sum_of_particles() + self.lift.energy() + kappa * self.lift.folds.energy()
    }
}
