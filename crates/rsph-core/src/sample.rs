//! A shape becomes particles: one for every lattice cell that lies inside, with the inside
//! fraction of its cell as volume.

mod lattice;
mod occupy;
mod search;
mod zero_surface;

use crate::error::InvalidInput;
use crate::grid::Grid;
use crate::shape::{Shape, check};

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
    /// 3, or 2 for a plane body with a single layer of cells around z = 0.
    pub dimension: usize,
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
    /// Volume of the particles: the sum of theta dx^3 (dx^2, at thickness one, in the plane). No correction is applied for the slivers
    /// below [`MIN_FRACTION`]; they are less than 1 % of an organ at 1,000 particles.
    pub fn volume(&self) -> f64 {
        self.fraction.iter().sum::<f64>() * self.grid.spacing.powi(self.dimension as i32)
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
/// `body.shape` when it is too small, too large or too far away to be computed with;
/// `body.spacing` when it is not positive, gives no particle, or more cells than memory holds;
/// `body.particles` when it is 0 or more than memory holds.
pub fn sample(
    shape: &dyn Shape,
    resolution: Resolution,
    alignment: &[Alignment],
) -> Result<Body, InvalidInput> {
    check::extent("body.shape", &shape.bounds(), shape.dimension())?;
    let occupied = match resolution {
        Resolution::Spacing(spacing) => lattice::with_spacing(shape, spacing, alignment)?,
        Resolution::Particles(count) => search::with_count(shape, count, alignment)?,
    };
    if shape.dimension() == 2 {
        let distance = |c: &[usize; 3]| shape.signed_distance(&occupied.grid.centre(*c));
        return Ok(Body {
            dimension: 2,
            level_set: occupied.cells.iter().map(distance).collect(),
            surface: shape.surface().clone(),
            grid: occupied.grid,
            cells: occupied.cells,
            fraction: occupied.fraction,
            dropped_volume: occupied.dropped_volume,
        });
    }
    let zero = zero_surface::zero_surface(shape, &occupied);
    Ok(Body {
        dimension: 3,
        grid: occupied.grid,
        cells: occupied.cells,
        fraction: occupied.fraction,
        level_set: zero.level_set,
        surface: zero.surface,
        dropped_volume: occupied.dropped_volume,
    })
}
