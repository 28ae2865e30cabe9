//! A coarse level: a symmetric matrix of 3 x 3 blocks between the nodes of a regular grid, 27 at most
//! for a node, its Chebyshev smoother and its coarsening. Fields are node by node, x y z.

use super::spectrum::largest_eigenvalue;
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Marks a node that is not there.
pub const NO_NODE: u32 = u32::MAX;
/// Nodes that one task works on.
const NODES_A_TASK: usize = 256;
/// The smoother damps the part of the spectrum above the largest eigenvalue divided by this.
pub const SMOOTHED: f64 = 6.0;
/// Steps of the iteration for the largest eigenvalue, and the margin for what they miss.
pub const LANCZOS_STEPS: usize = 15;
/// See [`LANCZOS_STEPS`].
pub const LANCZOS_MARGIN: f64 = 1.05;

/// A coarse level with its work space.
#[derive(Clone, Debug)]
pub struct Level {
    coordinates: Vec<[i32; 3]>,
    neighbours: Vec<[u32; 27]>,
    blocks: Vec<[[f32; 9]; 27]>,
    /// Mass of each component, zero where it is held.
    mass: Vec<f64>,
    inverse: Vec<Mat3>,
    scales: (f64, f64),
    largest: f64,
    /// Solution.
    pub x: Vec<f64>,
    /// Right-hand side.
    pub b: Vec<f64>,
    r: Vec<f64>,
    d: Vec<f64>,
}

/// From the nodes of a level to those of the next coarser one.
#[derive(Clone, Debug)]
pub struct Coarsening {
    parents: Vec<[u32; 8]>,
    children: Vec<[u32; 27]>,
}

/// Offset of slot `s` of the 27 around a node.
fn offset(s: usize) -> [i32; 3] {
    [s as i32 % 3 - 1, s as i32 / 3 % 3 - 1, s as i32 / 9 - 1]
}

/// Slot of an offset.
pub fn slot(o: [i32; 3]) -> usize {
    ((o[2] + 1) * 9 + (o[1] + 1) * 3 + o[0] + 1) as usize
}

/// Which node stands at which coordinates.
#[derive(Clone, Debug)]
pub struct NodeMap {
    size: [i32; 3],
    node_at: Vec<u32>,
    /// Coordinates of every node, x fastest.
    pub coordinates: Vec<[i32; 3]>,
}

impl NodeMap {
    /// Nodes at these coordinates (none negative), each named as often as one likes.
    pub fn new(places: impl Iterator<Item = [i32; 3]> + Clone) -> Self {
        let size = places.clone().fold([0; 3], |m: [i32; 3], c| std::array::from_fn(|i| m[i].max(c[i] + 1)));
        let mut map = Self {
            size,
            node_at: vec![NO_NODE; size.iter().map(|&s| s as usize).product()],
            coordinates: Vec::new(),
        };
        for c in places {
            let at = map.index(c);
            map.node_at[at] = 0;
        }
        for k in 0..size[2] {
            for j in 0..size[1] {
                for i in 0..size[0] {
                    let at = map.index([i, j, k]);
                    if map.node_at[at] != NO_NODE {
                        map.node_at[at] = map.coordinates.len() as u32;
                        map.coordinates.push([i, j, k]);
                    }
                }
            }
        }
        map
    }

    fn index(&self, c: [i32; 3]) -> usize {
        ((c[2] * self.size[1] + c[1]) * self.size[0] + c[0]) as usize
    }

    /// The node at `c`, or [`NO_NODE`].
    pub fn node(&self, c: [i32; 3]) -> u32 {
        if (0..3).all(|i| (0..self.size[i]).contains(&c[i])) { self.node_at[self.index(c)] } else { NO_NODE }
    }

    /// The 27 nodes around each node.
    fn neighbours(&self) -> Vec<[u32; 27]> {
        let around = |c: &[i32; 3]| {
            std::array::from_fn(|s| {
                let o = offset(s);
                self.node(std::array::from_fn(|i| c[i] + o[i]))
            })
        };
        self.coordinates.iter().map(around).collect()
    }
}

