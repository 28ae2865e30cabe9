//! The sums that the equations conserve, and what changes them.

use crate::dynamics::{Account, Energy, ForceSums, Imposed};
use crate::error::InvalidInput;
use crate::integrate::StepSums;
use crate::particles::{Field, Particles};
use crate::state::{State, Stateful};
use crate::tensor::Vec3;

/// Sums that the equations conserve, and what changes them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Conservation {
    /// Total mass.
    pub mass: f64,
    /// Total linear momentum.
    pub momentum: Vec3,
    /// Kinetic energy.
    pub kinetic_energy: f64,
    /// Elastic energy, hourglass energy included.
    pub elastic_energy: f64,
    /// Work done by loads and moving boundaries since the start.
    pub external_work: f64,
    /// Energy taken by the viscosity since the start: summed up by the dynamics if it does so, else what is
    /// missing.
    pub dissipated: f64,
    /// |energy + dissipated - energy at the start - work| relative to the larger of the energy at the start and
    /// the work; `None` where what is dissipated is known only as what is missing.
    pub energy_error: Option<f64>,
    /// Total force of the loads at this moment.
    pub load: Vec3,
    /// Total force of the clamps on the body at this moment.
    pub reaction: Vec3,
    /// |momentum - momentum at the start - impulse of loads and reactions| relative to the largest
    /// momentum or impulse, that of the loads alone included, so far.
    pub momentum_error: f64,
    /// |mass - mass at the start| / mass at the start; 0 where the equations do not conserve mass.
    pub mass_error: f64,
}

/// The balance of a simulation since its start.
#[derive(Clone, Copy, Debug)]
pub(super) struct Balance {
    account: Account,
    mass: f64,
    momentum: Vec3,
    energy: Energy,
    impulse: Vec3,
    load_impulse: Vec3,
    /// Work of loads and boundaries so far.
    pub work: f64,
    dissipated: f64,
    largest_momentum: f64,
    forces: ForceSums,
}

impl Balance {
    /// Starts from particles with that energy and those forces on them.
    pub fn new(account: Account, particles: &Particles, energy: Energy, forces: ForceSums) -> Self {
        let momentum = momentum(particles);
        Self {
            account,
            mass: total_mass(particles),
            momentum,
            energy,
            impulse: Vec3::zeros(),
            load_impulse: Vec3::zeros(),
            work: 0.0,
            dissipated: 0.0,
            largest_momentum: momentum.norm(),
            forces,
        }
    }

    /// Adds what a step did; `forces` are those at its start.
    pub fn add(&mut self, step: &StepSums, forces: ForceSums) {
        self.forces = forces;
        self.impulse += step.load + step.reaction;
        self.work += step.work;
        self.dissipated += step.dissipated;
        self.load_impulse += step.load;
        let reached = self.impulse.norm().max(self.load_impulse.norm());
        self.largest_momentum = self.largest_momentum.max(reached);
    }

    /// The body has been brought to rest under `forces`, as slowly as it takes to dissipate nothing.
    pub fn settle(&mut self, energy: Energy, forces: ForceSums) {
        self.forces = forces;
        self.work = energy.kinetic + energy.elastic - self.energy.kinetic - self.energy.elastic;
        self.impulse = -self.momentum;
    }

    /// Adds what was imposed on the body outside of a step.
    pub fn impose(&mut self, imposed: &Imposed) {
        self.impulse += imposed.momentum;
        self.work += imposed.energy;
    }

    /// The sums of this moment.
    pub fn conservation(&self, particles: &Particles, energy: Energy) -> Conservation {
        let Energy { kinetic, elastic } = energy;
        let (mass, momentum) = (total_mass(particles), momentum(particles));
        let defect = (momentum - self.momentum - self.impulse).norm();
        let missing = self.energy.kinetic + self.energy.elastic + self.work - kinetic - elastic;
        let at_stake = (self.energy.kinetic + self.energy.elastic).max(self.work.abs());
        let share = |x: f64| if at_stake > 0.0 { x.abs() / at_stake } else { 0.0 };
        let summed = self.account.sums_dissipation;
        let scale = self.largest_momentum.max(momentum.norm());
        Conservation {
            mass,
            momentum,
            kinetic_energy: kinetic,
            elastic_energy: elastic,
            external_work: self.work,
            dissipated: if summed { self.dissipated } else { missing },
            energy_error: summed.then(|| share(missing - self.dissipated)),
            load: self.forces.load,
            reaction: self.forces.reaction,
            momentum_error: if scale > 0.0 { defect / scale } else { 0.0 },
            mass_error: if self.account.conserves_mass { (mass - self.mass).abs() / self.mass } else { 0.0 },
        }
    }
}

impl Stateful for Balance {
    fn save(&self, state: &mut State) {
        let Energy { kinetic, elastic } = self.energy;
        let f = &self.forces;
        state.put("balance/start", [self.mass, kinetic, elastic]);
        state.put("balance/done", [self.work, self.dissipated]);
        state.put("balance/scale", [self.largest_momentum]);
        state.put("balance/power", [f.power, f.dissipation]);
        state.put_vectors(
            "balance/vectors",
            &[self.momentum, self.impulse, self.load_impulse, f.load, f.reaction],
        );
    }

    fn restore(&mut self, state: &State) -> Result<(), InvalidInput> {
        let Energy { kinetic, elastic } = &mut self.energy;
        [self.mass, *kinetic, *elastic] = state.numbers("balance/start")?;
        [self.work, self.dissipated] = state.numbers("balance/done")?;
        [self.largest_momentum] = state.numbers("balance/scale")?;
        let [power, dissipation] = state.numbers("balance/power")?;
        let v = state.vectors("balance/vectors", 5)?;
        (self.momentum, self.impulse, self.load_impulse) = (v[0], v[1], v[2]);
        self.forces = ForceSums { load: v[3], reaction: v[4], power, dissipation };
        Ok(())
    }
}

/// Sum of the masses.
pub(super) fn total_mass(particles: &Particles) -> f64 {
    particles.column(Field::Mass).values().iter().sum()
}

/// Sum of mass times velocity; zero where particles carry no velocity.
pub(super) fn momentum(particles: &Particles) -> Vec3 {
    let (m, v) = (particles.column(Field::Mass), particles.column(Field::Velocity));
    if v.is_empty() {
        return Vec3::zeros();
    }
    (0..particles.len()).map(|a| m.values()[a] * v.vector(a)).sum()
}
