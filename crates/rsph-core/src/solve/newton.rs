//! Newton's method for a body at rest: each step solves a tangent by conjugate gradients, with the multigrid of the undeformed
//! body. Steps go as far as the potential falls, or are whole ones; where neither lead to equilibrium loads are raised in steps.

use super::cg::{Goal, Outcome};
use super::linear::LinearSolver;
use super::multigrid::Multigrid;
use super::sums::combine;
use crate::boundary::nodal_load::NodalLoad;
use crate::dynamics::Scales;
use crate::dynamics::solid::Solid;

/// Steps of one load step.
const MAX_STEPS: usize = 15;
/// Steps where the potential is followed, which may be slow at first.
const MAX_SEARCHING_STEPS: usize = 60;
/// Iterations of one linear system.
const MAX_ITERATIONS: usize = 1000;
/// Largest residual of a linear system, as a share of its right-hand side.
const FORCING: f64 = 0.01;
/// Largest residual where the tangent is replaced by one that is positive.
const STEEPEST: f64 = 0.1;
/// Share of the decrease that the slope of the potential promises which a step must have.
const SUFFICIENT: f64 = 1e-4;
/// Halvings of a step; one that must be shorter is a sign of too large a load step.
const MAX_HALVINGS: usize = 4;
/// Change of the potential, as a share of it, that rounding hides.
const ROUNDING: f64 = 1e-12;
/// Residual of a load step on the way, as a share of the load.
const ON_THE_WAY: f64 = 1e-3;
/// Smallest load step, as a share of the load.
const SMALLEST_LOAD_STEP: f64 = 1.0 / 512.0;

/// A body to be brought to rest.
pub struct Newton<'a> {
    /// The body.
    pub solid: &'a mut Solid,
    /// Its linear solver.
    pub solver: LinearSolver,
    /// When: what moved faces go by.
    pub t: f64,
    /// Loads of that time, component by component, zero where the body is held; those that depend on the displacement as at the
    /// last state that was looked at.
    pub load: Vec<f64>,
    /// Internal forces of the last state that was looked at.
    pub force: Vec<f64>,
    /// Loads and internal forces, zero where the body is held.
    residual: Vec<f64>,
    /// The largest |residual| at the start of a load step or of the undeformed body: what others are compared with.
    pub reference: f64,
    /// Iterations of the linear solver.
    pub iterations: usize,
    /// Steps.
    pub steps: usize,
    /// The last direction.
    direction: Vec<f64>,
    /// The hierarchy of the undeformed body, where that of another state has taken its place.
    undeformed: Option<Multigrid>,
}

/// How a load step ended without equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// The linear solver or the steps did not converge.
    NotConverged,
    /// Who watches wants no more.
    Stopped,
}

impl<'a> Newton<'a> {
    /// For `solid` at time `t`.
    pub fn new(solid: &'a mut Solid, t: f64) -> Self {
        let n = solid.len();
        solid.linearise_undeformed();
        let zeros = || vec![0.0; 3 * n];
        let (mut load, mut undeformed) = (zeros(), zeros());
        solid.load_at(t, &undeformed, &mut load);
        solid.fixed.zero(&mut load, n);
        let solver = LinearSolver::new(solid);
        let mut newton = Self {
            solid,
            solver,
            t,
            load,
            force: zeros(),
            residual: zeros(),
            reference: 0.0,
            iterations: 0,
            steps: 0,
            direction: zeros(),
            undeformed: None,
        };
        newton.impose(1.0, &mut undeformed);
        let size = newton.residual_at(1.0, &undeformed);
        newton.compare_with(size);
        newton
    }

    /// Sets held components of u to where that share of their way has led them.
    pub fn impose(&self, share: f64, u: &mut [f64]) {
        let n = self.solid.len();
        for p in &self.solid.fixed.particles {
            let moved = p.motion.as_ref().map_or_else(Default::default, |m| m.displacement(self.t) * share);
            for i in (0..3).filter(|&i| p.fix[i]) {
                u[i * n + p.particle] = moved[i];
            }
        }
    }

    /// |loads + internal forces| where that share of loads and motions acts.
    pub fn residual_at(&mut self, share: f64, u: &[f64]) -> f64 {
        self.take_loads(u);
        let Self { solid, solver, t, load, force, residual, .. } = self;
        solid.force_at_rest(*t, share, u, force);
        residual.copy_from_slice(force);
        combine(share, load, 1.0, residual);
        solid.fixed.zero(residual, solid.len());
        solver.norm(residual)
    }

    /// Takes a residual to compare others with, if it is the largest so far; none where a face that has gone all of its way at once
    /// turns the undeformed body inside out.
    fn compare_with(&mut self, size: f64) {
        if size.is_finite() {
            self.reference = self.reference.max(size);
        }
    }

    /// Takes the loads at the displacement u, where they depend on it.
    fn take_loads(&mut self, u: &[f64]) {
        if NodalLoad::any_follows(&self.solid.loads) {
            self.solid.load_at(self.t, u, &mut self.load);
            self.solid.fixed.zero(&mut self.load, self.solid.len());
        }
    }

