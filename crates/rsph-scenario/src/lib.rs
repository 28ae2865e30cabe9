//! Scenario files, the run loop and what surrounds a simulation.

pub mod output;
pub mod sink;
