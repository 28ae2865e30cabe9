//! The sparse lattice of the last remesh: the home of every kernel sum.
//!
//! Between remeshings the particles keep their place on a regular lattice, so that the neighbours of
//! a particle are constant index offsets and the kernel gradient is one constant vector an offset:
//! no neighbour list. Fields that sums run over are laid out in tiles ([`crate::tiles`]).

mod weights;

use crate::grid::Grid;
use crate::tensor::Vec3;
use crate::tiles::Tiles;
pub use weights::{MAX_CUT, MAX_REACH, Weights};

/// Marks a cell without a particle.
pub const NO_PARTICLE: u32 = u32::MAX;

/// An offset with a weight.
#[derive(Clone, Copy, Debug)]
pub struct Neighbour {
    /// Cells of the padded box between the particle and this neighbour.
    pub shift: isize,
    /// X = x_b - x_a.
    pub x: Vec3,
    /// w(r) = -W'(r)/r.
    pub w: f64,
}

/// The lattice with its stencil and its particles.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Lower corner of the cell (0, 0, 0).
    pub origin: Vec3,
    /// Spacing dx.
    pub spacing: f64,
    /// Smoothing length h.
    pub smoothing_length: f64,
    /// The particles, tile by tile.
    pub tiles: Tiles,
    /// Weights of the kernel by distance.
    pub weights: Weights,
    /// Neighbours with a weight.
    pub neighbours: Vec<Neighbour>,
    /// Particle of every cell of the padded box, or [`NO_PARTICLE`].
    pub particle_at: Vec<u32>,
    /// Cell of the padded box of every particle.
    cell_of: Vec<u32>,
    /// Second moment sum_b V_b w X_x^2 of a full neighbourhood, the same along every axis that is there.
    pub full_moment: f64,
    /// 3, or 2 for a body in the plane z = 0, whose cells make up one layer.
    pub dimension: usize,
    /// Cells around the grid, at least as far as the kernel reaches.
    pad: usize,
    /// Cells of the padded box.
    size: [usize; 3],
}

impl Lattice {
    /// The lattice of `grid` with particles in `cells` (x fastest order) and h = `smoothing` dx, of a body in space
    /// (`dimension` 3) or in the plane (2), where `grid` is one layer of cells, which are of height one.
    pub fn new(grid: &Grid, cells: &[[usize; 3]], smoothing: f64, dimension: usize) -> Self {
        let dx = grid.spacing;
        let weights = Weights::new(dx, smoothing * dx, dimension);
        let pad = weights.cut.isqrt();
        let size = grid.cells.map(|n| n + 2 * pad);
        let reach = pad as isize;
        let across = if dimension == 2 { 0 } else { reach };
        let (mut neighbours, mut full_moment) = (Vec::new(), 0.0);
        for k in -across..=across {
            for j in -reach..=reach {
                for i in -reach..=reach {
                    let square = (i * i + j * j + k * k) as usize;
                    if square == 0 || square > weights.cut {
                        continue;
                    }
                    let x = Vec3::new(i as f64, j as f64, k as f64) * dx;
                    let w = weights.by_square[square];
                    full_moment += dx.powi(dimension as i32) * w * x.x.powi(2);
                    let shift = (k * size[1] as isize + j) * size[0] as isize + i;
                    neighbours.push(Neighbour { shift, x, w });
                }
            }
        }

        let mut particle_at = vec![NO_PARTICLE; size.iter().product()];
        let cell = |c: &[usize; 3]| ((c[2] + pad) * size[1] + c[1] + pad) * size[0] + c[0] + pad;
        let cell_of: Vec<u32> = cells.iter().map(|c| cell(c) as u32).collect();
        for (a, cell) in cell_of.iter().enumerate() {
            particle_at[*cell as usize] = a as u32;
        }
        Self {
            origin: grid.origin,
            spacing: dx,
            smoothing_length: smoothing * dx,
            tiles: Tiles::new(grid.cells, cells),
            weights,
            neighbours,
            particle_at,
            cell_of,
            full_moment,
            dimension,
            pad,
            size,
        }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.cell_of.len()
    }

    /// Volume of a cell, of height one in the plane.
    pub fn cell_volume(&self) -> f64 {
        self.spacing.powi(self.dimension as i32)
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.cell_of.is_empty()
    }

    /// The particle in the cell with (unpadded) coordinates `c`, which may lie outside of the grid.
    pub fn particle(&self, c: [isize; 3]) -> Option<usize> {
        let p: [isize; 3] = std::array::from_fn(|i| c[i] + self.pad as isize);
        if (0..3).any(|i| p[i] < 0 || p[i] >= self.size[i] as isize) {
            return None;
        }
        let cell = (p[2] as usize * self.size[1] + p[1] as usize) * self.size[0] + p[0] as usize;
        Some(self.particle_at[cell]).filter(|&a| a != NO_PARTICLE).map(|a| a as usize)
    }

    /// The particle at `neighbour` of particle `a`.
    #[inline(always)]
    pub fn neighbour(&self, a: usize, neighbour: &Neighbour) -> Option<usize> {
        let b = self.particle_at[(self.cell_of[a] as usize).wrapping_add_signed(neighbour.shift)];
        (b != NO_PARTICLE).then_some(b as usize)
    }

    /// (Unpadded) coordinates of the cell of a particle.
    pub fn coordinates(&self, a: usize) -> [usize; 3] {
        let cell = self.cell_of[a] as usize;
        let row = cell / self.size[0];
        [cell % self.size[0], row % self.size[1], row / self.size[1]].map(|c| c - self.pad)
    }

    /// Undeformed position of a particle: the centre of its cell.
    pub fn position(&self, a: usize) -> Vec3 {
        let cell = self.coordinates(a);
        self.origin + Vec3::from_fn(|i, _| (cell[i] as f64 + 0.5) * self.spacing)
    }
}
