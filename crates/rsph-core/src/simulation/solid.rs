//! A solid: from a set-up to its dynamics, remeshed where it has moved to.

mod assemble;
mod held;
mod level_set;
mod materials;
mod pieces;
mod plane;
mod remesh;
mod state;
mod surface_reading;

use super::Description;
use super::balance::{momentum, total_mass};
use super::checks;
use super::model::{Model, Moment, Parts};
use super::remeshing::RemeshOutcome;
use super::time_step::{Pace, choose_pace};
use crate::boundary::constraints::Constraints;
use crate::boundary::fold::Folds;
use crate::boundary::nodal_load::NodalLoad;
use crate::boundary::reaction::Reaction;
use crate::boundary::surface_quadrature::{SurfaceQuadrature, rim};
use crate::boundary::tag;
use crate::dynamics::Dynamics;
use crate::dynamics::paper::Paper;
use crate::dynamics::solid::Solid;
use crate::error::{Failure, InvalidInput};
use crate::material::Material;
use crate::mesh::TriangleMesh;
use crate::mls::{Cloud, GradientFit, PointWeights};
use crate::observe::{Reading, TaggedGauge, TaggedProbe};
use crate::particles::{Column, Field, Particles};
use crate::sample::{Body, sample};
use crate::setup::{
    Boundary, Formulation, Load, Probe, RemeshTrigger, Setup, SolidSetup, Units, VectorField,
};
use crate::snapshot::Snapshot;
use crate::stability::{StepLimit, step_limit};
use crate::state::State;
use crate::surface::Surface;
use crate::tensor::{Mat3, Vec3};
use assemble::LatticeParticles;
use held::{Held, with_cut_shape};
use pieces::LeftOutPlaces;
use remesh::{SolidRemeshError, Undeformed};
use std::sync::Arc;
use surface_reading::{Loading, SurfaceReading};

/// Length (m) beyond which a body is not measured in metres.
const LARGEST_TISSUE: f64 = 5.0;

/// A solid body.
#[derive(Clone, Debug)]
pub(super) struct SolidBody {
    setup: Setup<SolidSetup>,
    spacing: f64,
    /// Its surface as the zero of its level set, undeformed.
    zero_surface: TriangleMesh,
    held: Held,
    /// The centre of what each boundary holds, undeformed.
    held_centres: Vec<Vec3>,
    /// The surface that is loaded and held where it is not that of the shape: without pieces that hold no particle, or the rim
    /// of a body in the plane.
    kept_surface: Option<Arc<TriangleMesh>>,
    undeformed: Undeformed,
    lattice_particles: LatticeParticles,
    matter: Matter,
    /// Gradient of the displacement (or the strain) at the last remesh, where a strain since then decides.
    gradient_at_remesh: Vec<Mat3>,
    /// Time of the last remesh and the displacement that it left, if there was one.
    last_remesh: Option<(f64, Column)>,
    /// Where loads act, once they have been replaced.
    quadrature: Option<SurfaceQuadrature>,
    probes: Vec<TaggedProbe>,
    gauges: Vec<TaggedGauge>,
    /// The reference positions that the probes' particles were found for.
    probed: Arc<Vec<f64>>,
    fits: SurfaceFits,
    /// Strain and stress on the surface; none in the scheme of the paper.
    reading: Option<SurfaceReading>,
    left_out: LeftOutPlaces,
}

/// Fits of the particles around the vertices of the undeformed surface.
#[derive(Clone, Debug)]
struct SurfaceFits {
    weights: PointWeights,
    /// At the places where strain and stress are read.
    gradients: Vec<GradientFit>,
    /// The reference positions of the particles that they were found for.
    reference: Arc<Vec<f64>>,
}

impl SurfaceFits {
    fn new(
        cloud: &Cloud<'_>,
        vertices: &[Vec3],
        reading: Option<&SurfaceReading>,
        reference: Arc<Vec<f64>>,
    ) -> Self {
        Self {
            weights: PointWeights::new(cloud, vertices),
            gradients: reading.map_or_else(Vec::new, |reading| reading.fits(cloud)),
            reference,
        }
    }
}

/// What moves the particles.
#[derive(Clone, Debug)]
enum Matter {
    Adjoint(Box<Solid>),
    Paper(Box<Paper>),
}

