//! The solid angle of a triangle, exactly.

use crate::tensor::Vec3;

/// Signed solid angle (sr, -2 pi to 2 pi) of the triangle with the given corners, seen from `x`; positive where its
/// back is seen, so that the triangles of a closed outward surface add up to 4 pi inside. Van Oosterom and Strackee,
/// The solid angle of a plane triangle, IEEE Trans. Biomed. Eng. 30 (1983). Zero in the plane of the triangle.
#[inline]
pub fn solid_angle(corners: &[Vec3; 3], x: &Vec3) -> f64 {
    let [a, b, c] = corners.map(|v| v - x);
    let [la, lb, lc] = [a.norm(), b.norm(), c.norm()];
    let volume = a.dot(&b.cross(&c));
    let cosine = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    // Within the triangle itself both sides are equally near.
    if volume == 0.0 { 0.0 } else { 2.0 * volume.atan2(cosine) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    #[test]
    fn an_eighth_of_the_sphere_and_a_face_of_a_cube() {
        let corner = [Vec3::x(), Vec3::y(), Vec3::z()];
        assert_relative_eq!(solid_angle(&corner, &Vec3::zeros()), 4.0 * PI / 8.0, epsilon = 1e-14);
        let [a, b, c] = corner;
        assert_relative_eq!(solid_angle(&[a, c, b], &Vec3::zeros()), -4.0 * PI / 8.0, epsilon = 1e-14);
        let square = [[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]].map(Vec3::from);
        let face = solid_angle(&[square[0], square[1], square[2]], &Vec3::zeros())
            + solid_angle(&[square[0], square[2], square[3]], &Vec3::zeros());
        assert_relative_eq!(face, 4.0 * PI / 6.0, epsilon = 1e-14);
    }

    #[test]
    fn nothing_is_seen_of_a_triangle_from_its_own_plane() {
        let t = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        for x in [[0.2, 0.2, 0.0], [0.0, 0.0, 0.0], [5.0, -3.0, 0.0], [0.5, 0.0, 0.0]] {
            assert_eq!(solid_angle(&t, &Vec3::from(x)), 0.0);
        }
    }

    proptest! {
        /// Cutting a triangle in three changes nothing, and just before and behind it half a turn is seen.
        #[test]
        fn parts_add_up(v in prop::array::uniform9(-1.0..1.0_f64), at in prop::array::uniform3(-2.0..2.0_f64)) {
            let t = [0, 1, 2].map(|i| Vec3::new(v[3 * i], v[3 * i + 1], v[3 * i + 2]));
            let [a, b, c] = t;
            let (m, x) = ((a + b + c) / 3.0, Vec3::from(at));
            let n = (b - a).cross(&(c - a));
            prop_assume!(n.norm() > 1e-2 && (x - a).dot(&n).abs() > 1e-3);
            let parts = solid_angle(&[a, b, m], &x) + solid_angle(&[b, c, m], &x) + solid_angle(&[c, a, m], &x);
            prop_assert!((parts - solid_angle(&t, &x)).abs() < 1e-10);
            let near = n.normalize() * 1e-9;
            prop_assert!((solid_angle(&t, &(m - near)) - 2.0 * PI).abs() < 1e-5);
            prop_assert!((solid_angle(&t, &(m + near)) + 2.0 * PI).abs() < 1e-5);
        }
    }
}
