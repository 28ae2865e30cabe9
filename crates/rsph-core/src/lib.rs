//! The numerics of rsph: remeshed Smoothed Particle Hydrodynamics of viscoelastic organs, after
//! Hieber, Walther and Koumoutsakos.
#![allow(clippy::inline_always)]

pub mod error;
pub mod marching_cubes;
pub mod material;
pub mod mesh;
pub mod particles;
pub mod region;
pub mod sample;
pub mod setup;
pub mod shape;
pub mod simulation;
pub mod snapshot;
pub mod surface;
pub mod tensor;
