//! Geometric multigrid for m M + c K: the particles; trilinear hexahedra on blocks of two cells, their
//! stiffness scaled by how full they are; Galerkin levels of twice the distance each; a direct solve.

use super::blocks::diagonal_blocks;
use super::direct::Direct;
use super::galerkin::Coarsening;
use super::hexahedra;
use super::jacobi::Jacobi;
use super::level::{LANCZOS_MARGIN, LANCZOS_STEPS, Level, SMOOTHED};
use super::nodes::{NO_NODE, slot};
use super::operator::{Operator, Preconditioner};
use super::spectrum::largest_eigenvalue;
use super::sums::Sums;
use super::transfer::{BLOCK, Transfer};
use crate::dynamics::Scales;
use crate::dynamics::solid::Solid;
use crate::lattice::NO_PARTICLE;
use crate::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// Unknowns that the direct solve takes.
const DIRECT: usize = 600;
/// Least fullness of a block: its stiffness never vanishes.
const LEAST_FULL: f64 = 1e-3;
/// A node is held when this share of the weight around it is.
const HELD_SHARE: f64 = 0.5;
/// Stiffness of the springs of a held face on the nodes of the first coarse level, in E/dx.
const HOLD: f64 = 4.0;
/// Ratios of the moduli of pressure and shear waves (6 at nu = 0.4, 35 at 0.485, 400 at 0.4987) above each of which the
/// particles are smoothed once more: nearly incompressible bodies converge slowly.
const MORE_SMOOTHING: [f64; 5] = [6.0, 35.0, 150.0, 300.0, 400.0];
/// The ratio above which trilinear functions, of which few have no divergence, are too stiff for the body, and the share of
/// the pressure that the coarse levels count then.
const NEARLY_INCOMPRESSIBLE: f64 = 35.0;
/// See [`NEARLY_INCOMPRESSIBLE`].
const COARSE_PRESSURE: f64 = 0.3;

/// The hierarchy of a body on its lattice. It stands as long as the lattice and its boundaries do.
#[derive(Clone, Debug)]
pub struct Multigrid {
    mass: Arc<Vec<f64>>,
    diagonal: Vec<Mat3>,
    jacobi: Jacobi,
    /// Largest eigenvalue of D^-1 K on the particles.
    largest: f64,
    /// Steps of the smoother there.
    smoothing: usize,
    transfer: Transfer,
    levels: Vec<Level>,
    coarsenings: Vec<Coarsening>,
    direct: Option<Direct>,
    /// A z.
    product: Vec<f64>,
    sums: Sums,
}

impl Multigrid {
    /// The hierarchy for K alone (m = 0, c = 1).
    pub fn new(solid: &mut Solid) -> Self {
        let n = solid.len();
        let diagonal = free_diagonal(solid);
        let transfer = Transfer::new(solid);
        let mut levels = vec![first_level(solid, &transfer)];
        let mut coarsenings = Vec::new();
        while let Some(last) = levels.last().filter(|l| 3 * l.len() > DIRECT)
            && let Some((coarsening, level)) = last.coarser()
        {
            coarsenings.push(coarsening);
            levels.push(level);
        }
        let mut multigrid = Self {
            mass: Arc::clone(&solid.mass),
            jacobi: Jacobi::new(&diagonal, &solid.mass, (0.0, 1.0)),
            diagonal,
            largest: 1.0,
            smoothing: smoothing(solid),
            transfer,
            levels,
            coarsenings,
            direct: None,
            product: vec![0.0; 3 * n],
            sums: Sums::new(3 * n),
        };
        multigrid.set_scales(0.0, 1.0);
        multigrid.estimate_largest(solid);
        multigrid
    }

    /// Makes it the hierarchy of m M + c K.
    pub fn set_scales(&mut self, mass: f64, stiffness: f64) {
        self.jacobi = Jacobi::new(&self.diagonal, &self.mass, (mass, stiffness));
        for level in &mut self.levels {
            level.set_scales(mass, stiffness);
        }
        self.direct = self.levels.last().and_then(Direct::new);
    }

    /// Makes its smoother that of the tangent about the present state of `solid`, with m = 0, c = 1; the coarse levels stay those
    /// of the undeformed body.
    pub fn refresh(&mut self, solid: &mut Solid) {
        self.diagonal = free_diagonal(solid);
        self.jacobi = Jacobi::new(&self.diagonal, &self.mass, (0.0, 1.0));
        self.estimate_largest(solid);
    }

