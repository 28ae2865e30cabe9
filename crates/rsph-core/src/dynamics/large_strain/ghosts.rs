//! Clamps on flat faces: odd mirror ghosts of positions. A ghost is a point like any other, with the volume
//! of the particle that it mirrors and no energy of its own; it is an affine function of that particle, so
//! that forces stay the derivative of the energy.

use crate::boundary::mirror::{Group, MirrorPlane};
use crate::tensor::Vec3;

/// One mirror image of a particle.
#[derive(Clone, Copy, Debug)]
pub struct Ghost {
    /// The particle that it mirrors.
    pub partner: usize,
    /// Which group of planes it was mirrored at.
    group: usize,
}

/// The mirror images of all particles near the planes. With d = x - xi, the displacement since the last
/// remesh, a ghost has d_g = s d + (1 - s) (Delta(t) - Delta_0), where Delta is the displacement of the
/// plane and Delta_0 that at the last remesh; and its reference position X_g = xi_g + s (X - xi) -
/// (1 - s) Delta_0.
#[derive(Clone, Debug, Default)]
pub struct Ghosts {
    /// Planes where they were at the last remesh.
    planes: Vec<MirrorPlane>,
    groups: Vec<Group>,
    /// Delta_0 of each plane.
    moved: Vec<Vec3>,
    /// All ghosts.
    pub list: Vec<Ghost>,
    /// (1 - s)(Delta(t) - Delta_0) of each group, and its rate.
    offset: Vec<Vec3>,
    offset_rate: Vec<Vec3>,
}

/// Displacement of a plane.
pub fn displacement(plane: &MirrorPlane, t: f64) -> Vec3 {
    plane.motion.map_or_else(Vec3::zeros, |m| m.displacement(t))
}

impl Ghosts {
    /// The ghosts of particles at `nodes` within `reach` of the planes, which are given where they were in
    /// the undeformed state and are taken at time `t`.
    pub fn new(undeformed: &[MirrorPlane], t: f64, nodes: &[Vec3], reach: f64) -> Self {
        let moved: Vec<Vec3> = undeformed.iter().map(|p| displacement(p, t)).collect();
        let planes: Vec<MirrorPlane> = undeformed
            .iter()
            .zip(&moved)
            .map(|(p, moved)| MirrorPlane { at: p.at + moved[p.axis], ..*p })
            .collect();
        let groups = Group::all(&planes);
        let mut list = Vec::new();
        for (g, group) in groups.iter().enumerate() {
            for (partner, xi) in nodes.iter().enumerate() {
                // As far behind the plane as the particle is before it.
                if (group.image(&planes, xi) - xi).iter().all(|d| d.abs() < 2.0 * reach) {
                    list.push(Ghost { partner, group: g });
                }
            }
        }
        let rest = vec![Vec3::zeros(); groups.len()];
        Self { planes, groups, moved, list, offset: rest.clone(), offset_rate: rest }
    }

    /// The planes where they were at the last remesh.
    pub fn planes(&self) -> &[MirrorPlane] {
        &self.planes
    }

    /// Whether nothing is mirrored.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Appends the ghosts to a list of nodes.
    pub fn extend_nodes(&self, nodes: &mut Vec<Vec3>) {
        let images: Vec<Vec3> =
            self.list.iter().map(|g| self.groups[g.group].image(&self.planes, &nodes[g.partner])).collect();
        nodes.extend(images);
    }

    /// Appends the ghosts' reference positions to those of the particles.
    pub fn extend_reference(&self, nodes: &[Vec3], reference: &mut Vec<Vec3>) {
        let n = reference.len();
        for (ghost, node) in self.list.iter().zip(&nodes[n..]) {
            let group = &self.groups[ghost.group];
            let of_partner = reference[ghost.partner] - nodes[ghost.partner];
            let moved = group.offset(&self.planes, |p| self.moved[p]);
            reference.push(node + group.sign.component_mul(&of_partner) - moved);
        }
    }

    /// Moves the planes to where they are at time `t`.
    pub fn set_time(&mut self, t: f64) {
        for g in 0..self.groups.len() {
            let group = &self.groups[g];
            let planes = &self.planes;
            self.offset[g] = group.offset(planes, |p| displacement(&planes[p], t) - self.moved[p]);
            let rate = |p: usize| planes[p].motion.map_or_else(Vec3::zeros, |m| m.velocity(t));
            self.offset_rate[g] = group.offset(&self.planes, rate);
        }
    }

    /// Position of the ghost of number `i` when its particle is at `x`; `nodes` are those of all points, the
    /// particles first.
    #[inline]
    pub fn position(&self, i: usize, nodes: &[Vec3], x: Vec3) -> Vec3 {
        let (ghost, n) = (&self.list[i], nodes.len() - self.list.len());
        nodes[n + i] + self.change(i, x - nodes[ghost.partner]) + self.offset[ghost.group]
    }

    /// Its velocity when that of its particle is `v`.
    #[inline]
    pub fn velocity(&self, i: usize, v: Vec3) -> Vec3 {
        self.change(i, v) + self.offset_rate[self.list[i].group]
    }

    /// Its change of place while the planes rest, when that of its particle is `dx`.
    #[inline]
    pub fn change(&self, i: usize, dx: Vec3) -> Vec3 {
        self.groups[self.list[i].group].sign.component_mul(&dx)
    }

    /// Adds the forces on ghosts to their particles, by the chain rule; returns the power of the moving
    /// planes that hold them.
    pub fn fold_forces(&self, force: &mut [Vec3]) -> f64 {
        let n = force.len() - self.list.len();
        let mut power = 0.0;
        for (i, ghost) in self.list.iter().enumerate() {
            let f = force[n + i];
            force[ghost.partner] += self.groups[ghost.group].sign.component_mul(&f);
            power -= f.dot(&self.offset_rate[ghost.group]);
        }
        power
    }
}
