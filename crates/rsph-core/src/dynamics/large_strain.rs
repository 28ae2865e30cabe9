//! A solid at large strain: total Lagrangian between remeshings, with the reference position X carried by
//! the particles. The force is the exact derivative of a discrete energy of the positions.

pub mod body;
pub mod columns;
pub mod configuration;
pub mod equilibrium;
pub mod ghosts;
pub mod remeshing;
mod state;
pub mod sweeps;

use super::{Dynamics, Energy, ForceSums, Imposed};
use crate::boundary::fixed::Fixed;
use crate::boundary::nodal_load::NodalLoad;
use crate::error::InvalidInput;
use crate::material::{FiniteStrain, Material};
use crate::particles::{Column, Field, Particles};
use crate::tensor::{Mat3, SymTensor, Vec3};
use columns::Packed;
use configuration::Configuration;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::sync::Arc;
use sweeps::Stressed;

/// A body at large strain, in the plane (`D` = 2: plane strain) or in space.
#[derive(Clone, Debug)]
pub struct LargeStrain<const D: usize> {
    /// Lattice of the last remesh.
    pub configuration: Configuration<D>,
    /// Particles held or moved.
    pub fixed: Fixed,
    /// Dead loads.
    pub loads: Vec<NodalLoad>,
    /// Mass of each particle.
    pub mass: Vec<f64>,
    /// Constitutive law; it has a [`FiniteStrain`].
    pub material: Arc<dyn Material>,
    /// alpha (lambda + 2 mu): stiffness of the hourglass term.
    pub hourglass: f64,
    work: Workspace,
}

/// Fields that every evaluation reuses. Those of points hold ghosts behind the particles.
#[derive(Clone, Debug)]
struct Workspace {
    /// x of points.
    x: Vec<Vec3>,
    /// v of points.
    v: Vec<Vec3>,
    /// x + T v of points.
    effective: Vec<Vec3>,
    /// F of particles.
    f: Vec<Mat3>,
    /// dF/dt of particles.
    f_rate: Vec<Mat3>,
    /// F + T dF/dt of particles.
    f_effective: Vec<Mat3>,
    piola: Vec<Mat3>,
    tensor: Vec<Mat3>,
    /// Internal force on points; ghosts' are folded into the particles'.
    force: Vec<Vec3>,
    energy: Vec<f64>,
    load: Vec<f64>,
    packed: Packed,
}

/// Positions and velocities of points.
struct Points {
    x: Vec<Vec3>,
    v: Vec<Vec3>,
}

impl<const D: usize> LargeStrain<D> {
    /// A body of `configuration`, with the weight alpha of the hourglass term.
    ///
    /// # Errors
    /// `material.model` when the material has no law for large strain.
    pub fn new(
        configuration: Configuration<D>,
        material: Arc<dyn Material>,
        hourglass_weight: f64,
    ) -> Result<Self, InvalidInput> {
        if material.finite_strain().is_none() {
            return Err(InvalidInput::new(
                "material.model",
                material.name(),
                "has no law for large strain",
                "take \"neo-hookean\"",
            ));
        }
        let (n, points) = (configuration.len, configuration.nodes.len());
        let (zero, none) = (Vec3::zeros(), Mat3::zeros());
        let work = Workspace {
            x: vec![zero; points],
            v: vec![zero; points],
            effective: vec![zero; points],
            f: vec![none; n],
            f_rate: vec![none; n],
            f_effective: vec![none; n],
            piola: vec![none; n],
            tensor: vec![none; n],
            force: vec![zero; points],
            energy: vec![0.0; n],
            load: vec![0.0; 3 * n],
            packed: Packed::default(),
        };
        let density = material.density();
        Ok(Self {
            mass: configuration.reference_volume.iter().map(|v| v * density).collect(),
            hourglass: hourglass_weight * material.p_wave_modulus(),
            configuration,
            fixed: Fixed::default(),
            loads: Vec::new(),
            material,
            work,
        })
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.configuration.len
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.configuration.is_empty()
    }

