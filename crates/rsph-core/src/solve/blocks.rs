//! The 3 x 3 diagonal blocks of the stiffness K.

use crate::dynamics::solid::Solid;
use crate::lattice::reflection;
use crate::moments::Moments;
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;

/// How the gradient of a particle c answers to a displacement du of particle a and of its images:
/// dG_c = sum du_i e_i (x) `gradient`_i - (projector du) (x) `lifted`.
struct Response {
    particle: usize,
    /// V_a w X, X from c to a; its negative sum for c = a; row i for du_i.
    first: Mat3,
    gradient: Mat3,
    lifted: Vec<(Vec3, Mat3)>,
}

/// d^2 E / du_a^2 of every particle: 2 E = sum_c V_c (sigma_c : e_c + kappa |residual|^2) with every held face
/// at rest, and the penalty of held faces.
pub fn diagonal_blocks(solid: &Solid) -> Vec<Mat3> {
    let (lattice, moments) = (&solid.lattice, solid.moments());
    let signs = &solid.lift.folds.following.signs;
    (0..lattice.len())
        .into_par_iter()
        .map(|a| {
            let m = &moments[a];
            let mut responses: Vec<Response> = Vec::with_capacity(lattice.neighbours.len() + 1);
            let mut respond = |particle: usize, signs: &Vec3, first: Vec3, gradient: Vec3| {
                let (first, gradient) = (signs * first.transpose(), signs * gradient.transpose());
                let mut before = responses.iter_mut();
                match before.find(|r| !lattice.images.is_empty() && r.particle == particle) {
                    Some(r) => (r.first, r.gradient) = (r.first + first, r.gradient + gradient),
                    None => responses.push(Response { particle, first, gradient, lifted: Vec::new() }),
                }
            };
            let mut own = -(m.correction * m.first);
            if let Some(row) = solid.correction_row(a) {
                own -= row.zeroth - row.gamma * m.zeroth - row.slope * m.first;
            }
            respond(a, &Vec3::repeat(1.0), -m.first, own);
            let modulus = solid.modulus(a);
            let mut springs = Vec3::repeat(m.volume * m.zeroth * modulus);
            for neighbour in &lattice.neighbours {
                if let Some(seen) = lattice.seen(a, neighbour) {
                    let (c, signs) = (seen.particle, &signs[seen.mirrors as usize]);
                    let vw = m.volume * neighbour.w;
                    let mirror = reflection(seen.mirrors);
                    let x = -neighbour.x.component_mul(&mirror);
                    let mut gradient = moments[c].correction * x;
                    if let Some(row) = solid.correction_row(c) {
                        gradient += solid.gamma(a).component_mul(&mirror) - row.gamma - row.slope * x;
                    }
                    respond(c, signs, x * vw, gradient * vw);
                    springs.add_scalar_mut(moments[c].volume * vw * solid.modulus(c));
                    if c == a {
                        // It moves with its image, or against it.
                        springs -= signs * (2.0 * m.volume * vw * modulus);
                    }
                }
            }
            solid.lift.responses(
                a,
                |b| moments[b].volume,
                |b, vector, projector| {
                    let at = responses.iter().position(|r| r.particle == b).unwrap_or_else(|| {
                        let (first, gradient) = (Mat3::zeros(), Mat3::zeros());
                        responses.push(Response { particle: b, first, gradient, lifted: Vec::new() });
                        responses.len() - 1
                    });
                    responses[at].lifted.push((vector, *projector));
                },
            );
            let mut block = Mat3::from_diagonal(&(springs * solid.hourglass)) + solid.lift.penalty_block(a);
            for response in &responses {
                block += of_response(solid, &moments[response.particle], response);
            }
            0.5 * (block + block.transpose())
        })
        .collect()
}

/// V dP(G_j) : G_i for the gradients G of unit displacements, less the part of the hourglass term that the gradient takes.
fn of_response(solid: &Solid, m: &Moments, response: &Response) -> Mat3 {
    let gradients: [Mat3; 3] = std::array::from_fn(|j| {
        let direction = Vec3::ith(j, 1.0);
        let mut gradient = direction * response.gradient.row(j);
        for (vector, projector) in &response.lifted {
            gradient -= projector.column(j) * vector.transpose();
        }
        gradient
    });
    let mut block = Mat3::zeros();
    for j in 0..3 {
        let change = solid.stress_change(response.particle, &gradients[j]);
        for i in 0..3 {
            block[(i, j)] = m.volume * change.dot(&gradients[i]);
        }
    }
    let slope =
        Vec3::from_fn(|i, _| (response.first.row(i) * m.correction * response.first.row(i).transpose())[0]);
    block - Mat3::from_diagonal(&(slope * (solid.hourglass * solid.modulus(response.particle) * m.volume)))
}
