//! The step: the one file that sees all.

mod prescribed;
mod remeshing;

pub use remeshing::RemeshLog;

use crate::boundary::load::{LoadedBody, nodal_loads};
use crate::boundary::mirror::Mirror;
use crate::boundary::tag;
use crate::dynamics::elastic::Elastic;
use crate::dynamics::paper::Paper;
use crate::dynamics::{Dynamics, Energy, ForceSums};
use crate::error::{Failure, InvalidInput};
use crate::integrate::RungeKutta4;
use crate::lattice::Lattice;
use crate::mls::PointWeights;
use crate::moments::area_vectors;
pub use crate::observe::Reading;
use crate::observe::TaggedProbe;
use crate::particles::{Column, Field, Particles};
use crate::sample::{Body, sample};
use crate::setup::{Formulation, Mechanics, RemeshTrigger, Setup, TimeStep};
use crate::snapshot::Snapshot;
use crate::stability::{SAFETY, StepLimit, step_limit};
use crate::surface::Surface;
use crate::tensor::Vec3;
use crate::watch::Watch;
use prescribed::Reconstruction;
use remeshing::Remeshing;

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
    /// Energy taken by the viscosity since the start.
    pub dissipated: f64,
    /// Total force of the loads at this moment.
    pub load: Vec3,
    /// Total force of the clamps on the body at this moment.
    pub reaction: Vec3,
    /// |momentum - momentum at the start - impulse of loads and reactions| relative to the largest
    /// momentum or impulse so far.
    pub momentum_error: f64,
    /// |mass - mass at the start| / mass at the start.
    pub mass_error: f64,
}

/// What is known of a simulation before its first step.
#[derive(Clone, Debug)]
pub struct Description {
    /// Number of particles.
    pub particles: usize,
    /// Spacing dx.
    pub spacing: f64,
    /// Smoothing length h.
    pub smoothing_length: f64,
    /// Neighbours of an inner particle.
    pub neighbours: usize,
    /// Time step.
    pub dt: f64,
    /// Largest stable time step.
    pub dt_limit: f64,
    /// Whether viscosity (true) or wave speed (false) sets the limit.
    pub limited_by_viscosity: bool,
    /// Volume of the particles.
    pub volume: f64,
    /// Volume of the shape.
    pub shape_volume: f64,
    /// Total force of the loads at full ramp.
    pub load: Vec3,
    /// Things the user should know (one sentence each).
    pub notes: Vec<String>,
}

/// A running simulation.
#[derive(Debug)]
pub struct Simulation {
    setup: Setup,
    body: Body,
    description: Description,
    dynamics: Box<dyn Dynamics>,
    integrator: RungeKutta4,
    particles: Particles,
    probes: Vec<TaggedProbe>,
    surface: SurfaceSource,
    remeshing: Option<Remeshing>,
    watch: Watch,
    time: f64,
    steps: u64,
    start: Start,
    totals: Totals,
    forces: ForceSums,
}

/// Where the surface of a moment comes from.
#[derive(Clone, Debug)]
enum SurfaceSource {
    /// That of the undeformed body, moved with the particles around its vertices.
    Moved(PointWeights),
    /// The level set of what the particles carry, Eq. (8).
    Reconstructed(Reconstruction),
}

/// What a kind of body brings to a simulation.
struct Parts {
    body: Body,
    description: Description,
    dynamics: Box<dyn Dynamics>,
    particles: Particles,
    probes: Vec<TaggedProbe>,
    surface: SurfaceSource,
    remeshing: Option<Remeshing>,
}

/// Name of the reading that a prescribed motion adds to those of its probes: the volume inside the
/// surface.
pub const VOLUME_INSIDE: &str = "volume_inside";

/// Sums at the start, against which conservation is measured.
#[derive(Clone, Copy, Debug)]
struct Start {
    mass: f64,
    momentum: Vec3,
    energy: Energy,
}

/// What loads and boundaries have done since the start.
#[derive(Clone, Copy, Debug, Default)]
struct Totals {
    impulse: Vec3,
    work: f64,
    largest_momentum: f64,
}