    /// Work of the loads on the straight way to u, where they are now, from the displacement `from`, where they were `before`.
    fn work_on_the_way(&mut self, before: &[f64], from: &[f64], u: &[f64]) -> f64 {
        let work = |load: &[f64]| -> f64 {
            load.iter().zip(u.iter().zip(from)).map(|(f, (u, from))| f * (u - from)).sum()
        };
        if !NodalLoad::any_follows(&self.solid.loads) {
            return work(&self.load);
        }
        // Exact for loads that follow the surface, which are quadratic in the displacement.
        let ends = work(before) + work(&self.load);
        let middle: Vec<f64> = u.iter().zip(from).map(|(u, from)| 0.5 * (u + from)).collect();
        self.take_loads(&middle);
        let at_middle = work(&self.load);
        self.take_loads(u);
        (ends + 4.0 * at_middle) / 6.0
    }

    /// From `u` to equilibrium under all loads, in one step if it can be, else from the undeformed body in load steps that adapt
    /// themselves. `watch` sees (iterations, residual over that of the undeformed body).
    ///
    /// # Errors
    /// No equilibrium; u is then the last state.
    pub fn solve(
        &mut self,
        tolerance: f64,
        u: &mut [f64],
        watch: &mut dyn FnMut(usize, f64) -> bool,
    ) -> Result<(), Trouble> {
        let start = u.to_vec();
        self.impose(1.0, u);
        match self.load_step(1.0, tolerance, u, watch) {
            Err(Trouble::NotConverged) if !self.solid.is_linear() => {}
            ended => return ended,
        }
        let (mut share, mut step) = (0.0_f64, 0.5);
        u.fill(0.0);
        let mut reached = u.to_vec();
        let mut before: Option<(f64, Vec<f64>)> = None;
        while share < 1.0 {
            let next = (share + step).min(1.0);
            // On along the path.
            if let Some((earlier, there)) = &before {
                let on = (next - share) / (share - earlier);
                combine(1.0 + on, &reached, 0.0, u);
                combine(-on, there, 1.0, u);
                if !self.solid.elastic_energy(self.t, next, u).is_finite() {
                    u.copy_from_slice(&reached);
                }
            }
            let tolerance = if next < 1.0 { ON_THE_WAY } else { tolerance };
            match self.load_step(next, tolerance, u, watch) {
                Ok(()) => {
                    before = Some((share, std::mem::replace(&mut reached, u.to_vec())));
                    share = next;
                    step *= 1.5;
                }
                Err(Trouble::NotConverged) if step > SMALLEST_LOAD_STEP => {
                    u.copy_from_slice(&reached);
                    step *= 0.5;
                    before = None;
                }
                Err(trouble) => {
                    u.copy_from_slice(&start);
                    return Err(trouble);
                }
            }
        }
        Ok(())
    }

    /// From an equilibrium `u` to a closer one, if rounding lets it be found; else u stays.
    pub fn refine(&mut self, tolerance: f64, u: &mut [f64], watch: &mut dyn FnMut(usize, f64) -> bool) {
        let start = u.to_vec();
        let before = self.residual_at(1.0, u);
        let ended = self.iterate(1.0, tolerance, u, false, watch);
        let after = self.residual_at(1.0, u);
        if ended.is_err() && (after >= before || after.is_nan() || self.solid.inverted().is_some()) {
            u.copy_from_slice(&start);
        }
    }

    /// From `u` to equilibrium under that share of loads and motions: by steps along which the potential falls, and if these do not get
    /// there by whole steps.
    fn load_step(
        &mut self,
        share: f64,
        tolerance: f64,
        u: &mut [f64],
        watch: &mut dyn FnMut(usize, f64) -> bool,
    ) -> Result<(), Trouble> {
        let start = u.to_vec();
        match self.iterate(share, tolerance, u, true, watch) {
            Err(Trouble::NotConverged) if !self.solid.is_linear() => {
                u.copy_from_slice(&start);
                self.put_back();
                let ended = self.iterate(share, tolerance, u, false, watch);
                if ended.is_err() {
                    self.put_back();
                }
                ended
            }
            ended => ended,
        }
    }

    /// Smooths by the undeformed body again: states on a way that led nowhere may be no state of a body.
    fn put_back(&mut self) {
        if let Some(undeformed) = self.undeformed.take() {
            self.solver.put_back(undeformed);
        }
    }

