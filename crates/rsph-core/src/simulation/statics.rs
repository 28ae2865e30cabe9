//! Straight to equilibrium.

use super::Simulation;
use crate::dynamics::elastic::Elastic;
use crate::error::{Failure, FailureKind};
use crate::particles::{Column, Field};
use crate::solve::cg::Goal;
use crate::solve::rigid::{LoosePiece, loose_pieces};
use crate::solve::stiff::StiffSolver;
use crate::tensor::Vec3;

/// Residual at which a body counts as at rest, as a share of the load.
const TOLERANCE: f64 = 1e-6;
/// Corrections of a solution, each with a fresh residual: one for a linear material.
const MAX_CORRECTIONS: usize = 4;
/// Iterations of one correction.
const MAX_ITERATIONS: usize = 1000;

/// How an equilibrium was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Equilibrium {
    /// Iterations of the linear solver.
    pub iterations: usize,
    /// Applications of the stiffness, those of the preconditioner included.
    pub applications: u64,
    /// |forces out of balance| / |forces before the solve|, from a fresh evaluation.
    pub residual: f64,
    /// Work of the loads over the displacement, f . u (J): twice the elastic energy where nothing is moved.
    pub compliance: f64,
    /// Total force of the loads.
    pub load: Vec3,
    /// Total force of clamps and moved parts on the body.
    pub reaction: Vec3,
}

