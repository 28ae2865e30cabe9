//! The surface on which a winding number is one half, on a lattice.

use crate::grid::{Bounds, Grid};
use crate::marching_cubes::zero_level_set;
use crate::mesh::TriangleMesh;
use crate::winding::WindingField;
use rayon::prelude::*;

/// Most cells of the lattice, most along an axis, and the least number when a field takes long.
pub(super) const MOST_CELLS: usize = 1_000_000;
const MOST_ALONG: f64 = 1_000.0;
const LEAST_CELLS: usize = 10_000;
/// Looks at nodes and triangles for the cells of the lattice (about three seconds of a processor).
const EFFORT: usize = 100_000_000;
/// Empty cells around the surface.
const MARGIN: usize = 3;
/// Halvings that look for the surface between two cells.
const HALVINGS: usize = 6;

/// The inside: where the winding number is above this (Jacobson et al. 2013).
pub(super) const LEVEL: f64 = 0.5;

/// Winding numbers at the centres of the cells of a lattice around a surface.
pub(super) struct Sampled<'a> {
    field: &'a WindingField,
    pub(super) grid: Grid,
    pub(super) winding: Vec<f64>,
}

/// The lattice for a surface with these bounds: as fine as the number of cells allows.
pub(super) fn lattice(bounds: &Bounds, most_cells: usize) -> Grid {
    let size = bounds.size();
    let cells = |h: f64| size.map(|s| (s / h).ceil() + 1.0 + 2.0 * MARGIN as f64);
    let mut spacing = size.max() / MOST_ALONG;
    while cells(spacing).product() > most_cells as f64 {
        spacing *= 1.02;
    }
    let count = cells(spacing);
    let middle = 0.5 * (bounds.min + bounds.max);
    Grid { origin: middle - 0.5 * spacing * count, spacing, cells: [0, 1, 2].map(|i| count[i] as usize) }
}

/// Cells that can be afforded, by the effort of a few points.
pub(super) fn affordable_cells(field: &WindingField, bounds: &Bounds) -> usize {
    let probe = lattice(bounds, 1_000);
    let each = (probe.len() / 100).max(1);
    let efforts: Vec<usize> = (0..probe.len())
        .step_by(each)
        .map(|q| field.at_with_effort(&probe.centre(place(&probe, q))).1)
        .collect();
    let mean = efforts.iter().sum::<usize>() / efforts.len().max(1);
    (EFFORT / mean.max(1)).clamp(LEAST_CELLS, MOST_CELLS)
}

fn place(grid: &Grid, index: usize) -> [usize; 3] {
    let [nx, ny, _] = grid.cells;
    [index % nx, index / nx % ny, index / (nx * ny)]
}

impl<'a> Sampled<'a> {
    pub(super) fn new(field: &'a WindingField, grid: Grid) -> Self {
        let at = |q: usize| {
            let c = place(&grid, q);
            // What reaches the edge of the lattice is cut off there.
            let edge = (0..3).any(|i| c[i] == 0 || c[i] + 1 == grid.cells[i]);
            if edge { 0.0 } else { field.at(&grid.centre(c)) }
        };
        let winding = (0..grid.len()).into_par_iter().map(at).collect();
        Self { field, grid, winding }
    }

    /// Volume where the winding number is above `level`, by the number of cells.
    pub(super) fn volume_above(&self, level: f64) -> f64 {
        self.winding.iter().filter(|w| **w > level).count() as f64 * self.grid.spacing.powi(3)
    }

    /// The closed surface of the level one half. Sheets are met where they are, not where the lattice would see them: between
    /// two cells the place is found by halving.
    pub(super) fn surface(&self) -> TriangleMesh {
        let phi: Vec<f64> = self.winding.iter().map(|w| if *w > LEVEL { -1.0 } else { 1.0 }).collect();
        let mut mesh = zero_level_set(&self.grid, &phi);
        let (first, spacing) = (self.grid.centre([0; 3]), self.grid.spacing);
        mesh.vertices.par_iter_mut().for_each(|v| {
            // Between neighbours of -1 and 1 the vertex lies half-way on one axis.
            let at = (*v - first) / spacing;
            let axis = at.map(|c| (c - c.round()).abs()).imax();
            let mut cell = [0, 1, 2].map(|i| at[i].round() as usize);
            cell[axis] = at[axis].floor() as usize;
            let low_is_inside = self.winding[self.grid.index(cell)] > LEVEL;
            let (mut low, mut high) = (0.0, 1.0);
            let mut x = self.grid.centre(cell);
            let from = x[axis];
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                x[axis] = from + middle * spacing;
                if (self.field.at(&x) > LEVEL) == low_is_inside {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            x[axis] = from + 0.5 * (low + high) * spacing;
            *v = x;
        });
        mesh
    }
}
