//! The two sweeps of the adjoint formulation: gradient and stress, then the adjoint of the gradient.

use super::linear::Constants;
use super::{Elastic, Workspace};
use crate::boundary::mirror::{Ghost, Mirror};
use crate::moments::Moments;
use crate::ops::{self, PAIR_COMPONENTS, Plain};
use crate::tensor::{Mat3, SymTensor, Vec3};
use crate::tiles::{LANES, Tile, Tiles};
use rayon::prelude::*;
use std::ops::Range;

/// Tiles that one task spreads.
const TILES_A_TASK: usize = 128;

/// A field z that was spread over the tiles as V z.
#[derive(Clone, Copy)]
pub(super) struct Spread<'a> {
    pub(super) tiles: &'a Tiles,
    pub(super) q: &'a [Tile],
    pub(super) constants: &'a Constants,
}

impl Spread<'_> {
    /// V of a particle; zero for one that no sum sees.
    #[inline(always)]
    pub(super) fn volume(&self, a: usize) -> f64 {
        let (t, lane) = self.tiles.place(a);
        self.constants.volume(t)[lane]
    }

    /// Moments of a particle.
    #[inline(always)]
    pub(super) fn moments(&self, a: usize) -> Moments {
        let (t, lane) = self.tiles.place(a);
        self.constants.moments(t, lane)
    }

    /// z of a particle; zero for one that no sum sees.
    #[inline(always)]
    pub(super) fn value(&self, a: usize) -> Vec3 {
        let (t, lane) = self.tiles.place(a);
        let volume = self.constants.volume(t)[lane];
        let inverse = if volume > 0.0 { 1.0 / volume } else { 0.0 };
        Vec3::from_fn(|i, _| self.q[t * 3 + i].0[lane] * inverse)
    }

    /// z of a ghost.
    #[inline(always)]
    pub(super) fn ghost(&self, ghost: &Ghost, offset: &[Vec3]) -> Vec3 {
        ghost.sign.component_mul(&self.value(ghost.partner as usize)) + offset[ghost.group as usize]
    }

    /// z of a ghost as far as the sums of the lattice lack it.
    #[inline(always)]
    pub(super) fn lacking(&self, mirror: &Mirror, ghost: &Ghost, offset: &[Vec3]) -> Vec3 {
        if mirror.is_folded(ghost) { offset[ghost.group as usize] } else { self.ghost(ghost, offset) }
    }
}

/// The sums of a field z at a particle a.
pub(super) struct Sums {
    /// G_a = `first` L_a, on the lattice.
    pub(super) gradient: Mat3,
    /// sum V_b w (z_b - z_a) (x) X.
    pub(super) first: Mat3,
    /// sum V_b w (z_b - z_a).
    pub(super) laplacian: Vec3,
    pub(super) moments: Moments,
}

/// What the gradient of a field that was spread depends on.
pub(super) struct Body<'a> {
    pub(super) mirror: &'a Mirror,
    pub(super) stretch: &'a [Mat3],
    pub(super) spread: Spread<'a>,
    pub(super) offset: &'a [Vec3],
}

impl Body<'_> {
    /// Completes the lattice sums of particle a to G_a = sum V_b w (z_b - z_a) (x) L_a X, Eqs. (10),
    /// (13), and to the Laplacian sum V_b w (z_b - z_a).
    #[inline(always)]
    fn complete(&self, a: usize, h: &Mat3, q: &Vec3) -> Sums {
        let m = self.spread.moments(a);
        let z_a = self.spread.value(a);
        let (mut h, mut q) = (h - z_a * m.first.transpose(), q - z_a * m.zeroth);
        for ghost in self.mirror.ghosts_of(a) {
            let vw_z = self.spread.lacking(self.mirror, &ghost, self.offset)
                * (self.spread.volume(ghost.partner as usize) * ghost.w);
            h += vw_z * ghost.x.transpose();
            q += vw_z;
        }
        Sums { gradient: h * m.correction, first: h, laplacian: q, moments: m }
    }
}

