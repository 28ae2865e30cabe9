//! Remeshing: particles are replaced by those of a regular lattice, with their conserved quantities
//! interpolated by a kernel that conserves moments, section 3 of the paper.
//!
//! [`scatter`] and [`gather`] know nothing but values. [`Remesher`] applies scatter to the column table: for
//! clouds of particles that fill space. [`Carried`] inverts the map of particles that started on a lattice and
//! gathers: for bodies with a free surface.

mod columns;
mod fold;
mod follow;
mod gather;
mod nodes;
mod scatter;

pub use columns::{NewVolume, RemeshReport, Remeshed, Remesher};
pub use fold::{Folded, fold};
pub use follow::{Arrived, Carried};
pub use gather::gather;
pub use nodes::{NodeLattice, NodeValues, Row};
pub use scatter::scatter;

use crate::tensor::Vec3;

/// Most nodes of a row.
const LONGEST_ROW: i64 = 1 << 22;

/// Why particles can not be remeshed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RemeshError {
    /// A particle is nowhere.
    #[error(
        "particle {particle} is at ({}, {}, {}), where no lattice reaches",
        position.x, position.y, position.z
    )]
    Lost {
        /// Its number.
        particle: usize,
        /// Where it is.
        position: Vec3,
    },
    /// Particles of one row have flown too far apart.
    #[error(
        "the particles have flown {0} spacings apart; a row of the lattice has at most {LONGEST_ROW} nodes"
    )]
    TooFar(i64),
    /// A column is to be conserved under a weight that the particles do not carry.
    #[error("column `{column}` is conserved times {weight}, which the particles do not carry")]
    NoWeight {
        /// The column.
        column: &'static str,
        /// `mass` or `volume`.
        weight: &'static str,
    },
}

/// Length of a row from `first` up to but without `end`.
fn row_length(first: i64, end: i64) -> Result<usize, RemeshError> {
    let len = end - first;
    if len > LONGEST_ROW { Err(RemeshError::TooFar(len)) } else { Ok(len as usize) }
}
