//! A run's folder.

pub mod polydata;
pub mod vtkhdf;
