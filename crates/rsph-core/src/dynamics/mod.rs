//! What moves the particles: one dynamics a file.

pub mod fsi_1d;
pub mod paper;
pub mod prescribed;
pub mod solid;

pub use crate::boundary::force_sums::{ForceSums, Imposed};
use crate::boundary::nodal_load::NodalLoad;
use crate::particles::{Column, Field, Particles};

/// Columns of every frame of a solid that are derived from its state.
pub const DERIVED: [Field; 4] = [Field::Density, Field::Strain, Field::Stress, Field::VonMises];

/// Energies at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Solid energy, that of the hourglass term included.
    pub elastic: f64,
}

/// What the balances of a dynamics hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Account {
    /// Whether its equations conserve mass.
    pub conserves_mass: bool,
    /// Whether [`ForceSums::dissipation`] is what viscosity takes; else that is known only as what is missing
    /// in the balance of energy.
    pub sums_dissipation: bool,
}

/// Shares of masses M, stiffness K = -df/du and damping C = -df/dv in m M + k K + c C.
///
/// (0, 1, 0) is the static stiffness; (1, s^2, s) with s = gamma dt an implicit stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scales {
    /// m.
    pub mass: f64,
    /// k.
    pub stiffness: f64,
    /// c.
    pub damping: f64,
}

impl Scales {
    /// K alone.
    pub const STATIC: Self = Self { mass: 0.0, stiffness: 1.0, damping: 0.0 };

    /// k + c T, by which K counts where C = T K.
    pub fn of_stiffness(&self, relaxation_time: f64) -> f64 {
        self.stiffness + self.damping * relaxation_time
    }
}

/// A right-hand side.
pub trait Dynamics: std::fmt::Debug + Send + Sync {
    /// The columns that are integrated in time.
    fn integrated(&self) -> &'static [Field];

    /// Whether it stays bounded at a time step below its limit.
    fn is_stable(&self) -> bool {
        true
    }

    /// What its balances hold.
    fn account(&self) -> Account {
        Account { conserves_mass: true, sums_dissipation: false }
    }

    /// Whether the displacement is integrated before the velocity, which is its rate wherever [`Dynamics::impose`]
    /// does not set it: the column of this rate may then be empty.
    fn moves_with_velocity(&self) -> bool {
        false
    }

    /// Rates of change of the integrated columns at time `t`, in the order of
    /// [`Dynamics::integrated`].
    fn rates(&mut self, t: f64, particles: &Particles, rates: &mut [Column]) -> ForceSums;

    /// Sets what is prescribed at time `t`; returns what this added to the body.
    fn impose(&self, t: f64, particles: &mut Particles) -> Imposed;

    /// Adds the derived columns of every frame (strain, stress, density, ...) to a copy of the state.
    fn derive(&mut self, t: f64, particles: &mut Particles);

    /// Adds at least those of the derived columns, [measures](crate::measures::MEASURES) of a solid among them.
    fn derive_some(&mut self, t: f64, wanted: &[Field], particles: &mut Particles) {
        let _ = wanted;
        self.derive(t, particles);
    }

    /// The loads on its particles; `None`: it has no place for loads.
    fn loads_mut(&mut self) -> Option<&mut Vec<NodalLoad>> {
        None
    }

    /// The solid whose stiffness implicit and static solves use; `None`: there is none.
    fn solid(&mut self) -> Option<&mut solid::Solid> {
        None
    }

    /// The smallest det F and the particle that has it, where the dynamics does not look after that at every step.
    fn smallest_jacobian(&mut self, t: f64, particles: &Particles) -> Option<(usize, f64)> {
        let _ = (t, particles);
        None
    }

    /// Energies at this moment.
    fn energy(&mut self, t: f64, particles: &Particles) -> Energy;
}