impl Elastic {
    /// Prepares V_b z_b of the field z = u + T v, whose gradient is the effective strain of Eq. (5).
    pub(super) fn spread(&mut self, u: &[f64], v: Option<(&[f64], f64)>) {
        let n = self.len();
        let (tiles, constants) = (&self.lattice.tiles, &self.constants);
        self.work.q.par_chunks_mut(3).with_min_len(TILES_A_TASK).enumerate().for_each(|(t, q)| {
            let (a, mask) = tiles.particles(t);
            let volume = constants.volume(t);
            let count = mask.count_ones() as usize;
            for (i, q) in q.iter_mut().enumerate() {
                let here = i * n + a..i * n + a + count;
                let mut z = [0.0; LANES];
                z[..count].copy_from_slice(&u[here.clone()]);
                if let Some((v, relaxation_time)) = v {
                    for (z, v) in z.iter_mut().zip(&v[here]) {
                        *z += relaxation_time * v;
                    }
                }
                if mask == u8::MAX {
                    for l in 0..LANES {
                        q.0[l] = z[l] * volume[l];
                    }
                } else if count > 0 && mask >> mask.trailing_zeros() == u8::MAX >> (LANES - count) {
                    // Neighbouring lanes; V is zero in the others.
                    let mut shifted = [0.0; 2 * LANES];
                    let first = mask.trailing_zeros() as usize;
                    shifted[first..first + LANES].copy_from_slice(&z);
                    for l in 0..LANES {
                        q.0[l] = shifted[l] * volume[l];
                    }
                } else {
                    q.0 = [0.0; LANES];
                    let occupied = (0..LANES).filter(|l| mask >> l & 1 == 1);
                    occupied.zip(z).for_each(|(l, z)| q.0[l] = z * volume[l]);
                }
            }
        });
    }

