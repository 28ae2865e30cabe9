//! The largest stable time step, from the largest eigenvalue of the operator.

use crate::boundary::fixed::Fixed;
use crate::dynamics::elastic::Elastic;
use crate::dynamics::large_strain::LargeStrain;
use crate::tensor::Vec3;
use nalgebra::DMatrix;

/// Lanczos steps; the largest eigenvalue of an SPH operator on a lattice is found to 0.1 % in about
/// forty.
const LANCZOS_STEPS: usize = 40;
/// RK4 is stable on the negative real axis up to 2.785 and on the imaginary axis up to 2.828; the
/// margins cover eigenvalues in between and what Lanczos leaves open.
const REAL_LIMIT: f64 = 2.78;
const IMAGINARY_LIMIT: f64 = 2.6;
/// Share of the limit that `dt = "auto"` takes.
pub const SAFETY: f64 = 0.9;

/// The stability limit of a time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLimit {
    /// Largest eigenvalue kappa of M^-1 K (1/s^2).
    pub kappa: f64,
    /// Largest stable time step of RK4 (s).
    pub dt: f64,
    /// Whether the viscosity sets it (true) or the wave speed (false).
    pub viscous: bool,
}

/// dt_limit = min(2.78 / (T kappa), 2.6 / sqrt(kappa)).
pub fn step_limit(elastic: &mut Elastic) -> StepLimit {
    let relaxation_time = elastic.material.relaxation_time();
    limit(largest_eigenvalue(elastic), relaxation_time)
}

/// The same for a body at large strain whose particles are at `x` at time 0.
pub fn large_step_limit<const D: usize>(body: &mut LargeStrain<D>, x: &[Vec3]) -> StepLimit {
    let n = body.len();
    let (mut force, mut dx) = (vec![Vec3::zeros(); n], vec![Vec3::zeros(); n]);
    body.elastic_force(0.0, x, &mut force);
    let (mass, fixed) = (body.mass.clone(), body.fixed.clone());
    let kappa = lanczos(&mass, &fixed, &mut |u, f| {
        for (a, dx) in dx.iter_mut().enumerate() {
            *dx = Vec3::new(u[a], u[n + a], u[2 * n + a]);
        }
        body.tangent_force(&dx, &mut force);
        for (a, force) in force.iter().enumerate() {
            (f[a], f[n + a], f[2 * n + a]) = (force.x, force.y, force.z);
        }
        fixed.zero(f, n);
    });
    limit(kappa, body.material.relaxation_time())
}

fn limit(kappa: f64, relaxation_time: f64) -> StepLimit {
    let viscous = REAL_LIMIT / (relaxation_time * kappa);
    let wave = IMAGINARY_LIMIT / kappa.sqrt();
    StepLimit { kappa, dt: viscous.min(wave), viscous: viscous < wave }
}

/// Largest eigenvalue of M^-1/2 K M^-1/2.
pub fn largest_eigenvalue(elastic: &mut Elastic) -> f64 {
    let (mass, fixed) = (elastic.mass.clone(), elastic.fixed.clone());
    lanczos(&mass, &fixed, &mut |u, force| elastic.force_of(u, force))
}

/// Largest eigenvalue of M^-1/2 K M^-1/2 by the Lanczos iteration, where `apply(u, force)` sets -K u; from a
/// fixed pseudo-random start so that it is reproducible.
fn lanczos(mass: &[f64], fixed: &Fixed, apply: &mut dyn FnMut(&[f64], &mut [f64])) -> f64 {
    let n = mass.len();
    let root: Vec<f64> = mass.iter().map(|m| m.sqrt()).collect();
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut q: Vec<f64> = (0..3 * n)
        .map(|_| {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        })
        .collect();
    fixed.zero(&mut q, n);
    let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let scale = norm(&q);
    if scale == 0.0 {
        return 0.0;
    }
    for x in &mut q {
        *x /= scale;
    }
    let (mut previous, mut force) = (vec![0.0; 3 * n], vec![0.0; 3 * n]);
    let mut scaled = vec![0.0; 3 * n];
    let (mut diagonal, mut off) = (Vec::new(), Vec::new());
    for step in 0..LANCZOS_STEPS.min(3 * n) {
        for (i, s) in scaled.iter_mut().enumerate() {
            *s = q[i] / root[i % n];
        }
        apply(&scaled, &mut force);
        let beta = off.last().copied().unwrap_or(0.0);
        for (i, f) in force.iter_mut().enumerate() {
            *f = -*f / root[i % n] - beta * previous[i];
        }
        let alpha: f64 = q.iter().zip(&force).map(|(q, f)| q * f).sum();
        for (f, q) in force.iter_mut().zip(&q) {
            *f -= alpha * q;
        }
        diagonal.push(alpha);
        let beta = norm(&force);
        if beta <= 1e-12 * alpha.abs() || step + 1 == LANCZOS_STEPS.min(3 * n) {
            break;
        }
        off.push(beta);
        std::mem::swap(&mut previous, &mut q);
        for (q, f) in q.iter_mut().zip(&force) {
            *q = f / beta;
        }
    }
    let k = diagonal.len();
    let tridiagonal = DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => off[i.min(j)],
        _ => 0.0,
    });
    tridiagonal.symmetric_eigenvalues().max()
}
