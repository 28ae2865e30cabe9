//! Fields that a body carries, found at the nodes of the lattice that it has moved over.
//!
//! Particles that started at nodes xi make a smooth map x(xi) until the next remesh. For a new node x
//! the map is inverted, and what is carried is interpolated on the *undisturbed* lattice at xi: with the
//! kernel's full order, for any displacement, and without any change where nothing has moved. Outside of
//! the body the map is continued along straight lines through its nodes.

use super::gather::gather;
use super::nodes::{NodeLattice, NodeValues};
use super::{LONGEST_ROW, RemeshError};
use crate::kernel::RemeshKernel;
use crate::tensor::Vec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Rounds of the inversion x = xi + shift(xi); each shrinks the error by the strain since the last remesh.
const ROUNDS: usize = 60;
/// Error of the inversion that is good enough, in spacings.
const CONVERGED: f64 = 1e-12;
/// Error beyond which a node counts as not reached.
const ACCEPTED: f64 = 1e-6;

/// Index of a node.
type Node = [i64; 3];

/// What particles carry that started at nodes of a lattice.
#[derive(Clone, Copy, Debug)]
pub struct Carried<'a, const D: usize> {
    /// The lattice.
    pub lattice: NodeLattice<D>,
    /// The node where each particle started, sorted by z, y, x.
    pub nodes: &'a [Node],
    /// How far each has moved.
    pub shift: &'a [Vec3],
    /// Values a particle.
    pub columns: usize,
    /// Values, particle by particle.
    pub values: &'a [f64],
}

/// What is carried, at the nodes in and around the moved body.
#[derive(Clone, Debug)]
pub struct Arrived {
    /// Nodes, sorted by z, y, x.
    pub nodes: Vec<Node>,
    /// Values, node by node.
    pub values: Vec<f64>,
}

impl<const D: usize> Carried<'_, D> {
    /// The values at all nodes within about a spacing of the moved particles, with `kernel`.
    ///
    /// # Errors
    /// Particles that no lattice holds.
    pub fn follow(&self, kernel: RemeshKernel) -> Result<Arrived, RemeshError> {
        let field = self.continued(kernel.reach() + 1)?;
        let (targets, mut xi) = self.targets()?;
        let x: Vec<Vec3> = targets.iter().map(|n| self.lattice.position(*n)).collect();
        let columns = field.columns;
        let (mut values, mut error) = (Vec::new(), vec![f64::INFINITY; x.len()]);
        for _ in 0..ROUNDS {
            values = gather(kernel, &field, &xi);
            xi.par_iter_mut().zip(&x).zip(&mut error).zip(values.par_chunks(columns)).for_each(
                |(((xi, x), error), value)| {
                    let next = x - Vec3::from_fn(|i, _| value[1 + i]);
                    *error = (next - *xi).norm() / self.lattice.spacing;
                    *xi = next;
                },
            );
            if error.iter().all(|e| *e < CONVERGED || !e.is_finite()) {
                break;
            }
        }
        // Where the nodes around xi are not all there, their weights do not sum to 1.
        let reached = |n: &usize| error[*n] < ACCEPTED && (values[n * columns] - 1.0).abs() < 1e-9;
        let reached: Vec<usize> = (0..x.len()).filter(reached).collect();
        Ok(Arrived {
            nodes: reached.iter().map(|&n| targets[n]).collect(),
            values: reached
                .iter()
                .flat_map(|&n| &values[n * columns + 4..(n + 1) * columns])
                .copied()
                .collect(),
        })
    }

    /// Columns 1, shift, values at the nodes of the particles and, continued, `layers` around them.
    fn continued(&self, layers: usize) -> Result<NodeValues<D>, RemeshError> {
        let columns = 4 + self.columns;
        let mut known: BTreeMap<(i64, i64, i64), Vec<f64>> = BTreeMap::new();
        for (a, [x, y, z]) in self.nodes.iter().enumerate() {
            let mut row = Vec::with_capacity(columns);
            row.push(1.0);
            row.extend_from_slice(self.shift[a].as_slice());
            row.extend_from_slice(&self.values[a * self.columns..(a + 1) * self.columns]);
            known.insert((*z, *y, *x), row);
        }
        let around = offsets::<D>(1);
        let mut front: Vec<(i64, i64, i64)> = known.keys().copied().collect();
        for _ in 0..layers {
            let next: BTreeSet<(i64, i64, i64)> = front
                .iter()
                .flat_map(|n| around.iter().map(move |d| plus(*n, *d, 1)))
                .filter(|n| !known.contains_key(n))
                .collect();
            front = next.into_iter().collect();
            let values: Vec<Vec<f64>> = front.par_iter().map(|n| continuation(&known, &around, *n)).collect();
            known.extend(front.iter().copied().zip(values));
        }
        let nodes: Vec<Node> = known.keys().map(|(z, y, x)| [*x, *y, *z]).collect();
        let values: Vec<f64> = known.into_values().flatten().collect();
        NodeValues::from_nodes(self.lattice, &nodes, columns, &values)
    }

    /// The nodes around the moved particles, each with a guess of where it was on the lattice.
    fn targets(&self) -> Result<(Vec<Node>, Vec<Vec3>), RemeshError> {
        let mut found: Vec<((i64, i64, i64), f64, usize)> = Vec::new();
        let around: Vec<_> = offsets::<D>(2).into_iter().chain([(0, 0, 0)]).collect();
        for (a, node) in self.nodes.iter().enumerate() {
            let position = self.lattice.position(*node) + self.shift[a];
            let lost = RemeshError::Lost { particle: a, position };
            let ([x, y, z], _) = self.lattice.locate(&position).ok_or(lost)?;
            for d in around.iter().filter(|d| d.0 > -2 && d.1 > -2 && d.2 > -2) {
                let (z, y, x) = plus((z, y, x), *d, 1);
                let distance = (self.lattice.position([x, y, z]) - position).norm();
                found.push(((z, y, x), distance, a));
            }
        }
        found.par_sort_unstable_by(|p, q| p.0.cmp(&q.0).then(p.1.total_cmp(&q.1)).then(p.2.cmp(&q.2)));
        found.dedup_by_key(|f| f.0);
        for row in found.chunk_by(|p, q| (p.0.0, p.0.1) == (q.0.0, q.0.1)) {
            let length = row[row.len() - 1].0.2 - row[0].0.2;
            if length > LONGEST_ROW {
                return Err(RemeshError::TooFar(length));
            }
        }
        Ok(found
            .into_iter()
            .map(|((z, y, x), _, a)| ([x, y, z], self.lattice.position([x, y, z]) - self.shift[a]))
            .unzip())
    }
}