impl Matter {
    /// The formulation that the set-up asks for, from the adjoint one with its loads.
    fn new(setup: &Setup<SolidSetup>, solid: Solid) -> Self {
        match setup.solver.formulation {
            Formulation::Adjoint => Self::Adjoint(Box::new(solid)),
            Formulation::Paper => {
                let Solid { mass, fixed, loads, lattice, .. } = solid;
                let material = Arc::clone(&setup.mechanics.material);
                let (dx, smoothing) = (lattice.spacing, setup.solver.smoothing);
                Self::Paper(Box::new(Paper::new(material, mass.to_vec(), dx, smoothing, fixed, loads)))
            }
        }
    }

    /// [`Self::gradient`] if remeshing goes by it, nothing otherwise.
    fn gradient_for(&mut self, setup: &Setup<SolidSetup>, particles: &Particles, t: f64) -> Vec<Mat3> {
        let wanted = setup.remesh.trigger == RemeshTrigger::Strain;
        if wanted { self.gradient(particles, t) } else { Vec::new() }
    }

    /// Gradient of the displacement of every particle; in the paper's formulation its strain.
    fn gradient(&mut self, particles: &Particles, time: f64) -> Vec<Mat3> {
        match self {
            Self::Adjoint(solid) => solid.gradient(time, particles.column(Field::Displacement).values()),
            Self::Paper(_) => {
                let strain = particles.column(Field::Strain);
                (0..particles.len()).map(|a| strain.tensor(a).to_matrix()).collect()
            }
        }
    }
}

impl SolidBody {
    /// Samples the body and tags its boundaries, loads and probes.
    ///
    /// # Errors
    /// The first input that can not be simulated.
    pub fn parts(setup: &Setup<SolidSetup>) -> Result<Parts, InvalidInput> {
        check_solid(setup)?;
        let setup = &with_cut_shape(setup)?;
        let (solver, shape) = (setup.solver, &*setup.shape);
        let is_paper = solver.formulation == Formulation::Paper;
        let alignment = match solver.formulation {
            Formulation::Paper => tag::alignment(&setup.mechanics.boundaries, &shape.bounds(), &solver),
            Formulation::Adjoint => Vec::new(),
        };
        let mut body = sample(shape, setup.resolution, &alignment)?;
        let dx = body.grid.spacing;
        pieces::choose(setup, &mut body)?;
        let is_remeshed = setup.remesh.trigger != RemeshTrigger::Never;
        let (undeformed, lattice_particles) = Undeformed::new(shape, &body, is_remeshed);
        let notes = pieces::notes(setup, &body).into_iter().chain(in_millimetres(setup));
        let kept_surface = match shape.dimension() {
            2 => Some(Arc::new(rim(body.boundary_surface(shape), dx))),
            _ => body.kept_surface.take().map(Arc::new),
        };
        let Body { level_set, surface: zero_surface, cells, fraction, volume, left_out, .. } = body;
        drop((cells, fraction, volume));
        let positions = lattice_particles.positions();
        let surface = kept_surface.as_deref().unwrap_or_else(|| shape.surface());
        let held = if is_paper {
            Held::Layers(tag::holds(&setup.mechanics.boundaries, &positions, dx, &solver)?)
        } else {
            Held::Surface(Constraints::new(&setup.mechanics.boundaries, surface, &positions, dx)?)
        };
        let mut solid = lattice_particles.solid(setup, &undeformed.lattice, &held, surface, false)?;
        let quadrature = lattice_particles.quadrature(setup, surface, dx, &held, &solid.lift.folds);
        if !is_paper {
            solid = solid.with_surface(&quadrature, held.holds(), &lattice_particles.cut, &positions);
        }
        solid.loads = lattice_particles.loads(setup, &solid, (surface, &quadrature), &held)?;
        let mut reading = if is_paper {
            None
        } else {
            Some(SurfaceReading::new(setup, &held, &quadrature.points(), &zero_surface.vertices, dx)?)
        };
        drop(quadrature);
        let cloud = lattice_particles.cloud(&positions, &lattice_particles.volume, dx, shape.dimension());
        let weights = |points: &[Vec3]| PointWeights::new(&cloud, points);
        let left_out = LeftOutPlaces::new(left_out, dx);
        let probe = |(i, p)| {
            left_out.check_probe(i, p, &positions)?;
            let probe =
                TaggedProbe::new(i, p, (shape, surface), &positions, &lattice_particles.volume, dx, weights)?;
            Ok(if is_remeshed { probe } else { probe.settled() })
        };
        let probes = setup.probes.iter().enumerate().map(probe).collect::<Result<Vec<_>, _>>()?;
        let gauge = |(i, g)| {
            let body = (shape, surface);
            TaggedGauge::new(i, g, body, &positions, &lattice_particles.volume, dx, weights)
        };
        let gauges = setup.gauges.iter().enumerate().map(gauge).collect::<Result<Vec<_>, _>>()?;
        let fits = SurfaceFits::new(&cloud, &zero_surface.vertices, reading.as_ref(), Arc::default());
        if let (Some(reading), false) = (&mut reading, setup.initial.displacement.is_zero())
            && solid.relaxation_time() > 0.0
        {
            let u = setup.initial.displacement.at_all(&positions);
            reading.start_from(&setup.mechanics, (&cloud, &fits.gradients), |a| u[a]);
        }
        drop(cloud);

        let start = Column::from_vectors(&setup.initial.displacement.at_all(&positions));
        solid.linearise(0.0, start.values());
        if solid.inverted_in_state().contains(&true) {
            return Err(InvalidInput::new(
                "initial.displacement",
                "",
                "turns a part of the body inside out",
                "take a smaller displacement",
            ));
        }
        let limit = step_limit(&mut solid);
        let pace = choose_pace(setup, &setup.mechanics, &limit, !is_paper)?;
        let description = described(setup, (&solid, &lattice_particles.volume), &limit, pace, notes);
        let held_centres = solid.held_centres(&positions, setup.mechanics.boundaries.len());
        let particles = starting_particles(setup, &lattice_particles, &mut solid, level_set);
        let mut matter = Matter::new(setup, solid);
        let reference = particles.column(Field::Reference).share();
        let model = Box::new(Self {
            setup: setup.clone(),
            spacing: dx,
            zero_surface,
            held,
            held_centres,
            kept_surface,
            undeformed,
            gradient_at_remesh: matter.gradient_for(setup, &particles, 0.0),
            last_remesh: None,
            lattice_particles: if is_remeshed { lattice_particles } else { lattice_particles.for_good() },
            matter,
            quadrature: None,
            probes,
            gauges,
            probed: Arc::clone(&reference),
            fits: SurfaceFits { reference, ..fits },
            reading,
            left_out,
        });
        Ok(Parts { model, particles, description })
    }

