//! Elastic foundations: springs between a part of the surface and its surroundings.
//!
//! The energy is 1/2 sum_q w_q u(q) . k_q u(q) over the points q of the surface, with k_q = k_n n_q n_q^T + k_t (1 - n_q n_q^T) and u by
//! the weights of loads and clamps. u = r^T p is linear on each cluster of the surface, whose points may lie on several faces of the
//! body: its springs are one quadratic form of the coefficients r. `Lift` takes them with what is held.

use super::surface_quadrature::{Cluster, SurfaceQuadrature};
use crate::error::InvalidInput;
use crate::setup::Foundation;
use crate::tensor::Mat3;
use nalgebra::{Matrix4x3, SMatrix, Vector4};

/// The springs of one foundation on a cluster.
#[derive(Clone, Copy, Debug)]
pub(super) struct Springs {
    /// sum_q w_q k_q (x) p p^T over the points in the region, for r column by column.
    form: SMatrix<f64, 12, 12>,
    /// sum_q w_q k_q (N/m).
    pub stiffness: Mat3,
    /// Mean of the projectors on the directions that they hold.
    pub projector: Mat3,
}

impl Springs {
    /// Force over the monomials, sum_q w_q p (k_q r^T p)^T, of the coefficients r.
    pub fn force(&self, r: &Matrix4x3<f64>) -> Matrix4x3<f64> {
        let column = SMatrix::<f64, 12, 1>::from_column_slice(r.as_slice());
        Matrix4x3::from_column_slice((self.form * column).as_slice())
    }

    /// Stiffness between the components of a value that enters r by the coefficients `phi`.
    pub fn block(&self, phi: &Vector4<f64>) -> Mat3 {
        Mat3::from_fn(|i, j| phi.dot(&(self.form.fixed_view::<4, 4>(4 * i, 4 * j) * phi)))
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
        let free = Mat3::identity() - cluster.projector();
        let mut springs =
            Springs { form: SMatrix::zeros(), stiffness: Mat3::zeros(), projector: Mat3::zeros() };
        let mut area = 0.0;
        for k in cluster.panels.clone() {
            surface.three_points_of(k, |point| {
                if !self.region.contains_on_surface(&point.x, &point.normal, tolerance) {
                    return;
                }
                let along = point.normal * point.normal.transpose();
                let across = Mat3::identity() - along;
                let stiffness = free * (along * self.normal + across * self.tangential) * free;
                let p = cluster.monomials(&point.x);
                springs.form += (stiffness * point.area).kronecker(&(p * p.transpose()));
                springs.stiffness += stiffness * point.area;
                for (part, modulus) in [(along, self.normal), (across, self.tangential)] {
                    springs.projector += free * part * free * if modulus > 0.0 { point.area } else { 0.0 };
                }
                area += point.area;
            });
        }
        springs.projector /= area.max(f64::MIN_POSITIVE);
        (springs.stiffness.norm() > 0.0).then_some(springs)
    }
}
