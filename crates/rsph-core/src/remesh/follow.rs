//! Fields that a body carries, found at the nodes of the lattice that it has moved over.
//!
//! Particles that started at nodes xi make a smooth map x(xi) until the next remesh. For a new node x
//! the map is inverted, and what is carried is interpolated on the *undisturbed* lattice at xi: with the
//! kernel's full order, for any displacement, and without any change where nothing has moved. Outside of
//! the body the map is continued along straight lines through its nodes.

use super::gather::{gather, with_slopes};
use super::nodes::{NodeLattice, NodeValues};
use super::{LONGEST_ROW, RemeshError};
use crate::kernel::RemeshKernel;
use crate::tensor::{Mat3, Vec3};
use nalgebra::SVector;
use rayon::prelude::*;

/// Steps of Newton's method for x = xi + shift(xi), and after how many of them steps are halved: the kernel's second
/// derivatives may jump.
const STEPS: usize = 40;
/// See [`STEPS`].
const WHOLE_STEPS: usize = 10;
/// Longest step, in spacings.
const LONGEST_STEP: f64 = 1.0;
/// Residual of the inversion that is good enough, in spacings.
const CONVERGED: f64 = 1e-13;
/// Residual beyond which a node counts as not reached.
const ACCEPTED: f64 = 1e-8;

/// Layers of continued values beyond the reach of the kernel.
const LAYERS: usize = 2;
/// Most places of the box around the nodes.
const MOST_PLACES: usize = 1 << 28;

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
    /// Values a particle, three or more.
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
    /// Gradients, where the body is now, of the vector that the first three values are.
    pub gradients: Vec<Mat3>,
}

