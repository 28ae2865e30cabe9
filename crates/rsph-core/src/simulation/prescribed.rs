//! Simulations of bodies that move as told: the colour that particles carry, their remeshing, and the
//! surface of Eq. (8).

use super::remeshing::Remeshing;
use super::{Description, Parts, SurfaceSource};
use crate::dynamics::prescribed::Prescribed;
use crate::error::{Failure, FailureKind, InvalidInput};
use crate::grid::Grid;
use crate::level_set::volume_inside;
use crate::marching_cubes::zero_level_set;
use crate::particles::{Column, Field, Particles};
use crate::reconstruct::{grid_around, reconstruct};
use crate::remesh::{NewVolume, NodeLattice, RemeshError, Remesher};
use crate::sample::{Alignment, Body, sample};
use crate::setup::{Prescription, Setup, TimeStep};
use crate::snapshot::Snapshot;
use crate::surface::{Surface, SurfaceField};
use crate::tensor::Vec3;

/// Nodes with a smaller |c| hold no particle; what lands on them goes to the nearest one that does.
const SMALLEST_COLOUR: f64 = 1e-4;
/// A time step that is allowed turns or strains a particle by at most this much ...
const LARGEST_STRAIN: f64 = 1.0;
/// ... and one that the program chooses by this much.
const CHOSEN_STRAIN: f64 = 0.125;

/// Fields that the particles of a prescribed motion have.
const FIELDS: [Field; 6] =
    [Field::Displacement, Field::Velocity, Field::Mass, Field::Volume, Field::Colour, Field::Reference];

/// The surface of Eq. (8).
#[derive(Clone, Debug)]
pub(super) struct Reconstruction {
    pub prescription: Prescription,
    pub spacing: f64,
    pub smoothing_length: f64,
}

impl Reconstruction {
    /// iso - C(x), Eq. (8), on a grid of half the spacing around the particles.
    fn level_set(&self, particles: &Particles) -> (Grid, Vec<f64>) {
        let positions = positions(particles);
        let (colour, volume) = (particles.column(Field::Colour), particles.column(Field::Volume));
        let amount: Vec<f64> = colour.values().iter().zip(volume.values()).map(|(c, v)| c * v).collect();
        // The field ends at 2.5 h from the particles; one cell more for the surface to close.
        let grid = grid_around(&positions, 2.5 * self.smoothing_length + self.spacing, 0.5 * self.spacing);
        let mut phi = reconstruct(&positions, &amount, self.smoothing_length, &grid);
        for c in &mut phi {
            *c = self.prescription.iso - *c;
        }
        (grid, phi)
    }

    /// The surface with the velocity of the flow on it.
    pub fn surface(&self, snapshot: &Snapshot) -> Surface {
        let (grid, phi) = self.level_set(&snapshot.particles);
        let mesh = zero_level_set(&grid, &phi);
        let flow = &self.prescription.flow;
        let velocity: Vec<f64> =
            mesh.vertices.iter().flat_map(|x| <[f64; 3]>::from(flow.at(x, snapshot.time))).collect();
        let name = Field::Velocity.spec().name;
        Surface { mesh, fields: vec![SurfaceField { name, components: 3, values: velocity }] }
    }

    /// The volume inside that surface.
    pub fn volume_inside(&self, particles: &Particles) -> f64 {
        let (grid, phi) = self.level_set(particles);
        volume_inside(&grid, &phi)
    }
}

/// Positions x = X + u.
pub(super) fn positions(particles: &Particles) -> Vec<Vec3> {
    let (x0, u) = (particles.column(Field::Reference), particles.column(Field::Displacement));
    (0..particles.len()).map(|a| x0.vector(a) + u.vector(a)).collect()
}

