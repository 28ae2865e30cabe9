//! The sparse lattice of the last remesh: the home of every kernel sum.
//!
//! Between remeshings the particles keep their place on a regular lattice, so that the neighbours of
//! a particle are constant index offsets and the kernel gradient is one constant vector an offset:
//! no neighbour list. Fields are spread over a padded box, row after row along x; only rows that
//! hold particles are visited, and whatever lies beside a particle reads as zero.

use crate::grid::Grid;
use crate::kernel::QuarticSpline;
use crate::tensor::Vec3;

/// Values that a sweep reads and writes at once; rows are padded to a multiple of it.
pub const LANES: usize = 8;
/// Marks a cell without a particle.
pub const NO_PARTICLE: u32 = u32::MAX;

/// The offsets of one neighbouring row: all neighbours with the same (dy, dz).
#[derive(Clone, Debug)]
pub struct RowOffset {
    /// Rows between the particle's row and this one.
    pub rows: isize,
    /// y component of X = x_b - x_a.
    pub y: f64,
    /// z component of X.
    pub z: f64,
    /// Largest |dx| in cells.
    pub reach: usize,
    /// w(r) = -W'(r)/r for dx = -reach ..= reach.
    pub weight: Vec<f64>,
    /// w(r) times the x component of X.
    pub weight_x: Vec<f64>,
}

/// The occupied stretch of a row of the padded box; empty where the row holds no particle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Span {
    /// First occupied cell along x (padded).
    pub start: usize,
    /// One past the last occupied cell.
    pub end: usize,
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
    /// Cells of a row, padding included.
    pub stride: usize,
    /// Occupied stretch of every row of the padded box.
    pub spans: Vec<Span>,
    /// Stencil by rows.
    pub offsets: Vec<RowOffset>,
    /// Particle of every cell of the padded box, or [`NO_PARTICLE`].
    pub particle_at: Vec<u32>,
    /// Cell of the padded box of every particle.
    pub cell_of: Vec<usize>,
    /// Row of the padded box of every particle.
    pub row_of: Vec<u32>,
    /// Neighbours X = x_b - x_a with w > 0.
    pub neighbours: Vec<Vec3>,
    /// Isotropic second moment sum_b dx^3 w X_x^2 of a full neighbourhood.
    pub full_moment: f64,
    pad: [usize; 3],
    rows_y: usize,
}

impl Lattice {
    /// The lattice of `grid` with particles in `cells` (x fastest order) and h = `smoothing` dx.
    pub fn new(grid: &Grid, cells: &[[usize; 3]], smoothing: f64) -> Self {
        let dx = grid.spacing;
        let h = smoothing * dx;
        let kernel = QuarticSpline::<3>::new(h);
        // Neighbours at the very edge of the support have weight zero.
        let reach = (kernel.support() / dx * (1.0 - 1e-9)).floor() as isize;
        let within = |d: [isize; 3]| {
            let r2: isize = d.iter().map(|c| c * c).sum();
            let r = (r2 as f64).sqrt() * dx;
            (r2 > 0 && r < kernel.support() * (1.0 - 1e-9)).then_some(r)
        };
        let r = reach as usize;
        let pad = [r.next_multiple_of(LANES), r, r];
        let stride = (grid.cells[0] + LANES).next_multiple_of(LANES) + 2 * pad[0];
        let rows_y = grid.cells[1] + 2 * r;
        let row_count = rows_y * (grid.cells[2] + 2 * r);

        let (mut offsets, mut neighbours, mut full_moment) = (Vec::new(), Vec::new(), 0.0);
        for dz in -reach..=reach {
            for dy in -reach..=reach {
                let Some(m) = (0..=reach)
                    .rev()
                    .find(|&d| within([d, dy, dz]).is_some() || (d == 0 && dy == 0 && dz == 0))
                else {
                    continue;
                };
                let taps: Vec<f64> = (-m..=m)
                    .map(|d| within([d, dy, dz]).map_or(0.0, |r| kernel.gradient_weight(r)))
                    .collect();
                for (d, w) in (-m..=m).zip(&taps) {
                    if *w > 0.0 {
                        neighbours.push(Vec3::new(d as f64, dy as f64, dz as f64) * dx);
                        full_moment += dx.powi(3) * w * (d as f64 * dx).powi(2);
                    }
                }
                offsets.push(RowOffset {
                    rows: dz * rows_y as isize + dy,
                    y: dy as f64 * dx,
                    z: dz as f64 * dx,
                    reach: m as usize,
                    weight_x: (-m..=m).zip(&taps).map(|(d, w)| w * d as f64 * dx).collect(),
                    weight: taps,
                });
            }
        }

        let mut particle_at = vec![NO_PARTICLE; stride * row_count];
        let (mut cell_of, mut row_of) = (Vec::with_capacity(cells.len()), Vec::with_capacity(cells.len()));
        let mut spans = vec![Span::default(); row_count];
        for (a, c) in cells.iter().enumerate() {
            let row = (c[2] + pad[2]) * rows_y + c[1] + pad[1];
            let x = c[0] + pad[0];
            let cell = row * stride + x;
            particle_at[cell] = a as u32;
            cell_of.push(cell);
            row_of.push(row as u32);
            let span = &mut spans[row];
            if span.end == 0 {
                span.start = x;
            }
            span.end = x + 1;
        }
        Self {
            origin: grid.origin,
            spacing: dx,
            smoothing_length: h,
            stride,
            spans,
            offsets,
            particle_at,
            cell_of,
            row_of,
            neighbours,
            full_moment,
            pad,
            rows_y,
        }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.cell_of.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.cell_of.is_empty()
    }

    /// Number of cells of the padded box.
    pub fn box_len(&self) -> usize {
        self.stride * self.spans.len()
    }

    /// The particle in the cell with (unpadded) coordinates `c`, which may lie outside of the grid.
    pub fn particle(&self, c: [isize; 3]) -> Option<usize> {
        let p: [isize; 3] = std::array::from_fn(|i| c[i] + self.pad[i] as isize);
        let rows_z = self.spans.len() / self.rows_y;
        let limit = [self.stride, self.rows_y, rows_z];
        if (0..3).any(|i| p[i] < 0 || p[i] >= limit[i] as isize) {
            return None;
        }
        let cell = (p[2] as usize * self.rows_y + p[1] as usize) * self.stride + p[0] as usize;
        Some(self.particle_at[cell]).filter(|&a| a != NO_PARTICLE).map(|a| a as usize)
    }

    /// (Unpadded) coordinates of the cell of a particle.
    pub fn coordinates(&self, a: usize) -> [usize; 3] {
        let (row, x) = self.row_and_x(a);
        [x - self.pad[0], row % self.rows_y - self.pad[1], row / self.rows_y - self.pad[2]]
    }

    /// Undeformed position of a particle: the centre of its cell.
    pub fn position(&self, a: usize) -> Vec3 {
        let cell = self.coordinates(a);
        self.origin + Vec3::from_fn(|i, _| (cell[i] as f64 + 0.5) * self.spacing)
    }

    /// Row and place within the row of a particle.
    #[inline(always)]
    pub fn row_and_x(&self, a: usize) -> (usize, usize) {
        let row = self.row_of[a] as usize;
        (row, self.cell_of[a] - row * self.stride)
    }
}