    /// Number of unknowns of every level, the particles first.
    pub fn sizes(&self) -> Vec<usize> {
        std::iter::once(self.product.len()).chain(self.levels.iter().map(|l| 3 * l.len())).collect()
    }

    /// Middle of the part of the spectrum of D^-1 K that the smoother damps.
    fn estimate_largest(&mut self, solid: &mut Solid) {
        let jacobi = &mut self.jacobi;
        let mut divide = |r: &[f64], z: &mut [f64]| jacobi.step(0.0, 1.0, r, None, z);
        let mut apply = |x: &[f64], y: &mut [f64]| solid.apply(Scales::STATIC, x, y);
        let largest = largest_eigenvalue(self.product.len(), LANCZOS_STEPS, &mut apply, &mut divide);
        self.largest = LANCZOS_MARGIN * largest.max(f64::MIN_POSITIVE);
    }

    /// One V-cycle from level `l` on, whose right-hand side stands in its `b`.
    fn cycle(&mut self, l: usize) {
        if l + 1 == self.levels.len() {
            let level = &mut self.levels[l];
            if let Some(direct) = &self.direct {
                let (b, x) = level.b_and_x();
                direct.solve(b, x);
            } else {
                level.smooth(true);
                level.smooth(false);
            }
            return;
        }
        let (fine, coarse) = self.levels.split_at_mut(l + 1);
        fine[l].smooth(true);
        fine[l].restrict(&self.coarsenings[l], &mut coarse[0]);
        self.cycle(l + 1);
        let (fine, coarse) = self.levels.split_at_mut(l + 1);
        fine[l].prolong(&self.coarsenings[l], &coarse[0]);
        fine[l].smooth(false);
    }
}

impl Preconditioner for Multigrid {
    fn apply(&mut self, operator: &mut dyn Operator, r: &[f64], z: &mut [f64]) {
        // The coarse levels are in single precision: they get numbers of order one, in any units.
        let size = self.sums.norm(r);
        if size <= 0.0 || !size.is_finite() {
            z.fill(0.0);
            return;
        }
        self.smooth(operator, r, z, true);
        operator.apply(z, &mut self.product);
        self.transfer.restrict(1.0 / size, r, &self.product, &mut self.levels[0].b);
        self.cycle(0);
        let jacobi = &self.jacobi;
        self.transfer.prolong(size, self.levels[0].x(), z, |a, i| jacobi.is_free(a, i));
        self.smooth(operator, r, z, false);
    }
}

impl Multigrid {
    /// Chebyshev steps of the block Jacobi iteration for A z = r.
    fn smooth(&mut self, operator: &mut dyn Operator, r: &[f64], z: &mut [f64], from_zero: bool) {
        let (middle, half) = (0.5 * (1.0 + 1.0 / SMOOTHED), 0.5 * (1.0 - 1.0 / SMOOTHED));
        let ratio = half / middle;
        let mut rho = ratio;
        for step in 0..self.smoothing {
            let (keep, length) = if step == 0 {
                (0.0, 1.0 / middle)
            } else {
                let next = 1.0 / (2.0 / ratio - rho);
                let factors = (next * rho, 2.0 * next / half);
                rho = next;
                factors
            };
            let length = length / self.largest;
            if step == 0 && from_zero {
                self.jacobi.step(keep, length, r, None, z);
            } else {
                operator.apply(z, &mut self.product);
                self.jacobi.step(keep, length, r, Some(&self.product), z);
            }
        }
    }
}

/// The diagonal blocks of K, without what is held.
fn free_diagonal(solid: &Solid) -> Vec<Mat3> {
    let mut diagonal = diagonal_blocks(solid);
    for p in &solid.fixed.particles {
        for i in (0..3).filter(|&i| p.fix[i]) {
            diagonal[p.particle].set_row(i, &nalgebra::RowVector3::zeros());
            diagonal[p.particle].set_column(i, &Vec3::zeros());
        }
    }
    diagonal
}

/// Steps of the smoother on the particles.
fn smoothing(solid: &Solid) -> usize {
    let ratio = solid.materials.largest_ratio_of_moduli();
    1 + MORE_SMOOTHING.iter().filter(|r| ratio > **r).count()
}

