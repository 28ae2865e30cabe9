//! Implicit schemes: each stage solves M a = f(u* + c^2 a, v* + c a) by Newton's method, with M + c^2 K + c C, where c is the
//! stage's share of the time step; a linear law takes one step of it.

use super::{Integrator, Step, StepSums};
use crate::boundary::nodal_load::NodalLoad;
use crate::dynamics::{Dynamics, ForceSums, Scales};
use crate::error::{FailureKind, InvalidInput};
use crate::particles::{Column, Field, Particles};
use crate::solve::cg::Goal;
use crate::solve::linear::LinearSolver;
use crate::state::{State, Stateful};
use rayon::prelude::*;

/// Fewest values that a task works on.
const VALUES_PER_TASK: usize = 16384;
/// gamma of SDIRK2: L-stable and of second order.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Residual of a stage, as a share of the largest load, over the tolerance of a step.
const STAGE: f64 = 0.02;
/// Iterations after which a stage counts as unsolvable.
const MAX_ITERATIONS: usize = 500;
/// Steps of Newton's method in a stage.
const MAX_NEWTON_STEPS: usize = 12;
/// Growth of the residual from one of them to the next at which a stage is given up.
const DIVERGED: f64 = 10.0;
/// Residual of the linear system of one of them, as a share of its right-hand side.
const FORCING: f64 = 0.02;
/// Residual that is rounding, as a share of E V/dx sqrt(3 n): 1e-14 of the forces between particles at a strain of one.
const ROUNDING: f64 = 1e-14;
/// Bounds of the change of a step, and the share of the estimated best one that is taken.
const CHANGE: (f64, f64, f64) = (0.2, 2.0, 0.9);

/// The stages of a scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Two stages, second order, L-stable.
    Sdirk2,
    /// One stage, first order.
    BackwardEuler,
}

/// An implicit scheme with its work space.
#[derive(Clone, Debug)]
pub struct Implicit {
    scheme: Scheme,
    tolerance: f64,
    /// Displacement against which errors are measured; `None`: steps are as long as asked for.
    scale: Option<f64>,
    /// Steps not longer than this are taken whatever their error.
    shortest: f64,
    solver: Option<LinearSolver>,
    start: [Vec<f64>; 2],
    first: [Vec<f64>; 2],
    rates: Vec<Column>,
    force: Vec<f64>,
    /// Change of the acceleration of a step of Newton's method.
    acceleration: Vec<f64>,
    /// Acceleration of the stage.
    total: Vec<f64>,
    reference: f64,
    /// Residual that is rounding.
    rounding: f64,
}

impl Implicit {
    /// For `dynamics` on `particles`. `adaptive` is the shortest step worth taking, for a scheme that
    /// chooses its steps so that their error stays below `tolerance` of the displacement.
    pub fn new(
        scheme: Scheme,
        dynamics: &mut dyn Dynamics,
        particles: &Particles,
        tolerance: f64,
        adaptive: Option<f64>,
    ) -> Self {
        let n = particles.len();
        let zeros = || vec![0.0; 3 * n];
        let mut solver = dynamics.solid().map(|solid| {
            let solver = LinearSolver::new(solid);
            // What is remembered is of one matrix.
            if solid.is_linear() { solver.with_history() } else { solver }
        });
        let rounding = dynamics.solid().map_or(0.0, |solid| ROUNDING * solid.force_scale());
        let mut scale = 0.0;
        if let (Some(solid), Some(solver), Some(_)) = (dynamics.solid(), &mut solver, adaptive) {
            // The displacement at rest under all loads at their peaks, if the body is held.
            let mut load = zeros();
            NodalLoad::sum_of_peaks(&solid.loads, &mut load);
            solid.fixed.zero(&mut load, n);
            let mut rest = zeros();
            let goal = Goal { residual: 0.01 * solver.norm(&load), iterations: 100 };
            let outcome = solver.solve(solid, Scales::STATIC, &load, &mut rest, goal, &mut |_, _| true);
            if outcome.converged {
                scale = solver.norm(&rest);
            }
        }
        Self {
            scheme,
            tolerance,
            scale: adaptive.map(|_| scale),
            shortest: adaptive.unwrap_or(0.0),
            solver,
            start: [zeros(), zeros()],
            first: [zeros(), zeros()],
            rates: vec![Column::zeros(3, n), Column::zeros(3, n)],
            force: zeros(),
            acceleration: zeros(),
            total: zeros(),
            reference: 0.0,
            rounding,
        }
    }

