//! Straight to equilibrium.

use super::Simulation;
use super::model::Moment;
use crate::dynamics::solid::Solid;
use crate::dynamics::{Dynamics, ForceSums};
use crate::error::{Failure, FailureKind};
use crate::particles::{Column, Field};
use crate::solve::newton::Newton;
use crate::solve::rigid::{LoosePiece, loose_pieces};
use crate::tensor::Vec3;

/// Residual at which a body counts as at rest, as a share of the load.
const TOLERANCE: f64 = 1e-6;
/// The same where forces of boundaries are read, which are in error by as much.
const TOLERANCE_OF_REACTIONS: f64 = 1e-10;

/// How an equilibrium was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Equilibrium {
    /// Iterations of the linear solver.
    pub iterations: usize,
    /// Steps of Newton's method: one or two if the law is linear.
    pub steps: usize,
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
        let moment = Moment { time: self.time, step: self.steps };
        let reads_reactions = self.reads_reactions();
        let solid = held_solid(self.model.dynamics_mut(), moment)?;
        let n = self.particles.len();
        let start = [Field::Displacement, Field::Velocity].map(|f| self.particles.column(f).clone());
        let is_linear = solid.is_linear();
        let mut u = start[0].values().to_vec();
        let (found, sums, mut trouble) = solid.fully_relaxed(|solid| {
            let mut newton = Newton::new(solid, t);
            let ended = newton.solve(TOLERANCE, &mut u, watch);
            if ended.is_ok() && reads_reactions {
                newton.refine(TOLERANCE_OF_REACTIONS, &mut u, watch);
            }
            let (found, sums) = reached(&mut newton, &u);
            let trouble = ended.err().map(|_| {
                let place = newton.moves_most().map(|a| self.particles.column(Field::Reference).vector(a));
                not_converged(&found, is_linear, place, moment)
            });
            (found, sums, trouble)
        });
        self.particles.set(Field::Displacement, Column::from_vec(u, n));
        self.particles.set(Field::Velocity, Column::zeros(3, n));
        if trouble.is_none() {
            let smallest = self.model.dynamics_mut().smallest_jacobian(t, &self.particles);
            trouble = smallest.filter(|j| j.1 <= 0.0).map(|(a, jacobian)| {
                let place = self.particles.column(Field::Reference).vector(a);
                inverted_at_rest(jacobian, is_linear, place, moment)
            });
        }
        self.evaluations += found.applications + 1;
        if let Some(failure) = trouble {
            let [u, v] = start;
            self.particles.set(Field::Displacement, u);
            self.particles.set(Field::Velocity, v);
            return Err(failure);
        }
        if let Some(solid) = self.model.dynamics_mut().solid() {
            solid.relax_fully(t, &mut self.particles);
        }
        let energy = self.model.dynamics_mut().energy(t, &self.particles);
        self.balance.settle(energy, sums);
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

/// The solid that can be brought to rest.
///
/// # Errors
/// A body without stiffness, or one of which a piece is loose.
fn held_solid(dynamics: &mut dyn Dynamics, moment: Moment) -> Result<&mut Solid, Failure> {
    let Some(solid) = dynamics.solid() else {
        return Err(fail(
            moment,
            "this body has no stiffness: an equilibrium needs the adjoint formulation of a solid".into(),
            None,
            "set `solver.formulation = \"adjoint\"` and leave `dynamics.kind` at \"solid\"",
        ));
    };
    if let Some(piece) = loose_pieces(solid).first() {
        return Err(fail(
            moment,
            describe(piece),
            Some(piece.centre),
            "hold more of it: a clamp on a face or a region holds everything, `fix` some components",
        ));
    }
    Ok(solid)
}

/// What the method has reached with the displacement u, and what acts on the body there.
fn reached(newton: &mut Newton<'_>, u: &[f64]) -> (Equilibrium, ForceSums) {
    let residual = newton.residual_at(1.0, u) / newton.reference;
    let mut load = vec![0.0; u.len()];
    newton.solid.load_at(newton.t, u, &mut load);
    let sums = newton.solid.sums_at_rest(&load, &newton.force);
    let found = Equilibrium {
        iterations: newton.iterations,
        steps: newton.steps,
        applications: newton.solver.applications(),
        residual: if newton.reference > 0.0 { residual } else { 0.0 },
        compliance: load.iter().zip(u).map(|(f, u)| f * u).sum(),
        load: sums.load,
        reaction: sums.reaction,
    };
    (found, sums)
}

/// A solve without end, in words.
fn not_converged(found: &Equilibrium, is_linear: bool, place: Option<Vec3>, moment: Moment) -> Failure {
    let why = if is_linear {
        "some part hangs by a piece too thin for the spacing"
    } else {
        "the body gives way under the loads, or some part hangs by a piece too thin for the spacing"
    };
    let Equilibrium { iterations, residual, .. } = found;
    fail(
        moment,
        format!(
            "no equilibrium after {iterations} iterations: {residual:.1e} of the load is out of balance; {why}"
        ),
        place,
        "choose a smaller spacing, smaller loads, or hold that part, which moves most",
    )
}

/// An equilibrium with a particle inside out, in words.
fn inverted_at_rest(jacobian: f64, is_linear: bool, place: Vec3, moment: Moment) -> Failure {
    let remedy = if is_linear {
        "the loads are too much for this stiffness at small strain: lower them, take a stiffer material, or a \
         law for any strain such as \"neo-hookean\""
    } else {
        "lower the loads, or take a stiffer material"
    };
    let what = format!("at rest a particle would be turned inside out (det F = {jacobian:.3} <= 0)");
    Failure { kind: FailureKind::Inverted, ..fail(moment, what, Some(place), remedy) }
}

fn fail(moment: Moment, what: String, place: Option<Vec3>, remedy: &str) -> Failure {
    let Moment { time, step } = moment;
    Failure { kind: FailureKind::NotConverged, time, step, what, place, remedy: remedy.into() }
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
