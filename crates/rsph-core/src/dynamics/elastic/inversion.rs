//! Whether a part of the body is turned inside out: det F <= 0, where F = 1 + grad u. Equations of small strain do
//! not notice.

use super::Elastic;
use super::sweeps::undeformed;
use crate::ops::PAIR_COMPONENTS;
use crate::tensor::Mat3;

impl Elastic {
    /// The smallest det F, and the particle that has it, at time `t` with the displacement `u`.
    pub fn smallest_jacobian(&mut self, t: f64, u: &[f64]) -> Option<(usize, f64)> {
        self.lift.set_targets(|m| m.displacement(t), |m| m.velocity(t));
        self.spread(u, None);
        self.visit_sums(|body, a, sums, _| {
            let g = undeformed(body.stretch, a, &sums.gradient);
            let mut out = [0.0; PAIR_COMPONENTS];
            out[0] = (Mat3::identity() + g).determinant();
            out
        });
        let jacobian = |a: usize| {
            let (tile, lane) = self.lattice.tiles.place(a);
            self.work.pair[tile * PAIR_COMPONENTS].0[lane]
        };
        (0..self.len()).map(|a| (a, jacobian(a))).min_by(|p, q| p.1.total_cmp(&q.1))
    }
}