impl Simulation {
    /// Samples the body, tags boundaries, loads and probes, and chooses the time step.
    ///
    /// # Errors
    /// The first input that can not be simulated.
    pub fn new(setup: Setup) -> Result<Self, InvalidInput> {
        check_solver(&setup)?;
        let parts = match &setup.mechanics {
            Mechanics::Solid => Self::solid(&setup)?,
            Mechanics::Prescribed(prescription) => prescribed::parts(&setup, prescription)?,
        };
        let Parts { body, description, mut dynamics, mut particles, probes, surface, remeshing } = parts;
        dynamics.impose(0.0, &mut particles);
        let mut integrator = RungeKutta4::new(&*dynamics, &particles);
        let start = Start {
            mass: total_mass(&particles),
            momentum: momentum(&particles),
            energy: dynamics.energy(0.0, &particles),
        };
        let forces = integrator.evaluate(&mut *dynamics, &particles, 0.0);
        // Strains round to 1e-16 u / dx; ten digits more are far below any real energy.
        let rounding =
            1e-22 * setup.material.p_wave_modulus() * description.volume / description.spacing.powi(2);
        let watch = Watch::new(&*dynamics, &particles, start.energy, rounding);
        Ok(Self {
            setup,
            body,
            description,
            dynamics,
            integrator,
            particles,
            probes,
            surface,
            remeshing,
            watch,
            time: 0.0,
            steps: 0,
            totals: Totals { largest_momentum: start.momentum.norm(), ..Totals::default() },
            start,
            forces,
        })
    }

    /// A solid body, its boundaries, loads and probes tagged.
    fn solid(setup: &Setup) -> Result<Parts, InvalidInput> {
        let solver = setup.solver;
        check_solid(setup)?;
        let shape = &*setup.shape;
        let alignment = if shape.is_box() {
            Vec::new()
        } else {
            tag::alignment(&setup.boundaries, &shape.bounds(), &solver)
        };
        let body = sample(shape, setup.resolution, &alignment)?;
        let (dx, origin) = (body.grid.spacing, body.grid.origin);
        let n = body.cells.len();
        let positions: Vec<Vec3> = body.cells.iter().map(|c| body.grid.centre(*c)).collect();
        let volume: Vec<f64> = body.fraction.iter().map(|f| f * dx.powi(3)).collect();

        let tags = tag::tag(&setup.boundaries, &positions, dx, &solver)?;
        let lattice = Lattice::new(&body.grid, &body.cells, solver.smoothing);
        let mirror = Mirror::new(&lattice, &origin, &positions, tags.planes);
        let mut elastic = Elastic::new(
            lattice,
            &volume,
            mirror,
            tags.fixed,
            std::sync::Arc::clone(&setup.material),
            solver.hourglass,
        );
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
        let (dt, notes) = choose_step(setup, &limit)?;
        let total_volume: f64 = volume.iter().sum();
        let description = Description {
            particles: n,
            spacing: dx,
            smoothing_length: elastic.lattice.smoothing_length,
            neighbours: elastic.lattice.neighbours.len(),
            dt,
            dt_limit: limit.dt,
            limited_by_viscosity: limit.viscous,
            volume: total_volume,
            shape_volume: shape.volume(),
            load: loads.iter().map(super::boundary::nodal_load::NodalLoad::total).sum(),
            notes,
        };

        let mut particles = Particles::new(n);
        particles.set(Field::Reference, Column::from_vectors(&positions));
        let at = |f: &crate::setup::VectorField| Column::from_vectors(&f.at_all(&positions));
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
        Ok(Parts {
            body,
            description,
            dynamics,
            particles,
            probes,
            surface: SurfaceSource::Moved(surface_weights),
            remeshing: None,
        })
    }

    /// What it was made from.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// What is known before the first step.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The sampled body.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Advances by one time step of length `dt`.
    ///
    /// # Errors
    /// When the state becomes meaningless; the last good state is kept.
    pub fn step(&mut self) -> Result<(), Failure> {
        self.step_by(self.description.dt)?;
        self.check()
    }

    /// Advances to the time `t` exactly, shortening the steps evenly where needed. Stops early, at a
    /// whole step, when `keep_going` returns false (called after every step).
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn advance_to(
        &mut self,
        t: f64,
        keep_going: &mut dyn FnMut(&mut Self) -> bool,
    ) -> Result<(), Failure> {
        let from = self.time;
        let steps = ((t - from) / self.description.dt - 1e-6).ceil().max(0.0) as u64;
        for k in 1..=steps {
            let next = if k == steps { t } else { from + (t - from) * (k as f64 / steps as f64) };
            self.step_by(next - self.time)?;
            self.time = next;
            if !keep_going(self) {
                return Ok(());
            }
        }
        self.check()
    }

