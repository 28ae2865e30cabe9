//! The 3 x 3 diagonal blocks of the stiffness K.

use crate::dynamics::elastic::Elastic;
use crate::moments::Moments;
use crate::tensor::{Mat3, SymTensor, Vec3};
use rayon::prelude::*;

/// How the gradient of particle c answers to a displacement of a: dG_c = e_i (x) column i.
type Response = (usize, Mat3);

/// d^2 E / du_a^2 of every particle: 2 E = sum_c V_c (sigma_c : e_c + kappa |residual|^2) with every wall
/// at rest.
pub fn diagonal_blocks(elastic: &Elastic) -> Vec<Mat3> {
    let (lattice, moments, mirror) = (&elastic.lattice, elastic.moments(), &elastic.mirror);
    (0..lattice.len())
        .into_par_iter()
        .map(|a| {
            let m = &moments[a];
            let mut responses: Vec<Response> = Vec::with_capacity(lattice.neighbours.len() + 1);
            // a itself, then the particles that see it, then those that see an image of it.
            responses.push((a, columns(&-m.first)));
            let mut springs = Mat3::from_diagonal_element(m.volume * m.zeroth);
            for neighbour in &lattice.neighbours {
                if let Some(c) = lattice.neighbour(a, neighbour) {
                    responses.push((c, columns(&(-neighbour.x * (m.volume * neighbour.w)))));
                    springs += Mat3::from_diagonal_element(moments[c].volume * m.volume * neighbour.w);
                }
            }
            for ghost in mirror.ghosts_of(a) {
                let c = ghost.partner as usize;
                // c sees the image of a at -R X.
                let seen = columns(&(-ghost.reflection.component_mul(&ghost.x) * (m.volume * ghost.w)))
                    * Mat3::from_diagonal(&ghost.sign);
                match responses.iter_mut().find(|(b, _)| *b == c) {
                    Some((_, sum)) => *sum += seen,
                    None => responses.push((c, seen)),
                }
                let own = if c == a { Vec3::repeat(1.0) - ghost.sign } else { Vec3::repeat(1.0) };
                let vw = m.volume * moments[c].volume * ghost.w;
                // As the centre it was counted with weight one in `zeroth`.
                springs += Mat3::from_diagonal(&(own.component_mul(&own) - Vec3::repeat(1.0))) * vw;
                if c != a {
                    springs += Mat3::from_diagonal_element(vw);
                }
            }
            let mut block = springs * elastic.hourglass;
            for (c, columns) in &responses {
                block += of_gradient(elastic, &moments[*c], columns);
            }
            0.5 * (block + block.transpose())
        })
        .collect()
}

/// The same vector for each component.
fn columns(v: &Vec3) -> Mat3 {
    Mat3::from_columns(&[*v, *v, *v])
}

/// V (sigma(sym e_j (x) g_j) g_i)_i - kappa V g_i M g_j delta_ij for the columns g = L x of the columns x.
fn of_gradient(elastic: &Elastic, m: &Moments, columns: &Mat3) -> Mat3 {
    let g = m.correction * columns;
    let mut block = Mat3::zeros();
    for j in 0..3 {
        let mut direction = Vec3::zeros();
        direction[j] = 1.0;
        let strain = SymTensor::symmetric_part(&(direction * g.column(j).transpose()));
        let sigma = elastic.material.stress(strain).to_matrix();
        for i in 0..3 {
            block[(i, j)] += m.volume * sigma.row(i).dot(&g.column(i).transpose());
        }
        block[(j, j)] -= elastic.hourglass * m.volume * g.column(j).dot(&columns.column(j));
    }
    block
}
