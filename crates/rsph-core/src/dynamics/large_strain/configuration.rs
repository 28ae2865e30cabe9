//! What a remesh leaves behind for the steps that follow: points on a regular lattice, their neighbours, and
//! the constants of the gradient.

use super::ghosts::Ghosts;
use crate::boundary::fixed::Fixed;
use crate::kernel::QuarticSpline;
use crate::neighbors::Pairs;
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;

/// A moment matrix with a smaller eigenvalue, as a share of that of a full neighbourhood, gives no gradient.
pub const SMALLEST_MOMENT: f64 = 0.02;

/// Particles at the nodes xi of the lattice of the last remesh, with mirror ghosts behind them in the list
/// of points. Gradients are taken with respect to xi:
///
/// w_ab = -W'(r)/r, M_a = sum V_b w xi_ba (x) xi_ba, g_ab = V_b w M_a^-1 xi_ba;
/// F_inc = sum (x_b - x_a) (x) g_ab and F_0 = (sum (X_b - X_a) (x) g_ab)^-1; F = F_inc F_0.
///
/// In the plane (`D` = 2) every z is 0 and F_zz = 1: plane strain of a body of thickness one.
#[derive(Clone, Debug)]
pub struct Configuration<const D: usize> {
    /// Number of particles.
    pub len: usize,
    /// xi of particles, then of ghosts.
    pub nodes: Vec<Vec3>,
    /// X of particles, then of ghosts.
    pub reference: Vec<Vec3>,
    /// V of particles, then of ghosts.
    pub volume: Vec<f64>,
    /// m / rho_0 of particles.
    pub reference_volume: Vec<f64>,
    /// Neighbours of points.
    pub pairs: Pairs,
    /// c_ab = V_b w_ab of each pair.
    pub share: Vec<f64>,
    /// M_a^-1 of particles.
    pub correction: Vec<Mat3>,
    /// F_0 of particles.
    pub first_gradient: Vec<Mat3>,
    /// Mirror ghosts.
    pub ghosts: Ghosts,
    /// Smoothing length h.
    pub smoothing_length: f64,
}

impl<const D: usize> Configuration<D> {
    /// Particles of these volumes at `nodes` with reference positions `reference`, and `ghosts` made from
    /// those nodes. Masses follow from V / det F_0.
    pub fn new(
        mut nodes: Vec<Vec3>,
        mut reference: Vec<Vec3>,
        mut volume: Vec<f64>,
        ghosts: Ghosts,
        smoothing_length: f64,
    ) -> Self {
        let len = nodes.len();
        ghosts.extend_nodes(&mut nodes);
        ghosts.extend_reference(&nodes, &mut reference);
        volume.extend(ghosts.list.iter().map(|g| volume[g.partner]).collect::<Vec<_>>());
        let kernel = QuarticSpline::<D>::new(smoothing_length);
        let pairs = Pairs::new(&nodes, kernel.support() * (1.0 - 1e-9));
        let mut new = Self {
            len,
            correction: Vec::new(),
            first_gradient: Vec::new(),
            reference_volume: Vec::new(),
            nodes,
            reference,
            volume,
            pairs,
            share: Vec::new(),
            ghosts,
            smoothing_length,
        };
        new.take_shares();
        new.correction = (0..len).into_par_iter().map(|a| inverse::<D>(&new.moment(a))).collect();
        new.take_first_gradient();
        new
    }

    /// Takes changed reference positions of particles: those of ghosts follow, and F_0.
    pub fn take_reference(&mut self) {
        self.reference.truncate(self.len);
        self.ghosts.extend_reference(&self.nodes, &mut self.reference);
        self.take_first_gradient();
    }

    /// Gives held particles the reference positions from which their motion has led to their nodes at time
    /// `t`.
    pub fn place_held(&mut self, held: &Fixed, t: f64) {
        if held.particles.is_empty() {
            return;
        }
        for p in &held.particles {
            let moved = p.motion.map_or_else(Vec3::zeros, |m| m.displacement(t));
            for i in (0..3).filter(|&i| p.fix[i]) {
                self.reference[p.particle][i] = self.nodes[p.particle][i] - moved[i];
            }
        }
        self.take_reference();
    }

