//! Small tensors: vectors, matrices and symmetric tensors in three dimensions.
//!
//! A symmetric tensor keeps its six components in VTK order `XX YY ZZ XY YZ XZ`, the order of every
//! file and every Python array, so that no conversion ever has to guess.

pub mod lanes;

use nalgebra::{Matrix3, Vector3};

/// A vector of three components.
pub type Vec3 = Vector3<f64>;
/// A 3 x 3 matrix.
pub type Mat3 = Matrix3<f64>;

/// A symmetric 3 x 3 tensor, components in VTK order `XX YY ZZ XY YZ XZ`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SymTensor(pub [f64; 6]);

impl SymTensor {
    /// The zero tensor.
    pub const ZERO: Self = Self([0.0; 6]);

    /// The symmetric part of `m`, (m + m^T)/2: the strain of a displacement gradient, Eq. (7).
    #[inline(always)]
    pub fn symmetric_part(m: &Mat3) -> Self {
        Self([
            m[(0, 0)],
            m[(1, 1)],
            m[(2, 2)],
            0.5 * (m[(0, 1)] + m[(1, 0)]),
            0.5 * (m[(1, 2)] + m[(2, 1)]),
            0.5 * (m[(0, 2)] + m[(2, 0)]),
        ])
    }

    /// The tensor as a full matrix.
    #[inline(always)]
    pub fn to_matrix(self) -> Mat3 {
        let [xx, yy, zz, xy, yz, xz] = self.0;
        Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// The trace `e_kk`.
    #[inline(always)]
    pub fn trace(self) -> f64 {
        self.0[0] + self.0[1] + self.0[2]
    }

    /// The double contraction `a_ij b_ij`.
    #[inline(always)]
    pub fn double_dot(self, other: Self) -> f64 {
        let (a, b) = (self.0, other.0);
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
    }

    /// The product with a vector, `a_ij n_j`.
    #[inline(always)]
    pub fn dot(self, n: &Vec3) -> Vec3 {
        let [xx, yy, zz, xy, yz, xz] = self.0;
        Vec3::new(
            xx * n.x + xy * n.y + xz * n.z,
            xy * n.x + yy * n.y + yz * n.z,
            xz * n.x + yz * n.y + zz * n.z,
        )
    }

    /// Von Mises' equivalent of a stress tensor, `sqrt(3/2 s:s)` with the deviator `s`.
    pub fn von_mises(self) -> f64 {
        let p = self.trace() / 3.0;
        let mut s = self;
        for i in 0..3 {
            s.0[i] -= p;
        }
        (1.5 * s.double_dot(s)).sqrt()
    }
}

impl std::ops::Add for SymTensor {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + o.0[i]))
    }
}

impl std::ops::Sub for SymTensor {
    type Output = Self;

    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(std::array::from_fn(|c| self.0[c] - o.0[c]))
    }
}

impl std::ops::Mul<f64> for SymTensor {
    type Output = Self;
    #[inline(always)]
    fn mul(self, k: f64) -> Self {
        Self(self.0.map(|x| x * k))
    }
}