    /// Newton's method from `u`; `searches`: along each direction only as far as the potential falls.
    fn iterate(
        &mut self,
        share: f64,
        tolerance: f64,
        u: &mut [f64],
        searches: bool,
        watch: &mut dyn FnMut(usize, f64) -> bool,
    ) -> Result<(), Trouble> {
        self.impose(share, u);
        let mut size = self.residual_at(share, u);
        self.compare_with(size);
        let goal = tolerance * self.reference;
        let mut taken = None;
        for _ in 0..if searches { MAX_SEARCHING_STEPS } else { MAX_STEPS } {
            if size <= 2.0 * goal {
                return Ok(());
            }
            if !size.is_finite() || self.solid.inverted().is_some() {
                return Err(Trouble::NotConverged);
            }
            self.solid.linearise_for_newton(self.t, share, u, taken);
            let (new, length) = self.step(share, size, goal, u, searches, watch)?;
            (size, taken) = (new, Some(length));
        }
        Err(Trouble::NotConverged)
    }

    /// One step of Newton's method from `u` with |residual| = `size`; returns the new one and how much of the step was taken.
    fn step(
        &mut self,
        share: f64,
        size: f64,
        goal: f64,
        u: &mut [f64],
        searches: bool,
        watch: &mut dyn FnMut(usize, f64) -> bool,
    ) -> Result<(f64, f64), Trouble> {
        let is_linear = self.solid.is_linear();
        let mut direction = std::mem::take(&mut self.direction);
        direction.fill(0.0);
        // The nearer, the more exact: quadratic convergence.
        let forcing = FORCING * (size / self.reference).min(1.0);
        let wanted = if is_linear { goal } else { (forcing * size).max(goal) };
        let (mut outcome, mut stopped) = self.linear_solve(wanted, &mut direction, watch);
        if !is_linear && !outcome.converged && !stopped {
            // The smoother has aged.
            let before = self.solver.refresh(self.solid);
            self.undeformed.get_or_insert(before);
            direction.fill(0.0);
            (outcome, stopped) = self.linear_solve(wanted, &mut direction, watch);
        }
        if !is_linear && !outcome.converged && !stopped {
            // The tangent is not positive there.
            self.solid.make_tangent_positive(true);
            direction.fill(0.0);
            (outcome, stopped) = self.linear_solve(wanted.max(STEEPEST * size), &mut direction, watch);
        }
        self.steps += 1;
        let ended = if stopped {
            Err(Trouble::Stopped)
        } else if is_linear && !outcome.converged {
            Err(Trouble::NotConverged)
        } else {
            self.advance(share, size, &direction, u, searches)
        };
        self.direction = direction;
        ended
    }

    /// Solves the tangent for the residual, starting from `direction`; says whether `watch` wants no more.
    fn linear_solve(
        &mut self,
        wanted: f64,
        direction: &mut [f64],
        watch: &mut dyn FnMut(usize, f64) -> bool,
    ) -> (Outcome, bool) {
        let (done, reference) = (self.iterations, self.reference);
        let mut stopped = false;
        let outcome = self.solver.solve(
            self.solid,
            Scales::STATIC,
            &self.residual,
            direction,
            Goal { residual: wanted, iterations: MAX_ITERATIONS },
            &mut |k, r| {
                stopped = !watch(done + k, r / reference);
                r.is_finite() && !stopped
            },
        );
        self.iterations += outcome.iterations;
        (outcome, stopped)
    }

    /// Adds `direction` to u, or as much of it as turns nothing inside out and, if it `searches`, as the potential falls by; returns
    /// the new |residual| and how much.
    fn advance(
        &mut self,
        share: f64,
        size: f64,
        direction: &[f64],
        u: &mut [f64],
        searches: bool,
    ) -> Result<(f64, f64), Trouble> {
        if self.solid.is_linear() {
            combine(1.0, direction, 1.0, u);
            return Ok((self.residual_at(share, u), 1.0));
        }
        let slope: f64 = self.residual.iter().zip(direction).map(|(r, d)| r * d).sum();
        if slope.is_nan() || slope <= 0.0 {
            return Err(Trouble::NotConverged);
        }
        let start = if searches { self.solid.elastic_energy(self.t, share, u) } else { 0.0 };
        let (from, loads) = (u.to_vec(), self.load.clone());
        let mut length = 1.0;
        for _ in 0..=MAX_HALVINGS {
            u.copy_from_slice(&from);
            combine(length, direction, 1.0, u);
            let new = self.residual_at(share, u);
            if new.is_finite() && self.solid.inverted().is_none() {
                // A smaller residual will do, where rounding hides the potential.
                if !searches || new < 0.5 * size {
                    return Ok((new, length));
                }
                let stored = self.solid.elastic_energy(self.t, share, u) - start;
                let rise = stored - share * self.work_on_the_way(&loads, &from, u);
                if rise <= -SUFFICIENT * length * slope + ROUNDING * start.abs() {
                    return Ok((self.residual_at(share, u), length));
                }
            }
            length *= 0.5;
        }
        u.copy_from_slice(&from);
        Err(Trouble::NotConverged)
    }

    /// The place among the particles that the last direction moves most.
    pub fn moves_most(&self) -> Option<usize> {
        let n = self.solid.len();
        let size = |a: usize| (0..3).map(|i| self.direction[i * n + a].powi(2)).sum::<f64>();
        (0..n).max_by(|&a, &b| size(a).total_cmp(&size(b)))
    }
}
