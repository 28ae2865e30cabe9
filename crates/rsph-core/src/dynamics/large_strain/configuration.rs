//! What a remesh leaves behind for the steps that follow: points on a regular lattice, their neighbours, and
//! the constants of the gradient.

use super::columns::Packed;
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
    /// w of each pair.
    pub weight: Vec<f64>,
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
        let weight: Vec<f64> = (0..nodes.len())
            .flat_map(|a| pairs.numbers(a).map(move |q| (a, q)))
            .map(|(a, q)| kernel.gradient_weight((nodes[pairs.neighbour(q)] - nodes[a]).norm()))
            .collect();
        let mut new = Self {
            len,
            correction: Vec::new(),
            first_gradient: vec![Mat3::identity(); len],
            reference_volume: Vec::new(),
            nodes,
            reference,
            volume,
            pairs,
            weight,
            ghosts,
            smoothing_length,
        };
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
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// M_a; of ghosts too.
    fn moment(&self, a: usize) -> Mat3 {
        self.pairs.numbers(a).fold(Mat3::zeros(), |m, q| {
            let b = self.pairs.neighbour(q);
            let xi = self.nodes[b] - self.nodes[a];
            m + xi * xi.transpose() * (self.volume[b] * self.weight[q])
        })
    }

    /// F_0 and m/rho_0 from the reference positions.
    fn take_first_gradient(&mut self) {
        let one = Mat3::identity();
        self.first_gradient.fill(one);
        let mut gradient = vec![one; self.len];
        self.deformation(&self.reference, &mut Packed::default(), &mut gradient);
        let inverse = |g: &Mat3| g.try_inverse().unwrap_or_else(|| Mat3::repeat(f64::NAN));
        self.first_gradient = gradient.iter().map(inverse).collect();
        self.reference_volume =
            self.first_gradient.iter().zip(&self.volume).map(|(f, v)| v / f.determinant()).collect();
    }

    /// w of the pairs of point a.
    #[inline(always)]
    pub fn weights(&self, a: usize) -> &[f64] {
        &self.weight[self.pairs.numbers(a)]
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
