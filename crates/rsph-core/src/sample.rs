//! A shape becomes particles: one for every lattice cell that lies inside, with the inside
//! fraction of its cell as volume.

mod cell_pieces;
mod inside;
mod lattice;
mod occupy;
mod pieces;
mod search;
mod shift;
mod sight;
mod zero_surface;

use crate::error::InvalidInput;
use crate::grid::Grid;
use crate::shape::{Shape, check};
use crate::tensor::Vec3;

pub use inside::InsideFraction;
pub use pieces::{LeftOut, WhyLeftOut};
pub use sight::{Gap, Sight};
use std::sync::Arc;

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
    /// Volume that each particle stands for: of its cell, of neighbouring ones too empty for a particle, and scaled where
    /// the surface cuts cells, so that their sum is the volume within the surface.
    pub volume: Vec<f64>,
    /// The piece of the shape that each belongs to, numbered by their first particles: pieces hang together by nothing.
    pub piece: Vec<u32>,
    /// What of the shape sees what, if parts of its surface face each other.
    pub sight: Option<Arc<Sight>>,
    /// Centres of the cells with so much tissue on both sides of a gap that each could be a particle: the larger is, and the other
    /// belongs to particles beside it.
    pub parted_cells: Vec<Vec3>,
    /// The surface of the shape without pieces that are left out; `None`: all of it.
    pub kept_surface: Option<crate::mesh::TriangleMesh>,
    /// Pieces that are left out.
    pub left_out: Vec<LeftOut>,
    /// Their volume.
    pub dropped_volume: f64,
}

impl Body {
    /// Volume of the particles (area, at thickness one, of a plane body).
    pub fn volume(&self) -> f64 {
        self.volume.iter().sum()
    }

    /// Whether the surface cuts the cell of each particle.
    pub fn cut(&self) -> Vec<bool> {
        self.fraction.iter().map(|f| is_cut(*f)).collect()
    }
}

/// Whether a cell that lies inside to this fraction is cut by the surface.
pub fn is_cut(fraction: f64) -> bool {
    (fraction - 1.0).abs() > 1e-6
}

/// Relative error of the volume that is rounding: whole cells stay as they are.
const ROUNDING: f64 = 1e-12;
/// Largest relative error of the volume of the cells that is made up for in cut cells alone.
const LARGEST_CORRECTION: f64 = 0.05;

/// The volume of each particle.
fn volumes(shape: &dyn Shape, occupied: &occupy::Occupied) -> Vec<f64> {
    let cell = occupied.grid.spacing.powi(shape.dimension() as i32);
    let mut volume: Vec<f64> = occupied.share.iter().map(|s| s * cell).collect();
    let sum: f64 = volume.iter().sum();
    let wanted = shape.surface().volume();
    let in_cut: f64 =
        volume.iter().zip(&occupied.fraction).filter(|(_, f)| is_cut(**f)).map(|(v, _)| v).sum();
    let missing = wanted - sum;
    if missing.abs() <= ROUNDING * sum {
        return volume;
    }
    if in_cut > 0.0 && missing.abs() <= LARGEST_CORRECTION * sum {
        let factor = 1.0 + missing / in_cut;
        volume
            .iter_mut()
            .zip(&occupied.fraction)
            .filter(|(_, f)| is_cut(**f))
            .for_each(|(v, _)| *v *= factor);
    } else if wanted > 0.0 {
        for v in &mut volume {
            *v *= wanted / sum;
        }
    }
    volume
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

/// Samples `shape` on a lattice, all its pieces but crumbs. Boxes are aligned with their faces, other shapes centred on their
/// bounding box or, where parts of their surface face each other across less than a spacing, so that these lie between cells, unless `alignment` says otherwise for an axis.
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
    let mut occupied = match resolution {
        Resolution::Spacing(spacing) => lattice::with_spacing(shape, spacing, alignment)?,
        Resolution::Particles(count) => search::with_count(shape, count, alignment)?,
    };
    let mut sight = Sight::new(shape.surface(), &occupied.lattice);
    if let Some(mut found) = sight.take() {
        occupied = occupy::occupy(shape, occupied.lattice, Some(&mut found));
        if alignment.is_empty() {
            (occupied, found) = shift::shifted(shape, occupied, found);
        }
        sight = Some(found);
    }
    let (level_set, surface) = if shape.dimension() == 2 {
        let distance = |c: &[usize; 3]| shape.signed_distance(&occupied.grid.centre(*c));
        (occupied.cells.iter().map(distance).collect(), shape.surface().clone())
    } else {
        let zero = zero_surface::zero_surface(shape, &occupied);
        (zero.level_set, zero.surface)
    };
    let kept = pieces::without_crumbs(&occupied.sizes());
    let mut body = Body {
        dimension: shape.dimension(),
        volume: volumes(shape, &occupied),
        grid: occupied.grid,
        cells: occupied.cells,
        fraction: occupied.fraction,
        level_set,
        surface,
        piece: occupied.piece,
        sight: sight.map(Arc::new),
        parted_cells: occupied.parted.iter().map(|(centre, _)| *centre).collect(),
        kept_surface: None,
        left_out: Vec::new(),
        dropped_volume: 0.0,
    };
    body.leave_out(shape, &kept, WhyLeftOut::Crumb);
    Ok(body)
}
