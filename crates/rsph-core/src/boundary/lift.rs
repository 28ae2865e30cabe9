//! Clamps, rollers, moved parts of the surface and its foundations: the boundary value is lifted into the gradient.
//!
//! On a held part D of the surface u = u_D in the components that a projector P leaves. The gradient of particle a gets
//!
//! ```text
//! (1/V_a) sum_q w_q phi_a(q) r(q) (x) n_q,      r = P (u_D - sum_b phi_b u_b),
//! ```
//!
//! with the weights phi of the surface, and the energy (beta/2) E/dx sum_q w_q |r|^2. Both vanish where u = u_D, so that
//! linear fields stay exact, and the force is the derivative of the energy. r is linear on each cluster of the
//! surface: its coefficients are all that particles and clusters hand to each other.

mod reaction;

use super::constraints::Hold;
use super::fold::Folds;
use super::foundation::Springs;
use super::surface_quadrature::{Cluster, SurfaceQuadrature};
use crate::setup::Motion;
use crate::tensor::{Mat3, Vec3};
use nalgebra::{Matrix4, Matrix4x3, Vector4};
use rayon::prelude::*;
use std::ops::Range;

/// beta: stiffness of the penalty, in units of E/dx (E: Young's modulus). With the P-wave modulus in its place a clamp
/// of nearly incompressible tissue would lock.
const PENALTY: f64 = 0.67;
/// Fewest clusters or particles in a task.
const TASK: usize = 32;
/// Fewest particles in a task that copies their values.
const GATHER: usize = 1024;

/// A cluster of the surface that is held or rests on a foundation.
#[derive(Clone, Debug)]
struct HeldCluster {
    /// Number of each boundary that holds it, with the projector on what it holds.
    holds: Vec<(usize, Mat3)>,
    /// Projector on all that is held.
    projector: Mat3,
    /// Springs to the surroundings, in the directions that are free.
    springs: Vec<Springs>,
    centre: Vec3,
    /// Length h of its monomials.
    h: f64,
    area: f64,
    normal: Vec3,
    /// sum_q w_q p p^T.
    mass: Matrix4<f64>,
    /// Its particles among the pairs.
    pairs: Range<usize>,
    /// beta E / dx.
    penalty: f64,
}

/// A particle at a cluster, with the coefficients of phi_a = coefficients . p(x).
#[derive(Clone, Copy, Debug)]
struct Pair {
    /// Number among the particles near held parts, or of the cluster, in the list by particle.
    other: u32,
    phi: Vector4<f64>,
}

/// All held parts of the surface of a body.
#[derive(Clone, Debug, Default)]
pub struct Lift {
    /// Held parts that are folds.
    pub folds: Box<Folds>,
    /// Boundaries of the body.
    holds: Vec<Hold>,
    clusters: Vec<HeldCluster>,
    by_cluster: Vec<Pair>,
    /// Particles near held parts, in rising order.
    particles: Vec<u32>,
    starts: Vec<usize>,
    by_particle: Vec<Pair>,
    /// u_D of every boundary, and its rate.
    target: Vec<Vec3>,
    rate: Vec<Vec3>,
    /// Coefficients of r, then those of the force, of every cluster.
    residual: Vec<Matrix4x3<f64>>,
    /// int p r of every cluster, p its monomials.
    moment: Vec<Matrix4x3<f64>>,
    /// Values, then forces, of the particles.
    value: Vec<Vec3>,
    /// Gradients, then stresses, of the particles.
    gradient: Vec<Mat3>,
}

