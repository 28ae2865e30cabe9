//! Scenario files, the run loop and what surrounds a simulation.

pub mod sink;
