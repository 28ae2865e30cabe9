//! Numbers and tensors of several particles at once, in the lanes of vector registers.

use super::Mat3;
use pulp::Simd;
use std::fmt::Debug;
use std::ops::{Add, Mul, Neg, Sub};

/// Most lanes of a vector register of f64.
pub const MAX_LANES: usize = 8;

/// A number of one particle or of several at once: what a formula is written in.
pub trait Real:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
    + Add<f64, Output = Self>
{
    /// self * b + c.
    #[must_use]
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// self * k + c.
    #[must_use]
    fn scaled_add(self, k: f64, c: Self) -> Self;
    /// 1 / self.
    #[must_use]
    fn recip(self) -> Self;
    /// The natural logarithm.
    #[must_use]
    fn ln(self) -> Self;
    /// e to this power.
    #[must_use]
    fn exp(self) -> Self;
    /// This number where it is positive, 0 elsewhere.
    #[must_use]
    fn positive_part(self) -> Self;
    /// 1 where this number is positive, 0 elsewhere.
    #[must_use]
    fn is_positive(self) -> Self;
    /// The largest magnitude in any lane; NaN if there is one.
    fn largest(self) -> f64;
}

impl Real for f64 {
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        // Fused only where the instruction is sure to be there: a call of the library is slow.
        self * b + c
    }

    #[inline(always)]
    fn scaled_add(self, k: f64, c: Self) -> Self {
        self * k + c
    }

    #[inline(always)]
    fn recip(self) -> Self {
        1.0 / self
    }

    #[inline(always)]
    fn ln(self) -> Self {
        f64::ln(self)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        f64::exp(self)
    }

    #[inline(always)]
    fn positive_part(self) -> Self {
        self.max(0.0)
    }

    #[inline(always)]
    fn is_positive(self) -> Self {
        f64::from(u8::from(self > 0.0))
    }

    #[inline(always)]
    fn largest(self) -> f64 {
        self.abs()
    }
}

/// A vector register of f64, with the instructions for it.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd>(pub S, pub S::f64s);

impl<S: Simd> Lanes<S> {
    /// The same number in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, x: f64) -> Self {
        Self(simd, simd.splat_f64s(x))
    }

    /// The values at the start of `from`.
    #[inline(always)]
    pub fn load(simd: S, from: &[f64]) -> Self {
        Self(simd, S::as_simd_f64s(&from[..S::F64_LANES]).0[0])
    }

    /// A function of each lane.
    #[inline(always)]
    fn each(self, function: impl Fn(f64) -> f64) -> Self {
        let mut values = [0.0; MAX_LANES];
        self.store(&mut values);
        for value in &mut values[..S::F64_LANES] {
            *value = function(*value);
        }
        Self::load(self.0, &values)
    }

    /// Puts the values at the start of `to`.
    #[inline(always)]
    pub fn store(self, to: &mut [f64]) {
        S::as_mut_simd_f64s(&mut to[..S::F64_LANES]).0[0] = self.1;
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(self.0, self.0.add_f64s(self.1, o.1))
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(self.0, self.0.sub_f64s(self.1, o.1))
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(self.0, self.0.mul_f64s(self.1, o.1))
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0, self.0.neg_f64s(self.1))
    }
}

impl<S: Simd> Mul<f64> for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, k: f64) -> Self {
        self * Self::splat(self.0, k)
    }
}

impl<S: Simd> Add<f64> for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, k: f64) -> Self {
        self + Self::splat(self.0, k)
    }
}

impl<S: Simd> Real for Lanes<S> {
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(self.0, self.0.mul_add_e_f64s(self.1, b.1, c.1))
    }

    #[inline(always)]
    fn scaled_add(self, k: f64, c: Self) -> Self {
        self.mul_add(Self::splat(self.0, k), c)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        Self(self.0, self.0.div_f64s(self.0.splat_f64s(1.0), self.1))
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.each(f64::ln)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        self.each(f64::exp)
    }

    #[inline(always)]
    fn positive_part(self) -> Self {
        Self(self.0, self.0.max_f64s(self.1, self.0.splat_f64s(0.0)))
    }

    #[inline(always)]
    fn is_positive(self) -> Self {
        self.each(Real::is_positive)
    }

    #[inline(always)]
    fn largest(self) -> f64 {
        let mut values = [0.0; MAX_LANES];
        self.store(&mut values);
        let mut largest = 0.0;
        for value in values {
            let size = value.abs();
            if size.is_nan() || size > largest {
                largest = size;
            }
        }
        largest
    }
}

/// A 3 x 3 matrix of one particle or of several at once.
#[derive(Clone, Copy, Debug)]
pub struct Tensor<T>(pub [[T; 3]; 3]);

impl<T: Real> Tensor<T> {
    /// `x` on the diagonal added.
    #[inline(always)]
    #[must_use]
    pub fn plus_diagonal(mut self, x: T) -> Self {
        for i in 0..3 {
            self.0[i][i] = self.0[i][i] + x;
        }
        self
    }

    /// `x` times the unit tensor added.
    #[inline(always)]
    #[must_use]
    pub fn plus_number(mut self, x: f64) -> Self {
        for i in 0..3 {
            self.0[i][i] = self.0[i][i] + x;
        }
        self
    }

    /// `self` times `k`.
    #[inline(always)]
    #[must_use]
    pub fn scaled(mut self, k: T) -> Self {
        for row in &mut self.0 {
            for x in row {
                *x = *x * k;
            }
        }
        self
    }

