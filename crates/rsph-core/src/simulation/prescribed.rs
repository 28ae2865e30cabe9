//! Simulations of bodies that move as told: the colour that particles carry, their remeshing, and the
//! surface of Eq. (8).

mod checks;

use super::Description;
use super::model::{Model, Moment, Parts};
use super::remeshing::RemeshOutcome;
use super::time_step::only_rk4;
use crate::dynamics::Dynamics;
use crate::dynamics::prescribed::Prescribed;
use crate::error::{Failure, FailureKind, InvalidInput};
use crate::grid::Grid;
use crate::level_set::volume_inside;
use crate::marching_cubes::zero_level_set;
use crate::observe::{Reading, TaggedProbe};
use crate::particles::{Column, Field, Particles};
use crate::reconstruct::{grid_around, reconstruct};
use crate::remesh::{NewVolume, NodeLattice, RemeshError, Remesher};
use crate::sample::{Alignment, Body, sample};
use crate::setup::{Prescription, Probe, Scheme, Setup};
use crate::snapshot::Snapshot;
use crate::state::State;
use crate::surface::{Surface, SurfaceField};
use crate::tensor::Vec3;

/// Nodes with a smaller |c| hold no particle; what lands on them goes to the nearest one that does.
const SMALLEST_COLOUR: f64 = 1e-4;
/// Name of the reading that a prescribed motion adds to those of its probes: the volume inside the
/// surface.
pub const VOLUME_INSIDE: &str = "volume_inside";

/// A body that moves as told.
#[derive(Clone, Debug)]
pub(super) struct PrescribedBody {
    dynamics: Prescribed,
    iso: f64,
    smoothing_length: f64,
    probes: Vec<Probe>,
    remesher: Remesher<3>,
    /// Strain since the last remeshing, as far as it was asked for.
    strain: f64,
}

impl PrescribedBody {
    /// iso - C(x), Eq. (8), on a grid of half the spacing around the particles.
    fn level_set(&self, particles: &Particles) -> (Grid, Vec<f64>) {
        let (positions, spacing) = (positions(particles), self.remesher.lattice.spacing);
        let (colour, volume) = (particles.column(Field::Colour), particles.column(Field::Volume));
        let amount: Vec<f64> = colour.values().iter().zip(volume.values()).map(|(c, v)| c * v).collect();
        // The field ends at 2.5 h from the particles; one cell more for the surface to close.
        let grid = grid_around(&positions, 2.5 * self.smoothing_length + spacing, 0.5 * spacing);
        let mut phi = reconstruct(&positions, &amount, self.smoothing_length, &grid);
        for c in &mut phi {
            *c = self.iso - *c;
        }
        (grid, phi)
    }

    /// Samples the body and chooses the time step.
    ///
    /// # Errors
    /// The first input that can not be simulated.
    pub fn parts(setup: &Setup, p: &Prescription) -> Result<Parts, InvalidInput> {
        checks::check(setup, p)?;
        only_rk4(setup, "particles that move as told")?;
        // Nodes at (j + 1/2) dx, wherever the body is.
        let alignment = [0, 1, 2].map(|axis| Alignment { axis, at: 0.0, offset: 0.5 });
        let body = sample(&*setup.shape, setup.resolution, &alignment)?;
        let dx = body.grid.spacing;
        let (positions, colour) = coloured(setup, p, &body);
        if positions.is_empty() {
            return Err(InvalidInput::new(
                "body.spacing",
                dx,
                "no node of the lattice lies inside the body",
                "choose a smaller spacing",
            ));
        }
        let n = positions.len();
        let cell = dx.powi(3);
        let mass: Vec<f64> = colour.iter().map(|c| c * cell * p.density).collect();
        let rate = positions.iter().map(|x| p.flow.rate_at(x, 0.0)).fold(0.0, f64::max);
        let dt_limit = checks::LARGEST_STRAIN / p.flow.largest_rate().unwrap_or(rate);
        let description = Description {
            particles: n,
            spacing: dx,
            smoothing_length: setup.solver.smoothing * dx,
            neighbours: neighbours(setup.solver.smoothing),
            scheme: Scheme::Rk4,
            scheme_reason: None,
            dt: checks::time_step(setup, dt_limit)?,
            shortest_step: None,
            fastest_decay: 0.0,
            dt_limit,
            limited_by_viscosity: false,
            volume: colour.iter().sum::<f64>() * cell,
            shape_volume: setup.shape.volume(),
            load: Vec3::zeros(),
            notes: Vec::new(),
        };
        let mut particles = Particles::new(n);
        particles.set(Field::Reference, Column::from_vectors(&positions));
        particles.set(Field::Displacement, Column::zeros(3, n));
        particles.set(Field::Mass, Column::from_vec(mass, n));
        particles.set(Field::Volume, Column::from_vec(vec![cell; n], n));
        particles.set(Field::Colour, Column::from_vec(colour, n));
        let lattice = NodeLattice { origin: Vec3::zeros(), spacing: dx };
        let remesher = Remesher { kernel: setup.remesh.kernel, lattice, volume: NewVolume::Cell };
        let model = Box::new(Self {
            dynamics: Prescribed { flow: p.flow.clone() },
            iso: p.iso,
            smoothing_length: description.smoothing_length,
            probes: setup.probes.clone(),
            remesher,
            strain: 0.0,
        });
        Ok(Parts { model, particles, description })
    }
}