    /// Whether forces from outside act on each of `n` particles; nothing if there are none.
    fn pushed(&self, n: usize) -> Vec<bool> {
        match &self.matter {
            // The loads of the set-up come first.
            Matter::Adjoint(solid) => NodalLoad::acting_on(
                solid.loads.get(self.setup.mechanics.loads.len()..).unwrap_or_default(),
                n,
            ),
            Matter::Paper(_) => Vec::new(),
        }
    }

    /// The surface that is loaded and held, undeformed.
    fn boundary_surface(&self) -> &TriangleMesh {
        self.kept_surface.as_deref().unwrap_or_else(|| self.setup.shape.surface())
    }

    /// The particles at their reference `positions`.
    fn cloud<'a>(&'a self, positions: &'a [Vec3]) -> Cloud<'a> {
        self.cloud_of(positions, &self.lattice_particles.volume)
    }

    /// Particles with these volumes at their reference `positions`.
    fn cloud_of<'a>(&'a self, positions: &'a [Vec3], volume: &'a [f64]) -> Cloud<'a> {
        self.lattice_particles.cloud(positions, volume, self.spacing, self.setup.shape.dimension())
    }

    /// Remeshed particles with their dynamics.
    fn remeshed(
        &self,
        particles: &Particles,
        time: f64,
    ) -> Result<(RemeshOutcome, LatticeParticles, Solid), SolidRemeshError> {
        let setup = &self.setup;
        let remeshed = self.undeformed.remesh(
            setup,
            &self.held,
            (&self.lattice_particles.nodes(), particles),
            self.dynamics().integrated(),
            time,
            self.boundary_surface(),
        )?;
        let (lattice_particles, mut solid, mut new) =
            (remeshed.lattice_particles, remeshed.solid, remeshed.particles);
        let surface = (self.boundary_surface(), &remeshed.quadrature);
        solid.loads = lattice_particles.loads(setup, &solid, surface, &self.held)?;
        let (shape, restore) = (&*setup.shape, setup.remesh.restore_level_set);
        let level_set = if restore {
            let (nodes, undeformed) = &remeshed.around;
            let phi = level_set::carried(shape, undeformed);
            level_set::restored(&self.undeformed.lattice, nodes, &phi, &lattice_particles.nodes())
        } else {
            level_set::carried(shape, &lattice_particles.positions())
        };
        new.set(Field::LevelSet, Column::from_vec(level_set, lattice_particles.len()));
        // The interpolation leaves a little momentum behind, or makes some.
        let lost = momentum(particles) - momentum(&new);
        let missing = lost / total_mass(&new);
        for (values, missing) in new
            .column_mut(Field::Velocity)
            .values_mut()
            .chunks_mut(lattice_particles.len())
            .zip(missing.iter())
        {
            for v in values {
                *v += missing;
            }
        }
        if solid.lift.is_empty() && solid.fixed.is_free(setup.shape.dimension()) {
            restore_spin(spin(particles).2, &mut new);
        }
        let outcome = RemeshOutcome {
            particles: new,
            folded_mass: remeshed.folded_mass,
            dropped_mass: 0.0,
            momentum_correction: lost.norm(),
            rescaling: remeshed.rescaling,
            limit: Some(step_limit(&mut solid)),
        };
        Ok((outcome, lattice_particles, solid))
    }
}