    fn step_by(&mut self, dt: f64) -> Result<(), Failure> {
        let (step, forces) = self.integrator.step(&mut *self.dynamics, &mut self.particles, self.time, dt);
        self.time += dt;
        self.steps += 1;
        self.forces = forces;
        self.totals.impulse += step.load + step.reaction;
        self.totals.work += step.work;
        let reached = self.totals.impulse.norm();
        self.totals.largest_momentum = self.totals.largest_momentum.max(reached);
        if self.watch.is_due(self.steps) {
            self.check()?;
        }
        self.remesh_if_due(dt)
    }

    /// Lays the particles anew if it is time for it.
    fn remesh_if_due(&mut self, dt: f64) -> Result<(), Failure> {
        let (Mechanics::Prescribed(p), Some(remeshing)) = (&self.setup.mechanics, &mut self.remeshing) else {
            return Ok(());
        };
        let (time, particles) = (self.time, &self.particles);
        let rate = || {
            let x = prescribed::positions(particles);
            x.iter().map(|x| p.flow.rate_at(x, time)).fold(0.0, f64::max)
        };
        if !remeshing.is_due(dt, rate) {
            return Ok(());
        }
        match prescribed::remesh(remeshing, particles) {
            Ok(new) => {
                self.particles = new;
                self.integrator = RungeKutta4::new(&*self.dynamics, &self.particles);
                self.watch.restart(&*self.dynamics, &self.particles, self.time, self.steps);
                Ok(())
            }
            Err(error) => {
                let failure = prescribed::failure(error, self.time, self.steps);
                (self.time, self.steps) = self.watch.restore(&*self.dynamics, &mut self.particles);
                Err(failure)
            }
        }
    }

    /// Looks whether the state still makes sense; goes back to the last good one if not.
    fn check(&mut self) -> Result<(), Failure> {
        let (time, step) = (self.time, self.steps);
        let energy = self.dynamics.energy(time, &self.particles);
        let result = self.watch.check(&*self.dynamics, &self.particles, energy, self.totals.work, time, step);
        if result.is_err() {
            (self.time, self.steps) = self.watch.restore(&*self.dynamics, &mut self.particles);
        }
        result
    }

    /// Evaluates the right-hand side at this moment without advancing, for measurements.
    pub fn evaluate(&mut self) -> ForceSums {
        self.integrator.evaluate(&mut *self.dynamics, &self.particles, self.time)
    }

    /// Simulated time.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of steps taken.
    pub fn step_count(&self) -> u64 {
        self.steps
    }

    /// Number of right-hand sides evaluated.
    pub fn rhs_evaluations(&self) -> u64 {
        self.steps * RungeKutta4::EVALUATIONS
    }

    /// The state without derived columns.
    pub fn particles(&self) -> &Particles {
        &self.particles
    }

    /// A picture of this moment.
    pub fn snapshot(&mut self) -> Snapshot {
        let mut particles = self.particles.clone();
        self.dynamics.derive(self.time, &mut particles);
        Snapshot { time: self.time, step: self.steps, particles }
    }

    /// The surface of the moment of `snapshot`, which is one of this simulation's.
    pub fn surface(&self, snapshot: &Snapshot) -> Surface {
        match &self.surface {
            SurfaceSource::Moved(weights) => Surface::new(&self.body.surface, weights, snapshot),
            SurfaceSource::Reconstructed(reconstruction) => reconstruction.surface(snapshot),
        }
    }

    /// What remeshing has done so far; `None` if the particles are never laid anew.
    pub fn remesh_log(&self) -> Option<RemeshLog> {
        let remeshing = self.remeshing.as_ref()?;
        (self.setup.remesh.trigger != RemeshTrigger::Never).then_some(remeshing.log)
    }

    /// The probes' readings of this moment, in order; a prescribed motion adds [`VOLUME_INSIDE`].
    pub fn readings(&mut self) -> Vec<Reading> {
        let mut readings = Vec::new();
        if let SurfaceSource::Reconstructed(reconstruction) = &self.surface {
            let value = reconstruction.volume_inside(&self.particles);
            if !self.setup.probes.is_empty() {
                // Particles come and go: what is in a region now.
                let snapshot = self.snapshot();
                let x = prescribed::positions(&snapshot.particles);
                let volume = snapshot.column(Field::Volume).values();
                for probe in &self.setup.probes {
                    TaggedProbe::of_particles(probe, &x, volume).read(&snapshot.particles, &mut readings);
                }
            }
            readings.push(Reading { name: VOLUME_INSIDE.into(), value });
        } else if self.probes.iter().all(TaggedProbe::reads_state) {
            for probe in &self.probes {
                probe.read(&self.particles, &mut readings);
            }
        } else {
            let snapshot = self.snapshot();
            for probe in &self.probes {
                probe.read(&snapshot.particles, &mut readings);
            }
        }
        readings
    }

