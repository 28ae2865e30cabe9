//! A rectangle in the plane: a plane body.

use super::slab::slab;
use super::{Shape, check};
use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;

/// Pieces of each edge in the surface.
const PIECES: usize = 24;

/// An axis-aligned rectangle in the plane z = 0, of thickness one.
#[derive(Clone, Debug)]
pub struct RectangleShape {
    bounds: Bounds,
    surface: TriangleMesh,
}

impl RectangleShape {
    /// A rectangle of these edge lengths whose lower corner is `corner`.
    ///
    /// # Errors
    /// `body.shape.rectangle.size[i]` when a length is not positive and finite,
    /// `body.shape.rectangle.corner[i]` when a coordinate is not finite.
    pub fn new(size: [f64; 2], corner: [f64; 2]) -> Result<Self, InvalidInput> {
        let (size, corner) = (Vec3::new(size[0], size[1], 1.0), Vec3::new(corner[0], corner[1], -0.5));
        check::positive_vector("body.shape.rectangle.size", &size)?;
        check::finite("body.shape.rectangle.corner", &corner)?;
        let bounds = Bounds { min: corner, max: corner + size };
        let at = |x: f64, y: f64| Vec3::new(corner.x + x * size.x, corner.y + y * size.y, 0.0);
        let along = |k: usize| k as f64 / PIECES as f64;
        let outline: Vec<Vec3> = (0..4 * PIECES)
            .map(|q| (q / PIECES, along(q % PIECES)))
            .map(|(edge, s)| match edge {
                0 => at(s, 0.0),
                1 => at(1.0, s),
                2 => at(1.0 - s, 1.0),
                _ => at(0.0, 1.0 - s),
            })
            .collect();
        Ok(Self { surface: slab(&at(0.5, 0.5), &outline), bounds })
    }
}

impl Shape for RectangleShape {
    fn name(&self) -> String {
        "rectangle".into()
    }

    fn dimension(&self) -> usize {
        2
    }

    fn signed_distance(&self, x: &Vec3) -> f64 {
        let beyond = (self.bounds.min - x).sup(&(x - self.bounds.max)).xy();
        beyond.sup(&nalgebra::Vector2::zeros()).norm() + beyond.max().min(0.0)
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn volume(&self) -> f64 {
        self.bounds.size().product()
    }

    fn surface(&self) -> &TriangleMesh {
        &self.surface
    }

    fn is_box(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_slab_is_closed_and_has_the_volume() {
        let r = RectangleShape::new([2.0, 0.5], [-1.0, 3.0]).unwrap();
        assert_eq!(r.surface().genus(), Some(0));
        assert_relative_eq!(r.surface().volume(), 1.0, epsilon = 1e-12);
        assert_eq!(r.surface().bounds().unwrap(), r.bounds());
        assert_relative_eq!(r.signed_distance(&Vec3::new(0.0, 3.2, 7.0)), -0.2, epsilon = 1e-12);
        assert_relative_eq!(r.signed_distance(&Vec3::new(4.0, 7.5, 0.0)), 5.0, epsilon = 1e-12);
    }

    #[test]
    fn bad_sizes_name_their_key() {
        assert_eq!(
            RectangleShape::new([1.0, 0.0], [0.0; 2]).unwrap_err().key,
            "body.shape.rectangle.size[1]"
        );
        let e = RectangleShape::new([1.0; 2], [f64::NAN, 0.0]).unwrap_err();
        assert_eq!(e.key, "body.shape.rectangle.corner[0]");
    }
}