impl Lift {
    /// What boundaries that hold as `holds` says hold of `surface`, by a fold or by a lift, of a body with particles of Young's
    /// modulus E that are dx apart.
    pub fn new(
        surface: &SurfaceQuadrature,
        holds: &[Hold],
        folds: Folds,
        young_modulus: impl Fn(usize) -> f64,
        spacing: f64,
    ) -> Self {
        let is_lifted = |c: &Cluster| !c.springs.is_empty() || !c.held.is_empty() && !c.is_folded(&folds);
        let held: Vec<&Cluster> = surface.clusters.iter().filter(|c| is_lifted(c)).collect();
        let mut number = vec![u32::MAX; surface.clusters.len()];
        let all = surface.clusters.iter().enumerate().filter(|(_, c)| is_lifted(c));
        for (k, (c, _)) in all.enumerate() {
            number[c] = k as u32;
        }
        let shares = &surface.shares;
        let (mut particles, mut starts, mut by_particle) = (Vec::new(), vec![0], Vec::new());
        for (k, (a, x)) in shares.particles.iter().enumerate().filter(|(_, p)| !surface.is_image(p.0)) {
            let before = by_particle.len();
            for &(c, w) in shares.of(k).iter().filter(|(c, _)| number[*c as usize] != u32::MAX) {
                let cluster = &surface.clusters[c as usize];
                let phi = cluster.without_images * cluster.monomials(x) * w;
                by_particle.push(Pair { other: number[c as usize], phi });
            }
            if by_particle.len() > before {
                particles.push(*a);
                starts.push(by_particle.len());
            }
        }
        let mut end = vec![0_usize; held.len() + 1];
        for pair in &by_particle {
            end[pair.other as usize + 1] += 1;
        }
        for c in 0..held.len() {
            end[c + 1] += end[c];
        }
        let mut next = end.clone();
        let mut by_cluster = by_particle.clone();
        for k in 0..particles.len() {
            for pair in &by_particle[starts[k]..starts[k + 1]] {
                let at = &mut next[pair.other as usize];
                by_cluster[*at] = Pair { other: k as u32, phi: pair.phi };
                *at += 1;
            }
        }
        let clusters: Vec<HeldCluster> = held
            .iter()
            .enumerate()
            .map(|(k, cluster)| held_cluster(surface, cluster, end[k]..end[k + 1]))
            .collect();
        let mut lift = Self {
            residual: vec![Matrix4x3::zeros(); clusters.len()],
            moment: vec![Matrix4x3::zeros(); clusters.len()],
            value: vec![Vec3::zeros(); particles.len()],
            gradient: vec![Mat3::zeros(); particles.len()],
            clusters,
            by_cluster,
            particles,
            starts,
            by_particle,
            ..Self::folded(holds, folds)
        };
        lift.set_young_modulus(young_modulus, spacing);
        lift
    }

    /// Held by `folds` alone, for boundaries that hold as `holds` says.
    pub fn folded(holds: &[Hold], folds: Folds) -> Self {
        let rest = vec![Vec3::zeros(); holds.len()];
        Self {
            holds: holds.to_vec(),
            target: rest.clone(),
            rate: rest,
            folds: Box::new(folds),
            ..Self::default()
        }
    }

    /// Goes on for a body with another Young's modulus E of every particle, dx apart.
    pub fn set_young_modulus(&mut self, young_modulus: impl Fn(usize) -> f64, spacing: f64) {
        let moduli: Vec<f64> = self.particles.iter().map(|a| young_modulus(*a as usize)).collect();
        for cluster in &mut self.clusters {
            let (mut sum, mut weights) = (0.0, 0.0);
            for pair in &self.by_cluster[cluster.pairs.clone()] {
                // The value of phi at the centre.
                let weight = pair.phi[0].abs();
                (sum, weights) = (sum + weight * moduli[pair.other as usize], weights + weight);
            }
            cluster.penalty = PENALTY * sum / (weights.max(f64::MIN_POSITIVE) * spacing);
        }
    }

    /// Whether nothing is lifted.
    pub fn is_empty(&self) -> bool {
        self.clusters.is_empty()
    }

    /// Particles near held parts, in rising order.
    pub fn particles(&self) -> &[u32] {
        &self.particles
    }

    /// Sets u_D of every held part and its rate to what `displacement` and `rate` make of its motion.
    pub fn set_targets(&mut self, displacement: impl Fn(&Motion) -> Vec3, rate: impl Fn(&Motion) -> Vec3) {
        for (i, hold) in self.holds.iter().enumerate() {
            let Some(motion) = &hold.motion else { continue };
            (self.target[i], self.rate[i]) = (displacement(motion), rate(motion));
        }
        self.folds.set_targets(&self.target);
    }

    /// Puts every held part at rest where it was.
    pub fn rest(&mut self) {
        self.target.fill(Vec3::zeros());
        self.rate.fill(Vec3::zeros());
        self.folds.set_targets(&self.target);
    }

