//! Energies, what viscosity takes of them, and stresses for output.

use super::FluidStructure;
use crate::dynamics::Energy;
use crate::particles::{Column, Field, Particles};

impl FluidStructure {
    /// Kinetic and stored energy of both.
    pub(super) fn energies(&mut self, particles: &Particles) -> Energy {
        let u = particles.column(Field::Velocity).component(0);
        let mass = particles.column(Field::Mass).values();
        let kinetic = mass.iter().zip(u).map(|(m, u)| 0.5 * m * u * u).sum();
        Energy { kinetic, elastic: self.energy_of_each(particles).iter().sum::<f64>() - kinetic }
    }

    /// The energies E_f of the fluid and E_s of the solid.
    pub fn energy_of_each(&mut self, particles: &Particles) -> [f64; 2] {
        self.place(particles);
        let (n, law) = (self.interface, &*self.fluid);
        let u = particles.column(Field::Velocity).component(0);
        let d = particles.column(Field::Displacement).component(0);
        let p = particles.column(Field::Pressure).values();
        let pressure = |i: usize| p.get(i).copied().unwrap_or(0.0);
        let fluid = (0..=n).map(|i| self.volume[i] * law.energy_density(u[i], pressure(i))).sum();
        let cell = |j: usize| if j == n || j == u.len() - 1 { 0.5 } else { 1.0 };
        let moving: f64 = (n..u.len()).map(|j| cell(j) * u[j] * u[j]).sum();
        let strained: f64 = d[n..].windows(2).map(|d| (d[1] - d[0]).powi(2)).sum();
        let dxi = self.solid_spacing;
        [fluid, 0.5 * (self.solid_density * dxi * moving + self.elasticity * strained / dxi)]
    }

    /// Power that viscosity takes, nu int u_x^2 dx; positions are those of the work space.
    pub(super) fn dissipation(&self, u: &[f64]) -> f64 {
        let rates = u.windows(2).zip(self.x.windows(2)).map(|(u, x)| (u[1] - u[0]).powi(2) / (x[1] - x[0]));
        self.fluid.viscosity() * rates.sum::<f64>()
    }

    /// Adds stress and strain: of the fluid its viscous stress less its pressure, of the solid mu d_xi and
    /// d_xi. At the interface both are the solid's.
    pub(super) fn add_stress_and_strain(&mut self, particles: &mut Particles) {
        self.place(particles);
        let (n, len) = (self.interface, particles.len());
        let (mut strain, mut stress) = (vec![0.0; 6 * len], vec![0.0; 6 * len]);
        let u = particles.column(Field::Velocity).component(0);
        let d = particles.column(Field::Displacement).component(0);
        let p = particles.column(Field::Pressure).values();
        for i in 0..n {
            let p = if p.is_empty() { p } else { &p[..=n] };
            let [[u_x, _], _] = self.gradients(i, &u[..=n], p);
            stress[i] = self.fluid.viscosity() * u_x - p.get(i).unwrap_or(&0.0);
        }
        for j in n..len {
            // One-sided at the ends.
            let (left, right) = (j.saturating_sub(1).max(n), (j + 1).min(len - 1));
            strain[j] = (d[right] - d[left]) / ((right - left) as f64 * self.solid_spacing);
            stress[j] = self.elasticity * strain[j];
        }
        particles.set(Field::Strain, Column::from_vec(strain, len));
        particles.set(Field::Stress, Column::from_vec(stress, len));
    }
}
