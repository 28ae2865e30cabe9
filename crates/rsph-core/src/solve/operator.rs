//! Matrix-free operators.

use crate::dynamics::Scales;
use crate::dynamics::solid::Solid;

/// A symmetric linear map of fields on the particles (3 n values, component by component).
pub trait Operator: Send {
    /// Number of values of a field.
    fn len(&self) -> usize;

    /// Whether it acts on nothing.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// y = A x. Held components of x count as zero, those of y are zero.
    fn apply(&mut self, x: &[f64], y: &mut [f64]);
}

/// What an approximate inverse does with a residual.
pub trait Preconditioner: Send {
    /// z, roughly A^-1 r; symmetric and positive definite as a map from r to z.
    fn apply(&mut self, operator: &mut dyn Operator, r: &[f64], z: &mut [f64]);
}

/// m M + k K + c C of a body about the state of its last linearisation.
#[derive(Debug)]
pub struct Shifted<'a> {
    /// The body.
    pub solid: &'a mut Solid,
    /// m, k and c.
    pub scales: Scales,
}

impl Operator for Shifted<'_> {
    fn len(&self) -> usize {
        3 * self.solid.len()
    }

    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        self.solid.apply(self.scales, x, y);
    }
}
