//! What a boundary carries: the force and the moment by which it holds the body.

use crate::tensor::Vec3;

/// Force and moment of a boundary on the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reaction {
    /// Force (N).
    pub force: Vec3,
    /// Moment (N m) about `about`.
    pub moment: Vec3,
    /// The point that the moment is about (m).
    pub about: Vec3,
}

impl Reaction {
    /// No force and no moment about that point.
    pub fn about(point: Vec3) -> Self {
        Self { force: Vec3::zeros(), moment: Vec3::zeros(), about: point }
    }

    /// Adds a force at a place.
    pub fn add(&mut self, place: &Vec3, force: &Vec3) {
        self.force += force;
        self.moment += (place - self.about).cross(force);
    }

    /// Its moment about another point.
    pub fn moment_about(&self, point: &Vec3) -> Vec3 {
        self.moment + (self.about - point).cross(&self.force)
    }
}

/// Where the particles of a body were, and where forces on them act: under a law for small strain in the undeformed body, in which
/// such a law balances moments, under any other where the body is now.
#[derive(Clone, Copy, Debug)]
pub struct Arms<'a> {
    /// Places in the undeformed body, component by component.
    pub reference: &'a [f64],
    /// Displacement, component by component; `None`: forces act in the undeformed body.
    pub displacement: Option<&'a [f64]>,
}

impl Arms<'_> {
    /// Where particle `a` was in the undeformed body.
    pub fn reference(&self, a: usize) -> Vec3 {
        vector(self.reference, a)
    }

    /// By how much the arm of particle `a` has moved.
    pub fn moved(&self, a: usize) -> Vec3 {
        self.displacement.map_or_else(Vec3::zeros, |u| vector(u, a))
    }

    /// Where a force on particle `a` acts.
    pub fn place(&self, a: usize) -> Vec3 {
        self.reference(a) + self.moved(a)
    }
}

/// The vector of particle `a` in a field that is stored component by component.
fn vector(field: &[f64], a: usize) -> Vec3 {
    let n = field.len() / 3;
    Vec3::from_fn(|i, _| field[i * n + a])
}
