//! The analytic liver.

use super::implicit::{Ellipsoid, body, difference, union};
use super::{Bounds, MeshShape};
use crate::tensor::Vec3;

/// Spacing of the grid that its surface is taken on (m).
const SPACING: f64 = 0.0025;

/// Drawn at 1, built at this scale.
const SCALE: f64 = 0.95;

/// An adult's liver: a large domed right lobe, a left lobe that tapers to the side, the sharp lower
/// edge where the front meets the visceral surface, the groove of the spine behind, the notch of
/// the round ligament in the edge and the hollow of the porta.
pub(super) fn liver() -> MeshShape {
    let right = Ellipsoid::new([-0.050, -0.008, -0.006], [0.074, 0.090, 0.079], 0.0);
    let left = Ellipsoid::new([0.044, 0.028, 0.020], [0.086, 0.040, 0.042], -10.0);
    let spine = Ellipsoid::new([0.030, -0.020, -0.075], [0.050, 0.120, 0.060], 0.0);
    let notch = Ellipsoid::new([0.022, -0.034, 0.052], [0.006, 0.042, 0.040], -15.0);
    let porta = Ellipsoid::new([-0.024, -0.030, 0.004], [0.014, 0.022, 0.030], 0.0);
    // The visceral surface looks down and back; a wide ball hollows it.
    let below = Vec3::new(0.30, -0.74, -0.60).normalize();
    let visceral_radius = 0.34;
    let visceral_centre = Vec3::new(-0.010, -0.013, 0.004) + visceral_radius * below;

    let within = Bounds { min: Vec3::new(-0.14, -0.10, -0.10), max: Vec3::new(0.14, 0.10, 0.10) };
    body("organ liver", &within, SPACING, |x| {
        let x = x / SCALE;
        let lobes = union(right.at(&x), left.at(&x), 0.055);
        let standing = difference(lobes, spine.at(&x), 0.030);
        let visceral = (x - visceral_centre).norm() - visceral_radius;
        let wedge = difference(standing, visceral, 0.008);
        let notched = difference(wedge, notch.at(&x), 0.012);
        SCALE * difference(notched, porta.at(&x), 0.016)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;

    #[test]
    fn it_has_an_adults_size_in_one_piece_without_holes() {
        let liver = liver();
        assert!(liver.surface().is_closed());
        assert_eq!((liver.surface().components(), liver.surface().genus()), (1, Some(0)));
        assert!((1.3e-3..1.7e-3).contains(&liver.volume()), "{}", liver.volume());
        let size = liver.bounds().size();
        let allowed = [(0.22, 0.26), (0.145, 0.18), (0.135, 0.17)];
        for (s, (low, high)) in size.iter().zip(allowed) {
            assert!((low..high).contains(s), "{size:?}");
        }
    }

    #[test]
    fn the_right_lobe_is_the_larger_one() {
        let liver = liver();
        let b = liver.bounds();
        let extent_at = |x: f64| {
            let inside = (0..100).filter(|i| {
                let y = b.min.y + (f64::from(*i) + 0.5) / 100.0 * b.size().y;
                (0..20).any(|j| {
                    let z = b.min.z + (f64::from(j) + 0.5) / 20.0 * b.size().z;
                    liver.signed_distance(&Vec3::new(x, y, z)) < 0.0
                })
            });
            inside.count()
        };
        let (right, left) = (extent_at(b.min.x + 0.3 * b.size().x), extent_at(b.min.x + 0.85 * b.size().x));
        assert!(right > 2 * left, "{right} {left}");
    }
}
