//! A disc in the plane: a plane body.

use super::slab::slab;
use super::{Shape, check};
use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use std::f64::consts::{PI, TAU};

/// Corners of the outline of the surface.
const CORNERS: usize = 256;

/// A disc in the plane z = 0, of thickness one.
#[derive(Clone, Debug)]
pub struct DiscShape {
    radius: f64,
    centre: Vec3,
    surface: TriangleMesh,
}

impl DiscShape {
    /// A disc of that radius around `centre`.
    ///
    /// # Errors
    /// `body.shape.disc.radius` when it is not positive and finite, `body.shape.disc.centre[i]` when a
    /// coordinate is not finite.
    pub fn new(radius: f64, centre: [f64; 2]) -> Result<Self, InvalidInput> {
        let centre = Vec3::new(centre[0], centre[1], 0.0);
        check::positive("body.shape.disc.radius", radius)?;
        check::finite("body.shape.disc.centre", &centre)?;
        let at = |k: usize| {
            let angle = TAU * k as f64 / CORNERS as f64;
            centre + radius * Vec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let outline: Vec<Vec3> = (0..CORNERS).map(at).collect();
        Ok(Self { radius, centre, surface: slab(&centre, &outline) })
    }
}

impl Shape for DiscShape {
    fn name(&self) -> String {
        "disc".into()
    }

    fn dimension(&self) -> usize {
        2
    }

    fn signed_distance(&self, x: &Vec3) -> f64 {
        (x - self.centre).xy().norm() - self.radius
    }

    fn bounds(&self) -> Bounds {
        let r = Vec3::new(self.radius, self.radius, 0.5);
        Bounds { min: self.centre - r, max: self.centre + r }
    }

    fn volume(&self) -> f64 {
        PI * self.radius.powi(2)
    }

    fn surface(&self) -> &TriangleMesh {
        &self.surface
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_slab_is_closed_and_has_the_volume() {
        let d = DiscShape::new(0.5, [1.0, 2.0]).unwrap();
        assert_eq!(d.surface().genus(), Some(0));
        assert_relative_eq!(d.surface().volume(), d.volume(), max_relative = 1e-3);
        assert_relative_eq!(d.signed_distance(&Vec3::new(1.0, 3.0, 9.0)), 0.5, epsilon = 1e-12);
    }

    #[test]
    fn bad_input_names_its_key() {
        assert_eq!(DiscShape::new(0.0, [0.0; 2]).unwrap_err().key, "body.shape.disc.radius");
        assert_eq!(DiscShape::new(1.0, [0.0, f64::NAN]).unwrap_err().key, "body.shape.disc.centre[1]");
    }
}
