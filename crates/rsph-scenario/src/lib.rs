//! Scenario files, the run loop and what surrounds a simulation.
#![forbid(unsafe_code)]

pub mod label_map;
mod lower;
pub mod mesh_io;
pub mod output;
pub mod run;
pub mod scenario;
mod shape_of;
pub mod sink;
mod whole_file;

pub use lower::{Cadence, Job};
