//! A coarse level: a symmetric matrix of 3 x 3 blocks between the nodes of a regular grid, 27 at most
//! for a node, and its Chebyshev smoother. Fields are node by node, x y z, and everything is in single
//! precision: a preconditioner need not be exact, and it is bound by memory.

use super::galerkin::Coarsening;
use super::nodes::{NO_NODE, NodeMap};
use super::spectrum::largest_eigenvalue;
use crate::tensor::{Mat3, Vec3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Nodes that one task works on.
const NODES_PER_TASK: usize = 128;
/// Values of a row of blocks: 27 neighbours of three components, filled up to whole vectors.
const ROW: usize = 96;
/// The smoother damps the part of the spectrum above the largest eigenvalue divided by this.
pub const SMOOTHED: f64 = 6.0;
/// Steps of the iteration for the largest eigenvalue, and the margin for what they miss.
pub const LANCZOS_STEPS: usize = 15;
/// See [`LANCZOS_STEPS`].
pub const LANCZOS_MARGIN: f64 = 1.05;

/// The blocks of a node: row i of all of them, one after the other.
type Rows = [[f32; ROW]; 3];

/// A coarse level with its work space.
#[derive(Clone, Debug)]
pub struct Level {
    coordinates: Vec<[i32; 3]>,
    /// The 27 nodes around each; the number of nodes for one that is not there.
    neighbours: Vec<[u32; 27]>,
    rows: Vec<Rows>,
    /// Mass of each component, zero where it is held.
    mass: Vec<f32>,
    inverse: Vec<[f32; 9]>,
    scales: (f64, f64),
    largest: f64,
    /// Solution, with a node of zeros at its end.
    x: Vec<f32>,
    /// Right-hand side.
    pub b: Vec<f32>,
    r: Vec<f32>,
    d: Vec<f32>,
}

impl Level {
    /// A level whose node I has the blocks `blocks(I)`, by slot, and the component masses `mass`.
    pub fn new(map: &NodeMap, blocks: impl Fn(usize) -> [Mat3; 27] + Sync, mass: &[f64]) -> Self {
        let count = map.coordinates.len();
        let rows = (0..count)
            .into_par_iter()
            .map(|node| {
                let mut rows = [[0.0; ROW]; 3];
                for (s, block) in blocks(node).iter().enumerate() {
                    for i in 0..3 {
                        for j in 0..3 {
                            rows[i][3 * s + j] = block[(i, j)] as f32;
                        }
                    }
                }
                rows
            })
            .collect();
        let mut neighbours = map.neighbours();
        for node in neighbours.iter_mut().flatten().filter(|n| **n == NO_NODE) {
            *node = count as u32;
        }
        let zeros = || vec![0.0; 3 * count];
        let mut level = Self {
            neighbours,
            coordinates: map.coordinates.clone(),
            rows,
            inverse: Vec::new(),
            scales: (0.0, 1.0),
            largest: 1.0,
            x: vec![0.0; 3 * count + 3],
            b: zeros(),
            r: zeros(),
            d: zeros(),
            mass: mass.iter().map(|m| *m as f32).collect(),
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

    /// Grid coordinates of the nodes.
    pub fn coordinates(&self) -> &[[i32; 3]] {
        &self.coordinates
    }

    /// The block between a node and the one in slot `s` around it, if that is there.
    pub fn block(&self, node: usize, s: usize) -> Option<Mat3> {
        let there = (self.neighbours[node][s] as usize) < self.len();
        there.then(|| Mat3::from_fn(|i, j| f64::from(self.rows[node][i][3 * s + j])))
    }

    /// Mass of component `i`, counted through all nodes.
    pub fn mass(&self, i: usize) -> f64 {
        f64::from(self.mass[i])
    }

    /// Solution.
    pub fn x(&self) -> &[f32] {
        &self.x[..3 * self.len()]
    }

    /// Right-hand side and solution, to be changed.
    pub fn b_and_x(&mut self) -> (&[f32], &mut [f32]) {
        let len = self.b.len();
        (&self.b, &mut self.x[..len])
    }

    /// Solution, to be changed.
    fn x_mut(&mut self) -> &mut [f32] {
        let len = 3 * self.len();
        &mut self.x[..len]
    }

    /// Components of a node that have stiffness.
    fn free(inverse: &[f32; 9]) -> [bool; 3] {
        [inverse[0] != 0.0, inverse[4] != 0.0, inverse[8] != 0.0]
    }

    /// Makes it the matrix m M + c K.
    pub fn set_scales(&mut self, mass: f64, stiffness: f64) {
        self.scales = (mass, stiffness);
        self.inverse = (0..self.len())
            .into_par_iter()
            .map(|node| {
                let mut d = self.block(node, 13).map_or_else(Mat3::zeros, |block| stiffness * block);
                for i in 0..3 {
                    d[(i, i)] += mass * self.mass(3 * node + i);
                }
                let inverse = inverse_of_diagonal(d);
                std::array::from_fn(|k| inverse[(k / 3, k % 3)] as f32)
            })
            .collect();
    }

    /// Largest eigenvalue of D^-1 K, an upper bound for that of (m M + c D)^-1 (m M + c K).
    fn estimate_largest(&mut self) {
        let mut work = self.clone();
        work.b.fill(0.0);
        let inverse = &self.inverse;
        let mut divide = |r: &[f64], z: &mut [f64]| {
            for (node, z) in z.chunks_mut(3).enumerate() {
                let inverse = Mat3::from_fn(|i, j| f64::from(inverse[node][3 * i + j]));
                z.copy_from_slice((inverse * Vec3::from_column_slice(&r[3 * node..3 * node + 3])).as_slice());
            }
        };
        let mut apply = |x: &[f64], y: &mut [f64]| {
            work.x_mut().iter_mut().zip(x).for_each(|(to, from)| *to = *from as f32);
            work.residual();
            y.iter_mut().zip(&work.r).for_each(|(y, r)| *y = -f64::from(*r));
        };
        let found = largest_eigenvalue(3 * self.len(), LANCZOS_STEPS, &mut apply, &mut divide);
        self.largest = if found > 0.0 { LANCZOS_MARGIN * found } else { 1.0 };
    }

    /// Calls `visit(row, column, value)` for every entry of the matrix.
    pub fn for_each_entry(&self, mut visit: impl FnMut(usize, usize, f64)) {
        let (m, c) = self.scales;
        for (node, neighbours) in self.neighbours.iter().enumerate() {
            for (s, j) in neighbours.iter().enumerate() {
                let Some(block) = self.block(node, s) else { continue };
                for i in 0..3 {
                    for k in 0..3 {
                        visit(3 * node + i, 3 * *j as usize + k, c * block[(i, k)]);
                    }
                }
            }
            for i in 0..3 {
                visit(3 * node + i, 3 * node + i, m * self.mass(3 * node + i));
            }
        }
    }

    /// r = b - A x, zero in components without stiffness.
    fn residual(&mut self) {
        let arch = Arch::new();
        let Self { neighbours, rows, mass, inverse, scales, x, b, r, .. } = self;
        let (m, c) = (scales.0 as f32, scales.1 as f32);
        let n = NODES_PER_TASK;
        (r.par_chunks_mut(3 * n), rows.par_chunks(n), neighbours.par_chunks(n))
            .into_par_iter()
            .enumerate()
            .for_each(|(chunk, (r, rows, neighbours))| {
                arch.dispatch(Products { rows, neighbours, x, out: &mut *r });
                let first = chunk * n;
                for (i, r) in r.iter_mut().enumerate() {
                    let at = 3 * first + i;
                    let held = inverse[first + i / 3][4 * (i % 3)] == 0.0;
                    *r = if held { 0.0 } else { b[at] - c * *r - m * mass[at] * x[at] };
                }
            });
    }

    /// d = p d + q D^-1 r with r or, if `from_b`, b; x += d, or x = d. Where p is 0, d may hold anything.
    fn correct(&mut self, p: f64, q: f64, from_b: bool) {
        let Self { inverse, x, b, r, d, .. } = self;
        let (p, q) = (p as f32, q as f32);
        let len = d.len();
        (
            x[..len].par_chunks_mut(3),
            d.par_chunks_mut(3),
            if from_b { b } else { r }.par_chunks(3),
            &*inverse,
        )
            .into_par_iter()
            .with_min_len(8 * NODES_PER_TASK)
            .for_each(|(x, d, r, inverse)| {
                for i in 0..3 {
                    let z = inverse[3 * i] * r[0] + inverse[3 * i + 1] * r[1] + inverse[3 * i + 2] * r[2];
                    d[i] = if p == 0.0 { q * z } else { p * d[i] + q * z };
                    x[i] = if from_b { d[i] } else { x[i] + d[i] };
                }
            });
    }

    /// Two Chebyshev steps of the block Jacobi iteration; `from_zero`: x counts as zero.
    pub fn smooth(&mut self, from_zero: bool) {
        let (high, low) = (self.largest, self.largest / SMOOTHED);
        let (middle, half) = (0.5 * (high + low), 0.5 * (high - low));
        if !from_zero {
            self.residual();
        }
        self.correct(0.0, 1.0 / middle, from_zero);
        self.residual();
        let rho = half / middle;
        let next = 1.0 / (2.0 / rho - rho);
        self.correct(next * rho, 2.0 * next / half, false);
    }

    /// b of the coarser level = P^T (b - A x) of this one.
    pub fn restrict(&mut self, coarsening: &Coarsening, coarse: &mut Self) {
        self.residual();
        coarsening.restrict(&self.r, &mut coarse.b);
    }

    /// x += P x of the coarser level, in components that have stiffness.
    pub fn prolong(&mut self, coarsening: &Coarsening, coarse: &Self) {
        let Self { x, inverse, .. } = self;
        let len = x.len() - 3;
        coarsening.prolong(coarse.x(), &mut x[..len], |node| Self::free(&inverse[node]));
    }
}

/// Products of the rows of some nodes with x.
struct Products<'a> {
    rows: &'a [Rows],
    neighbours: &'a [[u32; 27]],
    x: &'a [f32],
    out: &'a mut [f32],
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut around = [0.0; ROW];
        for ((rows, neighbours), out) in
            self.rows.iter().zip(self.neighbours).zip(self.out.chunks_exact_mut(3))
        {
            for (to, &j) in around.chunks_exact_mut(3).zip(neighbours) {
                to.copy_from_slice(&self.x[3 * j as usize..3 * j as usize + 3]);
            }
            let (x, _) = S::as_simd_f32s(&around);
            for (row, out) in rows.iter().zip(out) {
                let (row, _) = S::as_simd_f32s(row);
                let mut sum = simd.splat_f32s(0.0);
                for (a, x) in row.iter().zip(x) {
                    sum = simd.mul_add_e_f32s(*a, *x, sum);
                }
                *out = simd.reduce_sum_f32s(sum);
            }
        }
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