    /// From u*, v* in `particles` to the end of a stage at time `t`: v = v* + c a, u = u* + c v.
    fn stage(
        &mut self,
        dynamics: &mut dyn Dynamics,
        particles: &mut Particles,
        t: f64,
        c: f64,
    ) -> Result<(ForceSums, u64), (FailureKind, String)> {
        let velocity = particles.column(Field::Velocity).clone();
        add(particles.column_mut(Field::Displacement).values_mut(), c, velocity.values());
        dynamics.impose(t, particles);
        let mut sums = dynamics.rates(t, particles, &mut self.rates);
        let Some(solid) = dynamics.solid() else {
            return Err((FailureKind::NotConverged, "this body has no stiffness to solve with".into()));
        };
        // Without inertia and with a constant load the velocity dies out like this.
        let guess = -1.0 / (c + solid.relaxation_time());
        crate::solve::sums::combine(guess, velocity.values(), 0.0, &mut self.acceleration);
        solid.fixed.zero(&mut self.acceleration, particles.len());
        drop(velocity);
        let is_linear = solid.is_linear();
        self.total.fill(0.0);
        let (mut applications, mut before) = (1, f64::INFINITY);
        for step in 0..MAX_NEWTON_STEPS {
            let (Some(solid), Some(solver)) = (dynamics.solid(), &mut self.solver) else { break };
            if let Some(a) = solid.inverted() {
                let what = format!("a particle was turned inside out (det F <= 0), number {a}");
                return Err((FailureKind::Inverted, what));
            }
            residual(&solid.mass, self.rates[1].values(), &self.total, &mut self.force);
            let size = solver.norm(&self.force);
            self.reference = self.reference.max(size);
            let goal = (STAGE * self.tolerance * self.reference).max(self.rounding);
            if step > 0 && (is_linear || size <= goal) {
                return Ok((sums, applications));
            }
            if size.is_nan() || size > DIVERGED * before {
                break;
            }
            before = size;
            let taken = (step > 0).then_some(1.0);
            solid.linearise_for_newton(t, 1.0, particles.column(Field::Displacement).values(), taken);
            let wanted = if is_linear { goal } else { (FORCING * size).max(0.5 * goal) };
            let so_far = solver.applications();
            let scales = Scales { mass: 1.0, stiffness: c * c, damping: c };
            let goal = Goal { residual: wanted, iterations: MAX_ITERATIONS };
            let mut watch = |_: usize, residual: f64| residual.is_finite();
            let (force, acceleration) = (&self.force, &mut self.acceleration);
            let mut outcome = solver.solve(solid, scales, force, acceleration, goal, &mut watch);
            if !outcome.converged && !is_linear {
                // The smoother has aged.
                let undeformed = solver.refresh(solid);
                acceleration.fill(0.0);
                outcome = solver.solve(solid, scales, force, acceleration, goal, &mut watch);
                // What a checkpoint does not hold must not decide how later steps are rounded.
                solver.put_back(undeformed);
            }
            applications += solver.applications() - so_far + 1;
            if !outcome.converged {
                return Err((
                    FailureKind::NotConverged,
                    format!(
                        "a stage of the time step was not solved in {} iterations (residual {:.1e} of the load)",
                        outcome.iterations,
                        outcome.residual / self.reference
                    ),
                ));
            }
            let a = &self.acceleration;
            add(particles.column_mut(Field::Displacement).values_mut(), c * c, a);
            add(particles.column_mut(Field::Velocity).values_mut(), c, a);
            add(&mut self.total, 1.0, a);
            if !is_linear {
                self.acceleration.fill(0.0);
            }
            // What holds the body, at the end of the stage.
            sums = dynamics.rates(t, particles, &mut self.rates);
        }
        let what =
            format!("Newton's method did not solve a stage of the time step in {MAX_NEWTON_STEPS} steps");
        Err((FailureKind::NotConverged, what))
    }

    fn set(particles: &mut Particles, u: &[f64], v: &[f64]) {
        particles.column_mut(Field::Displacement).values_mut().copy_from_slice(u);
        particles.column_mut(Field::Velocity).values_mut().copy_from_slice(v);
    }

    /// The error of the step as a share of the scale, for the next step.
    fn error(&mut self, particles: &Particles, dt: f64) -> Option<f64> {
        let (scale, solver) = (self.scale.as_mut()?, self.solver.as_mut()?);
        let (u, v) = (particles.column(Field::Displacement), particles.column(Field::Velocity));
        *scale = scale.max(solver.norm(u.values()));
        // Against the scheme of first order that has only the first stage.
        let (v, first) = (v.values(), &self.first[0]);
        self.force.copy_from_slice(v);
        crate::solve::sums::combine(-GAMMA * dt, first, GAMMA * dt, &mut self.force);
        let size = solver.norm(&self.force);
        Some(if size > 0.0 { size / *scale } else { 0.0 })
    }
}

impl Integrator for Implicit {
    fn save(&self, state: &mut State) {
        state.put("implicit/scale", self.scale.as_slice());
        state.put("implicit/reference", [self.reference]);
        if let Some(solver) = &self.solver {
            solver.save(state);
        }
    }

    fn restore(&mut self, state: &State) -> Result<(), InvalidInput> {
        self.scale = state.real("implicit/scale")?.first().copied();
        [self.reference] = state.numbers("implicit/reference")?;
        self.solver.as_mut().map_or(Ok(()), |solver| solver.restore(state))
    }

