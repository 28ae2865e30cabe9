//! Lambda_6,4, after Cottet, Etancelin, Perignon and Picard: the interpolant that takes value and four
//! derivatives at the nodes from differences of sixth order. Four times continuously differentiable,
//! reach 4.
//!
//! Between the nodes i and i + 1 it is a polynomial of degree 9 in t = s - i.

use super::remesh::horner;

/// Reach in lattice spacings.
pub(super) const REACH: usize = 4;

/// Coefficients of 1, t, t^2, ... on each interval, over their common denominator.
const BRANCHES: [(f64, [f64; 10]); REACH] = [
    (144.0, [144.0, 0.0, -196.0, 0.0, 56.0, -3521.0, 12029.0, -15617.0, 9135.0, -2030.0]),
    (240.0, [0.0, -180.0, 180.0, 65.0, -65.0, 3516.0, -12028.0, 15617.0, -9135.0, 2030.0]),
    (720.0, [0.0, 108.0, -54.0, -120.0, 60.0, -3509.0, 12027.0, -15617.0, 9135.0, -2030.0]),
    (720.0, [0.0, -12.0, 4.0, 15.0, -5.0, 500.0, -1718.0, 2231.0, -1305.0, 290.0]),
];

/// Lambda_6,4(s) for `s` >= 0, the distance in lattice spacings.
#[inline(always)]
pub(super) fn value(s: f64) -> f64 {
    horner(&BRANCHES, s).0
}

/// dLambda_6,4/ds for `s` >= 0.
#[inline(always)]
pub(super) fn derivative(s: f64) -> f64 {
    horner(&BRANCHES, s).1
}
