//! A solid: from a set-up to its dynamics, with boundaries, loads and probes tagged.

use super::Description;
use super::model::{Model, Moment, Parts};
use super::remeshing::Relaid;
use super::time_step::choose_pace;
use crate::boundary::load::{LoadedBody, nodal_loads};
use crate::boundary::mirror::Mirror;
use crate::boundary::tag;
use crate::dynamics::Dynamics;
use crate::dynamics::elastic::Elastic;
use crate::dynamics::paper::Paper;
use crate::error::{Failure, FailureKind, InvalidInput};
use crate::lattice::Lattice;
use crate::mls::PointWeights;
use crate::moments::area_vectors;
use crate::observe::{Reading, TaggedProbe};
use crate::particles::{Column, Field, Particles};
use crate::sample::{Body, sample};
use crate::setup::{Formulation, RemeshTrigger, Setup, VectorField};
use crate::snapshot::Snapshot;
use crate::stability::step_limit;
use crate::surface::Surface;
use crate::tensor::Vec3;
use std::sync::Arc;

/// A solid body.
#[derive(Debug)]
pub(super) struct Solid {
    body: Body,
    dynamics: Box<dyn Dynamics>,
    probes: Vec<TaggedProbe>,
    /// Of the particles at the vertices of the undeformed surface.
    surface_weights: PointWeights,
}

impl Solid {
    /// Samples the body and tags its boundaries, loads and probes.
    ///
    /// # Errors
    /// The first input that can not be simulated.
    pub fn parts(setup: &Setup) -> Result<Parts, InvalidInput> {
        let solver = setup.solver;
        check_solid(setup)?;
        let shape = &*setup.shape;
        let alignment = tag::alignment(&setup.boundaries, &shape.bounds(), &solver);
        let body = sample(shape, setup.resolution, &alignment)?;
        let (dx, origin) = (body.grid.spacing, body.grid.origin);
        let n = body.cells.len();
        let positions: Vec<Vec3> = body.cells.iter().map(|c| body.grid.centre(*c)).collect();
        let volume: Vec<f64> = body.fraction.iter().map(|f| f * dx.powi(3)).collect();

        let tags = tag::tag(&setup.boundaries, &positions, dx, &solver)?;
        let lattice = Lattice::new(&body.grid, &body.cells, solver.smoothing);
        let mirror = Mirror::new(&lattice, &origin, &positions, tags.planes);
        let mut elastic =
            Elastic::new(lattice, &volume, mirror, tags.fixed, Arc::clone(&setup.material), solver.hourglass);
        let weights = |points: &[Vec3]| PointWeights::new(&elastic.lattice, &origin, &positions, points);
        let area = area_vectors(&elastic.lattice, &elastic.moments, &elastic.mirror);
        let loaded = LoadedBody {
            shape,
            mass: &elastic.mass,
            positions: &positions,
            area_vectors: &area,
            spacing: dx,
            smoothing_length: elastic.lattice.smoothing_length,
            tolerance: 1e-3 * dx,
        };
        let loads = nodal_loads(&setup.loads, &loaded, weights)?;
        let probes = setup
            .probes
            .iter()
            .enumerate()
            .map(|(i, p)| TaggedProbe::new(i, p, shape, &positions, &volume, dx, weights))
            .collect::<Result<Vec<_>, _>>()?;
        let surface_weights = weights(&body.surface.vertices);

        let limit = step_limit(&mut elastic);
        let pace = choose_pace(setup, &limit, solver.formulation == Formulation::Adjoint)?;
        let total_volume: f64 = volume.iter().sum();
        let description = Description {
            particles: n,
            spacing: dx,
            smoothing_length: elastic.lattice.smoothing_length,
            neighbours: elastic.lattice.neighbours.len(),
            scheme: pace.scheme,
            scheme_reason: pace.reason,
            dt: pace.dt,
            shortest_step: pace.adaptive,
            fastest_decay: setup.material.relaxation_time() * limit.kappa,
            dt_limit: limit.dt,
            limited_by_viscosity: limit.viscous,
            volume: total_volume,
            shape_volume: shape.volume(),
            load: loads.iter().map(crate::boundary::nodal_load::NodalLoad::total).sum(),
            notes: pace.notes,
        };

        let mut particles = Particles::new(n);
        particles.set(Field::Reference, Column::from_vectors(&positions));
        let at = |f: &VectorField| Column::from_vectors(&f.at_all(&positions));
        particles.set(Field::Displacement, at(&setup.initial.displacement));
        particles.set(Field::Velocity, at(&setup.initial.velocity));
        particles.set(Field::Mass, Column::from_vec(elastic.mass.clone(), n));
        particles.set(Field::Volume, Column::from_vec(volume, n));
        particles.set(Field::LevelSet, Column::from_vec(body.level_set.clone(), n));
        elastic.loads = loads;
        let dynamics: Box<dyn Dynamics> = match solver.formulation {
            Formulation::Adjoint => Box::new(elastic),
            Formulation::Paper => {
                let strain = elastic.strain(0.0, particles.column(Field::Displacement).values());
                particles.set(Field::Strain, Column::from_vec(strain, n));
                particles.set(Field::Density, Column::from_vec(vec![setup.material.density(); n], n));
                let Elastic { material, mass, fixed, loads, .. } = elastic;
                Box::new(Paper::new(material, mass, dx, solver.smoothing, fixed, loads))
            }
        };
        let model = Box::new(Self { body, dynamics, probes, surface_weights });
        Ok(Parts { model, particles, description })
    }
}

impl Model for Solid {
    fn dynamics(&self) -> &dyn Dynamics {
        &*self.dynamics
    }

    fn dynamics_mut(&mut self) -> &mut dyn Dynamics {
        &mut *self.dynamics
    }

    fn strain(&mut self, _particles: &Particles, _time: f64, _dt: f64) -> f64 {
        0.0
    }

    fn remesh(&mut self, _particles: &Particles, moment: Moment) -> Result<Relaid, Failure> {
        Err(Failure {
            kind: FailureKind::Scattered,
            time: moment.time,
            step: moment.step,
            what: "a solid is not laid anew".into(),
            place: None,
            remedy: "set `remesh.every = 0`".into(),
        })
    }

    fn surface(&self, snapshot: &Snapshot) -> Surface {
        Surface::new(&self.body.surface, &self.surface_weights, snapshot)
    }

    fn readings(&mut self, particles: &Particles, time: f64) -> Vec<Reading> {
        let mut readings = Vec::new();
        let derived = self.probes.iter().any(|p| !p.reads_state()).then(|| self.derived(particles, time));
        for probe in &self.probes {
            probe.read(derived.as_ref().unwrap_or(particles), &mut readings);
        }
        readings
    }
}

/// What only a prescribed motion has.
fn check_solid(setup: &Setup) -> Result<(), InvalidInput> {
    if setup.remesh.trigger != RemeshTrigger::Never {
        return Err(InvalidInput::new(
            "remesh.every",
            "",
            "remeshing of a solid is not there yet; only 0 (never) is allowed",
            "set `every = 0` or remove the table",
        ));
    }
    if let Some(i) = setup.probes.iter().position(|p| p.quantity.field == Field::Colour) {
        return Err(InvalidInput::new(
            format!("probe[{i}].quantity"),
            "colour",
            "a solid has no colour: that is a field of a prescribed motion",
            "for example \"displacement.z\"",
        ));
    }
    Ok(())
}
