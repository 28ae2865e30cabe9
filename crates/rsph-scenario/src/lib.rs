//! Scenario files, mesh readers, output writers and the run loop.

pub mod mesh_io;