    /// The law for large strain.
    pub fn law(&self) -> &dyn FiniteStrain {
        match self.material.finite_strain() {
            Some(law) => law,
            None => unreachable!("checked when the body was made"),
        }
    }

    /// Takes positions of the particles, and with them ghosts and deformation gradients.
    fn take_positions(&mut self, position: impl Fn(usize) -> Vec3) {
        let (c, w) = (&self.configuration, &mut self.work);
        w.x.iter_mut().take(c.len).enumerate().for_each(|(a, x)| *x = position(a));
        c.ghosts.mirror_positions(&c.nodes, &mut w.x);
        c.deformation(&w.x, &mut w.packed, &mut w.f);
    }

    /// Takes velocities of the particles, and with them the rates of the deformation gradients.
    fn take_velocities(&mut self, velocity: impl Fn(usize) -> Vec3) {
        let (c, w) = (&self.configuration, &mut self.work);
        w.v.iter_mut().take(c.len).enumerate().for_each(|(a, v)| *v = velocity(a));
        c.ghosts.mirror_velocities(&mut w.v);
        c.gradients(&w.v, &mut w.packed, &mut w.f_rate);
    }

    /// Positions and velocities of all points, ghosts included, from those of the particles at time `t`, and
    /// the deformation gradients of that moment.
    fn all_points(&mut self, t: f64, x: &[Vec3], v: &[Vec3]) -> Points {
        self.configuration.ghosts.set_time(t);
        self.take_positions(|a| x[a]);
        self.take_velocities(|a| v[a]);
        Points { x: self.work.x.clone(), v: self.work.v.clone() }
    }

    /// Internal force of the stresses in `work.piola` and of the field and gradient that were taken; returns
    /// the power of moving planes.
    fn sum_forces(&mut self, viscous: bool) -> f64 {
        let (c, w) = (&self.configuration, &mut self.work);
        let (field, gradient) = if viscous { (&w.effective, &w.f_effective) } else { (&w.x, &w.f) };
        let stressed = Stressed { piola: &w.piola, hourglass: self.hourglass, field, gradient };
        c.pair_tensors(&stressed, &mut w.packed, &mut w.tensor);
        c.forces(&stressed, &w.tensor, &mut w.packed, &mut w.force); // Eq. (12)
        c.ghosts.fold_forces(&mut w.force)
    }

    /// Elastic force on the particles at rest at the positions `x` while planes are where they are at time
    /// `t`, and the elastic energy (infinite where the body is turned inside out).
    pub fn elastic_force(&mut self, t: f64, x: &[Vec3], force: &mut [Vec3]) -> f64 {
        self.configuration.ghosts.set_time(t);
        self.take_positions(|a| x[a]);
        let energy = self.elastic_energy();
        let mut piola = std::mem::take(&mut self.work.piola);
        let (law, f) = (self.law(), &self.work.f);
        piola.par_iter_mut().zip(f).for_each(|(p, f)| *p = law.first_piola(f));
        self.work.piola = piola;
        self.sum_forces(false);
        force.copy_from_slice(&self.work.force[..self.len()]);
        energy
    }

    /// Elastic energy at the positions that were taken.
    fn elastic_energy(&mut self) -> f64 {
        let mut energy = std::mem::take(&mut self.work.energy);
        let w = &self.work;
        self.configuration.energies(self.law(), self.hourglass, &w.x, &w.f, &mut energy);
        self.work.energy = energy;
        self.work.energy.iter().sum()
    }

