//! Matrix-free operators.

use crate::dynamics::elastic::Elastic;

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

/// m M + c K of a body: M the masses, K the tangent of its internal forces (constant for a linear
/// material). m = 0, c = 1 is the static stiffness; m = 1, c = gamma dt (gamma dt + T) an implicit stage.
#[derive(Debug)]
pub struct Shifted<'a> {
    /// The body.
    pub elastic: &'a mut Elastic,
    /// m.
    pub mass: f64,
    /// c.
    pub stiffness: f64,
}

impl Operator for Shifted<'_> {
    fn len(&self) -> usize {
        3 * self.elastic.len()
    }

    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        self.elastic.apply(self.mass, self.stiffness, x, y);
    }
}
