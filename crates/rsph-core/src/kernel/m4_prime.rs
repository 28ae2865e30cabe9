//! M'4, Eq. (16), after Monaghan: continuous with its first derivative, reach 2.
//!
//! The second branch carries the square, (1 - s)(2 - s)^2 / 2; without it, as Eq. (16) is printed, the
//! weights do not even sum to one.

/// Reach in lattice spacings.
pub(super) const REACH: usize = 2;

/// M'4(s) for `s` >= 0, the distance in lattice spacings.
#[inline(always)]
pub(super) fn value(s: f64) -> f64 {
    if s < 1.0 {
        1.0 + s * s * (1.5 * s - 2.5)
    } else if s < 2.0 {
        0.5 * (1.0 - s) * (2.0 - s) * (2.0 - s)
    } else {
        0.0
    }
}

/// dM'4/ds for `s` >= 0.
#[inline(always)]
pub(super) fn derivative(s: f64) -> f64 {
    if s < 1.0 {
        s * (4.5 * s - 5.0)
    } else if s < 2.0 {
        -0.5 * (2.0 - s) * (4.0 - 3.0 * s)
    } else {
        0.0
    }
}

/// Weights of the four nodes around a point that lies `fraction` (0 to 1) of a spacing above the second of
/// them, and their derivatives by the position of the point (per spacing).
#[inline]
pub fn weights_and_slopes(fraction: f64) -> ([f64; 4], [f64; 4]) {
    let distance = |m: usize| fraction + 1.0 - m as f64;
    let weights = std::array::from_fn(|m| value(distance(m).abs()));
    let slopes = std::array::from_fn(|m| derivative(distance(m).abs()) * distance(m).signum());
    (weights, slopes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_those_of_the_weights() {
        for k in 1..20 {
            let (x, e) = (f64::from(k) / 20.0, 1e-6);
            let slopes = weights_and_slopes(x).1;
            let (up, down) = (weights_and_slopes(x + e).0, weights_and_slopes(x - e).0);
            for m in 0..4 {
                assert!((slopes[m] - (up[m] - down[m]) / (2.0 * e)).abs() < 1e-8);
            }
        }
    }
}
