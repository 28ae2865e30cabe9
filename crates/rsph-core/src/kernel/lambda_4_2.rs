//! Lambda_4,2, after Cottet, Etancelin, Perignon and Picard: the interpolant that takes value and two
//! derivatives at the nodes from differences of fourth order. Twice continuously differentiable,
//! reach 3.
//!
//! Between the nodes i and i + 1 it is a polynomial of degree 5 in t = s - i.

use super::remesh::horner;

/// Reach in lattice spacings.
pub(super) const REACH: usize = 3;

/// Coefficients of 1, t, t^2, ... on each interval, over their common denominator.
const BRANCHES: [(f64, [f64; 6]); REACH] = [
    (12.0, [12.0, 0.0, -15.0, -35.0, 63.0, -25.0]),
    (24.0, [0.0, -16.0, 16.0, 39.0, -64.0, 25.0]),
    (24.0, [0.0, 2.0, -1.0, -9.0, 13.0, -5.0]),
];

/// Lambda_4,2(s) for `s` >= 0, the distance in lattice spacings.
#[inline(always)]
pub(super) fn value(s: f64) -> f64 {
    horner(&BRANCHES, s).0
}

/// dLambda_4,2/ds for `s` >= 0.
#[inline(always)]
pub(super) fn derivative(s: f64) -> f64 {
    horner(&BRANCHES, s).1
}
