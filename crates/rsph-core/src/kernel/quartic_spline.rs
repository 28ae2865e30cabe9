//! The quartic spline M5 built of B-splines, section 2.2 of the paper: the mollified Dirac function
//! of Eq. (9), with continuous first, second and third derivatives and support 2.5 h.

use std::f64::consts::PI;

/// The quartic B-spline kernel in `D` = 1, 2 or 3 dimensions with smoothing length h.
///
/// W(r) = sigma_D / h^D [ (5/2 - q)^4 - 5 (3/2 - q)^4 + 10 (1/2 - q)^4 ], q = r / h, each power cut
/// off where its base is negative; sigma = 1/24, 96/(1199 pi), 1/(20 pi).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuarticSpline<const D: usize> {
    inverse_h: f64,
    factor: f64,
}

impl<const D: usize> QuarticSpline<D> {
    /// Support radius in smoothing lengths.
    pub const SUPPORT: f64 = 2.5;

    /// The kernel with smoothing length `h` > 0.
    ///
    /// # Panics
    /// When `D` is not 1, 2 or 3.
    pub fn new(h: f64) -> Self {
        let sigma = match D {
            1 => 1.0 / 24.0,
            2 => 96.0 / (1199.0 * PI),
            3 => 1.0 / (20.0 * PI),
            _ => panic!("the quartic spline is defined in 1, 2 or 3 dimensions"),
        };
        Self { inverse_h: 1.0 / h, factor: sigma / h.powi(D as i32) }
    }

    /// Support radius (same unit as h).
    pub fn support(&self) -> f64 {
        Self::SUPPORT / self.inverse_h
    }

    /// W(r), Eq. (9); unit 1 / length^D.
    #[inline(always)]
    pub fn value(&self, r: f64) -> f64 {
        let q = r * self.inverse_h;
        let pow4 = |edge: f64| (edge - q).max(0.0).powi(4);
        self.factor * (pow4(2.5) - 5.0 * pow4(1.5) + 10.0 * pow4(0.5))
    }

    /// dW/dr; unit 1 / length^(D+1).
    #[inline(always)]
    pub fn derivative(&self, r: f64) -> f64 {
        let q = r * self.inverse_h;
        let pow3 = |edge: f64| (edge - q).max(0.0).powi(3);
        -4.0 * self.factor * self.inverse_h * (pow3(2.5) - 5.0 * pow3(1.5) + 10.0 * pow3(0.5))
    }

    /// w(r) = -W'(r) / r, the weight of all gradient sums: grad_a W(x_a - x_b) = w (x_b - x_a).
    /// `r` > 0.
    #[inline(always)]
    pub fn gradient_weight(&self, r: f64) -> f64 {
        -self.derivative(r) / r
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Composite Simpson rule on [0, support].
    fn radial_integral(f: impl Fn(f64) -> f64, support: f64) -> f64 {
        let n = 2000;
        let d = support / f64::from(n);
        (0..=n)
            .map(|i| {
                let c = if i == 0 || i == n {
                    1.0
                } else if i % 2 == 1 {
                    4.0
                } else {
                    2.0
                };
                c * f(f64::from(i) * d) * d / 3.0
            })
            .sum()
    }

    #[test]
    fn integrates_to_one_in_every_dimension() {
        let h = 0.37;
        let (k1, k2, k3) =
            (QuarticSpline::<1>::new(h), QuarticSpline::<2>::new(h), QuarticSpline::<3>::new(h));
        let s = k1.support();
        assert_relative_eq!(radial_integral(|r| 2.0 * k1.value(r), s), 1.0, epsilon = 1e-9);
        assert_relative_eq!(radial_integral(|r| 2.0 * PI * r * k2.value(r), s), 1.0, epsilon = 1e-9);
        assert_relative_eq!(radial_integral(|r| 4.0 * PI * r * r * k3.value(r), s), 1.0, epsilon = 1e-9);
    }

    #[test]
    fn derivative_is_that_of_the_value() {
        let k = QuarticSpline::<3>::new(0.8);
        for i in 1..250 {
            let (r, e) = (f64::from(i) * 0.008, 1e-6);
            let difference = (k.value(r + e) - k.value(r - e)) / (2.0 * e);
            assert!((difference - k.derivative(r)).abs() < 1e-7);
        }
    }

    #[test]
    fn vanishes_smoothly_at_the_support() {
        let k = QuarticSpline::<3>::new(1.25);
        assert!(k.value(k.support()).abs() < f64::MIN_POSITIVE);
        assert!(k.derivative(k.support() * 1.01).abs() < f64::MIN_POSITIVE);
        assert!(k.value(0.0) > 0.0);
    }
}