impl<const D: usize> Carried<'_, D> {
    /// The values at all nodes within about a spacing of the moved particles, with `kernel`.
    ///
    /// # Errors
    /// Particles that no lattice holds.
    pub fn follow(&self, kernel: RemeshKernel) -> Result<Arrived, RemeshError> {
        let field = self.continued(kernel.reach() + LAYERS)?;
        let (targets, guesses) = self.targets()?;
        let starts: Vec<Option<Vec3>> = targets
            .par_iter()
            .zip(&guesses)
            .map(|(target, guess)| start_of(kernel, &field, &self.lattice.position(*target), guess))
            .collect();
        let reached = || targets.iter().zip(&starts).filter_map(|(node, xi)| Some((*node, (*xi)?)));
        let xi: Vec<Vec3> = reached().map(|(_, xi)| xi).collect();
        let values = gather(kernel, &field, &xi);
        let carried = values.chunks(field.columns).flat_map(|row| &row[4..]).copied();
        let gradient = |xi: &Vec3| {
            let (_, slopes) = with_slopes::<D, 7>(kernel, &field, xi);
            let of = |first: usize| {
                let column = |v: &SVector<f64, 7>| Vec3::new(v[first], v[first + 1], v[first + 2]);
                Mat3::from_columns(&slopes.each_ref().map(column))
            };
            let motion = Mat3::identity() + of(1);
            motion.try_inverse().map_or_else(Mat3::zeros, |inverse| of(4) * inverse)
        };
        Ok(Arrived {
            nodes: reached().map(|(node, _)| node).collect(),
            values: carried.collect(),
            gradients: xi.par_iter().map(gradient).collect(),
        })
    }

    /// Columns 1, shift, values at the nodes of the particles and, continued, `layers` around them.
    fn continued(&self, layers: usize) -> Result<NodeValues<D>, RemeshError> {
        let mut known = Known::new::<D>(self, layers)?;
        let around = offsets::<D>(1);
        let mut front: Vec<usize> = known.place.clone();
        for _ in 0..layers {
            let mut next: Vec<usize> = front
                .iter()
                .flat_map(|p| around.iter().map(|d| p.wrapping_add_signed(known.stride(d))))
                .filter(|p| known.slot[*p] == UNKNOWN)
                .collect();
            next.par_sort_unstable();
            next.dedup();
            let values: Vec<Vec<f64>> =
                next.par_iter().map(|p| known.continuation(*p, &around).unwrap_or_default()).collect();
            for (p, value) in next.iter().zip(values) {
                known.add(*p, &value);
            }
            front = next;
        }
        // By z, y, x.
        let mut order: Vec<u32> = (0..known.place.len() as u32).collect();
        order.par_sort_unstable_by_key(|k| known.place[*k as usize]);
        let nodes: Vec<Node> = order.iter().map(|k| known.node(known.place[*k as usize])).collect();
        let columns = known.columns;
        let row = |k: &u32| &known.values[*k as usize * columns..(*k as usize + 1) * columns];
        let values: Vec<f64> = order.iter().flat_map(row).copied().collect();
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
                let (z, y, x) = plus((z, y, x), *d);
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

/// Where on the lattice what is now at `x` started, by Newton's method from a guess; `None` where the continued map does not
/// reach.
fn start_of<const D: usize>(
    kernel: RemeshKernel,
    field: &NodeValues<D>,
    x: &Vec3,
    guess: &Vec3,
) -> Option<Vec3> {
    let spacing = field.lattice.spacing;
    let mut xi = *guess;
    let mut best = (f64::INFINITY, xi);
    let mut last = Vec3::zeros();
    for step in 0..STEPS {
        let (value, slopes) = with_slopes::<D, 4>(kernel, field, &xi);
        // Where the nodes around xi are not all there, their weights do not sum to 1, or not beside it: back half way.
        let slope_of_sum = slopes.iter().map(|slope| slope[0].abs()).fold(0.0, f64::max);
        if (value[0] - 1.0).abs() > 1e-12 || slope_of_sum * spacing > 1e-10 {
            last *= -0.5;
            if step == 0 || last.norm() < 1e-3 * spacing {
                break;
            }
            xi += last;
            last = -last;
            continue;
        }
        let shift = |v: &SVector<f64, 4>| Vec3::new(v[1], v[2], v[3]);
        let residual = x - xi - shift(&value);
        if residual.norm() < best.0 {
            best = (residual.norm(), xi);
        }
        if residual.norm() < CONVERGED * spacing {
            break;
        }
        let motion = Mat3::identity() + Mat3::from_columns(&slopes.each_ref().map(shift));
        let whole = motion.try_inverse().unwrap_or_else(Mat3::identity) * residual;
        let length = (LONGEST_STEP * spacing / whole.norm()).min(if step < WHOLE_STEPS { 1.0 } else { 0.5 });
        last = whole * length;
        xi += last;
    }
    (best.0 < ACCEPTED * spacing).then_some(best.1)
}

/// Marks a place where nothing is known.
const UNKNOWN: u32 = u32::MAX;

/// Nodes where values are known, in a box around them.
struct Known {
    low: Node,
    size: [usize; 3],
    /// Number of the node at each place of the box, x fastest.
    slot: Vec<u32>,
    /// Place of each node.
    place: Vec<usize>,
    columns: usize,
    values: Vec<f64>,
}

impl Known {
    /// The nodes of the particles, in a box with two places more than `layers` around them.
    fn new<const D: usize>(carried: &Carried<'_, D>, layers: usize) -> Result<Self, RemeshError> {
        let margin = |i: usize| if i < D { layers as i64 + 2 } else { 0 };
        let nodes = carried.nodes;
        let low = std::array::from_fn(|i| nodes.iter().map(|n| n[i]).min().unwrap_or(0) - margin(i));
        let high: Node = std::array::from_fn(|i| nodes.iter().map(|n| n[i]).max().unwrap_or(0) + margin(i));
        let size: [usize; 3] = std::array::from_fn(|i| (high[i] - low[i] + 1) as usize);
        let places = size.iter().try_fold(1_usize, |p, n| p.checked_mul(*n)).filter(|p| *p <= MOST_PLACES);
        let widest = (0..3).map(|i| high[i] - low[i]).max().unwrap_or(0);
        let slot = vec![UNKNOWN; places.ok_or(RemeshError::TooFar(widest))?];
        let columns = 4 + carried.columns;
        let mut known = Self { low, size, slot, place: Vec::new(), columns, values: Vec::new() };
        let mut row = vec![1.0; columns];
        for (a, n) in nodes.iter().enumerate() {
            row[1..4].copy_from_slice(carried.shift[a].as_slice());
            row[4..].copy_from_slice(&carried.values[a * carried.columns..(a + 1) * carried.columns]);
            let [x, y, z]: [usize; 3] = std::array::from_fn(|i| (n[i] - low[i]) as usize);
            known.add((z * size[1] + y) * size[0] + x, &row);
        }
        Ok(known)
    }

    fn add(&mut self, place: usize, values: &[f64]) {
        self.slot[place] = self.place.len() as u32;
        self.place.push(place);
        self.values.extend_from_slice(values);
    }

    fn node(&self, place: usize) -> Node {
        let [nx, ny, _] = self.size;
        let n = [place % nx, place / nx % ny, place / nx / ny];
        std::array::from_fn(|i| n[i] as i64 + self.low[i])
    }

    fn stride(&self, (z, y, x): &(i64, i64, i64)) -> isize {
        ((z * self.size[1] as i64 + y) * self.size[0] as i64 + x) as isize
    }

    fn at(&self, place: usize) -> Option<&[f64]> {
        let k = self.slot[place];
        (k != UNKNOWN).then(|| &self.values[k as usize * self.columns..(k as usize + 1) * self.columns])
    }

    /// The value at a place from pairs of known nodes in line with it, 2 f(1) - f(2), nearer ones more;
    /// where there is no pair, the mean of the known nodes beside it.
    fn continuation(&self, place: usize, around: &[(i64, i64, i64)]) -> Option<Vec<f64>> {
        let mean = |straight: bool| {
            let (mut sum, mut total) = (vec![0.0; self.columns], 0.0);
            for d in around {
                let step = self.stride(d);
                let Some(one) = self.at(place.wrapping_add_signed(step)) else { continue };
                let two = self.at(place.wrapping_add_signed(2 * step)).filter(|_| straight);
                if straight && two.is_none() {
                    continue;
                }
                let weight = 1.0 / (d.0 * d.0 + d.1 * d.1 + d.2 * d.2) as f64;
                total += weight;
                for (c, sum) in sum.iter_mut().enumerate() {
                    *sum += weight * two.map_or(one[c], |two| 2.0 * one[c] - two[c]);
                }
            }
            for s in &mut sum {
                *s /= total;
            }
            (total > 0.0).then_some(sum)
        };
        mean(true).or_else(|| mean(false))
    }
}

fn plus(n: (i64, i64, i64), d: (i64, i64, i64)) -> (i64, i64, i64) {
    (n.0 + d.0, n.1 + d.1, n.2 + d.2)
}

/// Offsets (z, y, x) up to `reach` along each axis that is there, but for (0, 0, 0).
fn offsets<const D: usize>(reach: i64) -> Vec<(i64, i64, i64)> {
    let range = |axis: usize| if axis < D { -reach..=reach } else { 0..=0 };
    range(2)
        .flat_map(|z| range(1).flat_map(move |y| range(0).map(move |x| (z, y, x))))
        .filter(|d| *d != (0, 0, 0))
        .collect()
}
