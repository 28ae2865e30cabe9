//! The 3 x 3 diagonal blocks of the stiffness K.

use crate::dynamics::elastic::Elastic;
use crate::moments::Moments;
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;

/// How the gradient of a particle c answers to a displacement du of particle a:
/// dG_c = du (x) `gradient` - (projector du) (x) `lifted`.
struct Response {
    particle: usize,
    /// V_a w X, X from c to a; its negative sum for c = a.
    first: Vec3,
    gradient: Vec3,
    lifted: Vec<(Vec3, Mat3)>,
}

/// d^2 E / du_a^2 of every particle: 2 E = sum_c V_c (sigma_c : e_c + kappa |residual|^2) with every held face
/// at rest, and the penalty of held faces.
pub fn diagonal_blocks(elastic: &Elastic) -> Vec<Mat3> {
    let (lattice, moments) = (&elastic.lattice, elastic.moments());
    (0..lattice.len())
        .into_par_iter()
        .map(|a| {
            let m = &moments[a];
            let mut responses: Vec<Response> = Vec::with_capacity(lattice.neighbours.len() + 1);
            let mut own = -(m.correction * m.first);
            if let Some(row) = elastic.correction_row(a) {
                own -= row.zeroth - row.gamma * m.zeroth - row.slope * m.first;
            }
            responses.push(Response { particle: a, first: -m.first, gradient: own, lifted: Vec::new() });
            let mut springs = m.volume * m.zeroth;
            for neighbour in &lattice.neighbours {
                if let Some(c) = lattice.neighbour(a, neighbour) {
                    let vw = m.volume * neighbour.w;
                    let x = -neighbour.x;
                    let mut gradient = moments[c].correction * x;
                    if let Some(row) = elastic.correction_row(c) {
                        gradient += elastic.gamma(a) - row.gamma - row.slope * x;
                    }
                    let (first, gradient) = (x * vw, gradient * vw);
                    responses.push(Response { particle: c, first, gradient, lifted: Vec::new() });
                    springs += moments[c].volume * vw;
                }
            }
            elastic.lift.responses(
                a,
                |b| moments[b].volume,
                |b, vector, projector| {
                    let at = responses.iter().position(|r| r.particle == b).unwrap_or_else(|| {
                        let (first, gradient) = (Vec3::zeros(), Vec3::zeros());
                        responses.push(Response { particle: b, first, gradient, lifted: Vec::new() });
                        responses.len() - 1
                    });
                    responses[at].lifted.push((vector, *projector));
                },
            );
            let mut block =
                Mat3::from_diagonal_element(springs * elastic.hourglass) + elastic.lift.penalty_block(a);
            for response in &responses {
                block += of_response(elastic, &moments[response.particle], response);
            }
            0.5 * (block + block.transpose())
        })
        .collect()
}

/// V dP(G_j) : G_i for the gradients G of unit displacements, less the part of the hourglass term that the gradient takes.
fn of_response(elastic: &Elastic, m: &Moments, response: &Response) -> Mat3 {
    let gradients: [Mat3; 3] = std::array::from_fn(|j| {
        let direction = Vec3::ith(j, 1.0);
        let mut gradient = direction * response.gradient.transpose();
        for (vector, projector) in &response.lifted {
            gradient -= projector.column(j) * vector.transpose();
        }
        gradient
    });
    let mut block = Mat3::zeros();
    for j in 0..3 {
        let change = elastic.stress_change(response.particle, &gradients[j]);
        for i in 0..3 {
            block[(i, j)] = m.volume * change.dot(&gradients[i]);
        }
    }
    let slope = elastic.hourglass * m.volume * response.first.dot(&(m.correction * response.first));
    block - Mat3::from_diagonal_element(slope)
}
