//! Elastic foundations: springs between a part of the surface and its surroundings.
//!
//! The energy is 1/2 sum_q w_q u(q) . k u(q) over the points q of the surface, with k = k_n n n^T + k_t (1 - n n^T) and u by the
//! weights of loads and clamps. u is linear on each cluster of the surface, so that its springs are one matrix of moments and one
//! tensor k; `Lift` takes them with what is held.

use super::surface_quadrature::{Cluster, SurfaceQuadrature};
use crate::error::InvalidInput;
use crate::setup::Foundation;
use crate::tensor::{Mat3, Vec3};
use nalgebra::Matrix4;

/// The springs of one foundation on a cluster.
#[derive(Clone, Copy, Debug)]
pub(super) struct Springs {
    /// sum_q w_q p p^T over the points in the region.
    pub moments: Matrix4<f64>,
    /// k (Pa/m).
    pub stiffness: Mat3,
    /// Area in the region.
    pub area: f64,
}

impl Springs {
    /// Projector on the directions that they hold.
    pub fn projector(&self, normal: &Vec3) -> Mat3 {
        let along = normal * normal.transpose();
        let holds = |part: &Mat3| if self.stiffness.dot(part) > 0.0 { *part } else { Mat3::zeros() };
        holds(&along) + holds(&(Mat3::identity() - along))
    }
}

/// Refuses foundations that hold nothing.
///
/// # Errors
/// `foundation[i]...`.
pub fn check(
    foundations: &[Foundation],
    surface: &SurfaceQuadrature,
    is_paper: bool,
) -> Result<(), InvalidInput> {
    for (i, foundation) in foundations.iter().enumerate() {
        let key = |word: &str| format!("foundation[{i}]{word}");
        if is_paper {
            let problem = "is not for the scheme of the paper";
            return Err(InvalidInput::new(key(""), "", problem, "take formulation = \"adjoint\""));
        }
        for (word, x) in [(".normal", foundation.normal), (".tangential", foundation.tangential)] {
            if !(x >= 0.0 && x.is_finite()) {
                let problem = "the stiffness (Pa/m) must be a number that is not negative";
                return Err(InvalidInput::new(key(word), x, problem, "springs push back: give 0 or more"));
            }
        }
        if foundation.normal == 0.0 && foundation.tangential == 0.0 {
            let problem = "there is no stiffness (Pa/m), neither along the normal nor across it";
            return Err(InvalidInput::new(
                key(".normal"),
                0.0,
                problem,
                "give one of the two, or remove the entry",
            ));
        }
        if !surface.rests_on(i) {
            let problem = "there is no free part of the surface in this region";
            let remedy = "check the region, its units and signs, and what boundaries hold";
            return Err(InvalidInput::new(key(".region"), "(this region)", problem, remedy));
        }
    }
    Ok(())
}

impl Foundation {
    /// Its springs on a cluster of `surface`, in those directions that no boundary holds; `None` where it has none. Its region is
    /// enlarged by `tolerance`.
    pub(super) fn on(
        &self,
        surface: &SurfaceQuadrature,
        cluster: &Cluster,
        tolerance: f64,
    ) -> Option<Springs> {
        let (mut moments, mut area) = (Matrix4::zeros(), 0.0);
        for k in cluster.panels.clone() {
            surface.three_points_of(k, |point| {
                if self.region.contains_on_surface(&point.x, &point.normal, tolerance) {
                    let p = cluster.monomials(&point.x);
                    moments += p * p.transpose() * point.area;
                    area += point.area;
                }
            });
        }
        let along = cluster.normal * cluster.normal.transpose();
        let free = Mat3::identity() - cluster.projector();
        let stiffness = along * self.normal + (Mat3::identity() - along) * self.tangential;
        let stiffness = free * stiffness * free;
        (area > 0.0 && stiffness.norm() > 0.0).then_some(Springs { moments, stiffness, area })
    }
}
