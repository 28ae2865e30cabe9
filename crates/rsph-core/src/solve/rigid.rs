//! Motions of a body, or of a piece of it, that nothing holds back.

use crate::dynamics::solid::Solid;
use crate::tensor::Vec3;
use nalgebra::{Matrix6, Vector6};

/// Share of the largest eigenvalue below which a motion counts as free.
const FREE: f64 = 1e-9;
/// Share of its length that a vector component may miss of an axis and still be named after it.
const ALONG: f64 = 1e-6;

/// A piece of the body with motions that cost no energy.
#[derive(Clone, Debug, PartialEq)]
pub struct LoosePiece {
    /// Number of its particles.
    pub particles: usize,
    /// Its centre (undeformed).
    pub centre: Vec3,
    /// Whether nothing holds it at all.
    pub free: bool,
    /// Its free motions, in words.
    pub motions: Vec<String>,
}

/// The pieces of `solid` whose holds leave a motion as a rigid body.
pub fn loose_pieces(solid: &Solid) -> Vec<LoosePiece> {
    solid.lattice.pieces().iter().filter_map(|piece| loose(solid, piece)).collect()
}

/// What is free of one piece.
fn loose(solid: &Solid, piece: &[usize]) -> Option<LoosePiece> {
    let position = |a: usize| solid.lattice.position(a);
    let centre = piece.iter().map(|&a| position(a)).sum::<Vec3>() / piece.len() as f64;
    let radius = piece.iter().map(|&a| (position(a) - centre).norm()).fold(solid.lattice.spacing, f64::max);
    // A component held at x along an axis forbids (translation + rotation x (x - centre)) . axis.
    let mut holds = Matrix6::zeros();
    let mut forbid = |x: &Vec3, axis: &Vec3| {
        let turn = ((x - centre) / radius).cross(axis);
        let row = Vector6::new(axis.x, axis.y, axis.z, turn.x, turn.y, turn.z);
        holds += row * row.transpose();
    };
    let mut member = vec![false; solid.len()];
    for &a in piece {
        member[a] = true;
    }
    for (x, projector) in solid.lift.holds_near(|a| member[a]) {
        // The columns of a projector span what it holds.
        for i in 0..3 {
            forbid(&x, &projector.column(i).into());
        }
    }
    for p in solid.fixed.particles.iter().filter(|p| member[p.particle]) {
        for i in (0..3).filter(|&i| p.fix[i]) {
            forbid(&position(p.particle), &Vec3::ith(i, 1.0));
        }
    }
    let eigen = holds.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let free: Vec<Vector6<f64>> = (0..6)
        .filter(|&k| eigen.eigenvalues[k] <= FREE * largest)
        .map(|k| eigen.eigenvectors.column(k).into_owned())
        .collect();
    (!free.is_empty()).then(|| LoosePiece {
        particles: piece.len(),
        centre,
        free: free.len() == 6,
        motions: names(&free, &centre, radius),
    })
}

/// Names of the motions in the span of orthonormal `free`.
fn names(free: &[Vector6<f64>], centre: &Vec3, radius: f64) -> Vec<String> {
    let mut names = Vec::new();
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let within: f64 = free.iter().map(|f| f[k] * f[k]).sum();
        if within > 1.0 - ALONG {
            names.push(format!("shifted along {axis}"));
        }
    }
    let shifts = names.len();
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        // The free motion with the most of this turn.
        let best: Vector6<f64> = free.iter().map(|f| *f * f[3 + k]).sum();
        let turn = Vec3::new(best[3], best[4], best[5]);
        if turn.norm() > 1e-3 && (turn[k] / turn.norm()).abs() > 1.0 - ALONG {
            let shift = Vec3::new(best[0], best[1], best[2]);
            let p = centre + turn.cross(&shift) / turn.norm_squared() * radius;
            names.push(format!(
                "turned about an axis along {axis} through ({:.3}, {:.3}, {:.3})",
                p.x, p.y, p.z
            ));
        }
    }
    if names.len() < free.len() && shifts < names.len().max(1) {
        names.push("moved in a way that combines shift and turn".into());
    }
    names
}
