//! What remeshing does to the fluid's momentum.

use super::{END, finished, paper, with};
use crate::Row;
use crate::case::{FSI_1D, simulation};
use rsph_core::dynamics::fsi_1d::FluidStructure;
use rsph_core::particles::Field;
use rsph_core::setup::{Interaction, Mechanics};

/// Nodes at each end whose momentum remeshing may change.
const ENDS: usize = 4;
/// Momentum of fluid and solid at the start, the largest of the run.
const LARGEST_MOMENTUM: f64 = 0.1;

pub(super) fn rows(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    rows.push(Row::at_most(
        "fsi_1d: momentum, remeshing away from the ends",
        inside()?,
        1e-13,
        "of sum |V u|",
    ));
    // The bounds, and our own for the default at 400 elements, which remeshes 16 times more rarely.
    for (what, elements, sets, bound) in [
        ("scheme of the paper", 100, paper(), 1e-3),
        ("scheme of the paper", 400, paper(), 2e-5),
        ("default", 100, Vec::new(), 1e-3),
        ("default", 400, Vec::new(), 1e-4),
    ] {
        if quick && elements > 100 {
            continue;
        }
        let sim = finished(&with(elements, 0.8, &sets))?;
        let log = sim.remesh_log().ok_or("remeshing left no log")?;
        let name = format!("fsi_1d: closure at the ends a remeshing, {elements} elements, {what}");
        rows.push(Row::at_most(name, log.largest_momentum_jump / LARGEST_MOMENTUM, bound, "of the momentum"));
    }
    Ok(())
}

/// Change of the momentum of a fluid that rests at its ends, by one remeshing of particles that half a unit of
/// time has carried away from their nodes.
fn inside() -> Result<f64, String> {
    let (mut sim, _) = simulation(FSI_1D, &["remesh.every=0".into()])?;
    sim.advance_to(0.25 * END, &mut |_| true).map_err(|e| e.to_string())?;
    let Mechanics::Interaction(setting) = &sim.setup().mechanics else {
        return Err("the scenario has no fluid beside a solid".into());
    };
    let interaction = Interaction {
        fluid: setting.fluid.clone(),
        elasticity: setting.elasticity,
        solid_density: setting.solid_density,
        left: -0.5,
        interface: 0.0,
        right: 0.5,
        elements: [50, 50],
    };
    let mut particles = sim.particles().clone();
    let u = particles.column_mut(Field::Velocity).values_mut();
    u[..=ENDS].fill(0.0);
    u[50 - ENDS..=50].fill(0.0);
    let volume = particles.column(Field::Volume).values();
    let scale: f64 =
        (0..=50).map(|i| (volume[i] * particles.column(Field::Velocity).values()[i]).abs()).sum();
    let mut dynamics = FluidStructure::new(&interaction, sim.setup().solver.smoothing);
    let done = dynamics.remesh(sim.setup().remesh.kernel, &mut particles).map_err(|e| e.to_string())?;
    Ok((done.momentum[1] - done.momentum[0]).abs() / scale)
}
