//! Remeshing a body in the plane by inverting its map: for every new node p the place xi on the old
//! lattice from which the motion x(xi) leads to p, and there the reference position and the velocity.
//!
//! Interpolation by Eq. (17) from the deformed places would not do: the weights of a strongly stretched set
//! of particles do not sum to one. On the old lattice, where particles are regular, they do.

mod fraction;
mod map_grid;

pub use fraction::inside_fraction;
pub use map_grid::{MapGrid, MapValues};

use crate::neighbors::CellList;
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;

/// Newton steps; after so many whole ones, half ones.
const NEWTON_STEPS: usize = 20;
const WHOLE_STEPS: usize = 8;
/// A residual below this share of the spacing is corrected linearly, a larger one is no solution.
const LARGEST_RESIDUAL: f64 = 0.1;
/// A solution must lie within so many spacings of an old particle.
const FARTHEST: f64 = 1.6;
/// New nodes are sought within so many spacings of a deformed particle.
const REACH: f64 = 3.3;

/// A lattice whose nodes lie at `origin + (i + 1/2) spacing`, with a spacing for each axis. In the plane z
/// is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisLattice {
    /// Lower corner of cell 0.
    pub origin: Vec3,
    /// Spacings.
    pub spacing: Vec3,
}

impl AxisLattice {
    /// Position of a node.
    pub fn position<const D: usize>(&self, node: [i64; 3]) -> Vec3 {
        let at = |i: usize| self.origin[i] + (node[i] as f64 + 0.5) * self.spacing[i];
        Vec3::from_fn(|i, _| if i < D { at(i) } else { 0.0 })
    }

    /// Coordinates of a place in spacings, whole numbers at nodes.
    pub fn coordinates<const D: usize>(&self, x: &Vec3) -> Vec3 {
        let at = |i: usize| (x[i] - self.origin[i]) / self.spacing[i] - 0.5;
        Vec3::from_fn(|i, _| if i < D { at(i) } else { 0.0 })
    }

    /// Volume (area) of a cell.
    pub fn cell_volume<const D: usize>(&self) -> f64 {
        (0..D).map(|i| self.spacing[i]).product()
    }
}

/// A new node, and what has moved there.
#[derive(Clone, Copy, Debug)]
pub struct Landed {
    /// Its place p.
    pub position: Vec3,
    /// The old particle that is nearest to p.
    pub nearest: usize,
    /// Reference position X.
    pub reference: Vec3,
    /// dX/dx; the identity out of the plane.
    pub gradient: Mat3,
    /// Velocity.
    pub velocity: Vec3,
}

/// The old state at the nodes of the old lattice.
#[derive(Clone, Copy, Debug)]
pub struct OldMap<'a> {
    /// Nodes xi, particles first, mirror ghosts behind them.
    pub nodes: &'a [Vec3],
    /// Where they are now.
    pub x: &'a [Vec3],
    /// Their reference positions.
    pub reference: &'a [Vec3],
    /// Their velocities.
    pub velocity: &'a [Vec3],
    /// Number of particles.
    pub len: usize,
}

/// What has moved to the nodes of the lattice `new`, by z, y, x, for those that the body may reach.
/// `admit(p)` says which places count.
pub fn invert<const D: usize>(
    old: &OldMap<'_>,
    old_lattice: &AxisLattice,
    new: &AxisLattice,
    admit: &(dyn Fn(&Vec3) -> bool + Sync),
) -> Vec<Landed> {
    let grid = MapGrid::<D>::new(old, old_lattice);
    let dx = (0..D).map(|i| new.spacing[i].max(old_lattice.spacing[i])).fold(0.0, f64::max);
    let deformed = CellList::new(&old.x[..old.len], dx);
    let known = CellList::new(old.nodes, dx);
    let (low, high) = bounds(&old.x[..old.len]);
    let margin = Vec3::repeat(REACH * dx);
    let first = new.coordinates::<D>(&(low - margin)).map(f64::floor);
    let last = new.coordinates::<D>(&(high + margin)).map(f64::ceil);
    let count: [usize; 3] = std::array::from_fn(|i| (last[i] - first[i]) as usize + 1);
    (0..count.iter().product())
        .into_par_iter()
        .filter_map(|q: usize| {
            let offset = [q % count[0], q / count[0] % count[1], q / count[0] / count[1]];
            let p = new.position::<D>(std::array::from_fn(|i| first[i] as i64 + offset[i] as i64));
            if !admit(&p) {
                return None;
            }
            let (nearest, _) = deformed.nearest(&old.x[..old.len], &p, REACH * dx)?;
            let (xi, values) = solve(&grid, &p, old.nodes[nearest], dx)?;
            known.nearest(old.nodes, &xi, FARTHEST * dx)?;
            Some(Landed {
                position: p,
                nearest,
                reference: values.reference(),
                gradient: reference_gradient::<D>(&grid, &xi)?,
                velocity: values.velocity(),
            })
        })
        .collect()
}

/// Newton's method for x(xi) = p from `start`: xi, and the values there, corrected for what is left of the
/// residual.
fn solve<const D: usize>(grid: &MapGrid<D>, p: &Vec3, start: Vec3, dx: f64) -> Option<(Vec3, MapValues)> {
    let mut xi = start;
    let mut best: Option<(f64, Vec3)> = None;
    for k in 0..NEWTON_STEPS {
        let Some((values, slopes)) = grid.interpolate(&xi) else { break };
        let residual = p - values.x();
        let size = residual.norm();
        if best.is_none_or(|(b, _)| size < b) {
            best = Some((size, xi));
        }
        if size < 1e-14 * dx {
            break;
        }
        let jacobian = motion_gradient::<D>(&slopes);
        let inverse = jacobian.try_inverse().filter(|_| jacobian.determinant().abs() > 1e-3);
        let step = inverse.unwrap_or_else(Mat3::identity) * residual;
        // At most a spacing at once.
        let step = step * (dx / step.norm().max(dx));
        xi += if k < WHOLE_STEPS { step } else { 0.5 * step };
    }
    let (size, xi) = best?;
    if size >= LARGEST_RESIDUAL * dx {
        return None;
    }
    let (values, slopes) = grid.interpolate(&xi)?;
    let rest = motion_gradient::<D>(&slopes).try_inverse()? * (p - values.x());
    let corrected = (0..D).fold(values.0, |v, j| v + slopes[j].0 * rest[j]);
    Some((xi, MapValues(corrected)))
}

/// dx/dxi from the slopes along the axes; the identity out of the plane.
fn motion_gradient<const D: usize>(slopes: &[MapValues; 3]) -> Mat3 {
    let mut g = Mat3::identity();
    for j in 0..D {
        g.set_column(j, &slopes[j].x());
    }
    g
}

/// dX/dx = (dX/dxi) (dx/dxi)^-1.
fn reference_gradient<const D: usize>(grid: &MapGrid<D>, xi: &Vec3) -> Option<Mat3> {
    let (_, slopes) = grid.interpolate(xi)?;
    let mut g = Mat3::identity();
    for j in 0..D {
        g.set_column(j, &slopes[j].reference());
    }
    Some(g * motion_gradient::<D>(&slopes).try_inverse()?)
}

/// Corners of the box around some points.
fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    let low = points.iter().fold(Vec3::repeat(f64::INFINITY), |m, x| m.inf(x));
    let high = points.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |m, x| m.sup(x));
    (low, high)
}