    /// Gives particle a another F_0.
    pub fn set_first_gradient(&mut self, a: usize, f: Mat3) {
        self.first_gradient[a] = f;
        self.reference_volume[a] = self.volume[a] / f.determinant();
    }

    /// Multiplies all volumes, and with them the mass.
    pub fn scale_volumes(&mut self, factor: f64) {
        self.volume.iter_mut().chain(&mut self.reference_volume).for_each(|v| *v *= factor);
        self.correction.iter_mut().for_each(|l| *l /= factor);
        self.take_shares();
    }

    /// V_b w of all pairs, from the nodes and the volumes: to the last bit what a checkpoint of these gives.
    fn take_shares(&mut self) {
        let kernel = QuarticSpline::<D>::new(self.smoothing_length);
        let (nodes, volume, pairs) = (&self.nodes, &self.volume, &self.pairs);
        let rows: Vec<Vec<f64>> = (0..nodes.len())
            .into_par_iter()
            .map(|a| {
                let share = |b: &u32| {
                    let b = *b as usize;
                    volume[b] * kernel.gradient_weight((nodes[b] - nodes[a]).norm())
                };
                pairs.of(a).iter().map(share).collect()
            })
            .collect();
        self.share = rows.concat();
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// M_a; of ghosts too.
    fn moment(&self, a: usize) -> Mat3 {
        self.neighbours(a).fold(Mat3::zeros(), |m, (b, share)| {
            let xi = self.nodes[b] - self.nodes[a];
            m + xi * xi.transpose() * share
        })
    }

    /// F_0 and m/rho_0 from the reference positions.
    fn take_first_gradient(&mut self) {
        let inverse = |a: usize| {
            let sum = self.neighbours(a).fold(Mat3::zeros(), |sum, (b, share)| {
                let xi = self.nodes[b] - self.nodes[a];
                sum + (self.reference[b] - self.reference[a]) * xi.transpose() * share
            });
            let gradient = sum * self.correction[a] + out_of_plane::<D>();
            gradient.try_inverse().unwrap_or_else(|| Mat3::repeat(f64::NAN))
        };
        self.first_gradient = (0..self.len).into_par_iter().map(inverse).collect();
        self.reference_volume =
            self.first_gradient.iter().zip(&self.volume).map(|(f, v)| v / f.determinant()).collect();
    }

    /// The neighbours of point a, and V_b w of each.
    #[inline(always)]
    pub fn row(&self, a: usize) -> (&[u32], &[f64]) {
        (self.pairs.of(a), &self.share[self.pairs.numbers(a)])
    }

    /// The same one by one.
    #[inline(always)]
    pub fn neighbours(&self, a: usize) -> impl Iterator<Item = (usize, f64)> {
        let (neighbours, shares) = self.row(a);
        neighbours.iter().zip(shares).map(|(b, share)| (*b as usize, *share))
    }

    /// Particles whose neighbours do not span the space, so that they have no gradient.
    pub fn without_gradient(&self) -> Vec<usize> {
        let full = self.full_moment();
        let poor = |a: &usize| {
            let m = self.moment(*a) + full * out_of_plane::<D>();
            m.symmetric_eigenvalues().min() < SMALLEST_MOMENT * full
        };
        (0..self.len).into_par_iter().filter(poor).collect()
    }

    /// Eigenvalue of the moment matrix where all neighbours are there: 1, but for the lattice.
    fn full_moment(&self) -> f64 {
        let largest = (0..self.len).into_par_iter().map(|a| self.moment(a).trace() / D as f64);
        largest.reduce(|| 0.0, f64::max)
    }
}

/// e_z (x) e_z in the plane, nothing in space.
pub fn out_of_plane<const D: usize>() -> Mat3 {
    let mut m = Mat3::zeros();
    if D == 2 {
        m[(2, 2)] = 1.0;
    }
    m
}

/// Inverse of a moment matrix; zero out of the plane, and altogether where there is none.
fn inverse<const D: usize>(moment: &Mat3) -> Mat3 {
    let out = out_of_plane::<D>();
    let inverse = (moment + out).try_inverse().map_or_else(Mat3::zeros, |i| i - out);
    // Symmetric to the last bit: the operator relies on it.
    0.5 * (inverse + inverse.transpose())
}
