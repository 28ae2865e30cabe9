//! The largest stable time step, from the largest eigenvalue of the operator.

use crate::boundary::fixed::Fixed;
use crate::dynamics::Scales;
use crate::dynamics::solid::Solid;
use crate::solve::spectrum;

/// Lanczos steps; the largest eigenvalue of an SPH operator on a lattice is found to 0.1 % in about
/// forty.
const LANCZOS_STEPS: usize = 40;
/// RK4 is stable on the negative real axis up to 2.785 and on the imaginary axis up to 2.828; the
/// margins cover eigenvalues in between and what Lanczos leaves open.
const REAL_LIMIT: f64 = 2.78;
const IMAGINARY_LIMIT: f64 = 2.6;
/// Share of the limit that is allowed where stiffness changes with the strain: a body that is squeezed gets stiffer, up to the next
/// remesh.
const STEP_SAFETY: f64 = 0.6;
/// Share of the limit that `dt = "auto"` takes.
pub const SAFETY: f64 = 0.9;

/// The stability limit of a time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLimit {
    /// Largest eigenvalue kappa of M^-1 K (1/s^2).
    pub kappa: f64,
    /// Largest rate of decay (1/s).
    pub fastest_decay: f64,
    /// Largest stable time step of RK4 (s).
    pub dt: f64,
    /// Largest step that the waves alone would allow (s).
    pub wave: f64,
    /// Whether the viscosity sets it (true) or the wave speed (false).
    pub viscous: bool,
}

/// dt_limit = min(2.78 / (T kappa), 2.6 / sqrt(kappa)) about the state of the tangent, 0.6 of it where the law is not linear, and
/// 2.78 tau of the shortest term of a Prony series.
pub fn step_limit(solid: &mut Solid) -> StepLimit {
    let (relaxation_time, shortest) = (solid.relaxation_time(), solid.shortest_prony_time());
    let share = if solid.is_linear() { 1.0 } else { STEP_SAFETY };
    limit(largest_eigenvalue(solid), (relaxation_time, shortest), share)
}

fn limit(kappa: f64, (relaxation_time, shortest): (f64, f64), share: f64) -> StepLimit {
    let fastest_decay = (relaxation_time * kappa).max(1.0 / shortest);
    let viscous = (share * REAL_LIMIT / (relaxation_time * kappa)).min(REAL_LIMIT * shortest);
    let wave = share * IMAGINARY_LIMIT / kappa.sqrt();
    StepLimit { kappa, fastest_decay, dt: viscous.min(wave), wave, viscous: viscous < wave }
}

/// Largest eigenvalue of M^-1 K.
pub fn largest_eigenvalue(solid: &mut Solid) -> f64 {
    let (mass, fixed) = (solid.mass.clone(), solid.fixed.clone());
    largest(&mass, &fixed, &mut |x, y| solid.apply(Scales::STATIC, x, y))
}

/// The same where `apply(x, y)` sets y = K x.
fn largest(mass: &[f64], fixed: &Fixed, apply: &mut dyn FnMut(&[f64], &mut [f64])) -> f64 {
    let n = mass.len();
    let mut held = vec![1.0; 3 * n];
    fixed.zero(&mut held, n);
    let mut divide = |r: &[f64], z: &mut [f64]| {
        for (i, z) in z.iter_mut().enumerate() {
            *z = held[i] * r[i] / mass[i % n];
        }
    };
    spectrum::largest_eigenvalue(3 * n, LANCZOS_STEPS.min(3 * n), apply, &mut divide)
}
