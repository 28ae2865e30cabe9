//! Force and moment of every boundary on the body.

use super::Solid;
use crate::boundary::fold::ImageSums;
use crate::boundary::reaction::{Arms, Reaction};
use crate::particles::{Field, Particles};
use crate::tensor::Vec3;

impl Solid {
    /// Force and moment of every boundary on the body at time `t`, each moment about the point in `about`; where nothing moves, those
    /// of the body at rest. Under a law for small strain moments are those of forces on the undeformed body.
    pub fn reactions(&mut self, t: f64, particles: &Particles, about: &[Vec3]) -> Vec<Reaction> {
        let n = self.len();
        let [x, u, v] =
            [Field::Reference, Field::Displacement, Field::Velocity].map(|f| particles.column(f).values());
        self.take_relaxed(particles);
        let rests = v.iter().all(|v| *v == 0.0);
        let mut force = vec![0.0; u.len()];
        if rests {
            self.force_at_rest(t, 1.0, u, &mut force);
        } else {
            self.stress_sweep_at(t, u, v);
            self.adjoint_sweep();
            self.take_forces(&mut force);
        }
        let mut load = vec![0.0; u.len()];
        self.load_at(t, u, &mut load);
        force.iter_mut().zip(load).for_each(|(force, load)| *force += load);

        let mut reactions: Vec<Reaction> = about.iter().copied().map(Reaction::about).collect();
        let arms = Arms { reference: x, displacement: (!self.is_linear()).then_some(u) };
        let spread = self.lift.folds.following.clone();
        self.lift.set_targets(|m| m.displacement(t), |m| m.velocity(t));
        self.lift.add_reactions(&arms, &mut reactions);
        let relaxation_time = if rests { 0.0 } else { self.relaxation_time() };
        let sums = ImageSums {
            lattice: &self.lattice,
            following: &spread,
            z: &|a| Vec3::from_fn(|i, _| u[i * n + a] + relaxation_time * v[i * n + a]),
            volume: &|a| {
                let (t, lane) = self.lattice.tiles.place(a);
                self.constants.volume(t)[lane]
            },
            hourglass: self.hourglass,
            modulus: &|a| self.modulus(a),
            sums: &self.work.q,
        };
        self.lift.folds.add_reactions(&sums, &arms, &mut reactions);
        for p in &self.fixed.particles {
            // What several boundaries hold the first of them carries.
            let held =
                Vec3::from_fn(
                    |k, _| {
                        if p.fix[k] { std::mem::take(&mut force[k * n + p.particle]) } else { 0.0 }
                    },
                );
            if let Some(i) = p.boundary {
                reactions[i].add(&arms.place(p.particle), &-held);
            }
        }
        reactions
    }

    /// The centre of what every boundary holds in the undeformed body, its particles at `positions`: of an area of the surface, or of
    /// particles; the origin for one that holds nothing, because others hold all of it.
    pub fn held_centres(&self, positions: &[Vec3], boundaries: usize) -> Vec<Vec3> {
        let mut sums = vec![(Vec3::zeros(), 0.0); boundaries];
        let inside = self
            .fixed
            .particles
            .iter()
            .filter_map(|p| Some((p.boundary?, positions[p.particle], self.mass[p.particle])));
        for (i, x, weight) in self.lift.held_places().chain(self.lift.folds.held_places()).chain(inside) {
            sums[i].0 += x * weight;
            sums[i].1 += weight;
        }
        sums.into_iter().map(|(sum, total)| if total > 0.0 { sum / total } else { sum }).collect()
    }
}