impl Model for SolidBody {
    fn dynamics(&self) -> &dyn Dynamics {
        match &self.matter {
            Matter::Adjoint(solid) => &**solid,
            Matter::Paper(paper) => &**paper,
        }
    }

    fn dynamics_mut(&mut self) -> &mut dyn Dynamics {
        match &mut self.matter {
            Matter::Adjoint(solid) => &mut **solid,
            Matter::Paper(paper) => &mut **paper,
        }
    }

    fn strain(&mut self, particles: &Particles, time: f64, _dt: f64) -> f64 {
        let now = self.matter.gradient(particles, time);
        let turns = matches!(&self.matter, Matter::Adjoint(solid) if !solid.is_linear());
        let change =
            |(now, then): (&Mat3, &Mat3)| if turns { stretch(now, then) } else { (now - then).norm() };
        now.iter().zip(&self.gradient_at_remesh).map(change).fold(0.0, f64::max)
    }

    fn disorder(&self, particles: &Particles, moment: Moment) -> Option<Failure> {
        let Matter::Adjoint(solid) = &self.matter else { return None };
        let particle = solid.inverted()?;
        Some(checks::inverted(particles.column(Field::Reference).vector(particle), moment))
    }

    fn remesh(&mut self, particles: &Particles, moment: Moment) -> Result<RemeshOutcome, Failure> {
        let (outcome, lattice_particles, solid) =
            self.remeshed(particles, moment.time).map_err(|e| failure(&e, moment))?;
        self.matter = Matter::new(&self.setup, solid);
        self.lattice_particles = lattice_particles;
        self.quadrature = None;
        self.last_remesh = Some((moment.time, outcome.particles.column(Field::Displacement).clone()));
        self.gradient_at_remesh = self.matter.gradient_for(&self.setup, &outcome.particles, moment.time);
        Ok(outcome)
    }

    fn set_loads(&mut self, loads: &[Load], time: f64) -> Result<(), InvalidInput> {
        let Matter::Adjoint(solid) = &mut self.matter else {
            return Err(InvalidInput::new(
                "load",
                "",
                "the scheme of the paper keeps the loads that it starts with",
                "take `formulation = \"adjoint\"`",
            ));
        };
        let mut before = std::mem::replace(&mut self.setup.mechanics.loads, loads.to_vec());
        let surface = self.kept_surface.as_deref().unwrap_or_else(|| self.setup.shape.surface());
        let quadrature = self.quadrature.get_or_insert_with(|| {
            self.lattice_particles.quadrature(
                &self.setup,
                surface,
                self.spacing,
                &self.held,
                &solid.lift.folds,
            )
        });
        match self.lattice_particles.loads(&self.setup, solid, (surface, quadrature), &self.held) {
            Ok(new) => {
                solid.loads = new;
                if let Some(reading) = &mut self.reading {
                    // The strain of the surface goes on from what the loads before have done.
                    std::mem::swap(&mut self.setup.mechanics.loads, &mut before);
                    reading.settle(&Loading::of(&self.setup, surface, self.spacing), time, false);
                    std::mem::swap(&mut self.setup.mechanics.loads, &mut before);
                }
            }
            Err(error) => {
                self.setup.mechanics.loads = before;
                return Err(error);
            }
        }
        Ok(())
    }

