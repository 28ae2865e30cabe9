//! The watchdog: a simulation that goes wrong stops by itself and keeps its last good state.

use crate::dynamics::{Dynamics, Energy};
use crate::error::{Failure, FailureKind, InvalidInput};
use crate::particles::{Column, Field, Particles};
use crate::state::State;

/// Steps between two looks at the state.
const INTERVAL: u64 = 20;
/// Steps to the first look: a wrong setting shows at once.
const FIRST: u64 = 4;
/// Energy that may appear from nowhere, as a share of the largest work so far. A good run stays below
/// 1e-3; one that blows up passes any bound within a few looks.
const TOLERANCE: f64 = 0.25;
/// The same for a formulation that does not conserve energy even while it looks fine.
const TOLERANCE_OF_UNSTABLE: f64 = 10.0;

/// What the watchdog looks at besides the particles.
#[derive(Clone, Copy, Debug)]
pub struct Check {
    /// Energies.
    pub energy: Energy,
    /// Work done on the body since the start.
    pub work: f64,
    /// Smallest det F with its particle, if it is to be judged.
    pub smallest_jacobian: Option<(usize, f64)>,
}

/// Keeps the last good state and knows what a good state is.
#[derive(Clone, Debug)]
pub struct Watchdog {
    good: Vec<Column>,
    time: f64,
    step: u64,
    /// Step of the last look; a remesh in between is none.
    checked: u64,
    start: f64,
    scale: f64,
    rounding: f64,
}

impl Watchdog {
    /// Starts from a good state of that energy; `rounding` times the square of a displacement is the
    /// energy that rounding may feign.
    pub fn new(dynamics: &dyn Dynamics, particles: &Particles, energy: Energy, rounding: f64) -> Self {
        let start = energy.kinetic + energy.elastic;
        Self {
            good: copy(dynamics, particles),
            time: 0.0,
            step: 0,
            checked: 0,
            start,
            scale: start,
            rounding,
        }
    }

    /// Starts anew from other particles, which a remeshing has made of a good state.
    pub fn restart(&mut self, dynamics: &dyn Dynamics, particles: &Particles, time: f64, step: u64) {
        self.good = copy(dynamics, particles);
        (self.time, self.step) = (time, step);
    }

    /// Whether it is time for a look.
    pub fn is_due(&self, step: u64) -> bool {
        step >= self.checked + self.checked.clamp(FIRST, INTERVAL)
    }

    /// Looks at the state after `step` steps and keeps it if it is good.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn check(
        &mut self,
        dynamics: &dyn Dynamics,
        particles: &Particles,
        sums: &Check,
        time: f64,
        step: u64,
    ) -> Result<(), Failure> {
        let Check { energy, work, smallest_jacobian } = *sums;
        let u = particles.column(Field::Displacement);
        let n = particles.len();
        let remedy = if dynamics.is_stable() {
            "take `time.dt = \"auto\"`, and check the loads against the stiffness of the material"
        } else {
            "this formulation is unstable by itself: take `solver.formulation = \"adjoint\"`"
        };
        let fail = |kind, what: String, a: Option<usize>| Failure {
            kind,
            time,
            step,
            what,
            place: a.map(|a| particles.column(Field::Reference).vector(a)),
            remedy: remedy.into(),
        };
        for field in dynamics.integrated() {
            let column = particles.column(*field);
            if let Some(i) = column.values().iter().position(|x| !x.is_finite()) {
                let what = format!("{} is not a finite number", field.spec().name);
                return Err(fail(FailureKind::NotFinite, what, Some(i % n)));
            }
        }
        let farthest = (0..n).max_by(|&a, &b| u.vector(a).norm().total_cmp(&u.vector(b).norm()));
        let total = energy.kinetic + energy.elastic;
        let excess = total - self.start - work;
        self.scale = self.scale.max(work.abs());
        let tolerance = if dynamics.is_stable() { TOLERANCE } else { TOLERANCE_OF_UNSTABLE };
        // A body that only moves as a whole has an elastic energy of rounding.
        let reach = farthest.map_or(0.0, |a| u.vector(a).norm());
        let noise = self.rounding * reach * reach;
        if !total.is_finite() || excess > tolerance * self.scale + noise {
            let what = format!(
                "unstable: kinetic {:.4e} + elastic {:.4e} energy is {:.4e} more than the body had and \
                 the work done on it ({work:.4e})",
                energy.kinetic, energy.elastic, excess
            );
            return Err(fail(FailureKind::Unstable, what, farthest));
        }
        if let Some((a, jacobian)) = smallest_jacobian.filter(|j| j.1.is_nan() || j.1 <= 0.0) {
            let what = format!("a particle was turned inside out (det F = {jacobian:.3} <= 0)");
            let remedy = "loads or moved parts are too much for this stiffness at small strain: lower them, take a \
                          stiffer material, or one whose law is for large strain (`material.model = \"neo-hookean\"`)";
            return Err(Failure { remedy: remedy.into(), ..fail(FailureKind::Inverted, what, Some(a)) });
        }
        for (good, field) in self.good.iter_mut().zip(dynamics.integrated()) {
            good.values_mut().copy_from_slice(particles.column(*field).values());
        }
        (self.time, self.step, self.checked) = (time, step, step);
        Ok(())
    }

    /// Puts the last good state back; returns its time and step.
    pub fn restore(&self, dynamics: &dyn Dynamics, particles: &mut Particles) -> (f64, u64) {
        for (good, field) in self.good.iter().zip(dynamics.integrated()) {
            particles.column_mut(*field).values_mut().copy_from_slice(good.values());
        }
        (self.time, self.step)
    }

    /// Puts the last good state and what it is judged by into `state`.
    pub fn save(&self, state: &mut State) {
        state.put("watch/sums", [self.time, self.start, self.scale]);
        state.put_counts("watch/steps", &[self.step, self.checked]);
        for (i, column) in self.good.iter().enumerate() {
            state.share(&format!("watch/good_{i}"), column.share());
        }
    }

    /// Takes it back for `dynamics` of `n` particles.
    ///
    /// # Errors
    /// What is missing or has another length.
    pub fn restore_state(
        &mut self,
        state: &State,
        dynamics: &dyn Dynamics,
        n: usize,
    ) -> Result<(), InvalidInput> {
        [self.time, self.start, self.scale] = state.numbers("watch/sums")?;
        [self.step, self.checked] = state.counts("watch/steps")?;
        let good = |(i, field): (usize, &Field)| {
            let values = state.real_of(&format!("watch/good_{i}"), field.spec().components * n)?;
            Ok(Column::from_vec(values.to_vec(), n))
        };
        self.good = dynamics.integrated().iter().enumerate().map(good).collect::<Result<_, _>>()?;
        Ok(())
    }
}

fn copy(dynamics: &dyn Dynamics, particles: &Particles) -> Vec<Column> {
    let own = |f: &Field| Column::from_vec(particles.column(*f).values().to_vec(), particles.len());
    dynamics.integrated().iter().map(own).collect()
}