/// The value at a node from pairs of known nodes in line with it, 2 f(1) - f(2), nearer ones more; where
/// there is no pair, the mean of the known nodes beside it.
fn continuation(
    known: &BTreeMap<(i64, i64, i64), Vec<f64>>,
    around: &[(i64, i64, i64)],
    node: (i64, i64, i64),
) -> Vec<f64> {
    let mean = |straight: bool| {
        let (mut sum, mut total) = (Vec::new(), 0.0);
        for d in around {
            let Some(one) = known.get(&plus(node, *d, 1)) else { continue };
            let two = known.get(&plus(node, *d, 2));
            if straight && two.is_none() {
                continue;
            }
            let weight = 1.0 / (d.0 * d.0 + d.1 * d.1 + d.2 * d.2) as f64;
            total += weight;
            sum.resize(one.len(), 0.0);
            for (c, sum) in sum.iter_mut().enumerate() {
                *sum += weight * two.filter(|_| straight).map_or(one[c], |two| 2.0 * one[c] - two[c]);
            }
        }
        sum.iter_mut().for_each(|s| *s /= total);
        (total > 0.0).then_some(sum)
    };
    mean(true).or_else(|| mean(false)).unwrap_or_default()
}

fn plus(n: (i64, i64, i64), d: (i64, i64, i64), times: i64) -> (i64, i64, i64) {
    (n.0 + times * d.0, n.1 + times * d.1, n.2 + times * d.2)
}

/// Offsets (z, y, x) up to `reach` along each axis that is there, but for (0, 0, 0).
fn offsets<const D: usize>(reach: i64) -> Vec<(i64, i64, i64)> {
    let range = |axis: usize| if axis < D { -reach..=reach } else { 0..=0 };
    range(2)
        .flat_map(|z| range(1).flat_map(move |y| range(0).map(move |x| (z, y, x))))
        .filter(|d| *d != (0, 0, 0))
        .collect()
}
