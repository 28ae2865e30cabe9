//! The border between the simulation and the world: an immutable picture of one moment.

use crate::particles::{Column, ColumnSpec, Field, Particles, shown_columns};

/// One moment of a simulation. Columns are shared, not copied; nobody outside holds live state.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Simulated time.
    pub time: f64,
    /// Number of time steps taken.
    pub step: u64,
    /// Columns, derived ones included.
    pub particles: Particles,
}

impl Snapshot {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.particles.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.particles.is_empty()
    }

    /// A column by field; empty if the dynamics does not have it.
    pub fn column(&self, field: Field) -> &Column {
        self.particles.column(field)
    }

    /// Current positions x = X + u, one vector a particle.
    pub fn positions(&self) -> Vec<[f64; 3]> {
        let (x0, u) = (self.column(Field::Reference), self.column(Field::Displacement));
        (0..self.len()).map(|a| (x0.vector(a) + u.vector(a)).into()).collect()
    }

    /// The columns that are present and that results show, in table order.
    pub fn columns(&self) -> impl Iterator<Item = (&'static ColumnSpec, &Column)> {
        shown_columns().filter(|c| self.particles.has(c.field)).map(|c| (c, self.column(c.field)))
    }
}