/// Trilinear hexahedra on the blocks.
fn first_level(solid: &Solid, transfer: &Transfer) -> Level {
    let n = solid.len();
    let full = (BLOCK as f64).powi(solid.lattice.dimension as i32) * solid.lattice.cell_volume();
    // K of a cube is its edge times that of a unit cube, K of a square of height one that of a unit cube.
    let size = full / (BLOCK as f64 * solid.lattice.spacing).powi(2);
    let locks = solid.materials.largest_ratio_of_moduli() > NEARLY_INCOMPRESSIBLE;
    let stiffness =
        hexahedra::stiffness(solid.materials.first_stiffness(), if locks { COARSE_PRESSURE } else { 1.0 });
    let strength: Vec<f64> = transfer
        .particles_of
        .iter()
        .map(|particles| {
            // With the modulus of the particles, in units of that of the first material.
            let (mut volume, mut stiff) = (0.0, 0.0);
            for &a in particles.iter().filter(|a| **a != NO_PARTICLE) {
                let own = solid.moments_of(a as usize).volume;
                (volume, stiff) = (volume + own, stiff + own * solid.modulus(a as usize));
            }
            let modulus = if volume > 0.0 { stiff / volume } else { 1.0 };
            (volume / full).max(LEAST_FULL) * modulus * size
        })
        .collect();
    let mut held_particle = vec![0.0; 3 * n];
    for p in &solid.fixed.particles {
        for i in (0..3).filter(|&i| p.fix[i]) {
            held_particle[i * n + p.particle] = 1.0;
        }
    }
    let nodes = transfer.nodes.coordinates.len();
    let mut mass = vec![0.0; 3 * nodes];
    let held: Vec<[bool; 3]> = (0..nodes)
        .map(|node| {
            let (mut all, mut held, mut masses) = (0.0, [0.0; 3], [0.0; 3]);
            transfer.around(node, |a, w| {
                all += w;
                for i in 0..3 {
                    let h = held_particle[i * n + a];
                    held[i] += w * h;
                    masses[i] += w * solid.mass[a] * (1.0 - h);
                }
            });
            let held = std::array::from_fn(|i| held[i] >= HELD_SHARE * all);
            for i in (0..3).filter(|&i| !held[i]) {
                mass[3 * node + i] = masses[i];
            }
            held
        })
        .collect();
    // Held faces and foundations are springs on the nodes around them.
    let mut springs = vec![Vec::new(); nodes];
    let stiffness_of_hold = HOLD * solid.materials.young_modulus() / solid.lattice.spacing;
    let slot_of = |node: u32, other: u32| {
        let place = |node: u32| transfer.nodes.coordinates[node as usize];
        slot(std::array::from_fn(|i| place(other)[i] - place(node)[i]))
    };
    let holds = solid.lift.places().map(|(x, held, area)| (x, held * (stiffness_of_hold * area)));
    for (x, stiffness) in holds.chain(solid.lift.springs()) {
        let Some(corners) = transfer.corners_at(solid, &x) else { continue };
        for (m, weight) in corners {
            for (n, other) in corners {
                let spring = stiffness * (weight * other);
                springs[m as usize].push((slot_of(m, n), n, spring));
            }
        }
    }
    let rows = |node: usize| {
        let mut row = [Mat3::zeros(); 27];
        for (place, other, spring) in &springs[node] {
            let is_free = |i: usize, j: usize| !held[node][i] && !held[*other as usize][j];
            row[*place] += Mat3::from_fn(|i, j| if is_free(i, j) { spring[(i, j)] } else { 0.0 });
        }
        for (k, &block) in transfer.blocks_of[node].iter().enumerate().filter(|(_, b)| **b != NO_NODE) {
            for (c, &other) in transfer.nodes_of[block as usize].iter().enumerate() {
                let place = slot_of(node as u32, other);
                let mut part = stiffness[7 - k][c] * strength[block as usize];
                for i in 0..3 {
                    for j in 0..3 {
                        if held[node][i] || held[other as usize][j] {
                            part[(i, j)] = 0.0;
                        }
                    }
                }
                row[place] += part;
            }
        }
        row
    };
    Level::new(&transfer.nodes, rows, &mass)
}
