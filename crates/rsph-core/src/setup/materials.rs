//! Which material is where in a body of several.

use crate::material::Material;
use crate::region::Region;
use crate::shape::Shape;
use crate::tensor::Vec3;
use crate::vector_field::VectorField;
use std::fmt::Debug;
use std::sync::Arc;

/// A part of space that holds a material.
pub trait Place: Debug + Send + Sync {
    /// Whether a point of the undeformed body belongs to it.
    fn contains(&self, x: &Vec3) -> bool;
}

impl Place for Region {
    fn contains(&self, x: &Vec3) -> bool {
        Region::contains(self, x, 0.0)
    }
}

/// The inside of a closed shape.
#[derive(Clone, Debug)]
pub struct Within(pub Arc<dyn Shape>);

impl Place for Within {
    fn contains(&self, x: &Vec3) -> bool {
        self.0.signed_distance(x) <= 0.0
    }
}

/// From positions in the undeformed body to as many moduli (Pa).
pub type PointwiseModulus = dyn Fn(&[Vec3]) -> Vec<f64> + Send + Sync;

/// Young's modulus at small strain (Pa) as a field over the undeformed body, to which a law is scaled.
#[derive(Clone)]
pub struct ModulusField(pub Arc<PointwiseModulus>);

impl Debug for ModulusField {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("ModulusField")
    }
}

/// A material in a part of a body.
#[derive(Clone, Debug)]
pub struct MaterialPart {
    /// Its name in results and messages.
    pub name: String,
    /// Of what.
    pub material: Arc<dyn Material>,
    /// Its modulus where that differs from place to place.
    pub modulus: Option<ModulusField>,
    /// Direction of its fibres where that differs from place to place; of any length but zero.
    pub fibres: Option<VectorField>,
    /// Where.
    pub place: Arc<dyn Place>,
}