    fn set_material(&mut self, k: usize, material: &Arc<dyn Material>) -> Result<(), InvalidInput> {
        let Matter::Adjoint(solid) = &mut self.matter else {
            return Err(InvalidInput::new(
                "material",
                material.name(),
                "the scheme of the paper keeps the material that it starts with",
                "take `formulation = \"adjoint\"`",
            ));
        };
        let mut mechanics = self.setup.mechanics.clone();
        mechanics.set_material(k, material);
        let hourglass = self.setup.solver.hourglass_modulus(mechanics.material.young_modulus());
        solid.set_material(k, material, hourglass);
        self.setup.mechanics = mechanics;
        Ok(())
    }

    fn settle(&mut self, time: f64) {
        let surface = self.kept_surface.as_deref().unwrap_or_else(|| self.setup.shape.surface());
        if let Some(reading) = &mut self.reading {
            reading.settle(&Loading::of(&self.setup, surface, self.spacing), time, true);
        }
    }

    fn save(&self, state: &mut State) {
        state::save(self, state);
    }

    fn restore(&mut self, state: &State, particles: &Particles) -> Result<(), InvalidInput> {
        state::restore(self, state, particles)
    }

    fn surface_quadrature(&self) -> Option<SurfaceQuadrature> {
        let none = Folds::default();
        let folds = if let Matter::Adjoint(solid) = &self.matter { &solid.lift.folds } else { &none };
        Some(self.lattice_particles.quadrature(
            &self.setup,
            self.boundary_surface(),
            self.spacing,
            &self.held,
            folds,
        ))
    }

    fn reactions(&mut self, particles: &Particles, time: f64) -> Vec<Reaction> {
        let Matter::Adjoint(solid) = &mut self.matter else { return Vec::new() };
        let goes_along = !solid.is_linear();
        let about = |(boundary, centre): (&Boundary, &Vec3)| {
            let given = boundary.name.as_ref().and_then(|name| name.moment_about);
            let moved =
                boundary.motion.as_ref().filter(|_| goes_along).map(|motion| motion.displacement(time));
            given.unwrap_or_else(|| centre + moved.unwrap_or_default())
        };
        let about: Vec<Vec3> =
            self.setup.mechanics.boundaries.iter().zip(&self.held_centres).map(about).collect();
        solid.reactions(time, particles, &about)
    }

    fn add_probe(&mut self, probe: &Probe) -> Result<(), InvalidInput> {
        let (index, dx) = (self.setup.probes.len(), self.spacing);
        checks::check_quantity(&self.setup, index, probe)?;
        let (positions, volume) = (self.lattice_particles.positions(), &self.lattice_particles.volume);
        self.left_out.check_probe(index, probe, &positions)?;
        let cloud = self.cloud(&positions);
        let weights = |points: &[Vec3]| PointWeights::new(&cloud, points);
        self.probes.push(TaggedProbe::new(
            index,
            probe,
            (&*self.setup.shape, self.boundary_surface()),
            &positions,
            volume,
            dx,
            weights,
        )?);
        self.setup.probes.push(probe.clone());
        Ok(())
    }

    fn surface(&self, snapshot: &Snapshot) -> Surface {
        let reference = snapshot.column(Field::Reference);
        let positions: Vec<Vec3> = (0..reference.len()).map(|a| reference.vector(a)).collect();
        let cloud = self.cloud_of(&positions, snapshot.column(Field::Volume).values());
        let mut other = None;
        let fits = if Arc::ptr_eq(&self.fits.reference, &reference.share()) {
            &self.fits
        } else {
            let vertices = &self.zero_surface.vertices;
            other.insert(SurfaceFits::new(&cloud, vertices, self.reading.as_ref(), reference.share()))
        };
        let mut surface = Surface::new(&self.zero_surface, &fits.weights, snapshot);
        if let Some(reading) = self.reading.as_ref().filter(|_| snapshot.particles.has(Field::Strain)) {
            let loading = Loading::of(&self.setup, self.boundary_surface(), self.spacing);
            let (u, v) = (snapshot.column(Field::Displacement), snapshot.column(Field::Velocity));
            let relaxation_time = self.setup.mechanics.relaxation_time();
            let effective = |a: usize| u.vector(a) + relaxation_time * v.vector(a);
            let fits = (&cloud, &fits.gradients[..]);
            surface.set_strain_and_stress(&reading.read(
                &loading,
                fits,
                &self.pushed(positions.len()),
                snapshot.time,
                |a| u.vector(a),
                effective,
            ));
        }
        surface
    }