    /// Change of the elastic force when the particles change places by `dx`, at the positions of the last
    /// [`Self::elastic_force`]: minus the stiffness times `dx`.
    pub fn tangent_force(&mut self, dx: &[Vec3], force: &mut [Vec3]) {
        let n = self.len();
        let Some(law) = self.material.finite_strain() else { unreachable!("checked when the body was made") };
        let (c, w) = (&self.configuration, &mut self.work);
        w.v[..n].copy_from_slice(dx);
        c.ghosts.mirror_changes(&mut w.v);
        c.gradients(&w.v, &mut w.packed, &mut w.f_rate);
        let stiff = |(p, (f, df)): (&mut Mat3, (&Mat3, &Mat3))| *p = law.tangent(f, df);
        w.piola.par_iter_mut().zip(w.f.par_iter().zip(&w.f_rate)).for_each(stiff);
        let stressed =
            Stressed { piola: &w.piola, hourglass: self.hourglass, field: &w.v, gradient: &w.f_rate };
        c.pair_tensors(&stressed, &mut w.packed, &mut w.tensor);
        c.forces(&stressed, &w.tensor, &mut w.packed, &mut w.force);
        c.ghosts.fold_forces(&mut w.force);
        force.copy_from_slice(&w.force[..n]);
    }

    /// Forces on the particles in equilibrium with the uniform first Piola-Kirchhoff stress `p`, component by
    /// component: p times the discrete reference area vectors.
    pub fn surface_forces(&mut self, p: &Mat3) -> Vec<Vec3> {
        let (c, w) = (&self.configuration, &mut self.work);
        w.piola.fill(*p);
        let stressed = Stressed { piola: &w.piola, hourglass: 0.0, field: &w.x, gradient: &w.f };
        c.pair_tensors(&stressed, &mut w.packed, &mut w.tensor);
        c.forces(&stressed, &w.tensor, &mut w.packed, &mut w.force);
        c.ghosts.fold_forces(&mut w.force);
        w.force[..c.len].iter().map(|f| -f).collect()
    }

    /// Deformation gradients F at the last evaluation.
    pub fn deformation(&self) -> &[Mat3] {
        &self.work.f
    }

    /// A particle that is turned inside out, det F <= 0, at the last evaluation.
    pub fn inverted(&self) -> Option<usize> {
        // What is not a number was turned inside out a stage before.
        self.work.f.iter().position(|f| f.determinant().partial_cmp(&0.0) != Some(Ordering::Greater))
    }

    /// Smallest and largest singular value of F_inc, the deformation since the last remesh, at the last
    /// evaluation.
    pub fn stretches_since_remesh(&self) -> (f64, f64) {
        let stretch = |a: usize| {
            let inverse = self.configuration.first_gradient[a].try_inverse().unwrap_or_else(Mat3::zeros);
            let f = self.work.f[a] * inverse;
            let squares = (f.transpose() * f).symmetric_eigenvalues();
            (squares.min().max(0.0).sqrt(), squares.max().sqrt())
        };
        (0..self.len())
            .into_par_iter()
            .map(stretch)
            .reduce(|| (1.0, 1.0), |p, q| (p.0.min(q.0), p.1.max(q.1)))
    }
}

