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
