//! What makes the gradient exact for linear fields up to the surface: moment matrices, their
//! inverses, and the area vectors that follow from them.

use crate::lattice::{Lattice, reflection};
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;

/// Eigenvalues of a moment matrix below this share of the bulk value are dropped: a sliver of the
/// body has no gradient across itself.
const SMALLEST_MOMENT: f64 = 0.02;

/// Constants of one particle on the lattice. Sums run over its neighbours b, with X = x_b - x_a and
/// w = -W'(r)/r.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    /// V_a.
    pub volume: f64,
    /// L_a, the pseudo-inverse of sum V_b w X X^T.
    pub correction: Mat3,
    /// sum V_b w X.
    pub first: Vec3,
    /// sum V_b w.
    pub zeroth: f64,
}

impl Moments {
    /// Moments of particle `a`.
    pub fn new(lattice: &Lattice, volume: &[f64], a: usize) -> Self {
        let (mut second, mut first, mut zeroth) = (Mat3::zeros(), Vec3::zeros(), 0.0);
        let mut add = |vw: f64, x: &Vec3| {
            second += vw * x * x.transpose();
            first += vw * x;
            zeroth += vw;
        };
        for neighbour in &lattice.neighbours {
            if let Some(b) = lattice.neighbour(a, neighbour) {
                add(volume[b] * neighbour.w, &neighbour.x);
            }
        }
        let correction = inverse_moment(lattice, &second);
        Self { volume: volume[a], correction, first, zeroth }
    }
}

/// Inverse of a moment matrix on that lattice, without directions across which the body is a sliver.
pub fn inverse_moment(lattice: &Lattice, second: &Mat3) -> Mat3 {
    pseudo_inverse(second, SMALLEST_MOMENT * lattice.full_moment)
}

/// Pseudo-inverse of a symmetric matrix without eigenvalues below `smallest`.
fn pseudo_inverse(m: &Mat3, smallest: f64) -> Mat3 {
    if let Some(inverse) = m.try_inverse()
        && m.symmetric_eigenvalues().min() > smallest
    {
        // Symmetric to the last bit: the operator relies on it.
        return 0.5 * (inverse + inverse.transpose());
    }
    let eigen = m.symmetric_eigen();
    let mut inverse = Mat3::zeros();
    for (value, v) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > smallest {
            inverse += v * v.transpose() / *value;
        }
    }
    inverse
}

/// Area vectors A_a = -sum_b V_a V_b (F_a^T L_a + F_b^T L_b) grad_a W: outward, about four layers thick
/// with alternating signs, zero inside; their sum over a flat face is its undeformed area. `remesh_gradients` holds F = d xi / d X where a deformed body was remeshed, and is
/// empty where it was not. Images are as particles, mirrored.
pub fn area_vectors(lattice: &Lattice, moments: &[Moments], remesh_gradients: &[Mat3]) -> Vec<Vec3> {
    let corrections: Vec<Mat3> = moments
        .iter()
        .enumerate()
        .map(|(a, m)| remesh_gradients.get(a).map_or(m.correction, |f| f.transpose() * m.correction))
        .collect();
    (0..lattice.len())
        .into_par_iter()
        .map(|a| {
            let mut sum = corrections[a] * moments[a].first;
            for neighbour in &lattice.neighbours {
                if let Some(seen) = lattice.seen(a, neighbour) {
                    let (b, mirror) = (seen.particle, reflection(seen.mirrors));
                    let back = corrections[b] * neighbour.x.component_mul(&mirror);
                    sum += moments[b].volume * neighbour.w * back.component_mul(&mirror);
                }
            }
            -moments[a].volume * sum
        })
        .collect()
}
