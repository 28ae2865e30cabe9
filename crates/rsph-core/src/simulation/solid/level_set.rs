//! The level set of a solid after a remesh: that of the undeformed body, where a particle was (D phi / D t
//! = 0), or the distance from the surface as it is now.

use crate::grid::Grid;
use crate::level_set::restore;
use crate::remesh::NodeLattice;
use crate::shape::Shape;
use crate::tensor::Vec3;
use rayon::prelude::*;

/// Signed distance of each place in the undeformed body from its surface.
pub(super) fn carried(shape: &dyn Shape, undeformed: &[Vec3]) -> Vec<f64> {
    undeformed.par_iter().map(|x| shape.signed_distance(x)).collect()
}

/// Signed distance of `nodes` from the surface of the deformed body, whose carried level set is `phi` at the
/// nodes in and around it.
pub(super) fn restored(
    lattice: &NodeLattice<3>,
    around: &[[i64; 3]],
    phi: &[f64],
    nodes: &[[i64; 3]],
) -> Vec<f64> {
    let low: [i64; 3] = std::array::from_fn(|i| around.iter().map(|n| n[i]).min().unwrap_or(0));
    let high: [i64; 3] = std::array::from_fn(|i| around.iter().map(|n| n[i]).max().unwrap_or(0));
    let origin = lattice.origin + Vec3::from_fn(|i, _| low[i] as f64) * lattice.spacing;
    let cells = std::array::from_fn(|i| (high[i] - low[i] + 1) as usize);
    let grid = Grid { origin, spacing: lattice.spacing, cells };
    let index = |n: &[i64; 3]| grid.index(std::array::from_fn(|i| (n[i] - low[i]) as usize));
    // Far outside any positive value will do: distances follow from the surface.
    let mut values = vec![lattice.spacing; grid.len()];
    for (node, phi) in around.iter().zip(phi) {
        values[index(node)] = *phi;
    }
    restore(&grid, &mut values);
    nodes.iter().map(|n| values[index(n)]).collect()
}
