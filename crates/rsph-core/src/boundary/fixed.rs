//! Clamps and prescribed motion of a thick region: its particles are held.

use crate::boundary::force_sums::{ForceSums, Imposed};
use crate::particles::{Field, Particles};
use crate::setup::Motion;
use crate::tensor::Vec3;

/// One held particle.
#[derive(Clone, Debug)]
pub struct FixedParticle {
    /// Which particle.
    pub particle: usize,
    /// Which components.
    pub fix: [bool; 3],
    /// How it moves.
    pub motion: Option<Motion>,
    /// The number of the boundary that holds it; `None`: the plane of a body in the plane does.
    pub boundary: Option<usize>,
}

/// All held particles.
#[derive(Clone, Debug, Default)]
pub struct Fixed {
    /// Each particle once for each boundary that holds it; later entries win.
    pub particles: Vec<FixedParticle>,
}

impl Fixed {
    /// Holds the z component of all `n` particles: those of a body in the plane.
    pub fn hold_in_plane(&mut self, n: usize) {
        let along_z =
            |particle| FixedParticle { particle, fix: [false, false, true], motion: None, boundary: None };
        self.particles.extend((0..n).map(along_z));
    }

    /// Whether no component along the first `dimension` axes is held.
    pub fn is_free(&self, dimension: usize) -> bool {
        self.particles.iter().all(|p| !p.fix[..dimension].contains(&true))
    }

    /// Sets held components of a vector column to zero.
    pub fn zero(&self, column: &mut [f64], n: usize) {
        for p in &self.particles {
            for i in (0..3).filter(|&i| p.fix[i]) {
                column[i * n + p.particle] = 0.0;
            }
        }
    }

    /// Replaces the rates of held components by those of their motion; what holds them is a reaction,
    /// and if it moves it does work. `du` may be empty.
    pub fn hold(&self, t: f64, mass: &[f64], du: &mut [f64], dv: &mut [f64], sums: &mut ForceSums) {
        let n = mass.len();
        for p in &self.particles {
            let velocity = p.motion.as_ref().map_or_else(Vec3::zeros, |m| m.velocity(t));
            for i in (0..3).filter(|&i| p.fix[i]) {
                let at = i * n + p.particle;
                let reaction = -mass[p.particle] * dv[at];
                sums.reaction[i] += reaction;
                sums.power += reaction * velocity[i];
                if let Some(du) = du.get_mut(at) {
                    *du = velocity[i];
                }
                dv[at] = 0.0;
            }
        }
    }

    /// Sets displacement and velocity of held components; returns what this added.
    pub fn impose(&self, t: f64, mass: &[f64], particles: &mut Particles) -> Imposed {
        let mut added = Imposed::default();
        if self.particles.is_empty() {
            return added;
        }
        let n = mass.len();
        let u = particles.column_mut(Field::Displacement).values_mut();
        for p in &self.particles {
            let value = p.motion.as_ref().map_or_else(Vec3::zeros, |m| m.displacement(t));
            for i in (0..3).filter(|&i| p.fix[i]) {
                u[i * n + p.particle] = value[i];
            }
        }
        let v = particles.column_mut(Field::Velocity).values_mut();
        for p in &self.particles {
            let value = p.motion.as_ref().map_or_else(Vec3::zeros, |m| m.velocity(t));
            for i in (0..3).filter(|&i| p.fix[i]) {
                let at = i * n + p.particle;
                added.momentum[i] += mass[p.particle] * (value[i] - v[at]);
                added.energy += 0.5 * mass[p.particle] * (value[i].powi(2) - v[at].powi(2));
                v[at] = value[i];
            }
        }
        added
    }
}
