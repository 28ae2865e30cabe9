//! The kernels of remeshing: interpolation between particles and the nodes of a lattice that
//! conserves moments.

use super::{lambda_4_2, lambda_6_4, m4_prime};

/// Most weights that a kernel has along an axis.
pub const MAX_WEIGHTS: usize = 8;

/// A moment-conserving interpolation kernel, applied as a tensor product.
///
/// Of the quantities that particles carry, the nodes get sums that agree in all moments up to the
/// kernel's order: order 1 is total and centre, order 2 the tensor of inertia as well. A kernel of
/// order 2 or more can not be positive everywhere, so that new values may exceed the old ones at a
/// jump. All of them interpolate: a particle at a node stays as it is.
///
/// | kernel | order | reach | weights in 3D | derivatives | smallest value |
/// |---|---|---|---|---|---|
/// | M'4 | 2 | 2 | 64 | 1 | -0.074 |
/// | Lambda_4,2 | 4 | 3 | 216 | 2 | -0.117 |
/// | Lambda_6,4 | 6 | 4 | 512 | 4 | -0.144 |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RemeshKernel {
    /// Eq. (16).
    #[default]
    M4Prime,
    /// Fourth order.
    Lambda42,
    /// Sixth order.
    Lambda64,
}

impl RemeshKernel {
    /// All kernels.
    pub const ALL: [Self; 3] = [Self::M4Prime, Self::Lambda42, Self::Lambda64];

    /// Name in scenario files.
    pub fn name(self) -> &'static str {
        match self {
            Self::M4Prime => "m4-prime",
            Self::Lambda42 => "lambda-4-2",
            Self::Lambda64 => "lambda-6-4",
        }
    }

    /// The kernel of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|k| k.name() == name)
    }

    /// Half width of the support in lattice spacings: the kernel has `2 reach` weights an axis.
    pub fn reach(self) -> usize {
        match self {
            Self::M4Prime => m4_prime::REACH,
            Self::Lambda42 => lambda_4_2::REACH,
            Self::Lambda64 => lambda_6_4::REACH,
        }
    }

    /// The highest moment that interpolation conserves.
    pub fn order(self) -> usize {
        match self {
            Self::M4Prime => 2,
            Self::Lambda42 => 4,
            Self::Lambda64 => 6,
        }
    }

    /// The kernel's value at a distance of `s` lattice spacings.
    #[inline]
    pub fn value(self, s: f64) -> f64 {
        match self {
            Self::M4Prime => m4_prime::value(s.abs()),
            Self::Lambda42 => lambda_4_2::value(s.abs()),
            Self::Lambda64 => lambda_6_4::value(s.abs()),
        }
    }

    /// Its derivative at a distance of `s` lattice spacings, above the node or (negative) below it.
    #[inline]
    pub fn derivative(self, s: f64) -> f64 {
        let derivative = match self {
            Self::M4Prime => m4_prime::derivative(s.abs()),
            Self::Lambda42 => lambda_4_2::derivative(s.abs()),
            Self::Lambda64 => lambda_6_4::derivative(s.abs()),
        };
        derivative * s.signum()
    }

    /// Weights of the `2 reach` nodes around a point that lies `fraction` (0 to 1) of a spacing above
    /// the node number `reach - 1` of them; the rest of the array is zero.
    #[inline]
    pub fn weights(self, fraction: f64) -> [f64; MAX_WEIGHTS] {
        let (reach, mut w) = (self.reach(), [0.0; MAX_WEIGHTS]);
        for (m, w) in w.iter_mut().enumerate().take(2 * reach) {
            *w = self.value(m as f64 - (reach - 1) as f64 - fraction);
        }
        w
    }

    /// The derivatives of the [`weights`](Self::weights) by the place of the point, per spacing.
    #[inline]
    pub fn slopes(self, fraction: f64) -> [f64; MAX_WEIGHTS] {
        let (reach, mut slopes) = (self.reach(), [0.0; MAX_WEIGHTS]);
        for (m, slope) in slopes.iter_mut().enumerate().take(2 * reach) {
            *slope = self.derivative(fraction + (reach - 1) as f64 - m as f64);
        }
        slopes
    }
}