impl Simulation {
    /// Brings the body to rest under the loads and holds of the time `t` and makes that its time. `watch`
    /// sees (iteration, residual over the one at the start) and stops the solve by returning false.
    ///
    /// # Errors
    /// A body that is not held, that has no stiffness, or whose solve does not converge; the state is then
    /// as before.
    pub fn solve_static(
        &mut self,
        t: f64,
        watch: &mut dyn FnMut(usize, f64) -> bool,
    ) -> Result<Equilibrium, Failure> {
        let (time, step) = (self.time, self.steps);
        let fail = |what: String, place: Option<Vec3>, remedy: &str| Failure {
            kind: FailureKind::NotConverged,
            time,
            step,
            what,
            place,
            remedy: remedy.into(),
        };
        let dynamics = self.model.dynamics_mut();
        let Some(elastic) = dynamics.elastic() else {
            return Err(fail(
                "this body has no stiffness: an equilibrium needs the adjoint formulation of a solid".into(),
                None,
                "set `solver.formulation = \"adjoint\"` and leave `dynamics.kind` at \"solid\"",
            ));
        };
        if let Some(piece) = loose_pieces(elastic).first() {
            return Err(fail(
                describe(piece),
                Some(piece.centre),
                "hold more of it: a clamp on a face or a region holds everything, `fix` some components",
            ));
        }
        let n = self.particles.len();
        let start = [Field::Displacement, Field::Velocity].map(|f| self.particles.column(f).clone());
        self.particles.set(Field::Velocity, Column::zeros(3, n));
        let mut solver = StiffSolver::new(elastic);
        let mut rates = vec![Column::zeros(3, n), Column::zeros(3, n)];
        let mut found = Equilibrium::default();
        let mut reference = 0.0;
        let mut trouble = None;
        let from_zero = start[0].values().iter().all(|u| *u == 0.0);
        if !from_zero {
            // Residuals are relative to that of the undeformed body: a body at rest has none of its own.
            self.particles.set(Field::Displacement, Column::zeros(3, n));
            dynamics.impose(t, &mut self.particles);
            dynamics.rates(t, &self.particles, &mut rates);
            if let Some(elastic) = dynamics.elastic() {
                reference = solver.norm(&free_force(elastic, &rates[1]));
            }
            self.particles.set(Field::Displacement, start[0].clone());
        }
        for correction in 0..=MAX_CORRECTIONS {
            dynamics.impose(t, &mut self.particles);
            self.particles.set(Field::Velocity, Column::zeros(3, n)); // at rest, even if a hold moves
            let sums = dynamics.rates(t, &self.particles, &mut rates);
            let Some(elastic) = dynamics.elastic() else { break };
            let force = free_force(elastic, &rates[1]);
            let residual = solver.norm(&force);
            reference = reference.max(residual);
            found.residual = if reference > 0.0 { residual / reference } else { 0.0 };
            (found.load, found.reaction) = (sums.load, sums.reaction);
            if found.residual <= 2.0 * TOLERANCE {
                let load = elastic.load_at(t);
                let u = self.particles.column(Field::Displacement).values();
                found.compliance = load.iter().zip(u).map(|(f, u)| f * u).sum();
                self.balance.settle(dynamics.energy(t, &self.particles), sums);
                break;
            }
            let mut correction_of_u = vec![0.0; 3 * n];
            let outcome = solver.solve(
                elastic,
                (0.0, 1.0),
                &force,
                &mut correction_of_u,
                Goal { residual: TOLERANCE * reference, iterations: MAX_ITERATIONS },
                &mut |k, r| r.is_finite() && watch(found.iterations + k, r / reference),
            );
            found.iterations += outcome.iterations;
            if !outcome.converged || correction == MAX_CORRECTIONS {
                let farthest = (0..n).max_by(|&a, &b| {
                    let size = |a: usize| Vec3::from_fn(|i, _| correction_of_u[i * n + a]).norm();
                    size(a).total_cmp(&size(b))
                });
                trouble = Some(fail(
                    format!(
                        "no equilibrium after {} iterations: {:.1e} of the load is out of balance; some part \
                         hangs by a piece too thin for the spacing",
                        found.iterations,
                        outcome.residual / reference
                    ),
                    farthest.map(|a| elastic.lattice.position(a)),
                    "choose a smaller spacing or hold that part, which moves most",
                ));
                break;
            }
            let u = self.particles.column_mut(Field::Displacement).values_mut();
            u.iter_mut().zip(&correction_of_u).for_each(|(u, c)| *u += c);
        }
        if trouble.is_none()
            && let Some((a, jacobian)) =
                self.model.dynamics_mut().smallest_jacobian(t, &self.particles).filter(|j| j.1 <= 0.0)
        {
            trouble = Some(Failure {
                kind: FailureKind::Inverted,
                ..fail(
                    format!("at rest a particle would be turned inside out (det F = {jacobian:.3} <= 0)"),
                    Some(self.particles.column(Field::Reference).vector(a)),
                    "the loads are too much for this stiffness at small strain: lower them, or take a stiffer material",
                )
            });
        }
        found.applications = solver.applications();
        self.evaluations += found.applications + 1;
        if let Some(failure) = trouble {
            let [u, v] = start;
            self.particles.set(Field::Displacement, u);
            self.particles.set(Field::Velocity, v);
            return Err(failure);
        }
        self.time = t;
        self.steps += 1;
        self.model.settle(t);
        self.watch.restart(self.model.dynamics(), &self.particles, self.time, self.steps);
        self.equilibrium = Some(found);
        Ok(found)
    }

    /// How the last equilibrium was found; `None` if there was none.
    pub fn equilibrium(&self) -> Option<Equilibrium> {
        self.equilibrium
    }
}

/// Mass times acceleration, zero in components that are held.
fn free_force(elastic: &Elastic, acceleration: &Column) -> Vec<f64> {
    let n = elastic.len();
    let mut force: Vec<f64> =
        acceleration.values().iter().enumerate().map(|(i, a)| elastic.mass[i % n] * a).collect();
    elastic.fixed.zero(&mut force, n);
    force
}

/// What is loose, in words.
fn describe(piece: &LoosePiece) -> String {
    let c = &piece.centre;
    let which =
        format!("the piece of {} particles around ({:.3}, {:.3}, {:.3})", piece.particles, c.x, c.y, c.z);
    if piece.free {
        format!("{which} is held by nothing, so that it has no equilibrium")
    } else {
        format!("{which} is not held enough: it can be {}", piece.motions.join(" and "))
    }
}
