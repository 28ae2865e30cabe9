//! The viscoelastic solid in the adjoint formulation: the corrected gradient of Eq. (10) and, for the
//! divergence of Eq. (12), its exact adjoint, so that the force is the derivative of a discrete energy
//! and a free surface needs no force of its own (Eq. 14).

use super::{Dynamics, Energy, ForceSums};
use crate::boundary::fixed::Fixed;
use crate::boundary::mirror::{Ghost, Mirror};
use crate::boundary::nodal_load::NodalLoad;
use crate::lattice::Lattice;
use crate::material::Material;
use crate::moments::{Moments, moments};
use crate::ops::{self, PAIR_COMPONENTS};
use crate::particles::{Column, Field, Particles};
use crate::tensor::{Mat3, SymTensor, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Particles that one partial sum covers: fixed, so that sums do not depend on the thread count.
const PARTICLES_A_SUM: usize = 1024;

/// A solid body on its lattice.
#[derive(Clone, Debug)]
pub struct Elastic {
    /// The lattice of the last remesh.
    pub lattice: Lattice,
    /// Moments of all particles.
    pub moments: Vec<Moments>,
    /// Mirror ghosts of clamped faces.
    pub mirror: Mirror,
    /// Particles held or moved.
    pub fixed: Fixed,
    /// Loads.
    pub loads: Vec<NodalLoad>,
    /// Mass of each particle.
    pub mass: Vec<f64>,
    /// Constitutive law.
    pub material: Arc<dyn Material>,
    /// alpha (lambda + 2 mu): stiffness of the hourglass term.
    pub hourglass: f64,
    work: Workspace,
}

/// Derived fields that every evaluation of the rates reuses.
#[derive(Clone, Debug)]
struct Workspace {
    /// V (u + T v), box field of 3.
    q: Vec<f64>,
    /// T_a and the force that needs no neighbour's T, box field of 12.
    pair: Vec<f64>,
    /// sum w T_b X, box field of 3.
    adjoint: Vec<f64>,
    /// u + T v, component by component.
    effective: Vec<f64>,
    /// Load at this moment, component by component.
    load: Vec<f64>,
    /// (1 - s) u_D of each ghost group, and its rate.
    offset: Vec<Vec3>,
    offset_rate: Vec<Vec3>,
    sums: Vec<ForceSums>,
}

impl Elastic {
    /// A body of particles with these volumes at the nodes of `lattice`.
    pub fn new(
        lattice: Lattice,
        volume: &[f64],
        mirror: Mirror,
        fixed: Fixed,
        material: Arc<dyn Material>,
        hourglass_weight: f64,
    ) -> Self {
        let n = lattice.len();
        let moments = moments(&lattice, volume, &mirror);
        let groups = mirror.group_count();
        let work = Workspace {
            q: ops::box_field(&lattice, 3),
            pair: ops::box_field(&lattice, PAIR_COMPONENTS),
            adjoint: ops::box_field(&lattice, 3),
            effective: vec![0.0; 3 * n],
            load: vec![0.0; 3 * n],
            offset: vec![Vec3::zeros(); groups],
            offset_rate: vec![Vec3::zeros(); groups],
            sums: vec![ForceSums::default(); n.div_ceil(PARTICLES_A_SUM)],
        };
        Self {
            moments,
            mass: volume.iter().map(|v| v * material.density()).collect(),
            hourglass: hourglass_weight * material.p_wave_modulus(),
            lattice,
            mirror,
            fixed,
            loads: Vec::new(),
            material,
            work,
        }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.lattice.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.lattice.is_empty()
    }

    /// Prepares V_b z_b of the field z = u + T v, whose gradient is the effective strain of Eq. (5).
    fn spread(&mut self, u: &[f64], v: Option<(&[f64], f64)>) {
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
    fn ghost_value(ghost: &Ghost, z: &[f64], n: usize, offset: &[Vec3]) -> Vec3 {
        ghost.sign.component_mul(&vector(z, n, ghost.partner as usize)) + offset[ghost.group as usize]
    }

    /// Completes the lattice sums of particle a to G_a = sum V_b w (z_b - z_a) (x) L_a X, Eqs. (10),
    /// (13), and to the Laplacian sum V_b w (z_b - z_a).
    #[inline(always)]
    fn complete(
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

    /// Gradient of the field that was spread, through `visit(a, G_a, Laplacian_a) -> values`, which
    /// end up in the box field `pair`.
    fn visit_gradient(&mut self, visit: impl Fn(usize, &Mat3, &Vec3) -> [f64; PAIR_COMPONENTS] + Sync) {
        let Workspace { q, pair, effective, offset, .. } = &mut self.work;
        let (moments, mirror) = (&self.moments, &self.mirror);
        ops::gradient_sums(&self.lattice, q, pair, |a, h, q| {
            let (g, laplacian) = Self::complete(moments, mirror, offset, effective, a, h, q);
            visit(a, &g, &laplacian)
        });
    }

    /// From the field that was spread to T_a and the part of the force that needs no neighbour's T:
    /// T_a = V_a (sigma_a L_a - alpha (lambda + 2 mu) G_a).
    fn stress_sweep(&mut self) {
        let Workspace { q, pair, effective, offset, .. } = &mut self.work;
        let (moments, mirror, material, kappa) =
            (&self.moments, &self.mirror, &*self.material, self.hourglass);
        ops::gradient_sums(&self.lattice, q, pair, |a, h, q| {
            let m = &moments[a];
            let (g, laplacian) = Self::complete(moments, mirror, offset, effective, a, h, q);
            let sigma = material.stress(SymTensor::symmetric_part(&g)).to_matrix(); // Eq. (5)
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
        });
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
    fn internal_force(&self, a: usize) -> (Vec3, Vec3, f64) {
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
            // With the signs it is minus the derivative of the energy by the ghost's offset.
            power -=
                ghost.sign.component_mul(&(image + spring)).dot(&self.work.offset_rate[ghost.group as usize]);
        }
        (f, wall, power)
    }

    /// Internal force of the displacement field `u` (component by component) into `force`, with every
    /// wall at rest: -K u for a linear material. Components that are held get zero.
    pub fn force_of(&mut self, u: &[f64], force: &mut [f64]) {
        let n = self.len();
        self.work.offset.fill(Vec3::zeros());
        self.work.offset_rate.fill(Vec3::zeros());
        self.spread(u, None);
        self.stress_sweep();
        ops::adjoint_sums(&self.lattice, &self.work.pair, &mut self.work.adjoint);
        let (fx, fyz) = force.split_at_mut(n);
        let (fy, fz) = fyz.split_at_mut(n);
        fx.par_iter_mut().zip(fy).zip(fz).enumerate().for_each(|(a, ((fx, fy), fz))| {
            let f = self.internal_force(a).0;
            (*fx, *fy, *fz) = (f.x, f.y, f.z);
        });
        self.fixed.zero(force, n);
    }

    /// Strain e = sym grad u of every particle, component by component (6 n values).
    pub fn strain(&mut self, t: f64, u: &[f64]) -> Vec<f64> {
        self.mirror.offsets(&mut self.work.offset, |m| m.displacement(t));
        self.spread(u, None);
        self.visit_gradient(|_, g, _| {
            let mut out = [0.0; PAIR_COMPONENTS];
            out[..6].copy_from_slice(&SymTensor::symmetric_part(g).0);
            out
        });
        self.gather_pair(6)
    }

    /// The first `components` of the box field `pair`, component by component.
    fn gather_pair(&self, components: usize) -> Vec<f64> {
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

/// Vector `a` of a column of `n`.
#[inline(always)]
fn vector(column: &[f64], n: usize, a: usize) -> Vec3 {
    Vec3::new(column[a], column[n + a], column[2 * n + a])
}

impl Dynamics for Elastic {
    fn integrated(&self) -> &'static [Field] {
        &[Field::Displacement, Field::Velocity]
    }

    fn rates(&mut self, t: f64, particles: &Particles, rates: &mut [Column]) -> ForceSums {
        let n = self.len();
        let relaxation_time = self.material.relaxation_time();
        let (u, v) = (particles.column(Field::Displacement), particles.column(Field::Velocity));
        // Walls at this moment: u_D + T du_D/dt, like every other displacement.
        self.mirror.offsets(&mut self.work.offset, |m| m.displacement(t) + m.velocity(t) * relaxation_time);
        self.mirror.offsets(&mut self.work.offset_rate, |m| m.velocity(t));
        NodalLoad::sum(&self.loads, t, &mut self.work.load);

        self.spread(u.values(), Some((v.values(), relaxation_time)));
        self.stress_sweep(); // Eqs. (10), (13), (5)
        ops::adjoint_sums(&self.lattice, &self.work.pair, &mut self.work.adjoint); // Eq. (12)

        let [du, dv] = rates else { unreachable!("two integrated columns") };
        du.values_mut().copy_from_slice(v.values()); // Eq. (4)
        let mut sums = std::mem::take(&mut self.work.sums);
        let (ax, ayz) = dv.values_mut().split_at_mut(n);
        let (ay, az) = ayz.split_at_mut(n);
        let chunk = PARTICLES_A_SUM;
        (ax.par_chunks_mut(chunk), ay.par_chunks_mut(chunk), az.par_chunks_mut(chunk), &mut sums)
            .into_par_iter()
            .enumerate()
            .for_each(|(c, (ax, ay, az, sum))| {
                *sum = ForceSums::default();
                for i in 0..ax.len() {
                    let a = c * chunk + i;
                    let (mut force, wall, wall_power) = self.internal_force(a);
                    let load = vector(&self.work.load, n, a);
                    force += load;
                    sum.load += load;
                    sum.reaction += wall;
                    sum.power += wall_power + load.dot(&v.vector(a));
                    let acceleration = force / self.mass[a]; // Eq. (2)
                    (ax[i], ay[i], az[i]) = (acceleration.x, acceleration.y, acceleration.z);
                }
            });
        let mut total = sums.iter().fold(ForceSums::default(), |s, c| s.add_scaled(1.0, c));
        self.work.sums = sums;
        self.fixed.hold(t, &self.mass, du.values_mut(), dv.values_mut(), &mut total);
        total
    }

    fn impose(&self, t: f64, particles: &mut Particles) -> Vec3 {
        self.fixed.impose(t, &self.mass, particles)
    }

    fn derive(&mut self, t: f64, particles: &mut Particles) {
        let n = self.len();
        let relaxation_time = self.material.relaxation_time();
        let u = particles.column(Field::Displacement).clone();
        let v = particles.column(Field::Velocity).clone();
        let strain = self.strain(t, u.values());
        // Stress at the effective strain e + T de/dt, Eq. (5).
        self.mirror.offsets(&mut self.work.offset, |m| m.displacement(t) + m.velocity(t) * relaxation_time);
        self.spread(u.values(), Some((v.values(), relaxation_time)));
        let material = Arc::clone(&self.material);
        self.visit_gradient(|_, g, _| {
            let mut out = [0.0; PAIR_COMPONENTS];
            let sigma = material.stress(SymTensor::symmetric_part(g));
            out[..6].copy_from_slice(&sigma.0);
            out[6] = sigma.von_mises();
            out
        });
        let mut stress = self.gather_pair(7);
        let von_mises = stress.split_off(6 * n);
        // Eq. (1) on the lattice of the last remesh: d(ln rho)/dt = -tr(de/dt).
        let volume = particles.column(Field::Volume).values();
        let density = (0..n)
            .map(|a| self.mass[a] / volume[a] * (-(strain[a] + strain[n + a] + strain[2 * n + a])).exp())
            .collect();
        particles.set(Field::Density, Column::from_vec(density, n));
        particles.set(Field::Strain, Column::from_vec(strain, n));
        particles.set(Field::Stress, Column::from_vec(stress, n));
        particles.set(Field::VonMises, Column::from_vec(von_mises, n));
    }

    fn energy(&mut self, t: f64, particles: &Particles) -> Energy {
        let n = self.len();
        let (u, v) = (particles.column(Field::Displacement), particles.column(Field::Velocity));
        self.mirror.offsets(&mut self.work.offset, |m| m.displacement(t));
        self.spread(u.values(), None);
        let Workspace { q, pair, effective, offset, .. } = &mut self.work;
        let (moments, mirror, material, kappa) =
            (&self.moments, &self.mirror, &*self.material, self.hourglass);
        ops::gradient_sums(&self.lattice, q, pair, |a, h, q| {
            let m = &moments[a];
            let u_a = vector(effective, n, a);
            let (g, _) = Self::complete(moments, mirror, offset, effective, a, h, q);
            // Energy of the one-sided residual u_b - u_a - G_a X. Pairs of particles count from both
            // sides, ghosts from the particle's.
            let mut zeroth = m.zeroth;
            let mut springs = 0.0;
            for ghost in mirror.ghosts_of(a) {
                let vw = moments[ghost.partner as usize].volume * ghost.w;
                zeroth -= vw;
                springs += vw * (Self::ghost_value(ghost, effective, n, offset) - u_a).norm_squared();
            }
            springs += -2.0 * u_a.dot(&(q - u_a * zeroth));
            let residual = springs - (g * m.second * g.transpose()).trace();
            let strain_energy = material.energy_density(SymTensor::symmetric_part(&g));
            let mut out = [0.0; PAIR_COMPONENTS];
            out[0] = m.volume * (strain_energy + 0.5 * kappa * residual);
            out
        });
        let elastic = self.gather_pair(1).iter().sum();
        let kinetic = (0..n).map(|a| 0.5 * self.mass[a] * v.vector(a).norm_squared()).sum();
        Energy { kinetic, elastic }
    }
}
