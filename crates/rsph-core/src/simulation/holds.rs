//! Readings of boundaries that have a name: the force and the moment that each carries, and how far it has moved.

use super::{OwnReading, Reaction, Reading, Simulation};
use crate::particles::VECTOR;
use crate::setup::Boundary;
use crate::tensor::Vec3;

/// The readings of a boundary; none without a name.
pub(super) fn readings_of(boundary: &Boundary) -> Vec<OwnReading> {
    let Some(name) = &boundary.name else { return Vec::new() };
    let of_all = [("force", "N"), ("moment", "N m")];
    let of_moved = boundary.motion.as_ref().map(|_| ("displacement", "m"));
    let vectors = of_all.into_iter().chain(of_moved);
    let components = |(quantity, unit): (&str, &'static str)| {
        VECTOR.map(|component| OwnReading {
            name: format!("{}_{quantity}_{component}", name.text),
            quantity: format!("{quantity} of {}.{component}", name.text),
            unit,
        })
    };
    vectors.flat_map(components).collect()
}

impl Simulation {
    /// Force (N) and moment (N m) of every boundary on the body at this moment, in the order of the set-up; nothing for a body without a
    /// stiffness.
    ///
    /// A moment is about the point that [`BoundaryName`](crate::setup::BoundaryName) gives, else about the centre of what is held, which goes with
    /// the boundary. Under a law for small strain it is that of forces on the undeformed body.
    pub fn reactions(&mut self) -> Vec<Reaction> {
        self.model.reactions(&self.particles, self.time)
    }

    /// Whether a reaction is read, so that equilibria are to be found more closely.
    pub(super) fn reads_reactions(&self) -> bool {
        self.setup.solid().is_some_and(|solid| solid.boundaries.iter().any(|b| b.name.is_some()))
    }

    pub(super) fn read_holds(&mut self, readings: &mut Vec<Reading>) {
        if !self.reads_reactions() {
            return;
        }
        let reactions = self.reactions();
        let boundaries = self.setup.solid().map_or(&[][..], |solid| &solid.boundaries);
        for (boundary, reaction) in boundaries.iter().zip(reactions) {
            let displacement =
                boundary.motion.as_ref().map_or_else(Vec3::zeros, |m| m.displacement(self.time));
            let values = [reaction.force, reaction.moment, displacement];
            let values = values.iter().flat_map(|vector| vector.iter().copied());
            readings.extend(
                readings_of(boundary)
                    .into_iter()
                    .zip(values)
                    .map(|(own, value)| Reading { name: own.name, value }),
            );
        }
    }
}