impl Level {
    /// A level whose node I has the blocks `rows(I)`, by slot, and the component masses `mass`.
    pub fn new(map: &NodeMap, rows: impl Fn(usize) -> [Mat3; 27] + Sync, mass: Vec<f64>) -> Self {
        let blocks = (0..map.coordinates.len())
            .into_par_iter()
            .map(|node| rows(node).map(|b| std::array::from_fn(|k| b[(k / 3, k % 3)] as f32)))
            .collect();
        let zeros = || vec![0.0; mass.len()];
        let mut level = Self {
            neighbours: map.neighbours(),
            coordinates: map.coordinates.clone(),
            blocks,
            inverse: Vec::new(),
            scales: (0.0, 1.0),
            largest: 1.0,
            x: zeros(),
            b: zeros(),
            r: zeros(),
            d: zeros(),
            mass,
        };
        level.set_scales(0.0, 1.0);
        level.estimate_largest();
        level
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.coordinates.len()
    }

    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.coordinates.is_empty()
    }

    /// Makes it the matrix m M + c K.
    pub fn set_scales(&mut self, mass: f64, stiffness: f64) {
        self.scales = (mass, stiffness);
        self.inverse = (0..self.len())
            .into_par_iter()
            .map(|node| {
                let block = &self.blocks[node][13];
                let mut d = Mat3::from_fn(|i, j| stiffness * f64::from(block[3 * i + j]));
                for i in 0..3 {
                    d[(i, i)] += mass * self.mass[3 * node + i];
                }
                inverse_of_diagonal(d)
            })
            .collect();
    }

    /// Largest eigenvalue of D^-1 K, an upper bound for that of (m M + c D)^-1 (m M + c K).
    fn estimate_largest(&mut self) {
        let mut work = self.clone();
        let inverse = &self.inverse;
        let mut divide = |r: &[f64], z: &mut [f64]| {
            for (node, z) in z.chunks_mut(3).enumerate() {
                let r = Vec3::from_column_slice(&r[3 * node..3 * node + 3]);
                z.copy_from_slice((inverse[node] * r).as_slice());
            }
        };
        let mut apply = |x: &[f64], y: &mut [f64]| {
            work.x.copy_from_slice(x);
            work.residual();
            y.iter_mut().zip(&work.r).for_each(|(y, r)| *y = -r);
        };
        let found = largest_eigenvalue(3 * self.len(), LANCZOS_STEPS, &mut apply, &mut divide);
        self.largest = if found > 0.0 { LANCZOS_MARGIN * found } else { 1.0 };
    }

    /// Calls `visit(row, column, value)` for every entry of the matrix.
    pub fn for_each_entry(&self, mut visit: impl FnMut(usize, usize, f64)) {
        let (m, c) = self.scales;
        for (node, (neighbours, blocks)) in self.neighbours.iter().zip(&self.blocks).enumerate() {
            for (j, block) in neighbours.iter().zip(blocks).filter(|(j, _)| **j != NO_NODE) {
                for (k, value) in block.iter().enumerate() {
                    visit(3 * node + k / 3, 3 * *j as usize + k % 3, c * f64::from(*value));
                }
            }
            for i in 0..3 {
                visit(3 * node + i, 3 * node + i, m * self.mass[3 * node + i]);
            }
        }
    }

    /// r = b - A x, zero in components without stiffness.
    fn residual(&mut self) {
        let Self { neighbours, blocks, mass, inverse, scales: (m, c), x, b, r, .. } = self;
        r.par_chunks_mut(3).with_min_len(NODES_A_TASK).enumerate().for_each(|(node, r)| {
            let mut sum = [0.0; 3];
            for (&j, a) in neighbours[node].iter().zip(&blocks[node]) {
                if j != NO_NODE {
                    let x = &x[3 * j as usize..3 * j as usize + 3];
                    for i in 0..3 {
                        sum[i] += f64::from(a[3 * i]) * x[0]
                            + f64::from(a[3 * i + 1]) * x[1]
                            + f64::from(a[3 * i + 2]) * x[2];
                    }
                }
            }
            for i in 0..3 {
                let at = 3 * node + i;
                let held = inverse[node][(i, i)] == 0.0;
                r[i] = if held { 0.0 } else { b[at] - *c * sum[i] - *m * mass[at] * x[at] };
            }
        });
    }

    /// d = p d + q D^-1 r, x += d
    fn correct(&mut self, p: f64, q: f64) {
        let Self { inverse, x, r, d, .. } = self;
        (x.par_chunks_mut(3), d.par_chunks_mut(3), r.par_chunks(3), &*inverse)
            .into_par_iter()
            .with_min_len(4 * NODES_A_TASK)
            .for_each(|(x, d, r, inverse)| {
                let z = inverse * Vec3::new(r[0], r[1], r[2]);
                for i in 0..3 {
                    d[i] = p * d[i] + q * z[i];
                    x[i] += d[i];
                }
            });
    }

    /// Two Chebyshev steps of the block Jacobi iteration; `from_zero`: x counts as zero.
    pub fn smooth(&mut self, from_zero: bool) {
        let (high, low) = (self.largest, self.largest / SMOOTHED);
        let (middle, half) = (0.5 * (high + low), 0.5 * (high - low));
        if from_zero {
            self.x.fill(0.0);
            self.r.copy_from_slice(&self.b);
        } else {
            self.residual();
        }
        self.correct(0.0, 1.0 / middle);
        self.residual();
        let rho = half / middle;
        let next = 1.0 / (2.0 / rho - rho);
        self.correct(next * rho, 2.0 * next / half);
    }

    /// b of the coarser level = P^T (b - A x) of this one.
    pub fn restrict(&mut self, coarsening: &Coarsening, coarse: &mut [f64]) {
        self.residual();
        let r = &self.r;
        coarse.par_chunks_mut(3).with_min_len(NODES_A_TASK).zip(&coarsening.children).for_each(
            |(b, children)| {
                b.fill(0.0);
                for (s, &child) in children.iter().enumerate().filter(|(_, c)| **c != NO_NODE) {
                    for i in 0..3 {
                        b[i] += weight(s) * r[3 * child as usize + i];
                    }
                }
            },
        );
    }

    /// x += P x of the coarser level, in components that have stiffness.
    pub fn prolong(&mut self, coarsening: &Coarsening, coarse: &[f64]) {
        let inverse = &self.inverse;
        (self.x.par_chunks_mut(3), &coarsening.parents)
            .into_par_iter()
            .with_min_len(NODES_A_TASK)
            .enumerate()
            .for_each(|(node, (x, parents))| {
                let there = parents.iter().filter(|p| **p != NO_NODE);
                let share = 1.0 / there.clone().count() as f64;
                for i in (0..3).filter(|&i| inverse[node][(i, i)] != 0.0) {
                    x[i] += share * there.clone().map(|&p| coarse[3 * p as usize + i]).sum::<f64>();
                }
            });
    }

    /// The next coarser level, P^T A P with trilinear P between grids of twice the distance; `None` if it
    /// would not be smaller.
    pub fn coarser(&self) -> Option<(Coarsening, Self)> {
        let map = NodeMap::new(self.coordinates.iter().flat_map(|c| parent_places(*c)));
        if 2 * map.coordinates.len() > self.len() {
            return None;
        }
        let fine = NodeMap::new(self.coordinates.iter().copied());
        let children: Vec<[u32; 27]> = map
            .coordinates
            .iter()
            .map(|c| {
                std::array::from_fn(|s| {
                    let o = offset(s);
                    fine.node(std::array::from_fn(|i| 2 * c[i] + o[i]))
                })
            })
            .collect();
        let parents = self
            .coordinates
            .iter()
            .map(|c| {
                let mut ids = [NO_NODE; 8];
                for (id, place) in ids.iter_mut().zip(parent_places(*c)) {
                    *id = map.node(place);
                }
                ids
            })
            .collect();
        let rows = |node: usize| {
            let mut row = [Mat3::zeros(); 27];
            for (s, &child) in children[node].iter().enumerate().filter(|(_, c)| **c != NO_NODE) {
                let from = offset(s);
                for (t, block) in self.blocks[child as usize].iter().enumerate() {
                    if self.neighbours[child as usize][t] == NO_NODE {
                        continue;
                    }
                    let block = Mat3::from_fn(|i, j| f64::from(block[3 * i + j])) * weight(s);
                    let o = offset(t);
                    let [x, y, z] = std::array::from_fn(|i| shares(from[i] + o[i]));
                    for (k, wz) in z.clone() {
                        for (j, wy) in y.clone() {
                            for (i, wx) in x.clone() {
                                row[slot([i, j, k])] += block * (wx * wy * wz);
                            }
                        }
                    }
                }
            }
            row
        };
        let mass = (0..map.coordinates.len())
            .flat_map(|node| {
                let mut sum = [0.0; 3];
                for (s, &child) in children[node].iter().enumerate().filter(|(_, c)| **c != NO_NODE) {
                    for i in 0..3 {
                        sum[i] += weight(s) * self.mass[3 * child as usize + i];
                    }
                }
                sum
            })
            .collect();
        let level = Self::new(&map, rows, mass);
        Some((Coarsening { parents, children }, level))
    }
}