impl Model for PrescribedBody {
    fn dynamics(&self) -> &dyn Dynamics {
        &self.dynamics
    }

    fn dynamics_mut(&mut self) -> &mut dyn Dynamics {
        &mut self.dynamics
    }

    fn strain(&mut self, particles: &Particles, time: f64, dt: f64) -> f64 {
        let rate_at = |x: &Vec3| self.dynamics.flow.rate_at(x, time);
        self.strain += dt * positions(particles).iter().map(rate_at).fold(0.0, f64::max);
        self.strain
    }

    fn remesh(&mut self, particles: &Particles, moment: Moment) -> Result<RemeshOutcome, Failure> {
        let x = positions(particles);
        let keep = |_: &Vec3, values: &[f64]| values[0].abs() >= SMALLEST_COLOUR;
        let fields = [Field::Colour, Field::Mass];
        let new = self.remesher.remesh(particles, &x, &fields, &keep); // Eq. (17)
        let new = new.map_err(|error| failure(error, moment))?;
        let (n, mut particles) = (new.positions.len(), new.particles);
        particles.set(Field::Reference, Column::from_vectors(&new.positions));
        particles.set(Field::Displacement, Column::zeros(3, n));
        self.strain = 0.0;
        let (folded_mass, dropped_mass) = (new.report.folded_mass, new.report.dropped_mass);
        Ok(RemeshOutcome {
            particles,
            folded_mass,
            dropped_mass,
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

    /// The surface of Eq. (8) with the velocity of the flow on it.
    fn surface(&self, snapshot: &Snapshot) -> Surface {
        let (grid, phi) = self.level_set(&snapshot.particles);
        let mesh = zero_level_set(&grid, &phi);
        let flow = &self.dynamics.flow;
        let velocity: Vec<f64> =
            mesh.vertices.iter().flat_map(|x| <[f64; 3]>::from(flow.at(x, snapshot.time))).collect();
        let name = Field::Velocity.spec().name;
        Surface { mesh, fields: vec![SurfaceField { name, components: 3, values: velocity }] }
    }

    fn readings(&mut self, particles: &Particles, time: f64) -> Vec<Reading> {
        let mut readings = Vec::new();
        if !self.probes.is_empty() {
            // Particles come and go: what is in a region now.
            let derived = self.derived(particles, time, &[]);
            let (x, volume) = (positions(particles), particles.column(Field::Volume).values());
            for probe in &self.probes {
                TaggedProbe::of_particles(probe, &x, volume).read(&derived, &mut readings);
            }
        }
        let (grid, phi) = self.level_set(particles);
        readings.push(Reading { name: VOLUME_INSIDE.into(), value: volume_inside(&grid, &phi) });
        readings
    }
}

/// Positions x = X + u.
fn positions(particles: &Particles) -> Vec<Vec3> {
    let (x0, u) = (particles.column(Field::Reference), particles.column(Field::Displacement));
    (0..particles.len()).map(|a| x0.vector(a) + u.vector(a)).collect()
}

/// The nodes inside or in the band, by z, y, x, with their colours.
fn coloured(setup: &Setup, p: &Prescription, body: &Body) -> (Vec<Vec3>, Vec<f64>) {
    let margin = p.band.ceil() as usize;
    let mut grid = body.grid.clone();
    grid.origin -= Vec3::repeat(margin as f64 * grid.spacing);
    grid.cells = grid.cells.map(|n| n + 2 * margin);
    let [nx, ny, _] = grid.cells;
    (0..grid.len())
        .map(|q| grid.centre([q % nx, q / nx % ny, q / nx / ny]))
        .map(|x| (x, ramp(setup.shape.signed_distance(&x), p.band * grid.spacing)))
        .filter(|(_, c)| *c >= SMALLEST_COLOUR)
        .unzip()
}

/// 1 inside, 0 outside, and in between a polynomial with two continuous derivatives across a band of
/// that half width.
fn ramp(distance: f64, half_width: f64) -> f64 {
    if half_width <= 0.0 {
        return f64::from(u8::from(distance < 0.0));
    }
    let s = (distance / half_width).clamp(-1.0, 1.0);
    0.5 - s * (15.0 - 10.0 * s.powi(2) + 3.0 * s.powi(4)) / 16.0
}

/// Lattice neighbours within the support of the kernel.
fn neighbours(smoothing: f64) -> usize {
    let support = 2.5 * smoothing;
    let r = support.ceil() as i64;
    let all = (-r..=r).flat_map(|i| (-r..=r).flat_map(move |j| (-r..=r).map(move |k| i * i + j * j + k * k)));
    all.filter(|d2| *d2 > 0 && (*d2 as f64) < support * support * (1.0 - 1e-9)).count()
}

/// A remeshing that failed, as the end of a simulation.
fn failure(error: RemeshError, moment: Moment) -> Failure {
    let (kind, place) = match error {
        RemeshError::Lost { position, .. } if position.iter().all(|c| c.is_finite()) => {
            (FailureKind::Scattered, Some(position))
        }
        RemeshError::Lost { .. } => (FailureKind::NotFinite, None),
        _ => (FailureKind::Scattered, None),
    };
    Failure {
        kind,
        time: moment.time,
        step: moment.step,
        what: error.to_string(),
        place,
        remedy: "take a smaller `time.dt`, and look whether the velocity carries particles away".into(),
    }
}
