//! What every load becomes: a force on each particle times a factor that depends on time.

use crate::setup::Ramp;
use crate::tensor::Vec3;

/// A pattern of forces on the particles with its course in time.
#[derive(Clone, Debug)]
pub struct NodalLoad {
    /// Force on each particle at factor 1, component by component (3 n values).
    pub force: Vec<f64>,
    /// The factor.
    pub ramp: Ramp,
}

impl NodalLoad {
    /// Sum of all loads at time `t` into `total`.
    pub fn sum(loads: &[Self], t: f64, total: &mut [f64]) {
        total.fill(0.0);
        for load in loads {
            let factor = load.ramp.at(t);
            if factor != 0.0 {
                for (sum, f) in total.iter_mut().zip(&load.force) {
                    *sum += factor * f;
                }
            }
        }
    }

    /// Total force at factor 1.
    pub fn total(&self) -> Vec3 {
        let n = self.force.len() / 3;
        Vec3::from_fn(|i, _| self.force[i * n..(i + 1) * n].iter().sum())
    }
}
