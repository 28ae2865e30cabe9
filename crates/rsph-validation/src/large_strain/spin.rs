//! Bodies that are stretched and spin in empty space: what remeshing does to their energy and angular
//! momentum.

use super::setup;
use crate::Row;
use rsph_core::particles::Field;
use rsph_core::setup::{RemeshTrigger, Setup, SolidSetup, Solver, VectorField};
use rsph_core::shape::{DiscShape, SphereShape};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::{Mat3, Vec3};

/// Radius of the bodies.
const RADIUS: f64 = 0.5;
/// What the Runge-Kutta steps may change the angular momentum by: a bound of our own.
const SPIN_DRIFT: f64 = 1e-5;
/// Looks at the stretch on the way.
const LOOKS: usize = 24;

/// Drifts and stretch of a run.
struct Spun {
    /// Change of the total energy, relative to what it was.
    energy_drift: f64,
    /// Largest change of the angular momentum in one remesh, relative.
    remesh_jump: f64,
    /// Change of the angular momentum from the start to the end, relative.
    spin_drift: f64,
    /// Smallest and largest singular value of F on the way.
    stretch: (f64, f64),
}

/// A disc of the plane with the initial velocity of stretching by 2.2 and turning by 2, until t = 2. The bound
/// of the energy is that of issue 3.
pub(super) fn disc(quick: bool) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let rate = Mat3::new(2.2, -2.0, 0.0, 2.0, -2.2, 0.0, 0.0, 0.0, 0.0);
    for n in [20, 40] {
        for remeshings in if quick { vec![10] } else { vec![0, 1, 3, 10] } {
            let shape = DiscShape::new(RADIUS, [0.0; 2]).map_err(|e| e.to_string())?;
            let spun = spin(setup(shape, n), rate, 2.0, remeshings)
                .map_err(|e| format!("disc {n}, {remeshings} remeshings: {e}"))?;
            // At n = 20 a bound of our own: the surface is a fifth of the particles.
            let bound = if n == 20 { 2.0 } else { 0.5 };
            report(&format!("disc {n}"), remeshings, &spun, bound, &mut rows);
        }
    }
    Ok(rows)
}

/// A ball with the same velocity, until t = 1. Bounds are our own.
pub(super) fn ball(quick: bool) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let rate = Mat3::new(2.2, -2.0, 0.0, 2.0, -2.2, 0.0, 0.0, 0.0, 0.0);
    let n = if quick { 10 } else { 16 };
    for remeshings in if quick { vec![3] } else { vec![0, 1, 3] } {
        let shape = SphereShape::new(RADIUS, Vec3::zeros()).map_err(|e| e.to_string())?;
        let spun = spin(setup(shape, n), rate, 1.0, remeshings)?;
        let bound = if quick { 4.0 } else { 2.0 };
        report(&format!("ball {n}"), remeshings, &spun, bound, &mut rows);
    }
    Ok(rows)
}

fn report(name: &str, remeshings: usize, spun: &Spun, energy_bound: f64, rows: &mut Vec<Row>) {
    let name = |what: &str| format!("finite strain: {name}, {remeshings} remeshings, {what}");
    rows.push(Row::at_most(name("energy drift"), 100.0 * spun.energy_drift.abs(), energy_bound, "%"));
    if remeshings > 0 {
        rows.push(Row::at_most(name("angular momentum in a remesh"), spun.remesh_jump, 1e-12, "1"));
    }
    rows.push(Row::at_most(name("angular momentum in all"), spun.spin_drift, SPIN_DRIFT, "1"));
    rows.push(Row::at_least(name("largest stretch"), spun.stretch.1, 1.2, "1"));
}

fn spin(mut setup: Setup<SolidSetup>, gradient: Mat3, until: f64, remeshings: usize) -> Result<Spun, String> {
    setup.solver = Solver::ACCURATE;
    setup.remesh.trigger = if remeshings > 0 { RemeshTrigger::Steps(u64::MAX) } else { RemeshTrigger::Never };
    setup.initial.velocity = VectorField::Affine { constant: Vec3::zeros(), gradient };
    let mut body = Simulation::new(setup).map_err(|e| e.to_string())?;
    let start = (energy(&mut body), angular(&body));
    let (mut jump, mut stretch) = (0.0_f64, (1.0_f64, 1.0_f64));
    let looks = LOOKS.next_multiple_of(remeshings + 1);
    for k in 1..=looks {
        body.advance_to(until * k as f64 / looks as f64, &mut |_| true).map_err(|e| e.to_string())?;
        let snapshot = body.snapshot();
        let strain = snapshot.column(Field::Strain);
        for a in 0..strain.len() {
            let logarithms = strain.tensor(a).to_matrix().symmetric_eigenvalues();
            stretch = (stretch.0.min(logarithms.min().exp()), stretch.1.max(logarithms.max().exp()));
        }
        if k < looks && k % (looks / (remeshings + 1)) == 0 {
            let before = angular(&body);
            body.remesh().map_err(|e| e.to_string())?;
            jump = jump.max((angular(&body) - before).norm() / before.norm());
        }
    }
    Ok(Spun {
        energy_drift: energy(&mut body) / start.0 - 1.0,
        remesh_jump: jump,
        spin_drift: (angular(&body) - start.1).norm() / start.1.norm(),
        stretch,
    })
}

fn energy(body: &mut Simulation) -> f64 {
    let sums = body.conservation();
    sums.kinetic_energy + sums.elastic_energy
}

fn angular(body: &Simulation) -> Vec3 {
    let particles = body.particles();
    let (x, u) = (particles.column(Field::Reference), particles.column(Field::Displacement));
    let (v, mass) = (particles.column(Field::Velocity), particles.column(Field::Mass).values());
    (0..particles.len()).map(|a| (x.vector(a) + u.vector(a)).cross(&v.vector(a)) * mass[a]).sum()
}