/// A kernel that is a polynomial of t = s - i between the nodes i and i + 1: common denominator and
/// coefficients of each branch. Its value and derivative.
#[inline(always)]
pub(super) fn horner<const N: usize>(branches: &[(f64, [f64; N])], s: f64) -> (f64, f64) {
    // Beyond the reach, infinity included, the kernel is zero.
    let Some((denominator, c)) = branches.get(s as usize) else { return (0.0, 0.0) };
    let t = s - s.floor();
    let step = |(value, slope): (f64, f64), c: &f64| (value * t + c, slope * t + value);
    let (value, slope) = c.iter().rev().fold((0.0, 0.0), step);
    (value / denominator, slope / denominator)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Sums of w (x_node - x)^k: one for k = 0, zero up to the order, and no more.
        #[test]
        fn moments_up_to_the_order_are_conserved(fraction in 0.0..1.0_f64) {
            for kernel in RemeshKernel::ALL {
                let w = kernel.weights(fraction);
                for k in 0..=kernel.order() {
                    let moment: f64 = (0..2 * kernel.reach())
                        .map(|m| w[m] * (m as f64 - (kernel.reach() - 1) as f64 - fraction).powi(k as i32))
                        .sum();
                    let expected = if k == 0 { 1.0 } else { 0.0 };
                    // Terms of the sixth moment are as large as 4^6.
                    let tolerance = if k <= 4 { 1e-12 } else { 1e-11 };
                    prop_assert!((moment - expected).abs() < tolerance, "{} moment {k}: {moment:e}", kernel.name());
                }
            }
        }
    }

    #[test]
    fn slopes_are_those_of_the_weights() {
        for kernel in RemeshKernel::ALL {
            for k in 1..20 {
                let (x, e) = (f64::from(k) / 20.0, 1e-6);
                let (slopes, up, down) = (kernel.slopes(x), kernel.weights(x + e), kernel.weights(x - e));
                for m in 0..MAX_WEIGHTS {
                    assert!((slopes[m] - (up[m] - down[m]) / (2.0 * e)).abs() < 1e-7, "{}", kernel.name());
                }
            }
        }
    }

    #[test]
    fn the_next_moment_is_not_conserved() {
        for kernel in RemeshKernel::ALL {
            let k = kernel.order() as i32 + 1;
            let w = kernel.weights(0.3);
            let moment: f64 = (0..2 * kernel.reach())
                .map(|m| w[m] * (m as f64 - (kernel.reach() - 1) as f64 - 0.3).powi(k))
                .sum();
            assert!(moment.abs() > 1e-3, "{} moment {k}: {moment}", kernel.name());
        }
    }

    /// One-sided k-th difference over three or more points with step `e`.
    fn difference(kernel: RemeshKernel, at: f64, e: f64, k: usize) -> f64 {
        let mut v: Vec<f64> = (0..=k).map(|i| kernel.value(at + i as f64 * e)).collect();
        for _ in 0..k {
            v = v.windows(2).map(|w| (w[1] - w[0]) / e).collect();
        }
        v[0]
    }

    #[test]
    fn kernels_interpolate_and_are_smooth_at_the_nodes() {
        let smoothness = [1, 2, 4];
        let e = [1e-7, 1e-5, 1e-4, 1e-3, 1e-3];
        for (kernel, smooth) in RemeshKernel::ALL.into_iter().zip(smoothness) {
            for node in 0..=kernel.reach() {
                let x = node as f64;
                assert_eq!(kernel.value(x), if node == 0 { 1.0 } else { 0.0 });
                for k in 1..=smooth {
                    let e = e[k];
                    let (left, right) =
                        (difference(kernel, x - k as f64 * e, e, k), difference(kernel, x, e, k));
                    let scale = 10.0_f64.powi(k as i32 + 2);
                    assert!(
                        (left - right).abs() < scale * e,
                        "{} k={k} at {x}: {left} {right}",
                        kernel.name()
                    );
                }
            }
        }
    }

    #[test]
    fn smallest_values_are_those_of_the_table() {
        for (kernel, table) in RemeshKernel::ALL.into_iter().zip([-0.074, -0.117, -0.144]) {
            let smallest = (0..4000).map(|i| kernel.value(f64::from(i) * 1e-3)).fold(0.0, f64::min);
            assert!((smallest - table).abs() < 6e-4, "{} {smallest}", kernel.name());
        }
    }

    #[test]
    fn names_lead_back() {
        for kernel in RemeshKernel::ALL {
            assert_eq!(RemeshKernel::from_name(kernel.name()), Some(kernel));
            assert_eq!(kernel.value(f64::INFINITY), 0.0);
        }
        assert_eq!(RemeshKernel::from_name("m4"), None);
    }
}