/// Samples the body and chooses the time step.
pub(super) fn parts(setup: &Setup, p: &Prescription) -> Result<Parts, InvalidInput> {
    check(setup, p)?;
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
    let mass: Vec<f64> = colour.iter().map(|c| c * cell * setup.material.density()).collect();
    let rate = positions.iter().map(|x| p.flow.rate_at(x, 0.0)).fold(0.0, f64::max);
    let dt_limit = LARGEST_STRAIN / p.flow.largest_rate().unwrap_or(rate);
    let description = Description {
        particles: n,
        spacing: dx,
        smoothing_length: setup.solver.smoothing * dx,
        neighbours: neighbours(setup.solver.smoothing),
        dt: time_step(setup, dt_limit)?,
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
    let smoothing_length = description.smoothing_length;
    Ok(Parts {
        body,
        description,
        dynamics: Box::new(Prescribed { flow: p.flow.clone() }),
        particles,
        probes: Vec::new(),
        surface: SurfaceSource::Reconstructed(Reconstruction {
            prescription: p.clone(),
            spacing: dx,
            smoothing_length,
        }),
        remeshing: Some(Remeshing::new(remesher, setup.remesh.trigger)),
    })
}

/// What a prescribed motion has no use for, and values out of range.
fn check(setup: &Setup, p: &Prescription) -> Result<(), InvalidInput> {
    let useless = |key: &str, there: bool| {
        let refuse = || {
            InvalidInput::new(
                key,
                "",
                "a prescribed motion takes no loads, boundaries or initial values: the particles follow the \
                 given velocity",
                "remove it, or remove [dynamics] to simulate a solid",
            )
        };
        if there { Err(refuse()) } else { Ok(()) }
    };
    useless("boundary", !setup.boundaries.is_empty())?;
    useless("load", !setup.loads.is_empty())?;
    if !(p.iso > 0.0 && p.iso < 1.0) {
        return Err(InvalidInput::new(
            "dynamics.iso",
            p.iso,
            "the colour that makes the surface must lie between 0 and 1",
            "0.5 keeps the volume of a smooth body; thin sheets that the spacing hardly resolves need less",
        ));
    }
    if !(0.0..=8.0).contains(&p.band) {
        return Err(InvalidInput::new(
            "dynamics.band",
            p.band,
            "the half width of the colour's band must lie between 0 (a jump) and 8 spacings",
            "0 is good for thin sheets, 2 for a body that stays thick",
        ));
    }
    if let Some(period) = p.flow.reversal
        && !(period.is_finite() && period > 0.0)
    {
        return Err(InvalidInput::new(
            "dynamics.reversal",
            period,
            "the time after which everything is back in its place must be positive",
            "for example 1.257, or remove the key for a steady flow",
        ));
    }
    let strange = setup.probes.iter().position(|probe| !FIELDS.contains(&probe.quantity.field));
    if let Some(i) = strange {
        let field = setup.probes[i].quantity.field.spec().name;
        return Err(InvalidInput::new(
            format!("probe[{i}].quantity"),
            field,
            "the particles of a prescribed motion do not have this field",
            format!("choose one of {}", FIELDS.map(|f| f.spec().name).join(", ")),
        ));
    }
    Ok(())
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

fn time_step(setup: &Setup, limit: f64) -> Result<f64, InvalidInput> {
    let refuse = |value: String, problem: String, remedy: &str| {
        Err(InvalidInput::new("time.dt", value, problem, remedy))
    };
    match setup.time_step {
        TimeStep::Auto if limit.is_finite() => Ok(CHOSEN_STRAIN * limit),
        TimeStep::Auto => refuse(
            "auto".into(),
            "the velocity is the same everywhere, so that no time step follows from it".into(),
            "give `time.dt` a number",
        ),
        TimeStep::Fixed(dt) if !(dt.is_finite() && dt > 0.0) => {
            refuse(dt.to_string(), "must be a positive number".into(), "`dt = \"auto\"` chooses one")
        }
        TimeStep::Fixed(dt) if dt > limit && !setup.allow_unstable => refuse(
            dt.to_string(),
            format!(
                "strains the body by more than {LARGEST_STRAIN} in one step; at most {limit:.4e} is allowed"
            ),
            "take `dt = \"auto\"`; `time.allow_unstable = true` lets you try",
        ),
        TimeStep::Fixed(dt) => Ok(dt),
    }
}

/// Lays the particles anew.
///
/// # Errors
/// Particles that no lattice holds, or none that is left.
pub(super) fn remesh(remeshing: &mut Remeshing, particles: &Particles) -> Result<Particles, RemeshError> {
    let x = positions(particles);
    let keep = |_: &Vec3, values: &[f64]| values[0].abs() >= SMALLEST_COLOUR;
    let fields = [Field::Colour, Field::Mass];
    let new = remeshing.remesher.remesh(particles, &x, &fields, &keep)?; // Eq. (17)
    remeshing.done(&new.report);
    let (n, mut particles) = (new.positions.len(), new.particles);
    particles.set(Field::Reference, Column::from_vectors(&new.positions));
    particles.set(Field::Displacement, Column::zeros(3, n));
    Ok(particles)
}

/// A remeshing that failed, as the end of a simulation.
pub(super) fn failure(error: RemeshError, time: f64, step: u64) -> Failure {
    let (kind, place) = match error {
        RemeshError::Lost { position, .. } if position.iter().all(|c| c.is_finite()) => {
            (FailureKind::Scattered, Some(position))
        }
        RemeshError::Lost { .. } => (FailureKind::NotFinite, None),
        _ => (FailureKind::Scattered, None),
    };
    Failure {
        kind,
        time,
        step,
        what: error.to_string(),
        place,
        remedy: "take a smaller `time.dt`, and look whether the velocity carries particles away".into(),
    }
}
