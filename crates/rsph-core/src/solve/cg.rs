//! Preconditioned conjugate gradients.

use super::operator::{Operator, Preconditioner};
use super::sums::{Sums, combine};
use crate::pool::awake;

/// When a solve ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// |b - A x| at which it is done.
    pub residual: f64,
    /// Iterations after which it is given up.
    pub iterations: usize,
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Iterations, each with one application of the operator and one of the preconditioner.
    pub iterations: usize,
    /// |b - A x| as the iteration carries it.
    pub residual: f64,
    /// Whether the residual fell below what was asked for.
    pub converged: bool,
}

/// Work space of conjugate gradients.
#[derive(Clone, Debug)]
pub struct ConjugateGradients {
    r: Vec<f64>,
    z: Vec<f64>,
    p: Vec<f64>,
    q: Vec<f64>,
    sums: Sums,
}

impl ConjugateGradients {
    /// For fields of `len` values.
    pub fn new(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        Self { r: zeros(), z: zeros(), p: zeros(), q: zeros(), sums: Sums::new(len) }
    }

    /// Inner products of a fixed order, for callers that need the same norm.
    pub fn sums(&mut self) -> &mut Sums {
        &mut self.sums
    }

    /// b - A x at the end of the last solve, as the iteration carries it.
    pub fn residual(&self) -> &[f64] {
        &self.r
    }

    /// Improves `x` until `goal` is met; `b` must be zero in held
    /// components. `watch` sees (iteration, residual) and may stop the solve by returning false.
    pub fn solve(
        &mut self,
        operator: &mut dyn Operator,
        preconditioner: &mut dyn Preconditioner,
        b: &[f64],
        x: &mut [f64],
        goal: Goal,
        watch: &mut dyn FnMut(usize, f64) -> bool,
    ) -> Outcome {
        let Self { r, z, p, q, sums } = self;
        r.copy_from_slice(b);
        if x.iter().any(|x| *x != 0.0) {
            operator.apply(x, q);
            combine(-1.0, q, 1.0, r);
        }
        let mut outcome = Outcome { iterations: 0, residual: sums.norm(r), converged: false };
        let mut rz_before = 0.0;
        loop {
            outcome.converged = outcome.residual <= goal.residual;
            if outcome.converged
                || outcome.iterations == goal.iterations
                || !watch(outcome.iterations, outcome.residual)
            {
                return outcome;
            }
            let first = outcome.iterations == 0;
            // Inside the thread pool: entering it for every sum costs more than small sums.
            let squared = awake(|| {
                preconditioner.apply(operator, r, z);
                let rz = sums.dot(r, z);
                combine(1.0, z, if first { 0.0 } else { rz / rz_before }, p);
                rz_before = rz;
                operator.apply(p, q);
                let pq = sums.dot(p, q);
                // Not positive: what is left of the residual moves the body without resistance.
                (pq > 0.0 && rz > 0.0).then(|| sums.advance(rz / pq, x, p, r, q))
            });
            let Some(squared) = squared else { return outcome };
            outcome.residual = squared.sqrt();
            outcome.iterations += 1;
        }
    }
}
