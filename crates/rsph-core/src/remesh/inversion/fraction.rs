//! How much of a new cell lies inside the body: by the exact level set of the undeformed shape at the
//! reference positions of the cell, so that the surface does not drift.

use crate::tensor::{Mat3, Vec3};

/// Sub-points along each edge of a cell.
const SUBDIVISIONS: usize = 8;
/// Smallest slope of the level set across a sub-cell, in sub-cells.
const SMALLEST_SLOPE: f64 = 1e-3;

/// Inside fraction (0 to 1) of the cell of edges `spacing` around a node with reference position
/// `reference` and dX/dx = `gradient`, where `distance` is the signed distance of the undeformed body.
pub fn inside_fraction<const D: usize>(
    reference: &Vec3,
    gradient: &Mat3,
    spacing: &Vec3,
    distance: &dyn Fn(&Vec3) -> f64,
) -> f64 {
    let edge = |i: usize| gradient.column(i) * spacing[i];
    // A signed distance changes by no more than the way.
    let reach: f64 = (0..D).map(|i| edge(i).norm()).sum();
    let phi = distance(reference);
    if phi.abs() >= 0.75 * reach {
        return f64::from(u8::from(phi < 0.0));
    }
    let across = |i: usize| {
        let half = 0.5 * edge(i);
        (distance(&(reference + half)) - distance(&(reference - half))) / SUBDIVISIONS as f64
    };
    let shortest = (0..D).map(|i| spacing[i]).fold(f64::INFINITY, f64::min);
    let slope = (0..D).map(|i| across(i).powi(2)).sum::<f64>().sqrt();
    let slope = slope.max(SMALLEST_SLOPE * shortest / SUBDIVISIONS as f64);
    let points = SUBDIVISIONS.pow(D as u32);
    let offset = |k: usize| (k as f64 + 0.5) / SUBDIVISIONS as f64 - 0.5;
    let inside = |q: usize| {
        let k = [q % SUBDIVISIONS, q / SUBDIVISIONS % SUBDIVISIONS, q / SUBDIVISIONS / SUBDIVISIONS];
        let x = (0..D).fold(*reference, |x, i| x + edge(i) * offset(k[i]));
        (0.5 - distance(&x) / slope).clamp(0.0, 1.0)
    };
    (0..points).map(inside).sum::<f64>() / points as f64
}
