//! Forces and moments of held parts of the surface: derivatives of the energy with respect to a shift and a rotation of u_D.

use super::Lift;
use crate::boundary::reaction::{Arms, Reaction};
use crate::tensor::{Mat3, Vec3};
use nalgebra::Matrix4x3;

impl Lift {
    /// Adds what every boundary carries by the parts of the surface that are lifted, after [`Lift::react`]; u_D is that of
    /// [`Lift::set_targets`].
    ///
    /// The force on a cluster is linear in the monomials p = (1, (x - c)/h), like the place x that it acts at: in the components
    /// that are held the one that the boundary asks for, in the others that of the body.
    pub fn add_reactions(&self, arms: &Arms<'_>, reactions: &mut [Reaction]) {
        for (cluster, force) in self.clusters.iter().zip(&self.residual) {
            let mut place = Matrix4x3::zeros();
            place.set_row(0, &cluster.centre.transpose());
            for k in 0..3 {
                place[(k + 1, k)] = cluster.h;
            }
            if arms.displacement.is_some() {
                let free = Mat3::identity() - cluster.projector;
                for pair in &self.by_cluster[cluster.pairs.clone()] {
                    let a = self.particles[pair.other as usize] as usize;
                    place += pair.phi * (free * arms.moved(a)).transpose();
                }
                let wanted: Vec3 = cluster.holds.iter().map(|(i, held)| held * self.target[*i]).sum();
                let first = place.row(0) + wanted.transpose();
                place.set_row(0, &first);
            }
            for (i, projector) in &cluster.holds {
                let row = |of: &Matrix4x3<f64>, k: usize| -> Vec3 { of.row(k).transpose() };
                let reaction = &mut reactions[*i];
                reaction.add(&row(&place, 0), &(projector * row(force, 0)));
                for k in 1..4 {
                    reaction.moment += row(&place, k).cross(&(projector * row(force, k)));
                }
            }
        }
    }

    /// Middles and areas of the parts of the surface that are lifted, with a boundary that holds each.
    pub fn held_places(&self) -> impl Iterator<Item = (usize, Vec3, f64)> + '_ {
        self.clusters.iter().flat_map(|c| c.holds.iter().map(|(i, _)| (*i, c.centre, c.area)))
    }
}
