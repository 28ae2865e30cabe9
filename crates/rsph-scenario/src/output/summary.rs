//! `summary.json`: what a run amounted to, in names that scripts rely on.

use super::{RunInfo, VERSION, machine};
use crate::sink::{Outcome, Status};
use rsph_core::shape::Repair;
use rsph_core::simulation::{Conservation, RemeshLog};
use rsph_core::tensor::Vec3;
use serde::Serialize;
use std::collections::BTreeMap;

/// Energies of the last moment (J; energy unit of the scenario).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Energy {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Elastic energy.
    pub elastic: f64,
    /// Work done on the body since the start.
    pub external_work: f64,
    /// Energy taken by the viscosity since the start.
    pub dissipated: f64,
    /// |kinetic + elastic + dissipated - external work - energy at the start| over the energy at the start or the
    /// work; `null` where `dissipated` is known only as what is missing.
    pub error: Option<f64>,
}

/// Why a run failed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FailureSummary {
    /// `not_finite`, `unstable`, `inverted`, `scattered`, `crossed`, `not_converged`, `mass_lost`,
    /// `step_too_short`.
    pub kind: &'static str,
    /// Simulated time of the last good state.
    pub time: f64,
    /// Step that failed.
    pub step: u64,
    /// What happened.
    pub what: String,
    /// Reference position where it shows most.
    pub place: Option<[f64; 3]>,
    /// What to change.
    pub remedy: String,
}

/// How a surface that was open or overlapped itself became a body, and how sure that is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RepairSummary {
    /// Edges not shared by exactly two triangles that turn the same way.
    pub open_edges: usize,
    /// Parts of the surface.
    pub parts: usize,
    /// Volume where the winding number is above 1/2.
    pub volume: f64,
    /// Volume where the winding number is above 3/4.
    pub volume_above_three_quarters: f64,
    /// Volume where the winding number is above 1/4.
    pub volume_above_one_quarter: f64,
    /// Share of the body where the winding number is below 3/4.
    pub uncertain: f64,
    /// Share of the body where the winding number is above 3/2.
    pub overlapping: f64,
    /// Share of the given area that lies on another part of the surface.
    pub layered: f64,
    /// Share of the body's surface with no triangle within a cell of `spacing`.
    pub made_up: f64,
    /// Where the surface is farthest from every triangle.
    pub gap_at: [f64; 3],
    /// Distance from there to the nearest triangle.
    pub gap: f64,
    /// Edge length of the cells.
    pub spacing: f64,
    /// Number of pieces and voids that were left out.
    pub dropped: usize,
    /// Volume of the pieces and voids that were left out.
    pub dropped_volume: f64,
}

impl RepairSummary {
    /// As the text of `repair` in `summary.json`.
    ///
    /// # Errors
    /// When it can not be expressed in JSON, which does not happen for this type.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string(self)
    }
}

impl From<&Repair> for RepairSummary {
    fn from(r: &Repair) -> Self {
        Self {
            open_edges: r.open_edges,
            parts: r.parts,
            volume: r.volume,
            volume_above_three_quarters: r.between[0],
            volume_above_one_quarter: r.between[1],
            uncertain: r.uncertain,
            overlapping: r.overlapping,
            layered: r.layered,
            made_up: r.made_up,
            gap_at: components(&r.gap_at),
            gap: r.gap,
            spacing: r.spacing,
            dropped: r.dropped.0,
            dropped_volume: r.dropped.1,
        }
    }
}

/// Number of remeshings and their effect on particles, mass, momentum and energy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Remeshing {
    /// How often the body was remeshed.
    pub count: u64,
    /// Particles before the first remeshing.
    pub particles_before: usize,
    /// Particles after the last remeshing.
    pub particles_after: usize,
    /// Mass before the first remeshing.
    pub mass_before: f64,
    /// Mass after the last remeshing.
    pub mass_after: f64,
    /// Largest change of mass in one remeshing over the mass.
    pub largest_mass_jump: f64,
    /// Momentum before the first remeshing; zero in a prescribed motion.
    pub momentum_before: [f64; 3],
    /// Momentum after the last remeshing; zero in a prescribed motion.
    pub momentum_after: [f64; 3],
    /// Largest change of momentum in one remeshing.
    pub largest_momentum_jump: f64,
    /// Largest momentum that one remeshing would have lost or made, had it not been given back.
    pub largest_momentum_correction: f64,
    /// Kinetic and elastic energy before the first remeshing; zero in a prescribed motion.
    pub energy_before: f64,
    /// Kinetic and elastic energy after the last remeshing; zero in a prescribed motion.
    pub energy_after: f64,
    /// Sum of the changes of kinetic and elastic energy in all remeshings.
    pub energy_change: f64,
    /// Sum of |mass| that went from a node that holds too little for a particle to the nearest kept one.
    pub folded_mass: f64,
    /// Mass that had no kept node near and was lost.
    pub dropped_mass: f64,
    /// Largest relative change that the volumes of a solid got in one remeshing so that their sum stays.
    pub largest_rescaling: f64,
    /// Smallest time step after a remeshing of a solid.
    pub smallest_dt: f64,
}

