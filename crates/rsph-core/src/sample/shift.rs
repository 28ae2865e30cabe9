//! A lattice on which gaps narrower than its cells lie between cells, as far as that can be.

use super::occupy::{Occupied, occupy};
use super::sight::Sight;
use crate::grid::Grid;
use crate::shape::Shape;
use crate::tensor::Vec3;

/// Places that are tried for the planes of the lattice within a spacing.
const PLACES: usize = 8;

/// The cells of `shape` on the lattice of `occupied`, or on that lattice moved along the normal of most of its gaps if that leaves less
/// tissue in cells of the other side.
pub(super) fn shifted(shape: &dyn Shape, occupied: Occupied, sight: Sight) -> (Occupied, Sight) {
    let (lattice, axis) = (occupied.lattice.clone(), sight.axis());
    let mut best = (occupied, sight);
    for k in 1..PLACES {
        if best.0.parted.is_empty() {
            break;
        }
        let below = Vec3::ith(axis, k as f64 / PLACES as f64 * lattice.spacing);
        let mut moved = Grid { origin: lattice.origin - below, ..lattice.clone() };
        moved.cells[axis] += 1;
        let Some(mut sight) = Sight::new(shape.surface(), &moved) else { continue };
        let occupied = occupy(shape, moved, Some(&mut sight));
        if occupied.moved() < best.0.moved() {
            best = (occupied, sight);
        }
    }
    best
}
