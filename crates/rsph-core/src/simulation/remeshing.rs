//! Remeshing in a running simulation: when it is due, and what it did.

use crate::particles::Particles;
use crate::remesh::RemeshReport;
use crate::setup::{RemeshTrigger, STRAIN};
use crate::tensor::Vec3;

/// What remeshing has done since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RemeshLog {
    /// How often.
    pub count: u64,
    /// Mass before the first remeshing and after the last one.
    pub mass: [f64; 2],
    /// Momentum before the first remeshing and after the last one (zero in a prescribed motion).
    pub momentum: [Vec3; 2],
    /// Largest change of mass in one remeshing, relative to the mass.
    pub largest_mass_jump: f64,
    /// Largest change of momentum in one remeshing.
    pub largest_momentum_jump: f64,
    /// Sum of |mass| that landed on nodes which were not kept and went to their nearest kept ones.
    pub folded_mass: f64,
    /// Mass that was lost because no kept node was near.
    pub dropped_mass: f64,
    /// Particles before the first remeshing and after the last one.
    pub particles: [usize; 2],
}

impl RemeshLog {
    fn add(&mut self, r: &RemeshReport) {
        if self.count == 0 {
            (self.mass[0], self.momentum[0], self.particles[0]) = (r.mass[0], r.momentum[0], r.particles[0]);
        }
        self.count += 1;
        (self.mass[1], self.momentum[1], self.particles[1]) = (r.mass[1], r.momentum[1], r.particles[1]);
        self.largest_mass_jump = self.largest_mass_jump.max(((r.mass[1] - r.mass[0]) / r.mass[0]).abs());
        self.largest_momentum_jump = self.largest_momentum_jump.max((r.momentum[1] - r.momentum[0]).norm());
        self.folded_mass += r.folded_mass;
        self.dropped_mass += r.dropped_mass;
    }
}

/// Particles laid anew, and what that did.
#[derive(Clone, Debug)]
pub(super) struct Relaid {
    pub particles: Particles,
    pub report: RemeshReport,
}

/// When a simulation lays its particles anew, and what that has done.
#[derive(Clone, Debug)]
pub(super) struct Remeshing {
    trigger: RemeshTrigger,
    steps: u64,
    pub log: RemeshLog,
}

impl Remeshing {
    pub fn new(trigger: RemeshTrigger) -> Self {
        Self { trigger, steps: 0, log: RemeshLog::default() }
    }

    /// Counts a step; whether remeshing is due, at a strain of `strain()` since the last one.
    pub fn is_due(&mut self, strain: impl FnOnce() -> f64) -> bool {
        self.steps += 1;
        match self.trigger {
            RemeshTrigger::Never => false,
            RemeshTrigger::Steps(n) => self.steps >= n,
            RemeshTrigger::Strain => strain() > STRAIN,
        }
    }

    /// Notes a remeshing and starts to count anew.
    pub fn done(&mut self, report: &RemeshReport) {
        self.log.add(report);
        self.steps = 0;
    }
}
