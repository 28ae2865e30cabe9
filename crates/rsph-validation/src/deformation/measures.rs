//! How whole and how exact a deformed body is.

use rsph_core::dynamics::prescribed::Prescribed;
use rsph_core::flow::{Flow, VelocityField};
use rsph_core::grid::Grid;
use rsph_core::integrate::{Integrator, RungeKutta4};
use rsph_core::kernel::RemeshKernel;
use rsph_core::particles::{Column, Field, Particles};
use rsph_core::reconstruct::{grid_around, reconstruct};
use rsph_core::remesh::{NodeLattice, gather, scatter};
use rsph_core::simulation::Simulation;
use rsph_core::snapshot::Snapshot;
use rsph_core::tensor::Vec3;

/// The undeformed sphere.
const CENTRE: f64 = 0.35;
const RADIUS: f64 = 0.15;
/// Time step of tracing back.
const TRACING_STEP: f64 = 0.02;
/// The colour that separates inside from outside when a body is compared with the exact one.
const HALF: f64 = 0.5;
/// Levels that are tried between the lowest and the highest.
const LEVELS: u32 = 130;
const LOWEST: f64 = 0.05;
const HIGHEST: f64 = 0.7;
/// A piece with a smaller share of the volume does not count.
const SMALLEST_SHARE: f64 = 0.01;

/// Where the exact body is, on a grid over the unit cube.
pub(super) struct Exact {
    points: Vec<Vec3>,
    inside: Vec<bool>,
}

impl Exact {
    /// The undeformed sphere, for particles with that spacing.
    pub fn sphere(spacing: f64) -> Self {
        let points = points(spacing);
        let inside = points.iter().map(in_sphere).collect();
        Self { points, inside }
    }

    /// The sphere deformed until `time`: points are inside that come from inside, traced back.
    pub fn sheet(spacing: f64, time: f64) -> Result<Self, String> {
        let points = points(spacing);
        let mut particles = Particles::new(points.len());
        particles.set(Field::Reference, Column::from_vectors(&points));
        particles.set(Field::Displacement, Column::zeros(3, points.len()));
        let mut flow = Prescribed { flow: Flow { velocity: VelocityField::Leveque, reversal: None } };
        let mut integrator = RungeKutta4::default();
        let steps = (time / TRACING_STEP).round();
        if steps < 1.0 {
            return Err(format!("no step fits into {time}"));
        }
        for k in 0..steps as u32 {
            let dt = time / steps;
            let step = integrator.step(&mut flow, &mut particles, time - f64::from(k) * dt, -dt);
            debug_assert!(step.is_ok(), "explicit steps do not fail");
        }
        let u = particles.column(Field::Displacement);
        let inside = points.iter().enumerate().map(|(a, x)| in_sphere(&(x + u.vector(a)))).collect();
        Ok(Self { points, inside })
    }
}

fn in_sphere(x: &Vec3) -> bool {
    (x - Vec3::repeat(CENTRE)).norm() < RADIUS
}

/// Shift of the grid of points, in its spacings. Points that are symmetric to the sphere would lie on
/// few shells, and one shell beside the surface would decide.
const SHIFT: [f64; 3] = [0.137, 0.291, 0.413];

/// Points of a grid over the unit cube: of half the spacing unless that would be very many.
fn points(spacing: f64) -> Vec<Vec3> {
    let fine = if spacing > 0.02 { 0.5 * spacing } else { 0.8 * spacing };
    let n = (1.0 / fine).round() as usize;
    let grid = Grid { origin: -Vec3::from(SHIFT) * fine, spacing: fine, cells: [n + 1; 3] };
    (0..grid.len()).map(|q| grid.centre([q % (n + 1), q / (n + 1) % (n + 1), q / (n + 1).pow(2)])).collect()
}