    fn evaluate(&mut self, dynamics: &mut dyn Dynamics, particles: &Particles, t: f64) -> ForceSums {
        dynamics.rates(t, particles, &mut self.rates)
    }

    fn step(
        &mut self,
        dynamics: &mut dyn Dynamics,
        particles: &mut Particles,
        t: f64,
        dt: f64,
    ) -> Result<Step, (FailureKind, String)> {
        self.start[0].copy_from_slice(particles.column(Field::Displacement).values());
        self.start[1].copy_from_slice(particles.column(Field::Velocity).values());
        if let Some(solid) = dynamics.solid() {
            solid.start_step(t, particles);
        }
        let reference = self.reference;
        let so_far = self.applications();
        match self.stages(dynamics, particles, t, dt) {
            Err(_) if self.scale.is_some() && dt > self.shortest => {
                // A shorter step may be solved.
                self.reference = reference;
                self.give_up(dynamics, particles);
                let next = Some((CHANGE.0 * dt).max(self.shortest));
                let evaluations = self.applications() - so_far;
                Ok(Step { next, evaluations, taken: false, ..Step::default() })
            }
            ended => {
                if let Some(solid) = dynamics.solid() {
                    solid.drop_step();
                }
                ended
            }
        }
    }
}

impl Implicit {
    /// Applications of the operator so far.
    fn applications(&self) -> u64 {
        self.solver.as_ref().map_or(0, LinearSolver::applications)
    }

    /// Puts `particles` back to the start of the step.
    fn give_up(&self, dynamics: &mut dyn Dynamics, particles: &mut Particles) {
        Self::set(particles, &self.start[0], &self.start[1]);
        if let Some(solid) = dynamics.solid() {
            solid.drop_step();
        }
    }

    /// The stages of a step from `t` to `t + dt`.
    fn stages(
        &mut self,
        dynamics: &mut dyn Dynamics,
        particles: &mut Particles,
        t: f64,
        dt: f64,
    ) -> Result<Step, (FailureKind, String)> {
        let mut integral = ForceSums::default();
        let mut evaluations = 0;
        let c = if self.scheme == Scheme::Sdirk2 { GAMMA * dt } else { dt };
        if self.scheme == Scheme::Sdirk2 {
            start_stage(dynamics, particles, c);
            let (sums, count) = self.stage(dynamics, particles, t + c, c)?;
            integral = integral.add_scaled(dt - c, &sums);
            evaluations += count;
            self.first[0].copy_from_slice(particles.column(Field::Velocity).values());
            self.first[1].copy_from_slice(&self.total);
            let [u, v] = &self.start;
            Self::set(particles, u, v);
            add(particles.column_mut(Field::Displacement).values_mut(), dt - c, &self.first[0]);
            add(particles.column_mut(Field::Velocity).values_mut(), dt - c, &self.first[1]);
        }
        start_stage(dynamics, particles, dt);
        let (forces, count) = self.stage(dynamics, particles, t + dt, c)?;
        integral = integral.add_scaled(c, &forces);
        evaluations += count;
        let error = if self.scheme == Scheme::Sdirk2 { self.error(particles, dt) } else { None };
        let mut step = Step { sums: StepSums::default(), forces, evaluations, next: None, taken: true };
        if let Some(error) = error {
            let (least, most, safety) = CHANGE;
            let best = safety * (self.tolerance / error.max(1e-12)).sqrt();
            step.next = Some((dt * best.clamp(least, most)).max(self.shortest));
            step.taken = error <= self.tolerance || dt <= self.shortest;
            if !step.taken {
                self.give_up(dynamics, particles);
                return Ok(step);
            }
        }
        let imposed = dynamics.impose(t + dt, particles);
        if let Some(solid) = dynamics.solid() {
            solid.end_step(t + dt, dt, particles);
        }
        step.sums = StepSums {
            load: integral.load,
            reaction: integral.reaction + imposed.momentum,
            work: integral.power + imposed.energy,
            // A solid's is what its energy lacks.
            dissipated: 0.0,
        };
        Ok(step)
    }
}

/// Tells a solid that relaxes how long after the start of the step a stage ends.
fn start_stage(dynamics: &mut dyn Dynamics, particles: &Particles, h: f64) {
    if let Some(solid) = dynamics.solid() {
        solid.start_stage(h, particles);
    }
}

/// force = M (rate - acceleration) of fields component by component, rate the accelerations that the forces want.
fn residual(mass: &[f64], rate: &[f64], acceleration: &[f64], force: &mut [f64]) {
    let n = mass.len().max(1);
    for ((f, rate), a) in force.chunks_mut(n).zip(rate.chunks(n)).zip(acceleration.chunks(n)) {
        f.par_iter_mut()
            .zip(rate)
            .zip(a)
            .zip(mass)
            .with_min_len(VALUES_PER_TASK)
            .for_each(|(((f, rate), a), m)| *f = m * (rate - a));
    }
}

/// y += a x
fn add(y: &mut [f64], a: f64, x: &[f64]) {
    crate::solve::sums::combine(a, x, 1.0, y);
}
