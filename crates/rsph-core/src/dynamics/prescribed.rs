//! Particles that follow a given velocity field, section 3 of the paper: they carry what they carry,
//! and nothing acts back.

use super::{Dynamics, Energy, ForceSums, Imposed};
use crate::flow::Flow;
use crate::particles::{Column, Field, Particles};
use rayon::prelude::*;

/// A prescribed motion. It has no forces, hence no balance of momentum or energy.
#[derive(Clone, Debug)]
pub struct Prescribed {
    /// What the particles follow.
    pub flow: Flow,
}

impl Prescribed {
    fn velocities(&self, t: f64, particles: &Particles, out: &mut Column) {
        let (x0, u) = (particles.column(Field::Reference), particles.column(Field::Displacement));
        let n = particles.len();
        let (x, yz) = out.values_mut().split_at_mut(n);
        let (y, z) = yz.split_at_mut(n);
        x.par_iter_mut().zip(y).zip(z).enumerate().for_each(|(a, ((x, y), z))| {
            let v = self.flow.at(&(x0.vector(a) + u.vector(a)), t); // Eq. (18)
            (*x, *y, *z) = (v.x, v.y, v.z);
        });
    }
}

impl Dynamics for Prescribed {
    fn integrated(&self) -> &'static [Field] {
        &[Field::Displacement]
    }

    fn rates(&mut self, t: f64, particles: &Particles, rates: &mut [Column]) -> ForceSums {
        self.velocities(t, particles, &mut rates[0]); // Eq. (4)
        ForceSums::default()
    }

    fn impose(&self, _t: f64, _particles: &mut Particles) -> Imposed {
        Imposed::default()
    }

    fn derive(&mut self, t: f64, particles: &mut Particles) {
        let mut velocity = Column::zeros(3, particles.len());
        self.velocities(t, particles, &mut velocity);
        particles.set(Field::Velocity, velocity);
    }

    fn energy(&mut self, _t: f64, _particles: &Particles) -> Energy {
        Energy::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::VelocityField;
    use crate::integrate::{Integrator, RungeKutta4};
    use crate::tensor::Vec3;

    #[test]
    fn particles_return_when_time_is_turned_back() {
        let points: Vec<Vec3> = (0..50)
            .map(|i| Vec3::new(0.1 + 0.015 * f64::from(i), 0.35, 0.9 - 0.013 * f64::from(i)))
            .collect();
        let mut particles = Particles::new(points.len());
        particles.set(Field::Reference, Column::from_vectors(&points));
        particles.set(Field::Displacement, Column::zeros(3, points.len()));
        let mut flow = Prescribed { flow: Flow { velocity: VelocityField::Leveque, reversal: Some(1.257) } };
        let mut integrator = RungeKutta4::default();
        let (steps, mut largest) = (60, 0.0_f64);
        for k in 0..steps {
            let dt = 1.257 / f64::from(steps);
            integrator.step(&mut flow, &mut particles, f64::from(k) * dt, dt).unwrap();
            largest = largest
                .max(particles.column(Field::Displacement).values().iter().fold(0.0, |m, x| m.max(*x)));
        }
        let left = particles.column(Field::Displacement).values().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        assert!(largest > 0.1 && left < 2e-6, "{largest} {left}");
    }
}
