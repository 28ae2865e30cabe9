//! A fluid beside a solid on a line, Eqs. (19) to (21), as a simulation: the fluid's remeshing, the
//! watch over the order of the particles, and readings of the interface.

mod bar;
mod parts;

use super::model::{Model, Moment};
use super::remeshing::RemeshOutcome;
use crate::dynamics::Dynamics;
use crate::dynamics::fsi_1d::FluidStructure;
use crate::error::{Failure, FailureKind, InvalidInput};
use crate::kernel::RemeshKernel;
use crate::observe::{Reading, TaggedProbe};
use crate::particles::{Field, Particles};
use crate::setup::Probe;
use crate::snapshot::Snapshot;
use crate::state::State;
use crate::surface::Surface;
use crate::tensor::Vec3;
use bar::Bar;

/// Names and units of the readings that a fluid beside a solid adds to those of its probes: place and
/// velocity of the interface, and the energies E_f and E_s.
pub(super) const READINGS: &[(&str, &str)] = &[
    ("interface_position", "m"),
    ("interface_velocity", "m/s"),
    ("fluid_energy", "J"),
    ("solid_energy", "J"),
];

/// A fluid beside a solid.
#[derive(Clone, Debug)]
pub(super) struct FluidBesideSolid {
    dynamics: FluidStructure,
    kernel: RemeshKernel,
    probes: Vec<Probe>,
    bar: Bar,
    /// Strain of the fluid since the last remeshing, as far as it was asked for.
    strain: f64,
}

impl Model for FluidBesideSolid {
    fn dynamics(&self) -> &dyn Dynamics {
        &self.dynamics
    }

    fn dynamics_mut(&mut self) -> &mut dyn Dynamics {
        &mut self.dynamics
    }

    fn strain(&mut self, particles: &Particles, _time: f64, dt: f64) -> f64 {
        self.strain += dt * self.dynamics.largest_rate(particles);
        self.strain
    }

    fn disorder(&self, particles: &Particles, moment: Moment) -> Option<Failure> {
        let crossing = self.dynamics.crossing(particles)?;
        let fluid = crossing.particle < self.dynamics.interface();
        let remedy = if fluid {
            "remesh the fluid: `remesh.every = \"auto\"`, or more often than now; if that is \
             done already, take a smaller `time.dt`"
        } else {
            "the solid is compressed to nothing: raise `dynamics.solid.elasticity` or lower the velocity"
        };
        Some(Failure {
            kind: FailureKind::Crossed,
            time: moment.time,
            step: moment.step,
            what: format!(
                "particles {} and {} of the {} have passed each other: at x = {:.6} the distance to the \
                 right neighbour is {:.3e}",
                crossing.particle,
                crossing.particle + 1,
                if fluid { "fluid" } else { "solid" },
                crossing.position,
                crossing.gap
            ),
            place: Some(Vec3::new(crossing.position, 0.0, 0.0)),
            remedy: remedy.into(),
        })
    }

    fn remesh(&mut self, particles: &Particles, moment: Moment) -> Result<RemeshOutcome, Failure> {
        let mut new = particles.clone();
        self.dynamics.remesh(self.kernel, &mut new).map_err(|error| Failure {
            kind: FailureKind::Scattered,
            time: moment.time,
            step: moment.step,
            what: error.to_string(),
            place: None,
            remedy: "take a smaller `time.dt`, or remesh more often".into(),
        })?;
        self.strain = 0.0;
        Ok(RemeshOutcome {
            particles: new,
            folded_mass: 0.0,
            dropped_mass: 0.0,
            momentum_correction: 0.0,
            rescaling: 0.0,
            limit: None,
        })
    }

    fn save(&self, state: &mut State) {
        state.put("body/strain", [self.strain]);
    }

    fn restore(&mut self, state: &State, _particles: &Particles) -> Result<(), InvalidInput> {
        [self.strain] = state.numbers("body/strain")?;
        Ok(())
    }

    fn surface(&self, snapshot: &Snapshot) -> Surface {
        self.bar.surface(snapshot)
    }

    fn readings(&mut self, particles: &Particles, time: f64) -> Vec<Reading> {
        let mut readings = Vec::new();
        if !self.probes.is_empty() {
            // The fluid's particles change places: what is in a region now.
            let derived = self.derived(particles, time, &[]);
            let snapshot = Snapshot { time, step: 0, particles: derived };
            let x: Vec<Vec3> = snapshot.positions().into_iter().map(Vec3::from).collect();
            let volume = particles.column(Field::Volume).values();
            for probe in &self.probes {
                TaggedProbe::of_particles(probe, &x, volume).read(&snapshot.particles, &mut readings);
            }
        }
        let i = self.dynamics.interface();
        let x = particles.column(Field::Reference).vector(i).x
            + particles.column(Field::Displacement).vector(i).x;
        let u = particles.column(Field::Velocity).vector(i).x;
        let [fluid, solid] = self.dynamics.energy_of_each(particles);
        let own = READINGS.iter().zip([x, u, fluid, solid]);
        readings.extend(own.map(|((name, _), value)| Reading { name: (*name).into(), value }));
        readings
    }
}