    /// The conserved sums of this moment.
    pub fn conservation(&mut self) -> Conservation {
        let Energy { kinetic, elastic } = self.dynamics.energy(self.time, &self.particles);
        let (mass, momentum) = (total_mass(&self.particles), momentum(&self.particles));
        let defect = (momentum - self.start.momentum - self.totals.impulse).norm();
        let scale = self.totals.largest_momentum.max(momentum.norm());
        let Energy { kinetic: kinetic_0, elastic: elastic_0 } = self.start.energy;
        Conservation {
            mass,
            momentum,
            kinetic_energy: kinetic,
            elastic_energy: elastic,
            external_work: self.totals.work,
            dissipated: kinetic_0 + elastic_0 + self.totals.work - kinetic - elastic,
            load: self.forces.load,
            reaction: self.forces.reaction,
            momentum_error: if scale > 0.0 { defect / scale } else { 0.0 },
            mass_error: (mass - self.start.mass).abs() / self.start.mass,
        }
    }
}

fn total_mass(particles: &Particles) -> f64 {
    particles.column(Field::Mass).values().iter().sum()
}

fn momentum(particles: &Particles) -> Vec3 {
    let (m, v) = (particles.column(Field::Mass), particles.column(Field::Velocity));
    if v.is_empty() {
        return Vec3::zeros();
    }
    (0..particles.len()).map(|a| m.values()[a] * v.vector(a)).sum()
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

fn check_solver(setup: &Setup) -> Result<(), InvalidInput> {
    let solver = &setup.solver;
    if !(0.75..=2.0).contains(&solver.smoothing) {
        return Err(InvalidInput::new(
            "solver.smoothing",
            solver.smoothing,
            "must lie between 0.75 and 2 spacings: below that a particle has too few neighbours for a \
             gradient, above it detail is lost and cost grows with the third power",
            "the paper uses 1.25 (122 neighbours); 0.8 (26 neighbours) is as accurate and faster",
        ));
    }
    if !(0.0..=1.0).contains(&solver.hourglass) {
        return Err(InvalidInput::new(
            "solver.hourglass",
            solver.hourglass,
            "must lie between 0 (off) and 1",
            "0.1 is a good value",
        ));
    }
    Ok(())
}

/// The time step, and what to tell the user about it.
fn choose_step(setup: &Setup, limit: &StepLimit) -> Result<(f64, Vec<String>), InvalidInput> {
    let cause = if limit.viscous { "viscosity (dt ~ dx^2 rho / (E T))" } else { "wave speed (dt ~ dx / c)" };
    let unit = if setup.units == crate::setup::Units::Si { " s" } else { "" };
    match setup.time_step {
        TimeStep::Auto => {
            if limit.dt.is_finite() && limit.dt > 0.0 {
                Ok((SAFETY * limit.dt, Vec::new()))
            } else {
                Err(InvalidInput::new(
                    "time.dt",
                    "auto",
                    "the body has no stiffness from which a time step follows (every particle is held, \
                     or there is only one)",
                    "give `time.dt` a number, or choose a smaller spacing",
                ))
            }
        }
        TimeStep::Fixed(dt) if !(dt.is_finite() && dt > 0.0) => Err(InvalidInput::new(
            "time.dt",
            dt,
            "must be a positive number",
            "`dt = \"auto\"` takes 0.9 of the stability limit",
        )),
        TimeStep::Fixed(dt) if dt > limit.dt => {
            if setup.allow_unstable {
                Ok((
                    dt,
                    vec![format!(
                        "dt = {dt:.3e}{unit} is above the stability limit {:.3e}{unit}, set by {cause}; \
                         the run will blow up",
                        limit.dt
                    )],
                ))
            } else {
                Err(InvalidInput::new(
                    "time.dt",
                    dt,
                    format!("is above the stability limit {:.4e}{unit}, which is set by {cause}", limit.dt),
                    format!(
                        "take `dt = \"auto\"` or at most {:.4e}{unit}; `time.allow_unstable = true` lets \
                         you try",
                        limit.dt
                    ),
                ))
            }
        }
        TimeStep::Fixed(dt) => Ok((dt, Vec::new())),
    }
}