    /// From the values u of the particles to r on the clusters and to the gradient that it lifts into each particle
    /// of volume V, which [`Lift::gradients`] gives.
    pub fn lift(&mut self, u: impl Fn(usize) -> Vec3 + Sync, volume: impl Fn(usize) -> f64 + Sync) {
        let Self {
            clusters,
            by_cluster,
            particles,
            starts,
            by_particle,
            target,
            residual,
            moment,
            value,
            gradient,
            ..
        } = self;
        (&mut *value, &*particles)
            .into_par_iter()
            .with_min_len(GATHER)
            .for_each(|(value, a)| *value = u(*a as usize));
        let each = (&mut *residual, &mut *moment, &*clusters);
        each.into_par_iter().with_min_len(TASK).for_each(|(r, moment, cluster)| {
            let mut sum = Matrix4x3::zeros();
            for pair in &by_cluster[cluster.pairs.clone()] {
                sum += pair.phi * value[pair.other as usize].transpose();
            }
            *r = -sum;
            let wanted: Vec3 = cluster.holds.iter().map(|(i, projector)| projector * target[*i]).sum();
            let first = r.row(0) + wanted.transpose();
            r.set_row(0, &first);
            *moment = cluster.mass * *r * cluster.projector;
        });
        gradient.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(k, gradient)| {
            *gradient = Mat3::zeros();
            for pair in &by_particle[starts[k]..starts[k + 1]] {
                let normal = &clusters[pair.other as usize].normal;
                *gradient += moment[pair.other as usize].tr_mul(&pair.phi) * normal.transpose();
            }
            *gradient /= volume(particles[k] as usize);
        });
    }

    /// The gradients that [`Lift::lift`] found, in the order of [`Lift::particles`].
    pub fn gradients(&self) -> &[Mat3] {
        &self.gradient
    }

    /// From the stresses of the particles (first Piola-Kirchhoff's) to the forces on them, which [`Lift::forces`] gives.
    pub fn react(&mut self, stress: impl Fn(usize) -> Mat3 + Sync) {
        let Self { clusters, by_cluster, particles, starts, by_particle, residual, value, gradient, .. } =
            self;
        (&mut *gradient, &*particles)
            .into_par_iter()
            .with_min_len(GATHER)
            .for_each(|(sigma, a)| *sigma = stress(*a as usize));
        (&mut *residual, &*clusters).into_par_iter().with_min_len(TASK).for_each(|(r, cluster)| {
            let mut traction = *r * cluster.penalty;
            for pair in &by_cluster[cluster.pairs.clone()] {
                let t = gradient[pair.other as usize] * cluster.normal;
                traction += pair.phi * t.transpose();
            }
            let springs: Matrix4x3<f64> = cluster.springs.iter().map(|s| s.force(r)).sum();
            *r = cluster.mass * traction * cluster.projector + springs;
        });
        value.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(k, force)| {
            *force = Vec3::zeros();
            for pair in &by_particle[starts[k]..starts[k + 1]] {
                *force += residual[pair.other as usize].tr_mul(&pair.phi);
            }
        });
    }

    /// The forces that [`Lift::react`] found, of the particles in `range` of all, as (particle, force).
    pub fn forces(&self, range: Range<usize>) -> impl Iterator<Item = (usize, Vec3)> + '_ {
        let at = |a: usize| self.particles.partition_point(|p| (*p as usize) < a);
        (at(range.start)..at(range.end)).map(|k| (self.particles[k] as usize, self.value[k]))
    }

    /// Force of every held part on the body and the power of its motion, after [`Lift::react`].
    pub fn reaction(&self) -> (Vec3, f64) {
        // The weights of the particles sum to 1.
        let forces = self.clusters.iter().zip(&self.residual);
        forces.fold(self.folds.reaction(&self.rate), |(sum, power), (cluster, force)| {
            let force: Vec3 = force.row(0).transpose();
            let velocity: Vec3 = cluster.holds.iter().map(|(i, projector)| projector * self.rate[*i]).sum();
            (sum + force, power + force.dot(&velocity))
        })
    }

    /// Energy of the penalty and of the springs, after [`Lift::lift`].
    pub fn energy(&self) -> f64 {
        let of_cluster = |(cluster, r): (&HeldCluster, &Matrix4x3<f64>)| {
            let held = (r.transpose() * cluster.mass * r * cluster.projector).trace();
            let of = |s: &Springs| r.dot(&s.force(r));
            cluster.penalty * held + cluster.springs.iter().map(of).sum::<f64>()
        };
        0.5 * self.clusters.iter().zip(&self.residual).map(of_cluster).sum::<f64>()
    }

    /// Places on held parts with the projector on what is held there and their areas.
    pub fn places(&self) -> impl Iterator<Item = (Vec3, Mat3, f64)> + '_ {
        let folded = self.folds.places().map(|(_, x, projector, area)| (x, projector, area));
        self.clusters.iter().map(|c| (c.centre, c.projector, c.area)).chain(folded)
    }

    /// Places on foundations with the stiffness (N/m) of the springs there.
    pub fn springs(&self) -> impl Iterator<Item = (Vec3, Mat3)> + '_ {
        self.clusters.iter().flat_map(|c| c.springs.iter().map(|s| (c.centre, s.stiffness)))
    }

    /// Places on held parts and foundations that see a particle for which `belongs` holds, with the projector on what is held
    /// there.
    pub fn holds_near(&self, belongs: impl Fn(usize) -> bool + Copy) -> impl Iterator<Item = (Vec3, Mat3)> {
        let sees = move |c: &&HeldCluster| {
            let pairs = &self.by_cluster[c.pairs.clone()];
            pairs.iter().any(|pair| belongs(self.particles[pair.other as usize] as usize))
        };
        let folded = self.folds.places().filter(move |p| belongs(p.0)).map(|(_, x, held, _)| (x, held));
        let held = |c: &HeldCluster| {
            let by_springs: Mat3 = c.springs.iter().map(|s| s.projector).sum();
            (c.centre, c.projector + by_springs)
        };
        self.clusters.iter().filter(sees).map(held).chain(folded)
    }

    /// How the lifted gradient of each particle of volume V answers to a displacement of particle `a`: calls
    /// `visit(particle, vector, projector)` for dG = -(projector du) (x) vector.
    pub fn responses(
        &self,
        a: usize,
        volume: impl Fn(usize) -> f64,
        mut visit: impl FnMut(usize, Vec3, &Mat3),
    ) {
        let Ok(k) = self.particles.binary_search(&(a as u32)) else { return };
        for pair in &self.by_particle[self.starts[k]..self.starts[k + 1]] {
            let cluster = &self.clusters[pair.other as usize];
            if cluster.holds.is_empty() {
                continue;
            }
            let m = cluster.mass * pair.phi;
            for other in &self.by_cluster[cluster.pairs.clone()] {
                let b = self.particles[other.other as usize] as usize;
                let vector = cluster.normal * (other.phi.dot(&m) / volume(b));
                visit(b, vector, &cluster.projector);
            }
        }
    }

    /// The part of penalty and springs in the stiffness between the components of particle `a`.
    pub fn penalty_block(&self, a: usize) -> Mat3 {
        let Ok(k) = self.particles.binary_search(&(a as u32)) else { return Mat3::zeros() };
        self.by_particle[self.starts[k]..self.starts[k + 1]]
            .iter()
            .map(|pair| {
                let cluster = &self.clusters[pair.other as usize];
                let stiffness = cluster.penalty * pair.phi.dot(&(cluster.mass * pair.phi));
                let springs: Mat3 = cluster.springs.iter().map(|s| s.block(&pair.phi)).sum();
                cluster.projector * stiffness + springs
            })
            .sum()
    }
}

/// A held cluster of `surface` with its pairs.
fn held_cluster(surface: &SurfaceQuadrature, cluster: &Cluster, pairs: Range<usize>) -> HeldCluster {
    let (mut mass, mut area) = (Matrix4::zeros(), 0.0);
    for k in cluster.panels.clone() {
        area += surface.panels[k].centre.area;
        surface.three_points_of(k, |point| {
            let p = cluster.monomials(&point.x);
            mass += p * p.transpose() * point.area;
        });
    }
    HeldCluster {
        projector: cluster.projector(),
        holds: cluster.held.clone(),
        springs: cluster.springs.iter().map(|(_, springs)| *springs).collect(),
        centre: cluster.centre,
        h: cluster.h,
        area,
        normal: cluster.normal,
        mass,
        pairs,
        penalty: 0.0,
    }
}