    fn readings(&mut self, particles: &Particles, time: f64) -> Vec<Reading> {
        let reference = particles.column(Field::Reference).share();
        if !Arc::ptr_eq(&self.probed, &reference) {
            let positions = self.lattice_particles.positions();
            let dimension = self.setup.shape.dimension();
            let cloud = self
                .lattice_particles
                .cloud(&positions, &self.lattice_particles.volume, self.spacing, dimension)
                .sharp();
            for probe in &mut self.probes {
                probe.find(particles.len(), |points| PointWeights::new(&cloud, points));
            }
            for gauge in &mut self.gauges {
                gauge.find(particles.len(), |points| PointWeights::new(&cloud, points));
            }
            let fits = SurfaceFits::new(
                &self.cloud(&positions),
                &self.zero_surface.vertices,
                self.reading.as_ref(),
                Arc::clone(&reference),
            );
            self.fits = fits;
            self.probed = reference;
        }
        let mut readings = Vec::new();
        let wanted: Vec<Field> =
            self.probes.iter().filter(|p| !p.reads_state()).map(TaggedProbe::field).collect();
        let derived = (!wanted.is_empty()).then(|| {
            let mut derived = particles.clone();
            self.dynamics_mut().derive_some(time, &wanted, &mut derived);
            derived
        });
        for probe in &self.probes {
            probe.read(derived.as_ref().unwrap_or(particles), &mut readings);
        }
        self.gauges.iter().for_each(|gauge| gauge.read(particles, &mut readings));
        readings
    }
}

/// How far the ratio of a length now and then is from 1 at most, from the displacement gradients; one below 1 counts as its
/// inverse.
fn stretch(now: &Mat3, then: &Mat3) -> f64 {
    let Some(back) = (Mat3::identity() + then).try_inverse() else { return f64::INFINITY };
    let f = (Mat3::identity() + now) * back;
    let squares = (f.transpose() * f).symmetric_eigenvalues();
    squares.max().max(1.0 / squares.min()).sqrt() - 1.0
}

/// Where the particles are now, their centre of mass, and their angular momentum about it.
fn spin(particles: &Particles) -> (Vec<Vec3>, Vec3, Vec3) {
    let mass = particles.column(Field::Mass).values();
    let (x0, u) = (particles.column(Field::Reference), particles.column(Field::Displacement));
    let v = particles.column(Field::Velocity);
    let x: Vec<Vec3> = (0..mass.len()).map(|a| x0.vector(a) + u.vector(a)).collect();
    let centre = x.iter().zip(mass).map(|(x, m)| x * *m).sum::<Vec3>() / mass.iter().sum::<f64>();
    let spin = (0..mass.len()).map(|a| (x[a] - centre).cross(&v.vector(a)) * mass[a]).sum();
    (x, centre, spin)
}

/// Adds the rigid rotation that gives the particles this angular momentum about their centre of mass.
fn restore_spin(wanted: Vec3, particles: &mut Particles) {
    // Twice: the second time takes away the rounding of the first.
    for _ in 0..2 {
        let (x, centre, spin) = spin(particles);
        let mass = particles.column(Field::Mass).values();
        let of = |(x, m): (&Vec3, &f64)| {
            let arm = x - centre;
            (Mat3::identity() * arm.norm_squared() - arm * arm.transpose()) * *m
        };
        let inertia: Mat3 = x.iter().zip(mass).map(of).sum();
        let Some(rate) = inertia.try_inverse().map(|inverse| inverse * (wanted - spin)) else { return };
        let n = x.len();
        let velocity = particles.column_mut(Field::Velocity).values_mut();
        for (a, x) in x.iter().enumerate() {
            let turn = rate.cross(&(x - centre));
            (0..3).for_each(|i| velocity[i * n + a] += turn[i]);
        }
    }
}