/// Volume in which the body of `sim` and the exact one differ over the exact volume. Inside is where
/// the colour, brought to the lattice and interpolated by `kernel`, exceeds one half.
pub(super) fn difference(sim: &mut Simulation, kernel: RemeshKernel, exact: &Exact) -> f64 {
    let snapshot = sim.snapshot();
    let lattice = NodeLattice::<3> { origin: Vec3::zeros(), spacing: sim.description().spacing };
    let positions: Vec<Vec3> = snapshot.positions().into_iter().map(Vec3::from).collect();
    let colour = snapshot.column(Field::Colour).values();
    let Ok(nodes) = scatter(kernel, lattice, &positions, 1, colour) else { return f64::INFINITY };
    let field = gather(kernel, &nodes, &exact.points);
    let differs = field.iter().zip(&exact.inside).filter(|(c, inside)| (**c > HALF) != **inside).count();
    differs as f64 / exact.inside.iter().filter(|i| **i).count() as f64
}

/// The highest level up to which {C > level}, Eq. (8), is one piece; small pieces do not count.
pub(super) fn tear_level(snapshot: &Snapshot, spacing: f64) -> f64 {
    let positions: Vec<Vec3> = snapshot.positions().into_iter().map(Vec3::from).collect();
    let (colour, volume) = (snapshot.column(Field::Colour), snapshot.column(Field::Volume));
    let amount: Vec<f64> = colour.values().iter().zip(volume.values()).map(|(c, v)| c * v).collect();
    let smoothing_length = 1.25 * spacing;
    let grid = grid_around(&positions, 2.5 * smoothing_length, 0.5 * spacing);
    let field = reconstruct(&positions, &amount, smoothing_length, &grid);
    let top = field.iter().copied().fold(0.0, f64::max).min(HIGHEST);
    let level = |k: u32| LOWEST + (top - LOWEST) * f64::from(k) / f64::from(LEVELS);
    let torn = (0..=LEVELS).find(|&k| pieces(&grid, &field, level(k)) != 1);
    torn.map_or(top, |k| level(k.saturating_sub(1)))
}

/// Pieces of the cells above `level`, with all 26 neighbours, that are not small.
fn pieces(grid: &Grid, field: &[f64], level: f64) -> usize {
    let [nx, ny, nz] = grid.cells;
    let mut open: Vec<bool> = field.iter().map(|c| *c > level).collect();
    let (mut sizes, mut stack) = (Vec::new(), Vec::new());
    for first in 0..open.len() {
        if !std::mem::take(&mut open[first]) {
            continue;
        }
        let mut size = 0_usize;
        stack.push(first);
        while let Some(n) = stack.pop() {
            size += 1;
            let around = |i: usize, cells: usize| i.saturating_sub(1)..(i + 2).min(cells);
            for k in around(n / nx / ny, nz) {
                for j in around(n / nx % ny, ny) {
                    for i in around(n % nx, nx) {
                        let m = (k * ny + j) * nx + i;
                        if std::mem::take(&mut open[m]) {
                            stack.push(m);
                        }
                    }
                }
            }
        }
        sizes.push(size);
    }
    let all: usize = sizes.iter().sum();
    sizes.iter().filter(|s| **s as f64 >= SMALLEST_SHARE * all as f64).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_touch_at_corners_and_crumbs_do_not_count() {
        let grid = Grid { origin: Vec3::zeros(), spacing: 1.0, cells: [10, 10, 2] };
        let block = |x0: usize, x1: usize| move |q: usize| (x0..x1).contains(&(q % 10)) && q / 10 % 10 < 5;
        let field = |inside: &dyn Fn(usize) -> bool| -> Vec<f64> {
            (0..200).map(|q| f64::from(u8::from(inside(q)))).collect()
        };
        let (left, right) = (block(0, 3), block(5, 10));
        assert_eq!(pieces(&grid, &field(&|q| left(q) || right(q)), 0.5), 2);
        assert_eq!(pieces(&grid, &field(&|q| left(q) || right(q) || block(2, 6)(q)), 0.5), 1);
        // One cell of a hundred and more.
        assert_eq!(
            pieces(&grid, &field(&|q| block(0, 10)(q) || block(0, 10)(q.wrapping_sub(50)) || q == 199), 0.5),
            1
        );
        let diagonal = |q: usize| [0, 11, 122].contains(&q);
        assert_eq!(pieces(&grid, &field(&diagonal), 0.5), 1);
        assert_eq!(pieces(&grid, &field(&|_| false), 0.5), 0);
    }
}
