//! A run's folder.

mod atomic;
pub mod polydata;
pub mod vtkhdf;
pub mod vtp;