    /// `self` + `k` `other`.
    #[inline(always)]
    #[must_use]
    pub fn plus(mut self, k: T, other: &Self) -> Self {
        for i in 0..3 {
            for j in 0..3 {
                self.0[i][j] = k.mul_add(other.0[i][j], self.0[i][j]);
            }
        }
        self
    }

    /// The matrix product `self` `other`.
    #[inline(always)]
    #[must_use]
    pub fn times(&self, other: &Self) -> Self {
        let mut product = *self;
        for i in 0..3 {
            for j in 0..3 {
                let sum = self.0[i][0] * other.0[0][j];
                let sum = self.0[i][1].mul_add(other.0[1][j], sum);
                product.0[i][j] = self.0[i][2].mul_add(other.0[2][j], sum);
            }
        }
        product
    }

    /// The matrix product with a matrix that is the same in every lane.
    #[inline(always)]
    #[must_use]
    pub fn times_matrix(&self, other: &Mat3) -> Self {
        let mut product = *self;
        for i in 0..3 {
            for j in 0..3 {
                let sum = self.0[i][1].scaled_add(other[(1, j)], self.0[i][0] * other[(0, j)]);
                product.0[i][j] = self.0[i][2].scaled_add(other[(2, j)], sum);
            }
        }
        product
    }

    /// The transpose.
    #[inline(always)]
    #[must_use]
    pub fn transpose(&self) -> Self {
        let [[a, b, c], [d, e, f], [g, h, i]] = self.0;
        Self([[a, d, g], [b, e, h], [c, f, i]])
    }

    /// The symmetric part.
    #[inline(always)]
    #[must_use]
    pub fn symmetric_part(&self) -> Self {
        (*self + self.transpose()) * 0.5
    }

    /// The trace.
    #[inline(always)]
    pub fn trace(&self) -> T {
        self.0[0][0] + self.0[1][1] + self.0[2][2]
    }

    /// The double contraction A_ij B_ij.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> T {
        let mut sum = self.0[0][0] * other.0[0][0];
        for c in 1..9 {
            sum = self.0[c / 3][c % 3].mul_add(other.0[c / 3][c % 3], sum);
        }
        sum
    }

    /// The cofactors, det(A) A^-T.
    #[inline(always)]
    #[must_use]
    pub fn cofactors(&self) -> Self {
        let a = &self.0;
        let mut cofactors = *self;
        for i in 0..3 {
            for j in 0..3 {
                let (k, l, m, n) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
                cofactors.0[i][j] = a[k][m].mul_add(a[l][n], -(a[k][n] * a[l][m]));
            }
        }
        cofactors
    }

    /// A^-T and det A.
    #[inline(always)]
    pub fn inverse_transpose(&self) -> (Self, T) {
        let (cofactors, determinant) = (self.cofactors(), self.determinant());
        (cofactors.scaled(determinant.recip()), determinant)
    }

    /// det A.
    #[inline(always)]
    pub fn determinant(&self) -> T {
        let (cofactors, first) = (self.cofactors(), &self.0[0]);
        let sum = first[1].mul_add(cofactors.0[0][1], first[0] * cofactors.0[0][0]);
        first[2].mul_add(cofactors.0[0][2], sum)
    }

    /// The largest magnitude of a component in any lane.
    #[inline(always)]
    pub fn largest(&self) -> f64 {
        let mut largest = 0.0;
        for x in self.0.as_flattened() {
            let size = x.largest();
            if size.is_nan() || size > largest {
                largest = size;
            }
        }
        largest
    }
}

impl<T: Real> Add for Tensor<T> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, o: Self) -> Self {
        for i in 0..3 {
            for j in 0..3 {
                self.0[i][j] = self.0[i][j] + o.0[i][j];
            }
        }
        self
    }
}

impl<T: Real> Sub for Tensor<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, o: Self) -> Self {
        for i in 0..3 {
            for j in 0..3 {
                self.0[i][j] = self.0[i][j] - o.0[i][j];
            }
        }
        self
    }
}

impl<T: Real> Mul<f64> for Tensor<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, k: f64) -> Self {
        for row in &mut self.0 {
            for x in row {
                *x = *x * k;
            }
        }
        self
    }
}

impl From<&Mat3> for Tensor<f64> {
    #[inline(always)]
    fn from(m: &Mat3) -> Self {
        Self(std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)])))
    }
}

impl From<Tensor<f64>> for Mat3 {
    #[inline(always)]
    fn from(t: Tensor<f64>) -> Self {
        Mat3::from_fn(|i, j| t.0[i][j])
    }
}

/// A tensor in each of some particles, component by component (row by row): what crosses between the sums and a law.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Tensors(pub [[f64; MAX_LANES]; 9]);

impl Tensors {
    /// Zeros.
    pub const ZERO: Self = Self([[0.0; MAX_LANES]; 9]);

    /// The tensor of one particle.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Mat3 {
        Mat3::from_fn(|i, j| self.0[3 * i + j][lane])
    }

    /// Sets the tensor of one particle.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, m: &Mat3) {
        for c in 0..9 {
            self.0[c][lane] = m[(c / 3, c % 3)];
        }
    }

    /// Tensors of the first lanes.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> Tensor<Lanes<S>> {
        let mut tensor = Tensor([[Lanes::splat(simd, 0.0); 3]; 3]);
        for c in 0..9 {
            tensor.0[c / 3][c % 3] = Lanes::load(simd, &self.0[c]);
        }
        tensor
    }

    /// Sets the tensors of the first lanes.
    #[inline(always)]
    pub fn store<S: Simd>(&mut self, tensor: &Tensor<Lanes<S>>) {
        for c in 0..9 {
            tensor.0[c / 3][c % 3].store(&mut self.0[c]);
        }
    }
}