impl From<&RemeshLog> for Remeshing {
    fn from(log: &RemeshLog) -> Self {
        let [before, after] = &log.sums;
        Self {
            count: log.count,
            particles_before: before.particles,
            particles_after: after.particles,
            mass_before: before.mass,
            mass_after: after.mass,
            largest_mass_jump: log.largest_mass_jump,
            momentum_before: components(&before.momentum),
            momentum_after: components(&after.momentum),
            largest_momentum_jump: log.largest_momentum_jump,
            largest_momentum_correction: log.largest_momentum_correction,
            energy_before: before.energy,
            energy_after: after.energy,
            energy_change: log.energy_change,
            folded_mass: log.folded_mass,
            dropped_mass: log.dropped_mass,
            largest_rescaling: log.largest_rescaling,
            smallest_dt: log.smallest_dt,
        }
    }
}

/// An equilibrium of `solver.mode = "static"`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EquilibriumSummary {
    /// Iterations of the linear solver.
    pub iterations: usize,
    /// Steps of Newton's method: one or two if the law is linear.
    pub newton_steps: usize,
    /// Forces out of balance as a share of the load.
    pub residual: f64,
    /// Loads times displacement, f . u.
    pub compliance: f64,
    /// Total force of the loads.
    pub load: [f64; 3],
    /// Total force of the clamps on the body.
    pub reaction: [f64; 3],
}

/// The contents of `summary.json`. Numbers that are not finite become `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Title of the scenario.
    pub title: String,
    /// `finished`, `interrupted` or `failed`.
    pub status: &'static str,
    /// Why, if it failed.
    pub failure: Option<FailureSummary>,
    /// Number of particles at the end.
    pub particles: usize,
    /// Time steps taken.
    pub steps: u64,
    /// Simulated time reached.
    pub time: f64,
    /// Wall time of the run loop (s).
    pub wall_seconds: f64,
    /// Steps per second of wall time.
    pub steps_per_second: f64,
    /// Right-hand sides evaluated.
    pub rhs_evaluations: u64,
    /// Particles x right-hand sides per second of wall time.
    pub particle_updates_per_second: f64,
    /// Simulated time per wall time.
    pub real_time_factor: f64,
    /// |mass - mass at the start| / mass at the start.
    pub mass_error: f64,
    /// Relative error of the momentum balance.
    pub momentum_error: f64,
    /// Energies at the end.
    pub energy: Energy,
    /// Scheme of integration in time.
    pub integrator: &'static str,
    /// Why, if the program chose it; `null` otherwise.
    pub integrator_reason: Option<String>,
    /// Time step; the first of a scheme that chooses its steps.
    pub dt: f64,
    /// Largest stable time step.
    pub dt_limit: f64,
    /// Threads used.
    pub threads: usize,
    /// Version of rsph.
    pub version: &'static str,
    /// Vector instructions that the sums use: `x86-64-v4`, `x86-64-v3`, `neon` or `scalar`. The last digits of
    /// results depend on it.
    pub simd: &'static str,
    /// Name of the processor.
    pub processor: String,
    /// SHA-256 of the scenario as run.
    pub scenario_sha256: String,
    /// `SI` or `normalised`.
    pub units: &'static str,
    /// Particle spacing dx.
    pub spacing: f64,
    /// Smoothing length h.
    pub smoothing_length: f64,
    /// Neighbours of an inner particle.
    pub neighbours: usize,
    /// Volume of the particles.
    pub volume: f64,
    /// Volume of the shape.
    pub shape_volume: f64,
    /// Total force of the loads at the end.
    pub load: [f64; 3],
    /// Total force of the clamps on the body at the end.
    pub reaction: [f64; 3],
    /// The last row of `probes.csv`, by column.
    pub readings: BTreeMap<String, f64>,
    /// The last equilibrium of mode "static"; `null` if none was asked for.
    pub equilibrium: Option<EquilibriumSummary>,
    /// What remeshing did; `null` if remeshing is off.
    pub remesh: Option<Remeshing>,
    /// How the body's surface was made whole; `null` if it was closed.
    pub repair: Option<RepairSummary>,
    /// Number of frames stored.
    pub frames: usize,
    /// Things the user should know.
    pub notes: Vec<String>,
}