/// Inverse of a diagonal block; components without stiffness stay zero.
pub fn inverse_of_diagonal(mut d: Mat3) -> Mat3 {
    let held: [bool; 3] = std::array::from_fn(|i| d[(i, i)] <= 0.0);
    for i in (0..3).filter(|&i| held[i]) {
        for j in 0..3 {
            (d[(i, j)], d[(j, i)]) = (0.0, 0.0);
        }
        d[(i, i)] = 1.0;
    }
    let mut inverse = d.try_inverse().unwrap_or_else(Mat3::zeros);
    inverse = 0.5 * (inverse + inverse.transpose());
    for i in (0..3).filter(|&i| held[i]) {
        inverse[(i, i)] = 0.0;
    }
    inverse
}

/// Weight of the child in slot `s`: a half for each axis along which it stands aside.
fn weight(s: usize) -> f64 {
    0.5_f64.powi(offset(s).iter().map(|o| o.abs()).sum())
}

/// Coarse coordinates, relative to a node, that a fine node `t` grid lines away depends on, with weights.
fn shares(t: i32) -> impl Iterator<Item = (i32, f64)> + Clone {
    let Range { start, end } = t.div_euclid(2)..(t + 1).div_euclid(2) + 1;
    let share = 1.0 / f64::from(end - start);
    (start..end).map(move |c| (c, share))
}

/// Coarse coordinates that the node at `c` depends on.
fn parent_places(c: [i32; 3]) -> impl Iterator<Item = [i32; 3]> + Clone {
    let range = move |i: usize| c[i].div_euclid(2)..(c[i] + 1).div_euclid(2) + 1;
    range(2).flat_map(move |z| range(1).flat_map(move |y| range(0).map(move |x| [x, y, z])))
}
