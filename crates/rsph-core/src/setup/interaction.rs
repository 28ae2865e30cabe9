//! A fluid beside a solid on a line.

use crate::fluid::FluidLaw;
use std::sync::Arc;

/// What a scenario says of a fluid beside a solid; where they lie is that of the body's box.
#[derive(Clone, Debug)]
pub struct InteractionSetting {
    /// The fluid, left of the interface.
    pub fluid: Arc<dyn FluidLaw>,
    /// Elasticity mu of the solid.
    pub elasticity: f64,
    /// Density of the solid.
    pub solid_density: f64,
    /// Where fluid and solid meet at rest.
    pub interface: f64,
}

/// A fluid from a wall at `left` to the interface, and an elastic solid from there to `right`, where it
/// is held, section 4 of the paper.
#[derive(Clone, Debug)]
pub struct Interaction {
    /// The fluid.
    pub fluid: Arc<dyn FluidLaw>,
    /// Elasticity mu of the solid: stress per strain.
    pub elasticity: f64,
    /// Density of the solid.
    pub solid_density: f64,
    /// The wall.
    pub left: f64,
    /// Where fluid and solid meet at rest.
    pub interface: f64,
    /// The held end of the solid.
    pub right: f64,
    /// Elements of the fluid and of the solid; a particle sits at each end of an element.
    pub elements: [usize; 2],
}

impl Interaction {
    /// Lengths of an element of the fluid and of the solid at rest.
    pub fn spacings(&self) -> [f64; 2] {
        let [n, m] = self.elements;
        [(self.interface - self.left) / n as f64, (self.right - self.interface) / m as f64]
    }
}