/// What is known of the body before its first step.
fn described(
    setup: &Setup<SolidSetup>,
    (solid, volume): (&Solid, &[f64]),
    limit: &StepLimit,
    pace: Pace,
    notes: impl Iterator<Item = String>,
) -> Description {
    Description {
        particles: solid.mass.len(),
        spacing: solid.lattice.spacing,
        smoothing_length: solid.lattice.smoothing_length,
        neighbours: solid.lattice.neighbours.len(),
        scheme: pace.scheme,
        scheme_reason: pace.reason,
        dt: pace.dt,
        shortest_step: pace.adaptive,
        fastest_decay: setup.mechanics.relaxation_time() * limit.kappa,
        dt_limit: limit.dt,
        limited_by_viscosity: limit.viscous,
        volume: volume.iter().sum(),
        shape_volume: setup.shape.volume(),
        load: solid.loads.iter().map(NodalLoad::total).sum(),
        notes: notes.chain(pace.notes).collect(),
    }
}

/// The particles of `solid` as the simulation starts.
fn starting_particles(
    setup: &Setup<SolidSetup>,
    lattice_particles: &LatticeParticles,
    solid: &mut Solid,
    level_set: Vec<f64>,
) -> Particles {
    let (n, positions) = (lattice_particles.len(), lattice_particles.positions());
    let mut particles = Particles::new(n);
    particles.set(Field::Reference, lattice_particles.reference.clone());
    let at = |f: &VectorField| Column::from_vectors(&f.at_all(&positions));
    particles.set(Field::Displacement, at(&setup.initial.displacement));
    particles.set(Field::Velocity, at(&setup.initial.velocity));
    particles.set(Field::Mass, Column::shared(Arc::clone(&solid.mass), n));
    particles.set(Field::Volume, Column::shared(Arc::clone(&lattice_particles.volume), n));
    particles.set(Field::LevelSet, Column::from_vec(level_set, n));
    if setup.solver.formulation == Formulation::Paper {
        let strain = solid.strain(0.0, particles.column(Field::Displacement).values());
        particles.set(Field::Strain, Column::from_vec(strain, n));
        particles.set(Field::Density, Column::from_vec(vec![setup.mechanics.material.density(); n], n));
    }
    particles
}

/// A remeshing that failed, as the end of a simulation.
fn failure(error: &SolidRemeshError, moment: Moment) -> Failure {
    let (kind, place) = error.class();
    Failure {
        kind,
        time: moment.time,
        step: moment.step,
        what: format!("remeshing failed: {error}"),
        place,
        remedy: "remesh more often (`remesh.every`), and check the loads against the stiffness of the \
                 material"
            .into(),
    }
}

/// That a body is so large that its coordinates must be millimetres.
fn in_millimetres(setup: &Setup<SolidSetup>) -> Option<String> {
    let size = setup.shape.bounds().size().max();
    (setup.units == Units::Si && size > LARGEST_TISSUE).then(|| {
        format!(
            "the body is {size:.1} m long, and no tissue is: if the coordinates of its file are millimetres, give the mesh \
             `scale = 0.001`"
        )
    })
}

/// What only a prescribed motion has.
fn check_solid(setup: &Setup<SolidSetup>) -> Result<(), InvalidInput> {
    if setup.shape.dimension() == 2 {
        plane::check(setup)?;
    }
    if setup.solver.formulation == Formulation::Paper && setup.mechanics.is_by_place() {
        return Err(InvalidInput::new(
            "solver.formulation",
            "paper",
            "the scheme of the paper has one material",
            "take \"adjoint\", or one [material] without a place or a modulus map",
        ));
    }
    if setup.solver.formulation == Formulation::Paper
        && setup.mechanics.material.law().finite_strain().is_some()
    {
        return Err(InvalidInput::new(
            "solver.formulation",
            "paper",
            "the scheme of the paper has linear laws only",
            "take \"adjoint\", or material.model = \"kelvin-voigt\"",
        ));
    }
    let named = setup.mechanics.boundaries.iter().position(|b| b.name.is_some());
    if let (Formulation::Paper, Some(i)) = (setup.solver.formulation, named) {
        return Err(InvalidInput::new(
            format!("boundary[{i}].name"),
            "",
            "names a force that the scheme of the paper does not tell",
            "remove it, or take formulation = \"adjoint\"",
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
