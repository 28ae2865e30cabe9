//! The far field of many triangles: a dipole and its first two moments about a point.

use crate::tensor::{Mat3, Vec3};

/// Moments of oriented triangles about a centre c, y = x - c.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moments {
    /// Integral of n dA.
    dipole: Vec3,
    /// Integral of n (x) y dA.
    first: Mat3,
    /// Component i: integral of `n_i` y (x) y dA.
    second: [Mat3; 3],
}

/// Moments as the far field needs them: the symmetries of the derivatives of r/|r|^3 used up.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FarField {
    dipole: Vec3,
    trace: f64,
    /// Coefficients of x^2, y^2, z^2, x y, y z and x z.
    first: [f64; 6],
    vector: Vec3,
    /// Coefficients of x^3, y^3, z^3, x^2 y, x^2 z, y^2 x, y^2 z, z^2 x, z^2 y and x y z.
    second: [f64; 10],
}

impl Moments {
    /// Moments about `centre` of a triangle that counts `weight` times.
    pub(super) fn of_triangle(corners: &[Vec3; 3], weight: f64, centre: &Vec3) -> Self {
        let [a, b, c] = corners.map(|v| v - centre);
        let area = 0.5 * weight * (b - a).cross(&(c - a));
        let sum = a + b + c;
        let quadratic =
            (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose()) / 12.0;
        Self {
            dipole: area,
            first: area * (sum / 3.0).transpose(),
            second: [0, 1, 2].map(|i| area[i] * quadratic),
        }
    }

    /// The same about a centre moved by `-shift`: y' = y + shift.
    pub(super) fn moved(&self, shift: &Vec3) -> Self {
        let outer = shift * shift.transpose();
        let second = [0, 1, 2].map(|i| {
            let row = self.first.row(i).transpose();
            let mixed = row * shift.transpose();
            self.second[i] + mixed + mixed.transpose() + self.dipole[i] * outer
        });
        Self { dipole: self.dipole, first: self.first + self.dipole * shift.transpose(), second }
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        Self {
            dipole: self.dipole + other.dipole,
            first: self.first + other.first,
            second: [0, 1, 2].map(|i| self.second[i] + other.second[i]),
        }
    }

    pub(super) fn far_field(&self) -> FarField {
        let m = &self.first;
        let t = |i: usize, j: usize, k: usize| self.second[i][(j, k)];
        let xxy = |a: usize, b: usize| 2.0 * t(a, a, b) + t(b, a, a);
        FarField {
            dipole: self.dipole,
            trace: m.trace(),
            first: [
                m[(0, 0)],
                m[(1, 1)],
                m[(2, 2)],
                m[(0, 1)] + m[(1, 0)],
                m[(1, 2)] + m[(2, 1)],
                m[(0, 2)] + m[(2, 0)],
            ],
            vector: Vec3::from_fn(|k, _| {
                (0..3).map(|i| 2.0 * t(i, i, k)).sum::<f64>() + self.second[k].trace()
            }),
            second: [
                t(0, 0, 0),
                t(1, 1, 1),
                t(2, 2, 2),
                xxy(0, 1),
                xxy(0, 2),
                xxy(1, 0),
                xxy(1, 2),
                xxy(2, 0),
                xxy(2, 1),
                2.0 * (t(0, 1, 2) + t(1, 2, 0) + t(2, 0, 1)),
            ],
        }
    }
}

impl FarField {
    /// Solid angle seen from where the centre is at `r`, |r| not less than the triangles' reach: the Taylor series
    /// of n.(r + y)/|r + y|^3 in y to second order.
    #[inline]
    pub(super) fn solid_angle(&self, r: &Vec3) -> f64 {
        let square = r.norm_squared();
        let inverse = 1.0 / square;
        let cube = inverse / square.sqrt();
        let (x, y, z) = (r.x, r.y, r.z);
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let f = &self.first;
        let first = f[0] * xx + f[1] * yy + f[2] * zz + f[3] * x * y + f[4] * y * z + f[5] * x * z;
        let s = &self.second;
        let second = x * (s[0] * xx + s[5] * yy + s[7] * zz)
            + y * (s[1] * yy + s[3] * xx + s[8] * zz)
            + z * (s[2] * zz + s[4] * xx + s[6] * yy)
            + s[9] * x * y * z;
        let dipole = self.dipole.dot(r) + self.trace;
        cube * (dipole + inverse * (7.5 * inverse * second - 1.5 * self.vector.dot(r) - 3.0 * first))
    }
}

#[cfg(test)]
mod tests {
    use super::super::solid_angle;
    use super::*;
    use proptest::prelude::*;

    fn triangle(v: [f64; 9]) -> [Vec3; 3] {
        [0, 1, 2].map(|i| Vec3::new(v[3 * i], v[3 * i + 1], v[3 * i + 2]))
    }

    proptest! {
        /// The error falls with the fifth power of the distance, as the first moment that is left out says.
        #[test]
        fn the_far_field_is_of_second_order(v in prop::array::uniform9(-1.0..1.0_f64), d in prop::array::uniform3(-1.0..1.0_f64)) {
            let (t, d) = (triangle(v), Vec3::from(d));
            prop_assume!(d.norm() > 0.1);
            let far = Moments::of_triangle(&t, 1.0, &Vec3::zeros()).far_field();
            let error = |distance: f64| {
                let x = d.normalize() * distance;
                (far.solid_angle(&-x) - solid_angle(&t, &x)).abs()
            };
            prop_assert!(error(20.0) < 2e-5);
            prop_assert!(error(40.0) < error(20.0) / 20.0 + 1e-8, "{} {}", error(20.0), error(40.0));
        }

        /// Moments about another centre are those taken there.
        #[test]
        fn moments_move(v in prop::array::uniform9(-1.0..1.0_f64), c in prop::array::uniform3(-1.0..1.0_f64), weight in 0.1..2.0_f64) {
            let (t, c) = (triangle(v), Vec3::from(c));
            let moved = Moments::of_triangle(&t, weight, &Vec3::zeros()).moved(&-c);
            let there = Moments::of_triangle(&t, weight, &c);
            prop_assert!((moved.first - there.first).amax() < 1e-12);
            for i in 0..3 {
                prop_assert!((moved.second[i] - there.second[i]).amax() < 1e-12);
            }
        }
    }
}