impl<const D: usize> Dynamics for LargeStrain<D> {
    fn integrated(&self) -> &'static [Field] {
        &[Field::Displacement, Field::Velocity]
    }

    fn rates(&mut self, t: f64, particles: &Particles, rates: &mut [Column]) -> ForceSums {
        let n = self.len();
        let (reference, u, v) = (
            particles.column(Field::Reference),
            particles.column(Field::Displacement),
            particles.column(Field::Velocity),
        );
        self.configuration.ghosts.set_time(t);
        self.take_positions(|a| reference.vector(a) + u.vector(a)); // Eqs. (10), (13)
        self.take_velocities(|a| v.vector(a));
        let relaxation_time = self.material.relaxation_time();
        let mut w = std::mem::take(&mut self.work.piola);
        let law = self.law();
        w.par_iter_mut().zip(self.work.f.par_iter().zip(&self.work.f_rate)).for_each(|(p, (f, f_rate))| {
            *p = law.first_piola(f) + law.viscous_piola(f, f_rate);
        });
        self.work.piola = w;
        let w = &mut self.work;
        let z = w.effective.par_iter_mut().zip(w.x.par_iter().zip(&w.v));
        z.for_each(|(z, (x, v))| *z = x + v * relaxation_time);
        let g = w.f_effective.par_iter_mut().zip(w.f.par_iter().zip(&w.f_rate));
        g.for_each(|(g, (f, f_rate))| *g = f + f_rate * relaxation_time);
        let mut total = ForceSums { power: self.sum_forces(true), ..ForceSums::default() };

        NodalLoad::sum(&self.loads, t, &mut self.work.load);
        let [du, dv] = rates else { unreachable!("two integrated columns") };
        du.values_mut().copy_from_slice(v.values()); // Eq. (4)
        let acceleration = dv.values_mut();
        for a in 0..n {
            let (internal, load) = (self.work.force[a], vector(&self.work.load, n, a));
            total.reaction += internal;
            total.load += load;
            total.power += load.dot(&v.vector(a));
            let dv = (internal + load) / self.mass[a]; // Eq. (2)
            for i in 0..3 {
                acceleration[i * n + a] = dv[i];
            }
        }
        self.fixed.hold(t, &self.mass, du.values_mut(), acceleration, &mut total);
        total
    }

    fn loads_mut(&mut self) -> Option<&mut Vec<NodalLoad>> {
        Some(&mut self.loads)
    }

    fn impose(&self, t: f64, particles: &mut Particles) -> Imposed {
        self.fixed.impose(t, &self.mass, particles)
    }

    /// Strain is Hencky's, ln V = 1/2 ln(F F^T); stress is Cauchy's, its viscous part included.
    fn derive(&mut self, t: f64, particles: &mut Particles) {
        let n = self.len();
        let (reference, u, v) = (
            particles.column(Field::Reference).clone(),
            particles.column(Field::Displacement).clone(),
            particles.column(Field::Velocity).clone(),
        );
        self.configuration.ghosts.set_time(t);
        self.take_positions(|a| reference.vector(a) + u.vector(a));
        self.take_velocities(|a| v.vector(a));
        let (mut strain, mut stress) = (vec![0.0; 6 * n], vec![0.0; 6 * n]);
        let (mut density, mut von_mises) = (vec![0.0; n], vec![0.0; n]);
        let law = self.law();
        for (a, (f, f_rate)) in self.work.f.iter().zip(&self.work.f_rate).enumerate() {
            let j = f.determinant();
            let piola = law.first_piola(f) + law.viscous_piola(f, f_rate);
            let cauchy = SymTensor::symmetric_part(&(piola * f.transpose() / j));
            let hencky = SymTensor::symmetric_part(&logarithmic_strain(f));
            for c in 0..6 {
                strain[c * n + a] = hencky.0[c];
                stress[c * n + a] = cauchy.0[c];
            }
            density[a] = self.material.density() / j; // Eq. (1), integrated
            von_mises[a] = cauchy.von_mises();
        }
        particles.set(Field::Density, Column::from_vec(density, n));
        particles.set(Field::Strain, Column::from_vec(strain, n));
        particles.set(Field::Stress, Column::from_vec(stress, n));
        particles.set(Field::VonMises, Column::from_vec(von_mises, n));
    }

    fn energy(&mut self, t: f64, particles: &Particles) -> Energy {
        let (reference, u, v) = (
            particles.column(Field::Reference),
            particles.column(Field::Displacement),
            particles.column(Field::Velocity),
        );
        self.configuration.ghosts.set_time(t);
        self.take_positions(|a| reference.vector(a) + u.vector(a));
        let kinetic = (0..self.len()).map(|a| 0.5 * self.mass[a] * v.vector(a).norm_squared()).sum();
        Energy { kinetic, elastic: self.elastic_energy() }
    }
}

/// ln V = 1/2 ln(F F^T).
fn logarithmic_strain(f: &Mat3) -> Mat3 {
    let eigen = (f * f.transpose()).symmetric_eigen();
    let logarithms = eigen.eigenvalues.map(|s| 0.5 * s.max(f64::MIN_POSITIVE).ln());
    eigen.eigenvectors * Mat3::from_diagonal(&logarithms) * eigen.eigenvectors.transpose()
}

/// Vector `a` of a column of `n`.
fn vector(column: &[f64], n: usize, a: usize) -> Vec3 {
    Vec3::new(column[a], column[n + a], column[2 * n + a])
}
