//! The seam between a simulation and the kind of body that it moves.

use super::Description;
use super::remeshing::RemeshOutcome;
use crate::boundary::reaction::Reaction;
use crate::boundary::surface_quadrature::SurfaceQuadrature;
use crate::dynamics::{DERIVED, Dynamics};
use crate::error::{Failure, InvalidInput};
use crate::material::Material;
use crate::observe::Reading;
use crate::particles::{Field, Particles};
use crate::setup::{Load, Probe};
use crate::snapshot::Snapshot;
use crate::state::State;
use crate::surface::Surface;
use dyn_clone::DynClone;
use std::sync::Arc;

/// What a kind of body brings: its dynamics, how it is remeshed, and what it shows. The particles,
/// their integration in time, the watchdog and the balances are the simulation's.
pub(super) trait Model: DynClone + std::fmt::Debug + Send + Sync {
    /// What moves the particles.
    fn dynamics(&self) -> &dyn Dynamics;

    /// What moves the particles.
    fn dynamics_mut(&mut self) -> &mut dyn Dynamics;

    /// The strain since the last remeshing, largest over the particles; called after every step (of
    /// length `dt`) of a simulation that goes by it.
    fn strain(&mut self, particles: &Particles, time: f64, dt: f64) -> f64;

    /// What is wrong with the order of the particles, if anything; looked at after every step.
    fn disorder(&self, particles: &Particles, moment: Moment) -> Option<Failure> {
        let _ = (particles, moment);
        None
    }

    /// Lays the particles anew and makes its dynamics that of the new ones. A model that fails stays
    /// as it was.
    ///
    /// # Errors
    /// Particles that can not be remeshed.
    fn remesh(&mut self, particles: &Particles, moment: Moment) -> Result<RemeshOutcome, Failure>;

    /// Replaces all loads at that time.
    ///
    /// # Errors
    /// A load that acts on nothing, or a body whose loads are what they are; it stays as it was.
    fn set_loads(&mut self, loads: &[Load], time: f64) -> Result<(), InvalidInput> {
        let _ = (loads, time);
        Err(InvalidInput::new(
            "load",
            "",
            "only the loads of a solid in space in the adjoint formulation can be replaced as it moves",
            "give the loads a `curve`, or start a new simulation",
        ))
    }

    /// Takes another material in the place of number `k`, of the same density and linear if the one before is.
    ///
    /// # Errors
    /// A body whose material is what it is; it stays as it was.
    fn set_material(&mut self, k: usize, material: &Arc<dyn Material>) -> Result<(), InvalidInput> {
        let _ = k;
        Err(InvalidInput::new(
            "material",
            material.name(),
            "only that of a solid in the adjoint formulation can be replaced as it moves",
            "start a new simulation",
        ))
    }

    /// Knows that the body is at rest under its loads at that time.
    fn settle(&mut self, time: f64) {
        let _ = time;
    }

    /// Puts what the particles and the set-up do not say of the body into `state`.
    fn save(&self, state: &mut State);

    /// Takes it back, with `particles` of that state.
    ///
    /// # Errors
    /// A state of another body, or one that is damaged.
    fn restore(&mut self, state: &State, particles: &Particles) -> Result<(), InvalidInput>;

    /// The quadrature of the undeformed surface with the weights of the present particles at its points;
    /// `None` for a body that forces can not be put on.
    fn surface_quadrature(&self) -> Option<SurfaceQuadrature> {
        None
    }

    /// Adds a probe, after those that are there.
    ///
    /// # Errors
    /// A probe that reads nothing, or a body whose probes are what they are; it stays as it was.
    fn add_probe(&mut self, probe: &Probe) -> Result<(), InvalidInput> {
        Err(InvalidInput::new(
            "probe",
            &probe.name,
            "only a solid takes probes as it moves",
            "give the probe when the simulation is made",
        ))
    }

    /// The surface of the moment of `snapshot`.
    fn surface(&self, snapshot: &Snapshot) -> Surface;

    /// The readings of this moment, in the order of the probes; readings of its own follow.
    fn readings(&mut self, particles: &Particles, time: f64) -> Vec<Reading>;

    /// What every boundary carries, in the order of the set-up; nothing for a body without a stiffness.
    fn reactions(&mut self, particles: &Particles, time: f64) -> Vec<Reaction> {
        let _ = (particles, time);
        Vec::new()
    }

    /// The state with the derived columns of every frame and, of a solid, those `further` ones.
    fn derived(&mut self, particles: &Particles, time: f64, further: &[Field]) -> Particles {
        let mut particles = particles.clone();
        self.dynamics_mut().derive_some(time, &[&DERIVED, further].concat(), &mut particles);
        particles
    }
}

dyn_clone::clone_trait_object!(Model);

/// When something happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moment {
    /// Simulated time.
    pub time: f64,
    /// Time steps taken.
    pub step: u64,
}

/// A body ready to start.
#[derive(Debug)]
pub(super) struct Parts {
    /// The body.
    pub model: Box<dyn Model>,
    /// Its particles.
    pub particles: Particles,
    /// What is known of it.
    pub description: Description,
}
