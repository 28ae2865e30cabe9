//! The paper to the letter: Eqs. (10) to (14) on updated positions, with neighbour pairs and without
//! kernel correction.
//!
//! This scheme is unstable (a cube of liver under tension blows up within half a second of simulated
//! time): at free surfaces the truncated kernel and a stress divergence that is not the adjoint of the
//! strain rate feed energy into the body. It is kept so that this can be shown; use
//! [`super::elastic`].

use super::{Dynamics, Energy, ForceSums, Imposed};
use crate::boundary::fixed::Fixed;
use crate::boundary::nodal_load::NodalLoad;
use crate::boundary::traction_free::penalty_force;
use crate::kernel::QuarticSpline;
use crate::level_set::normals;
use crate::material::{Material, Stiffness};
use crate::neighbors::Pairs;
use crate::particles::{Column, Field, Particles};
use crate::tensor::{Mat3, SymTensor, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Extra radius of the neighbour list in spacings; it is rebuilt when a particle has moved half of it.
const SKIN: f64 = 0.2;

/// A solid body as the paper discretises it.
#[derive(Clone, Debug)]
pub struct Paper {
    /// Constitutive law.
    pub material: Arc<dyn Material>,
    /// Particles held or moved.
    pub fixed: Fixed,
    /// Loads.
    pub loads: Vec<NodalLoad>,
    mass: Vec<f64>,
    stiffness: Stiffness,
    spacing: f64,
    kernel: QuarticSpline<3>,
    pairs: Pairs,
    listed_at: Vec<Vec3>,
    position: Vec<Vec3>,
    volume: Vec<f64>,
    stress: Vec<SymTensor>,
    strain_rate: Vec<SymTensor>,
    load: Vec<f64>,
}

impl Paper {
    /// A body of particles of these masses on a lattice of that spacing.
    pub fn new(
        material: Arc<dyn Material>,
        mass: Vec<f64>,
        spacing: f64,
        smoothing: f64,
        fixed: Fixed,
        loads: Vec<NodalLoad>,
    ) -> Self {
        let n = mass.len();
        Self {
            stiffness: material.stiffness(),
            material,
            fixed,
            loads,
            mass,
            spacing,
            kernel: QuarticSpline::new(smoothing * spacing),
            pairs: Pairs::default(),
            listed_at: Vec::new(),
            position: vec![Vec3::zeros(); n],
            volume: vec![0.0; n],
            stress: vec![SymTensor::ZERO; n],
            strain_rate: vec![SymTensor::ZERO; n],
            load: vec![0.0; 3 * n],
        }
    }

    /// Positions and volumes of this moment, and pairs that are good for them.
    fn place(&mut self, particles: &Particles) {
        let (x0, u) = (particles.column(Field::Reference), particles.column(Field::Displacement));
        let density = particles.column(Field::Density).values();
        for a in 0..self.mass.len() {
            self.position[a] = x0.vector(a) + u.vector(a);
            self.volume[a] = self.mass[a] / density[a];
        }
        let skin = SKIN * self.spacing;
        let near = |(x, y): (&Vec3, &Vec3)| (x - y).norm_squared() < 0.25 * skin * skin;
        if self.listed_at.is_empty() || !self.position.iter().zip(&self.listed_at).all(near) {
            self.list_at(self.position.clone());
        }
    }

    /// Where the particles were when their neighbours were last listed: the order of the sums.
    pub fn listed_at(&self) -> &[Vec3] {
        &self.listed_at
    }

    /// Lists the neighbours of particles at those positions.
    pub fn list_at(&mut self, positions: Vec<Vec3>) {
        self.pairs = Pairs::new(&positions, self.kernel.support() + SKIN * self.spacing);
        self.listed_at = positions;
    }

    /// sum_b V_b (A_b - A_a) (x) grad_a W for a vector quantity, Eq. (10).
    fn gradient(&self, a: usize, value: impl Fn(usize) -> Vec3) -> Mat3 {
        let (x_a, value_a) = (self.position[a], value(a));
        self.pairs.of(a).iter().fold(Mat3::zeros(), |sum, &b| {
            let b = b as usize;
            let grad_w = self.grad_w(&(self.position[b] - x_a));
            sum + self.volume[b] * (value(b) - value_a) * grad_w.transpose()
        })
    }

    /// grad_a W(x_a - x_b) for X = x_b - x_a.
    fn grad_w(&self, x: &Vec3) -> Vec3 {
        let r = x.norm();
        if r > 0.0 { x * self.kernel.gradient_weight(r) } else { Vec3::zeros() }
    }
}

impl Dynamics for Paper {
    fn integrated(&self) -> &'static [Field] {
        &[Field::Displacement, Field::Velocity, Field::Density, Field::Strain]
    }

    fn is_stable(&self) -> bool {
        false
    }

    fn rates(&mut self, t: f64, particles: &Particles, rates: &mut [Column]) -> ForceSums {
        let n = self.mass.len();
        self.place(particles);
        NodalLoad::sum(&self.loads, t, &mut self.load);
        let v = particles.column(Field::Velocity);
        let (density, strain) = (particles.column(Field::Density), particles.column(Field::Strain));
        let velocity_gradient: Vec<Mat3> =
            (0..n).into_par_iter().map(|a| self.gradient(a, |b| v.vector(b))).collect();
        for a in 0..n {
            self.strain_rate[a] = SymTensor::symmetric_part(&velocity_gradient[a]); // Eq. (13)
            let effective = strain.tensor(a) + self.strain_rate[a] * self.material.relaxation_time();
            self.stress[a] = self.stiffness.stress(effective); // Eq. (5)
        }
        let level_set = particles.column(Field::LevelSet).values();
        let normal = normals(&self.position, &self.volume, level_set, &self.pairs, &self.kernel); // Eq. (15)
        let boundary = |a: usize| level_set[a] > -self.spacing;
        let force: Vec<Vec3> = (0..n)
            .into_par_iter()
            .map(|a| {
                // Eq. (12), times V_a.
                let divergence = self.pairs.of(a).iter().fold(Vec3::zeros(), |sum, &b| {
                    let b = b as usize;
                    let grad_w = self.grad_w(&(self.position[b] - self.position[a]));
                    let difference = self.stress[b] + self.stress[a] * -1.0;
                    sum + self.volume[b] * difference.dot(&grad_w)
                });
                let mut f = self.volume[a] * divergence;
                if boundary(a) {
                    f += penalty_force(self.stress[a], &normal[a], self.volume[a] / self.spacing); // Eq. (14)
                }
                f
            })
            .collect();

        let mut sums = ForceSums::default();
        let [du, dv, drho, de] = rates else { unreachable!("four integrated columns") };
        du.values_mut().copy_from_slice(v.values()); // Eq. (4)
        for a in 0..n {
            let load = Vec3::new(self.load[a], self.load[n + a], self.load[2 * n + a]);
            sums.load += load;
            sums.power += load.dot(&v.vector(a));
            // The scheme does not conserve momentum: what its forces sum to counts as reaction.
            sums.reaction += force[a];
            dv.set_vector(a, &((force[a] + load) / self.mass[a])); // Eq. (2)
            drho.values_mut()[a] = -density.values()[a] * self.strain_rate[a].trace(); // Eq. (11)
            for (c, e) in self.strain_rate[a].0.iter().enumerate() {
                de.values_mut()[c * n + a] = *e; // Eq. (13)
            }
        }
        self.fixed.hold(t, &self.mass, du.values_mut(), dv.values_mut(), &mut sums);
        sums
    }

    fn loads_mut(&mut self) -> Option<&mut Vec<NodalLoad>> {
        Some(&mut self.loads)
    }

    fn impose(&self, t: f64, particles: &mut Particles) -> Imposed {
        self.fixed.impose(t, &self.mass, particles)
    }

    fn derive(&mut self, _t: f64, particles: &mut Particles) {
        let n = self.mass.len();
        self.place(particles);
        let v = particles.column(Field::Velocity);
        let strain = particles.column(Field::Strain);
        let (mut stress, mut von_mises) = (vec![0.0; 6 * n], vec![0.0; n]);
        for a in 0..n {
            let rate = SymTensor::symmetric_part(&self.gradient(a, |b| v.vector(b)));
            let sigma = self.stiffness.stress(strain.tensor(a) + rate * self.material.relaxation_time());
            for (c, s) in sigma.0.iter().enumerate() {
                stress[c * n + a] = *s;
            }
            von_mises[a] = sigma.von_mises();
        }
        particles.set(Field::Volume, Column::from_vec(self.volume.clone(), n));
        particles.set(Field::Stress, Column::from_vec(stress, n));
        particles.set(Field::VonMises, Column::from_vec(von_mises, n));
    }

    fn energy(&mut self, _t: f64, particles: &Particles) -> Energy {
        self.place(particles);
        let (v, strain) = (particles.column(Field::Velocity), particles.column(Field::Strain));
        let mut energy = Energy::default();
        for a in 0..self.mass.len() {
            energy.kinetic += 0.5 * self.mass[a] * v.vector(a).norm_squared();
            energy.elastic += self.volume[a] * self.stiffness.energy_density(strain.tensor(a));
        }
        energy
    }
}
