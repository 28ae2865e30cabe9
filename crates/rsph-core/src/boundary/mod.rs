//! Boundaries and loads. One a file.

pub mod body_force;
pub mod constraints;
pub mod fixed;
pub mod flat_face;
pub mod fold;
pub mod follower;
pub mod force_sums;
pub mod foundation;
pub mod lift;
pub mod load;
pub mod nodal_load;
pub mod patch;
pub mod reaction;
pub mod surface_load;
pub mod surface_quadrature;
pub mod tag;
pub mod traction_free;