impl Summary {
    /// Sums up a run whose last moment had `particles`, `conservation` and these `readings`.
    pub fn new(
        info: &RunInfo,
        outcome: &Outcome,
        (conservation, readings): (&Conservation, &[f64]),
        particles: usize,
        frames: usize,
    ) -> Self {
        let d = &info.description;
        let rate = |x: f64| if outcome.wall_seconds > 0.0 { x / outcome.wall_seconds } else { 0.0 };
        let (status, failure) = match &outcome.status {
            Status::Finished => ("finished", None),
            Status::Interrupted => ("interrupted", None),
            Status::Failed(f) => ("failed", Some(f)),
        };
        Self {
            title: info.title.clone(),
            status,
            failure: failure.map(failure_summary),
            particles,
            steps: outcome.steps,
            time: outcome.time,
            wall_seconds: outcome.wall_seconds,
            steps_per_second: rate(outcome.steps as f64),
            rhs_evaluations: outcome.rhs_evaluations,
            particle_updates_per_second: rate(particles as f64 * outcome.rhs_evaluations as f64),
            real_time_factor: rate(outcome.time),
            mass_error: conservation.mass_error,
            momentum_error: conservation.momentum_error,
            energy: Energy {
                kinetic: conservation.kinetic_energy,
                elastic: conservation.elastic_energy,
                external_work: conservation.external_work,
                dissipated: conservation.dissipated,
                error: conservation.energy_error,
            },
            integrator: d.scheme.name(),
            integrator_reason: d.scheme_reason.clone(),
            dt: d.dt,
            dt_limit: d.dt_limit,
            threads: outcome.threads,
            version: VERSION,
            simd: machine::simd(),
            processor: machine::processor(),
            scenario_sha256: info.scenario_sha256(),
            units: super::units::name(info.units),
            spacing: d.spacing,
            smoothing_length: d.smoothing_length,
            neighbours: d.neighbours,
            volume: d.volume,
            shape_volume: d.shape_volume,
            load: components(&conservation.load),
            reaction: components(&conservation.reaction),
            readings: info.probes.iter().map(|p| p.name.clone()).zip(readings.iter().copied()).collect(),
            equilibrium: outcome.equilibrium.map(|e| EquilibriumSummary {
                iterations: e.iterations,
                newton_steps: e.steps,
                residual: e.residual,
                compliance: e.compliance,
                load: components(&e.load),
                reaction: components(&e.reaction),
            }),
            remesh: outcome.remesh.as_ref().map(Remeshing::from),
            repair: info.repair.as_ref().map(RepairSummary::from),
            frames,
            notes: d.notes.iter().chain(&outcome.notes).cloned().collect(),
        }
    }

    /// As the text of `summary.json`.
    ///
    /// # Errors
    /// When it can not be expressed in JSON, which does not happen for this type.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|s| s + "\n")
    }
}

fn failure_summary(f: &rsph_core::error::Failure) -> FailureSummary {
    use rsph_core::error::FailureKind::{
        Crossed, Inverted, MassLost, NotConverged, NotFinite, Scattered, StepTooShort, Unstable,
    };
    FailureSummary {
        kind: match f.kind {
            NotFinite => "not_finite",
            Unstable => "unstable",
            Inverted => "inverted",
            Scattered => "scattered",
            Crossed => "crossed",
            NotConverged => "not_converged",
            MassLost => "mass_lost",
            StepTooShort => "step_too_short",
        },
        time: f.time,
        step: f.step,
        what: f.what.clone(),
        place: f.place.as_ref().map(components),
        remedy: f.remedy.clone(),
    }
}

fn components(v: &Vec3) -> [f64; 3] {
    (*v).into()
}
