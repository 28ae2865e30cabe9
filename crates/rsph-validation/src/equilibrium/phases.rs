//! How much the answer depends on where the lattice happens to lie in the body.

use super::super::Row;
use super::super::case::{LIVER_VISIBLE_HUMAN, setup};
use super::super::liver::COMPLIANCE;
use super::accurate_liver;
use rsph_core::boundary::constraints::cuts;
use rsph_core::grid::{Bounds, Grid};
use rsph_core::mesh::TriangleMesh;
use rsph_core::sample::Resolution;
use rsph_core::shape::{Shape, cut};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// Particles, about.
const PARTICLES: usize = 5_000;
/// Positions of the lattice along x and z, in spacings, drawn once from uniform random numbers; along y their sum.
const PHASES: [[f64; 2]; 8] = [
    [0.6394, 0.0250],
    [0.2750, 0.2232],
    [0.7365, 0.6767],
    [0.8922, 0.0869],
    [0.4219, 0.0298],
    [0.2186, 0.5054],
    [0.0265, 0.1988],
    [0.6499, 0.5449],
];

/// A body in a bounding box that begins lower than it need: the lattice, which is centred in the box, moves.
#[derive(Debug)]
pub(in super::super) struct Placed {
    pub shape: Arc<dyn Shape>,
    /// By how much.
    pub more: Vec3,
}

impl Shape for Placed {
    fn name(&self) -> String {
        self.shape.name()
    }

    fn signed_distance(&self, x: &Vec3) -> f64 {
        self.shape.signed_distance(x)
    }

    fn signed_distances(&self, grid: &Grid, reach: f64) -> Vec<f64> {
        self.shape.signed_distances(grid, reach)
    }

    fn bounds(&self) -> Bounds {
        let Bounds { min, max } = self.shape.bounds();
        Bounds { min: min - self.more, max }
    }

    fn volume(&self) -> f64 {
        self.shape.volume()
    }

    fn surface(&self) -> &TriangleMesh {
        self.shape.surface()
    }

    fn fill(&self, grid: &Grid) -> Vec<f64> {
        self.shape.fill(grid)
    }
}

pub(super) fn run(quick: bool) -> Result<Vec<Row>, String> {
    let mut error = Vec::new();
    for phase in PHASES.iter().take(if quick { 3 } else { PHASES.len() }) {
        let (mut setup, until) = setup(LIVER_VISIBLE_HUMAN, &accurate_liver(PARTICLES))?;
        // Cut here, since what is cut has bounds of its own.
        let plane = setup
            .solid()
            .and_then(|solid| cuts(&solid.boundaries[0]))
            .ok_or("the liver is not clamped by a plane")?;
        let cut = cut(&setup.shape, &plane.point, &plane.normal, 1e-9).map_err(|e| e.to_string())?;
        let spacing = (cut.volume() / PARTICLES as f64).cbrt();
        // A longer box by twice the phase moves its centre, and the lattice, by the phase.
        let more = 2.0 * spacing * Vec3::new(phase[0], (phase[0] + phase[1]).fract(), phase[1]);
        setup.shape = Arc::new(Placed { shape: cut, more });
        setup.resolution = Resolution::Spacing(spacing);
        let mut liver = Simulation::new(setup).map_err(|e| e.to_string())?;
        let found = liver.solve_static(until, &mut |_, _| true).map_err(|e| e.to_string())?;
        error.push(100.0 * (found.compliance / COMPLIANCE - 1.0));
    }
    let (low, high) =
        error.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(*e), h.max(*e)));
    let name = format!("equilibrium: liver, {PARTICLES} particles, {} positions of the lattice", error.len());
    Ok(vec![
        Row::at_most(format!("{name}, scatter of compliance"), high - low, 0.5, "%"),
        Row::at_most(format!("{name}, compliance off at most"), high.max(-low), 1.5, "%"),
    ])
}
