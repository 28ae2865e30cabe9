//! Particles that pass each other: the end of a description by particles on a line.

use super::FluidStructure;
use crate::particles::{Field, Particles};

/// Two neighbours that have changed places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Number of the left one.
    pub particle: usize,
    /// Its position.
    pub position: f64,
    /// Distance to its right neighbour: not positive, or not a number.
    pub gap: f64,
}

impl FluidStructure {
    /// The first two neighbours that are not in order, the solid's included (a solid turned inside out).
    pub fn crossing(&self, particles: &Particles) -> Option<Crossing> {
        let x0 = particles.column(Field::Reference).component(0);
        let d = particles.column(Field::Displacement).component(0);
        let x = |i: usize| x0[i] + d[i];
        let gap = |i: usize| x(i + 1) - x(i);
        let crossed = |i: &usize| gap(*i).partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater);
        let i = (0..particles.len() - 1).find(crossed)?;
        Some(Crossing { particle: i, position: x(i), gap: gap(i) })
    }
}
