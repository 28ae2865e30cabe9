//! The largest stable time step, from the largest eigenvalue of the operator.

use crate::dynamics::elastic::Elastic;
use crate::solve::spectrum;

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
    /// Largest step that the waves alone would allow (s).
    pub wave: f64,
    /// Whether the viscosity sets it (true) or the wave speed (false).
    pub viscous: bool,
}

/// dt_limit = min(2.78 / (T kappa), 2.6 / sqrt(kappa)).
pub fn step_limit(elastic: &mut Elastic) -> StepLimit {
    let kappa = largest_eigenvalue(elastic);
    let relaxation_time = elastic.material.relaxation_time();
    let viscous = REAL_LIMIT / (relaxation_time * kappa);
    let wave = IMAGINARY_LIMIT / kappa.sqrt();
    StepLimit { kappa, dt: viscous.min(wave), wave, viscous: viscous < wave }
}

/// Largest eigenvalue of M^-1 K.
pub fn largest_eigenvalue(elastic: &mut Elastic) -> f64 {
    let n = elastic.len();
    let mut held = vec![1.0; 3 * n];
    elastic.fixed.zero(&mut held, n);
    let mass = elastic.mass.clone();
    let mut divide = |r: &[f64], z: &mut [f64]| {
        for (i, z) in z.iter_mut().enumerate() {
            *z = held[i] * r[i] / mass[i % n];
        }
    };
    let mut apply = |x: &[f64], y: &mut [f64]| elastic.apply(0.0, 1.0, x, y);
    spectrum::largest_eigenvalue(3 * n, LANCZOS_STEPS.min(3 * n), &mut apply, &mut divide)
}
