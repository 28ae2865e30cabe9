//! Remeshing in a running simulation: when it is due, and what it did.

use super::balance::{momentum, total_mass};
use crate::dynamics::Energy;
use crate::error::InvalidInput;
use crate::particles::Particles;
use crate::setup::{RemeshTrigger, STRAIN};
use crate::stability::StepLimit;
use crate::state::{State, Stateful};
use crate::tensor::Vec3;

/// What remeshing has done since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RemeshLog {
    /// How often.
    pub count: u64,
    /// Sums before the first remeshing and after the last one.
    pub sums: [Sums; 2],
    /// Largest change of mass in one remeshing, relative to the mass.
    pub largest_mass_jump: f64,
    /// Largest change of momentum in one remeshing.
    pub largest_momentum_jump: f64,
    /// Largest momentum that one remeshing would have lost or made, had it not been given back.
    pub largest_momentum_correction: f64,
    /// Sum of all changes of the energy, kinetic and elastic.
    pub energy_change: f64,
    /// Sum of |mass| that landed where no particle is kept and went to the nearest one.
    pub folded_mass: f64,
    /// Mass that was lost because no particle was near.
    pub dropped_mass: f64,
    /// Largest relative change that volumes got in one remeshing so that their sum stays.
    pub largest_rescaling: f64,
    /// The smallest time step after a remeshing; 0 where remeshing does not change it.
    pub smallest_dt: f64,
}

/// Sums over the particles, on one side of a remeshing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Number of particles.
    pub particles: usize,
    /// Mass.
    pub mass: f64,
    /// Momentum (zero in a prescribed motion).
    pub momentum: Vec3,
    /// Kinetic and elastic energy (zero in a prescribed motion).
    pub energy: f64,
}

impl Sums {
    /// Sums over `particles`, with `energy` as their energy.
    pub(super) fn new(particles: &Particles, energy: Energy) -> Self {
        Self {
            particles: particles.len(),
            mass: total_mass(particles),
            momentum: momentum(particles),
            energy: energy.kinetic + energy.elastic,
        }
    }
}

/// Remeshed particles, and what that did.
#[derive(Clone, Debug)]
pub(super) struct RemeshOutcome {
    pub particles: Particles,
    /// Sum of |mass| that landed where no particle is kept and went to the nearest one.
    pub folded_mass: f64,
    /// Mass that was lost.
    pub dropped_mass: f64,
    /// Momentum that would have been lost or made, had it not been given back.
    pub momentum_correction: f64,
    /// Relative change that volumes got so that their sum stays.
    pub rescaling: f64,
    /// What is stable now, if that may have changed.
    pub limit: Option<StepLimit>,
}

/// When a simulation remeshes, and what that has done.
#[derive(Clone, Debug)]
pub(super) struct Remeshing {
    trigger: RemeshTrigger,
    steps: u64,
    elapsed: f64,
    pub log: RemeshLog,
}

impl Remeshing {
    pub fn new(trigger: RemeshTrigger) -> Self {
        Self { trigger, steps: 0, elapsed: 0.0, log: RemeshLog::default() }
    }

    /// Counts a step of length `dt`; whether remeshing is due, at a strain of `strain()` since the last
    /// one.
    pub fn is_due(&mut self, dt: f64, strain: impl FnOnce() -> f64) -> bool {
        self.steps += 1;
        self.elapsed += dt;
        match self.trigger {
            RemeshTrigger::Never => false,
            RemeshTrigger::Steps(n) => self.steps >= n,
            // Steps that add up to the interval but for rounding reach it.
            RemeshTrigger::Interval(t) => self.elapsed >= t * (1.0 - 1e-9),
            RemeshTrigger::Strain => strain() > STRAIN,
        }
    }

    /// Notes a remeshing between those sums, and starts to count anew.
    pub fn done(&mut self, outcome: &RemeshOutcome, before: Sums, after: Sums, dt: f64) {
        let log = &mut self.log;
        if log.count == 0 {
            (log.sums[0], log.smallest_dt) = (before, if outcome.limit.is_some() { dt } else { 0.0 });
        }
        log.count += 1;
        log.sums[1] = after;
        log.largest_mass_jump = log.largest_mass_jump.max((after.mass / before.mass - 1.0).abs());
        log.largest_momentum_jump = log.largest_momentum_jump.max((after.momentum - before.momentum).norm());
        log.largest_momentum_correction = log.largest_momentum_correction.max(outcome.momentum_correction);
        log.energy_change += after.energy - before.energy;
        log.folded_mass += outcome.folded_mass;
        log.dropped_mass += outcome.dropped_mass;
        log.largest_rescaling = log.largest_rescaling.max(outcome.rescaling.abs());
        log.smallest_dt = log.smallest_dt.min(dt);
        (self.steps, self.elapsed) = (0, 0.0);
    }
}

/// The numbers of a log that a checkpoint keeps beside its sums.
fn kept(log: &mut RemeshLog) -> [&mut f64; 8] {
    [
        &mut log.largest_mass_jump,
        &mut log.largest_momentum_jump,
        &mut log.largest_momentum_correction,
        &mut log.energy_change,
        &mut log.folded_mass,
        &mut log.dropped_mass,
        &mut log.largest_rescaling,
        &mut log.smallest_dt,
    ]
}

impl Stateful for Remeshing {
    fn save(&self, state: &mut State) {
        let log = &self.log;
        let [before, after] = &log.sums;
        let particles = [before.particles, after.particles].map(|n| n as u64);
        state.put_counts("remesh/counts", &[self.steps, log.count, particles[0], particles[1]]);
        state.put("remesh/elapsed", [self.elapsed]);
        state.put("remesh/sums", [before.mass, before.energy, after.mass, after.energy]);
        state.put_vectors("remesh/momenta", &[before.momentum, after.momentum]);
        state.put("remesh/log", kept(&mut log.clone()).map(|number| *number));
    }

    fn restore(&mut self, state: &State) -> Result<(), InvalidInput> {
        let [steps, count, first, last] = state.counts("remesh/counts")?;
        [self.elapsed] = state.numbers("remesh/elapsed")?;
        self.steps = steps;
        let [mass_before, energy_before, mass_after, energy_after] = state.numbers("remesh/sums")?;
        let momenta = state.vectors("remesh/momenta", 2)?;
        let sums = |particles: u64, mass, energy, momentum| Sums {
            particles: particles as usize,
            mass,
            momentum,
            energy,
        };
        let log = &mut self.log;
        log.count = count;
        log.sums = [
            sums(first, mass_before, energy_before, momenta[0]),
            sums(last, mass_after, energy_after, momenta[1]),
        ];
        for (number, stored) in kept(log).into_iter().zip(state.numbers::<8>("remesh/log")?) {
            *number = stored;
        }
        Ok(())
    }
}
