//! The numerics of rsph: remeshed Smoothed Particle Hydrodynamics of viscoelastic organs, after
//! Hieber, Walther and Koumoutsakos.
#![forbid(unsafe_code)]
#![allow(clippy::inline_always)]
// Tests compare exact values.
#![cfg_attr(test, allow(clippy::float_cmp))]

pub mod boundary;
pub mod dynamics;
pub mod error;
pub mod flow;
pub mod fluid;
pub mod grid;
pub mod integrate;
pub mod kernel;
pub mod lattice;
pub mod level_set;
pub mod marching_cubes;
pub mod material;
pub mod measures;
pub mod mesh;
pub mod mls;
pub mod moments;
pub mod neighbors;
pub mod observe;
pub mod ops;
pub mod particles;
mod pool;
pub mod reconstruct;
pub mod region;
pub mod remesh;
pub mod sample;
pub mod setup;
pub mod shape;
pub mod simulation;
pub mod snapshot;
pub mod solve;
pub mod stability;
pub mod state;
pub mod surface;
pub mod tensor;
pub mod tiles;
pub mod vector_field;
mod watchdog;
pub mod winding;
