//! Bodies that are stretched and spin in empty space: what remeshing does to their energy and angular
//! momentum. Time goes on by the velocity Verlet method, which keeps angular momentum to rounding.

use super::{body, setup};
use crate::validation::Row;
use rsph_core::dynamics::large_strain::body::LargeBody;
use rsph_core::setup::Setup;
use rsph_core::shape::{DiscShape, SphereShape};
use rsph_core::tensor::{Mat3, Vec3};

/// Radius of the bodies.
const RADIUS: f64 = 0.5;
/// Time step in spacings over the speed of pressure waves.
const COURANT: f64 = 0.3;

/// What a run has come to.
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
            let setup = setup(shape, n, 1.0);
            let spun = spin::<2>(&setup, &rate, 2.0, remeshings)?;
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
        let setup = setup(shape, n, 1.0);
        let spun = spin::<3>(&setup, &rate, 1.0, remeshings)?;
        let bound = if quick { 4.0 } else { 2.0 };
        report(&format!("ball {n}"), remeshings, &spun, bound, &mut rows);
    }
    Ok(rows)
}

fn report(name: &str, remeshings: usize, spun: &Spun, energy_bound: f64, rows: &mut Vec<Row>) {
    let name = |what: &str| format!("large strain: {name}, {remeshings} remeshings, {what}");
    rows.push(Row::at_most(name("energy drift"), 100.0 * spun.energy_drift.abs(), energy_bound, "%"));
    if remeshings > 0 {
        rows.push(Row::at_most(name("angular momentum in a remesh"), spun.remesh_jump, 1e-12, "1"));
    }
    rows.push(Row::at_most(name("angular momentum in all"), spun.spin_drift, 1e-11, "1"));
    rows.push(Row::at_least(name("largest stretch"), spun.stretch.1, 1.2, "1"));
}

fn spin<const D: usize>(setup: &Setup, rate: &Mat3, until: f64, remeshings: usize) -> Result<Spun, String> {
    let mut body = body::<D>(setup)?;
    let mut x = body.nodes().to_vec();
    let mut v: Vec<Vec3> = x.iter().map(|x| rate * x).collect();
    let speed = (setup.material.p_wave_modulus() / setup.material.density()).sqrt();
    // As many steps as all numbers of remeshings divide.
    let steps = ((until * speed / (COURANT * body.spacing)) as usize / 132 + 1) * 132;
    let dt = until / steps as f64;
    let mut force = vec![Vec3::zeros(); x.len()];
    let mut elastic = body.dynamics.elastic_force(0.0, &x, &mut force);
    let start = (elastic + kinetic(&body, &v), angular(&body, &x, &v));
    let (mut jump, mut stretch) = (0.0_f64, (1.0_f64, 1.0_f64));
    for k in 1..=steps {
        kick(&body, 0.5 * dt, &force, &mut v);
        x.iter_mut().zip(&v).for_each(|(x, v)| *x += dt * v);
        elastic = body.dynamics.elastic_force(0.0, &x, &mut force);
        if !elastic.is_finite() {
            return Err(format!("turned inside out at t = {}", k as f64 * dt));
        }
        kick(&body, 0.5 * dt, &force, &mut v);
        if k % 12 == 0 {
            for f in body.dynamics.deformation() {
                let squares = (f.transpose() * f).symmetric_eigenvalues();
                stretch = (stretch.0.min(squares.min().sqrt()), stretch.1.max(squares.max().sqrt()));
            }
        }
        if k < steps && k % (steps / (remeshings + 1)) == 0 {
            let new = body.remesh(k as f64 * dt, &x, &v).map_err(|e| e.to_string())?;
            let [before, after] = new.angular_momentum;
            jump = jump.max((after - before).norm() / before.norm());
            (x, v) = (body.nodes().to_vec(), new.velocity);
            force.resize(x.len(), Vec3::zeros());
            elastic = body.dynamics.elastic_force(0.0, &x, &mut force);
        }
    }
    Ok(Spun {
        energy_drift: (elastic + kinetic(&body, &v)) / start.0 - 1.0,
        remesh_jump: jump,
        spin_drift: (angular(&body, &x, &v) - start.1).norm() / start.1.norm(),
        stretch,
    })
}

fn kick<const D: usize>(body: &LargeBody<D>, dt: f64, force: &[Vec3], v: &mut [Vec3]) {
    for ((v, f), m) in v.iter_mut().zip(force).zip(&body.dynamics.mass) {
        *v += f * (dt / m);
    }
}

fn kinetic<const D: usize>(body: &LargeBody<D>, v: &[Vec3]) -> f64 {
    v.iter().zip(&body.dynamics.mass).map(|(v, m)| 0.5 * m * v.norm_squared()).sum()
}

fn angular<const D: usize>(body: &LargeBody<D>, x: &[Vec3], v: &[Vec3]) -> Vec3 {
    x.iter().zip(v).zip(&body.dynamics.mass).map(|((x, v), m)| x.cross(v) * *m).sum()
}