    /// The field that was spread.
    pub(super) fn spread_field(&self) -> Spread<'_> {
        Spread { tiles: &self.lattice.tiles, q: &self.work.q, constants: &self.constants }
    }

    /// Leaves `visit(body, particle, sums)` of the field that was spread in the tiled field `pair`.
    pub(super) fn visit_sums(
        &mut self,
        visit: impl Fn(&Body<'_>, usize, &Sums) -> [f64; PAIR_COMPONENTS] + Sync,
    ) {
        let Workspace { q, pair, offset, .. } = &mut self.work;
        ops::gradient_sums(&self.lattice, self.mirror.folds(), q, pair, &Plain);
        let tiles = &self.lattice.tiles;
        let body = Body {
            mirror: &self.mirror,
            stretch: &self.stretch,
            spread: Spread { tiles, q, constants: &self.constants },
            offset,
        };
        ops::per_particle(tiles, pair, |a, h, q| visit(&body, a, &body.complete(a, h, q)));
    }

    /// Gradient in the undeformed body of the field that was spread, through `visit(gradient) -> values`,
    /// which end up in the tiled field `pair`.
    pub(super) fn visit_gradient(&mut self, visit: impl Fn(&Mat3) -> [f64; PAIR_COMPONENTS] + Sync) {
        self.visit_sums(|body, a, sums| visit(&undeformed(body.stretch, a, &sums.gradient)));
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
        let (material, kappa) = (std::sync::Arc::clone(&self.material), self.hourglass);
        self.visit_sums(|body, a, sums| {
            let (g, m) = (&sums.gradient, &sums.moments);
            let strain = SymTensor::symmetric_part(&undeformed(body.stretch, a, g));
            let mut sigma = material.stress(strain).to_matrix(); // Eq. (5)
            if let Some(f) = body.stretch.get(a) {
                sigma *= f.transpose();
            }
            let t = (sigma * m.correction - g * kappa) * m.volume;
            let own = t * m.first + sums.laplacian * (2.0 * kappa * m.volume);
            let mut out = [0.0; PAIR_COMPONENTS];
            for i in 0..3 {
                for j in 0..3 {
                    out[3 * i + j] = t[(i, j)];
                }
                out[9 + i] = own[i];
            }
            out
        });
    }

    /// From T_a to the sums of the second sweep, the adjoint of the gradient.
    pub(super) fn adjoint_sweep(&mut self) {
        let Workspace { q, pair, adjoint, .. } = &mut self.work;
        let out = if adjoint.is_empty() { q } else { adjoint };
        ops::adjoint_sums(&self.lattice, self.mirror.folds(), pair, out);
    }

    /// T of particle `a` after [`Self::stress_sweep`].
    #[inline(always)]
    fn pair_tensor(&self, a: usize) -> Mat3 {
        let (t, lane) = self.lattice.tiles.place(a);
        Mat3::from_fn(|i, j| self.work.pair[t * PAIR_COMPONENTS + 3 * i + j].0[lane])
    }

    /// Internal forces on the particles from `first` on after both sweeps, Eq. (12) in adjoint form,
    /// component by component; the share of them that comes from the walls, and the power of moving
    /// walls.
    #[inline(always)]
    pub(super) fn internal_forces(&self, first: usize, force: [&mut [f64]; 3]) -> (Vec3, f64) {
        let [fx, fy, fz] = force;
        let mut power = 0.0;
        let others = self.mirror.has_others();
        let Workspace { q, adjoint, .. } = &self.work;
        let sums = if adjoint.is_empty() { q } else { adjoint };
        let moving = self.work.offset_rate.iter().any(|rate| *rate != Vec3::zeros());
        self.lattice.tiles.for_each_run(first..first + fx.len(), |a, t, lane, count| {
            let at = a - first;
            let volume = self.constants.volume(t);
            for (i, f) in [&mut *fx, &mut *fy, &mut *fz].into_iter().enumerate() {
                let own = &self.work.pair[t * PAIR_COMPONENTS + 9 + i].0;
                let adjoint = &sums[t * 3 + i].0;
                let f = &mut f[at..at + count];
                if let Ok(f) = <&mut [f64; LANES]>::try_from(&mut *f) {
                    for l in 0..LANES {
                        f[l] = own[l] + volume[l] * adjoint[l];
                    }
                } else {
                    for (l, f) in (lane..).zip(f) {
                        *f = own[l] + volume[l] * adjoint[l];
                    }
                }
            }
            if others && self.constants.near_wall(t) {
                for l in 0..count {
                    let image = self.images(a + l);
                    (fx[at + l], fy[at + l], fz[at + l]) =
                        (fx[at + l] + image.x, fy[at + l] + image.y, fz[at + l] + image.z);
                }
            }
            if moving && self.constants.near_wall(t) {
                power += (a..a + count).map(|a| self.wall_power(a)).sum::<f64>();
            }
        });
        // Forces between particles have no resultant: what is left comes from the walls.
        let wall = if self.mirror.is_empty() {
            Vec3::zeros()
        } else {
            Vec3::new(fx.iter().sum(), fy.iter().sum(), fz.iter().sum())
        };
        (wall, power)
    }

    /// What the image of a ghost's partner puts on particle `a`: the partner's T, mirrored.
    #[inline(always)]
    fn image(&self, a: usize, ghost: &Ghost) -> Vec3 {
        let t_b = self.pair_tensor(ghost.partner as usize);
        let t_b_x = ghost.sign.component_mul(&(t_b * ghost.reflection.component_mul(&ghost.x)));
        t_b_x * (self.spread_field().volume(a) * ghost.w)
    }

    /// What images that the sums of the lattice do not see put on particle `a`.
    fn images(&self, a: usize) -> Vec3 {
        let others = self.mirror.ghosts_of(a).filter(|g| !self.mirror.is_folded(g));
        others.map(|ghost| self.image(a, &ghost)).sum()
    }

    /// Power of moving walls on particle `a`: a wall holds against the force on a ghost, and works when
    /// the ghost moves.
    fn wall_power(&self, a: usize) -> f64 {
        let spread = self.spread_field();
        let volume = spread.volume(a);
        let z_a = spread.value(a);
        let of_ghost = |ghost: Ghost| {
            let v_b = spread.volume(ghost.partner as usize);
            let spring =
                (spread.ghost(&ghost, &self.work.offset) - z_a) * (self.hourglass * volume * v_b * ghost.w);
            let on_ghost = ghost.sign.component_mul(&(self.image(a, &ghost) + spring));
            -on_ghost.dot(&self.work.offset_rate[ghost.group as usize])
        };
        self.mirror.ghosts_of(a).map(of_ghost).sum()
    }

    /// Those components of the tiled field `pair`, component by component.
    pub(super) fn gather_pair(&self, components: Range<usize>) -> Vec<f64> {
        let n = self.len();
        let mut values = vec![0.0; components.len() * n];
        for a in 0..n {
            let (t, lane) = self.lattice.tiles.place(a);
            for (k, c) in components.clone().enumerate() {
                values[k * n + a] = self.work.pair[t * PAIR_COMPONENTS + c].0[lane];
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
