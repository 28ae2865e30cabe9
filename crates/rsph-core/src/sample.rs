//! A shape becomes particles: one for every lattice cell that lies inside, with the inside
//! fraction of its cell as volume.

mod lattice;
mod occupy;
mod search;
mod zero_surface;

use crate::error::InvalidInput;
use crate::shape::Shape;
use crate::tensor::Vec3;

/// A regular grid of cubic cells, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Lower corner of cell (0, 0, 0).
    pub origin: Vec3,
    /// Edge length dx of a cell.
    pub spacing: f64,
    /// Number of cells along x, y, z.
    pub cells: [usize; 3],
}

impl Grid {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.cells.iter().product()
    }

    /// Whether there is no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Centre of the cell with integer coordinates `c`.
    pub fn centre(&self, c: [usize; 3]) -> Vec3 {
        self.origin + Vec3::new(c[0] as f64 + 0.5, c[1] as f64 + 0.5, c[2] as f64 + 0.5) * self.spacing
    }

    /// Index of the cell with integer coordinates `c`, x fastest.
    pub fn index(&self, c: [usize; 3]) -> usize {
        (c[2] * self.cells[1] + c[1]) * self.cells[0] + c[0]
    }
}

/// How fine the lattice is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// The spacing dx.
    Spacing(f64),
    /// The spacing at which the body has (about) that many particles.
    Particles(usize),
}

/// A sampled body.
#[derive(Clone, Debug)]
pub struct Body {
    /// The lattice, just large enough for the body.
    pub grid: Grid,
    /// Integer cell coordinates of each particle, x fastest order.
    pub cells: Vec<[usize; 3]>,
    /// Inside fraction theta of each particle's cell, >= `MIN_FRACTION`.
    pub fraction: Vec<f64>,
    /// Signed distance at each particle.
    pub level_set: Vec<f64>,
    /// The body's surface as the zero of its level set on the lattice (marching cubes), in the
    /// undeformed state.
    pub surface: crate::mesh::TriangleMesh,
    /// Volume of the cells that were dropped because they do not hang together with the largest
    /// piece.
    pub dropped_volume: f64,
}

impl Body {
    /// Volume of the particles: the sum of theta dx^3. No correction is applied for the slivers
    /// below [`MIN_FRACTION`]; they are less than 1 % of an organ at 1,000 particles.
    pub fn volume(&self) -> f64 {
        self.fraction.iter().sum::<f64>() * self.grid.spacing.powi(3)
    }
}

/// Cells with a smaller inside fraction hold no particle.
pub const MIN_FRACTION: f64 = 0.1;

/// Where the lattice planes lie relative to a shape along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// Axis 0, 1, 2.
    pub axis: usize,
    /// A coordinate on that axis.
    pub at: f64,
    /// The offset, in spacings above `at`, of a plane of cell centres.
    pub offset: f64,
}

/// Samples `shape` on a lattice. Boxes are aligned with their faces, other shapes centred on their
/// bounding box, unless `alignment` says otherwise for an axis.
///
/// # Errors
/// `body.spacing` when it is not positive, gives no particle, or more cells than memory holds;
/// `body.particles` when it is 0 or more than memory holds.
pub fn sample(
    shape: &dyn Shape,
    resolution: Resolution,
    alignment: &[Alignment],
) -> Result<Body, InvalidInput> {
    let occupied = match resolution {
        Resolution::Spacing(spacing) => lattice::with_spacing(shape, spacing, alignment)?,
        Resolution::Particles(count) => search::with_count(shape, count, alignment)?,
    };
    let zero = zero_surface::zero_surface(shape, &occupied);
    Ok(Body {
        grid: occupied.grid,
        cells: occupied.cells,
        fraction: occupied.fraction,
        level_set: zero.level_set,
        surface: zero.surface,
        dropped_volume: occupied.dropped_volume,
    })
}
