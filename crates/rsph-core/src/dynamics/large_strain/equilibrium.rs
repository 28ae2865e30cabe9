//! Rest under given loads: Newton's method on the energy, each step by conjugate gradients with the exact
//! tangent, without a matrix.

use super::{LargeStrain, law_of, vector};
use crate::boundary::nodal_load::NodalLoad;
use crate::tensor::Vec3;

/// Newton steps that are tried.
const MAX_NEWTON: usize = 60;
/// Most conjugate gradients of a Newton step.
const MAX_GRADIENTS: usize = 2000;
/// Largest share of the residual that conjugate gradients may leave.
const LOOSEST: f64 = 0.1;
/// Share of the predicted decrease of the energy that a step must reach.
const ARMIJO: f64 = 1e-4;

/// How an equilibrium was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equilibrium {
    /// Newton steps.
    pub steps: usize,
    /// Applications of the force or of its tangent.
    pub evaluations: usize,
    /// Norm of the force that is left, relative to that of loads and reactions.
    pub residual: f64,
    /// Elastic energy.
    pub energy: f64,
}

/// Why no equilibrium was found.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoEquilibrium {
    /// A particle is turned inside out from the start.
    #[error("a particle is turned inside out at the start")]
    Inverted,
    /// The load may exceed what the body can bear, or the start may be too far away.
    #[error("no equilibrium found; the force that is left is {0:.1e} of the loads")]
    NotReached(f64),
}

impl<const D: usize> LargeStrain<D> {
    /// Moves the particles from `x` to where they rest under the loads of time `t` and with the planes where
    /// they are then, until the force that is left is `tolerance` of the loads and reactions.
    ///
    /// # Errors
    /// When there is no such place near; `x` is then the best that was found.
    pub fn equilibrate(
        &mut self,
        t: f64,
        x: &mut [Vec3],
        tolerance: f64,
    ) -> Result<Equilibrium, NoEquilibrium> {
        let n = self.len();
        let mut flat = vec![0.0; 3 * n];
        NodalLoad::sum(&self.loads, t, &mut flat);
        let load: Vec<Vec3> = (0..n).map(|a| vector(&flat, n, a)).collect();
        let held = self.held();
        let mut force = vec![Vec3::zeros(); n];
        let mut energy = self.elastic_force(t, x, &mut force);
        let mut evaluations = 1;
        if !energy.is_finite() {
            return Err(NoEquilibrium::Inverted);
        }
        let mut relative = f64::INFINITY;
        for steps in 0..MAX_NEWTON {
            let residual = residual(&force, &load, &held);
            let scale = norm(&load).max(self.largest_internal_force());
            relative = if scale > 0.0 { norm(&residual) / scale } else { 0.0 };
            if relative <= tolerance {
                return Ok(Equilibrium { steps, evaluations, residual: relative, energy });
            }
            let goal = LOOSEST.min(relative.sqrt()).max(0.1 * tolerance / relative);
            let (step, used) = self.newton_step(&residual, &held, goal);
            evaluations += used;
            // Down the potential, not too far: a step that turns something inside out has no energy.
            let slope = dot(&residual, &step);
            let before = energy - dot(&load, x);
            let noise = 1e-14 * (energy.abs() + dot(&load, x).abs());
            let (start, mut length) = (x.to_vec(), 1.0);
            loop {
                for (x, (s, d)) in x.iter_mut().zip(start.iter().zip(&step)) {
                    *x = s + length * d;
                }
                energy = self.elastic_force(t, x, &mut force);
                evaluations += 1;
                let after = energy - dot(&load, x);
                if after <= before - ARMIJO * length * slope + noise {
                    break;
                }
                length *= 0.5;
                if length < 1e-6 {
                    x.copy_from_slice(&start);
                    return Err(NoEquilibrium::NotReached(relative));
                }
            }
        }
        Err(NoEquilibrium::NotReached(relative))
    }

    /// Components that are held, as factors 0 and 1.
    fn held(&self) -> Vec<Vec3> {
        let n = self.len();
        let mut free = vec![1.0; 3 * n];
        self.fixed.zero(&mut free, n);
        (0..n).map(|a| vector(&free, n, a)).collect()
    }

    /// The scale of the forces between particles where nothing loads the body: what a plane bears.
    fn largest_internal_force(&self) -> f64 {
        let law = law_of(&*self.material);
        let area = |a: usize| self.configuration.volume[a].powf((D as f64 - 1.0) / D as f64);
        let stress = |a: usize| law.first_piola(&self.work.f[a]).norm();
        (0..self.len()).map(|a| (stress(a) * area(a)).powi(2)).sum::<f64>().sqrt()
    }

    /// Solves K step = residual until the share `goal` of it is left, or the energy turns out not to be
    /// convex that way; returns the number of applications, too.
    fn newton_step(&mut self, residual: &[Vec3], held: &[Vec3], goal: f64) -> (Vec<Vec3>, usize) {
        let n = self.len();
        let weight: Vec<f64> = self.configuration.volume[..n].iter().map(|v| 1.0 / v).collect();
        let precondition = |r: &[Vec3]| r.iter().zip(&weight).map(|(r, w)| r * *w).collect::<Vec<_>>();
        let mut step = vec![Vec3::zeros(); n];
        let mut r = residual.to_vec();
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut q = vec![Vec3::zeros(); n];
        let mut rz = dot(&r, &z);
        let end = goal * norm(residual);
        for k in 1..=MAX_GRADIENTS {
            self.tangent_force(&p, &mut q);
            for (q, held) in q.iter_mut().zip(held) {
                *q = -q.component_mul(held);
            }
            let curvature = dot(&p, &q);
            if curvature <= 1e-14 * dot(&p, &p) {
                // Not convex: the way so far, or straight down.
                return if k == 1 { (p, k) } else { (step, k) };
            }
            let alpha = rz / curvature;
            for a in 0..n {
                step[a] += p[a] * alpha;
                r[a] -= q[a] * alpha;
            }
            if norm(&r) <= end {
                return (step, k);
            }
            z = precondition(&r);
            let next = dot(&r, &z);
            let beta = next / rz;
            for (p, z) in p.iter_mut().zip(&z) {
                *p = z + *p * beta;
            }
            rz = next;
        }
        (step, MAX_GRADIENTS)
    }
}

fn residual(force: &[Vec3], load: &[Vec3], held: &[Vec3]) -> Vec<Vec3> {
    force.iter().zip(load).zip(held).map(|((f, l), free)| (f + l).component_mul(free)).collect()
}

fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

fn norm(a: &[Vec3]) -> f64 {
    dot(a, a).sqrt()
}
