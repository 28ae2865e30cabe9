//! A solid at large strain, in space or in the plane: from a set-up to its dynamics, its remeshing, and what it
//! shows.

use super::Description;
use super::checks;
use super::model::{Model, Moment, Parts};
use super::remeshing::Relaid;
use super::time_step::{choose_step, only_rk4};
use crate::boundary::nodal_load::NodalLoad;
use crate::boundary::surface_quadrature::SurfaceQuadrature;
use crate::dynamics::Dynamics;
use crate::dynamics::large_strain::body::LargeBody;
use crate::dynamics::large_strain::remeshing::LargeRemeshError;
use crate::error::{Failure, FailureKind, InvalidInput};
use crate::fit::Degree;
use crate::kernel::RemeshKernel;
use crate::mesh::TriangleMesh;
use crate::mls::PointWeights;
use crate::observe::{Reading, TaggedProbe};
use crate::particles::{Column, Field, Particles};
use crate::setup::{Formulation, Probe, Scheme, Setup};
use crate::snapshot::Snapshot;
use crate::stability::large_step_limit;
use crate::state::State;
use crate::surface::Surface;
use crate::tensor::Vec3;

/// A solid at large strain in `D` dimensions.
#[derive(Clone, Debug)]
pub(super) struct LargeSolid<const D: usize> {
    body: LargeBody<D>,
    /// Surface of the undeformed body.
    surface: TriangleMesh,
    setup: Setup,
    /// Of the particles at the vertices of the surface.
    surface_weights: PointWeights,
    tagged: Vec<TaggedProbe>,
}

impl<const D: usize> LargeSolid<D> {
    /// Samples the body and tags its boundaries, loads and probes.
    ///
    /// # Errors
    /// The first input that can not be simulated.
    pub fn parts(setup: &Setup) -> Result<Parts, InvalidInput> {
        check(setup)?;
        only_rk4(setup, "a body in the plane")?;
        let (mut body, sampled) = LargeBody::<D>::sampled(setup)?;
        let reference = body.reference().to_vec();
        let displacement = setup.initial.displacement.at_all(&reference);
        let x: Vec<Vec3> = reference.iter().zip(&displacement).map(|(x, u)| x + u).collect();
        let limit = large_step_limit(&mut body.dynamics, &x);
        if body.dynamics.inverted().is_some() {
            return Err(InvalidInput::new(
                "initial.displacement",
                "",
                "turns a part of the body inside out",
                "take a smaller displacement",
            ));
        }
        let (dt, notes) = choose_step(setup, &limit)?;
        let tagged = tag_probes(&body, setup)?;
        let surface_weights = body.weights(Degree::Quadratic, &sampled.surface.vertices);
        let configuration = &body.dynamics.configuration;
        let description = Description {
            particles: reference.len(),
            spacing: body.spacing,
            smoothing_length: configuration.smoothing_length,
            neighbours: (0..configuration.len)
                .map(|a| configuration.pairs.numbers(a).len())
                .max()
                .unwrap_or(0),
            scheme: Scheme::Rk4,
            scheme_reason: None,
            dt,
            shortest_step: None,
            fastest_decay: 0.0,
            dt_limit: limit.dt,
            limited_by_viscosity: limit.viscous,
            volume: configuration.reference_volume.iter().sum(),
            shape_volume: setup.shape.volume(),
            load: body.dynamics.loads.iter().map(NodalLoad::total).sum(),
            notes,
        };
        let velocity = setup.initial.velocity.at_all(&reference);
        let particles = particles_of(&body, &displacement, &velocity);
        let model = Self { body, surface: sampled.surface, setup: setup.clone(), surface_weights, tagged };
        Ok(Parts { model: Box::new(model), particles, description })
    }
}

impl<const D: usize> LargeSolid<D> {
    /// Finds the particles that probes and the surface read.
    fn find_readers(&mut self) -> Result<(), InvalidInput> {
        self.tagged = tag_probes(&self.body, &self.setup)?;
        self.surface_weights = self.body.weights(Degree::Quadratic, &self.surface.vertices);
        Ok(())
    }
}

impl<const D: usize> Model for LargeSolid<D> {
    fn dynamics(&self) -> &dyn Dynamics {
        &self.body.dynamics
    }

    fn dynamics_mut(&mut self) -> &mut dyn Dynamics {
        &mut self.body.dynamics
    }

    /// How far a singular value of F_inc is from 1, as a ratio: more than 0.25 is outside of 0.8 to 1.25.
    fn strain(&mut self, _particles: &Particles, _time: f64, _dt: f64) -> f64 {
        let (smallest, largest) = self.body.dynamics.stretches_since_remesh();
        largest.max(1.0 / smallest) - 1.0
    }

    fn disorder(&self, particles: &Particles, moment: Moment) -> Option<Failure> {
        let particle = self.body.dynamics.inverted()?;
        Some(checks::inverted(particles.column(Field::Reference).vector(particle), moment))
    }

