//! The analytic kidney.

use super::implicit::{Ellipsoid, body, difference, union};
use super::{Bounds, MeshShape};
use crate::tensor::Vec3;

/// Spacing of the grid that its surface is taken on (m).
const SPACING: f64 = 0.00125;

/// An adult's kidney: a bean of two poles, the upper one broader, bent towards the hilum, which
/// opens to +x and a little to the front.
pub(super) fn kidney() -> MeshShape {
    let upper = Ellipsoid::new([0.0035, 0.0250, -0.0010], [0.0255, 0.0305, 0.0209], -16.0);
    let lower = Ellipsoid::new([0.0035, -0.0260, 0.0007], [0.0237, 0.0295, 0.0197], 16.0);
    let middle = Ellipsoid::new([-0.0060, 0.0, 0.0], [0.0225, 0.0320, 0.0207], 0.0);
    let hilum = Ellipsoid::new([0.030, -0.0010, 0.0030], [0.0220, 0.0125, 0.0100], 0.0);

    let within = Bounds { min: Vec3::new(-0.035, -0.062, -0.028), max: Vec3::new(0.035, 0.062, 0.028) };
    body("organ kidney", &within, SPACING, |x| {
        let poles = union(upper.at(x), lower.at(x), 0.020);
        let bean = union(poles, middle.at(x), 0.014);
        difference(bean, hilum.at(x), 0.012)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;

    #[test]
    fn it_has_an_adults_size_in_one_piece_without_holes() {
        let kidney = kidney();
        assert!(kidney.surface().is_closed());
        assert_eq!((kidney.surface().components(), kidney.surface().genus()), (1, Some(0)));
        assert!((130e-6..200e-6).contains(&kidney.volume()), "{}", kidney.volume());
        let size = kidney.bounds().size();
        for (s, expected) in size.iter().zip([0.06, 0.11, 0.045]) {
            assert!((s / expected - 1.0).abs() < 0.08, "{size:?}");
        }
    }

    #[test]
    fn the_hilum_is_a_hollow_between_the_poles() {
        let kidney = kidney();
        let x = kidney.bounds().max.x - 0.006;
        assert!(kidney.signed_distance(&Vec3::new(x, 0.0, 0.0)) > 0.0);
        for y in [-0.028, 0.028] {
            assert!(kidney.signed_distance(&Vec3::new(x, y, 0.0)) < 0.0);
        }
    }
}