    fn remesh(&mut self, particles: &Particles, moment: Moment) -> Result<Relaid, Failure> {
        let (reference, u) = (particles.column(Field::Reference), particles.column(Field::Displacement));
        let velocity = particles.column(Field::Velocity);
        let n = particles.len();
        let x: Vec<Vec3> = (0..n).map(|a| reference.vector(a) + u.vector(a)).collect();
        let v: Vec<Vec3> = (0..n).map(|a| velocity.vector(a)).collect();
        let fail = |error: &LargeRemeshError| Failure {
            kind: FailureKind::Inverted,
            time: moment.time,
            step: moment.step,
            what: format!("remeshing failed: {error}"),
            place: if let LargeRemeshError::Torn(place) = error { Some(*place) } else { None },
            remedy:
                "remesh earlier (a smaller `remesh.every`, or \"auto\"), load more slowly, or take a smaller \
                     spacing"
                    .into(),
        };
        let new = self.body.remesh(moment.time, &x, &v).map_err(|e| fail(&e))?;
        self.find_readers().map_err(|e| fail(&e.into()))?;
        let displacement: Vec<Vec3> =
            self.body.nodes().iter().zip(self.body.reference()).map(|(x, x0)| x - x0).collect();
        let [before, interpolated, _] = new.momentum;
        Ok(Relaid {
            particles: particles_of(&self.body, &displacement, &new.velocity),
            folded_mass: 0.0,
            dropped_mass: 0.0,
            momentum_correction: (interpolated - before).norm(),
            rescaling: 1.0 / (1.0 + new.raw_mass_error) - 1.0,
            limit: None,
        })
    }

    fn save(&self, state: &mut State) {
        self.body.save(state);
    }

    fn restore(&mut self, state: &State, particles: &Particles) -> Result<(), InvalidInput> {
        self.body.restore(state, particles.len())?;
        self.find_readers()
    }

    fn surface_quadrature(&self) -> Option<SurfaceQuadrature> {
        Some(self.body.surface_quadrature())
    }

    fn add_probe(&mut self, probe: &Probe) -> Result<(), InvalidInput> {
        self.setup.probes.push(probe.clone());
        match tag_probes(&self.body, &self.setup) {
            Ok(tagged) => {
                self.tagged = tagged;
                Ok(())
            }
            Err(error) => {
                self.setup.probes.pop();
                Err(error)
            }
        }
    }

    fn surface(&self, snapshot: &Snapshot) -> Surface {
        Surface::new(&self.surface, &self.surface_weights, snapshot)
    }

    fn readings(&mut self, particles: &Particles, time: f64) -> Vec<Reading> {
        let mut readings = Vec::new();
        let derived = self.tagged.iter().any(|p| !p.reads_state()).then(|| self.derived(particles, time));
        for probe in &self.tagged {
            probe.read(derived.as_ref().unwrap_or(particles), &mut readings);
        }
        readings
    }
}

/// Finds the particles that probes read, by their reference positions.
fn tag_probes<const D: usize>(body: &LargeBody<D>, setup: &Setup) -> Result<Vec<TaggedProbe>, InvalidInput> {
    let positions = body.tagging_positions();
    let volume = &body.dynamics.configuration.reference_volume;
    let weights = |points: &[Vec3]| body.weights(Degree::Quadratic, points);
    let probes = setup.probes.iter().enumerate();
    probes
        .map(|(i, p)| TaggedProbe::new(i, p, &*setup.shape, &positions, volume, body.spacing, weights))
        .collect()
}

/// The columns of the particles of `body`.
fn particles_of<const D: usize>(body: &LargeBody<D>, displacement: &[Vec3], velocity: &[Vec3]) -> Particles {
    let n = displacement.len();
    let mut particles = Particles::new(n);
    let volume = body.dynamics.configuration.volume[..n].to_vec();
    particles.set(Field::Reference, Column::from_vectors(body.reference()));
    particles.set(Field::Node, Column::from_vectors(body.nodes()));
    particles.set(Field::Displacement, Column::from_vectors(displacement));
    particles.set(Field::Velocity, Column::from_vectors(velocity));
    particles.set(Field::Mass, Column::from_vec(body.dynamics.mass.clone(), n));
    particles.set(Field::Volume, Column::from_vec(volume, n));
    particles.set(Field::LevelSet, Column::from_vec(body.level_set(), n));
    particles
}

/// What a solid at large strain can not do.
fn check(setup: &Setup) -> Result<(), InvalidInput> {
    let refuse = |key: String, value: &str, problem: &str, remedy: &str| {
        Err(InvalidInput::new(key, value, problem, remedy))
    };
    if setup.solver.formulation == Formulation::Paper {
        return refuse(
            "solver.formulation".into(),
            "paper",
            "the scheme of the paper knows small strain only",
            "take \"adjoint\", or material.model = \"kelvin-voigt\"",
        );
    }
    if setup.remesh.kernel != RemeshKernel::M4Prime {
        return refuse(
            "remesh.kernel".into(),
            setup.remesh.kernel.name(),
            "a solid at large strain is laid anew by inverting its map, interpolated by \"m4-prime\"",
            "take \"m4-prime\" or remove the key",
        );
    }
    if let Some(i) = setup.probes.iter().position(|p| p.quantity.field == Field::Colour) {
        return refuse(
            format!("probe[{i}].quantity"),
            "colour",
            "a solid has no colour: that is a field of a prescribed motion",
            "for example \"displacement.z\"",
        );
    }
    Ok(())
}
