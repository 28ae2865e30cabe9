//! What the sums over neighbours read of a point, packed into whole cache lines, and the sums that stay the same
//! between remeshes.

use super::configuration::Configuration;
use crate::tensor::{Mat3, Vec3};
use pulp::Simd;
use rayon::prelude::*;

/// Points that a thread packs at once.
const CHUNK: usize = 1024;

/// Numbers as the vectors of an instruction set.
#[inline(always)]
pub(super) fn vectors<S: Simd>(numbers: &[f64]) -> &[S::f64s] {
    S::as_simd_f64s(numbers).0
}

/// The same to write to.
#[inline(always)]
pub(super) fn vectors_mut<S: Simd>(numbers: &mut [f64]) -> &mut [S::f64s] {
    S::as_mut_simd_f64s(numbers).0
}

/// A point as the first sweep reads it. Both halves are two vectors of three, each with a zero behind it.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(128))]
pub(super) struct Point {
    /// x and its companion, a velocity or a change of place.
    pub moving: [f64; 8],
    /// xi and X, both from where the particle in the middle has them: the sums multiply them before they take
    /// differences, and far from the origin that would cost digits.
    pub place: [f64; 8],
}

/// Two vectors of three in eight lanes.
#[inline(always)]
pub(super) fn lanes(first: &Vec3, second: &Vec3) -> [f64; 8] {
    [first.x, first.y, first.z, 0.0, second.x, second.y, second.z, 0.0]
}

impl Point {
    /// x
    #[inline(always)]
    pub fn position(&self) -> Vec3 {
        Vec3::from_column_slice(&self.moving[..3])
    }

    /// The companion of x.
    #[inline(always)]
    pub fn companion(&self) -> Vec3 {
        Vec3::from_column_slice(&self.moving[4..7])
    }

    /// xi
    #[inline(always)]
    pub fn node(&self) -> Vec3 {
        Vec3::from_column_slice(&self.place[..3])
    }

    /// X
    #[inline(always)]
    pub fn reference(&self) -> Vec3 {
        Vec3::from_column_slice(&self.place[4..7])
    }
}

/// What a point does to its neighbours, as the second sweep reads it.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Source(pub [f64; Source::LEN]);

impl Source {
    pub const LEN: usize = 24;

    /// T (column by column), k G, T xi + k (z - G X), and the force that the point takes itself.
    #[inline(always)]
    pub fn new(tensor: &Mat3, spring: &Mat3, vector: &Vec3, own: &Vec3) -> Self {
        let mut numbers = [0.0; Self::LEN];
        numbers[..9].copy_from_slice(tensor.as_slice());
        numbers[9..18].copy_from_slice(spring.as_slice());
        numbers[18..21].copy_from_slice(vector.as_slice());
        numbers[21..].copy_from_slice(own.as_slice());
        Self(numbers)
    }

    /// The force that the point takes itself.
    #[inline(always)]
    pub fn own(&self) -> Vec3 {
        Vec3::from_column_slice(&self.0[21..])
    }
}

/// Sums over the neighbours of a point that stay the same between remeshes, with c_ab = V_b w_ab; those of ghosts
/// are zero but for `springs`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constants {
    /// L_a F_0: takes sum c z_ba (x) xi_ba to the gradient with respect to X.
    pub gradient: Mat3,
    /// sum c X_ba (x) X_ba
    pub second_moment: Mat3,
    /// sum c xi_ba
    pub node: Vec3,
    /// sum c X_ba
    pub reference: Vec3,
    /// sum c over the neighbours that are no ghosts.
    pub springs: f64,
    /// (m / rho_0) / V
    pub reference_share: f64,
}

impl Constants {
    fn new<const D: usize>(c: &Configuration<D>, p: usize) -> Self {
        let mut new = Self {
            gradient: Mat3::zeros(),
            second_moment: Mat3::zeros(),
            node: Vec3::zeros(),
            reference: Vec3::zeros(),
            springs: 0.0,
            reference_share: 0.0,
        };
        for (b, share) in c.neighbours(p) {
            if b < c.len {
                new.springs += share;
            }
            if p < c.len {
                let (xi, x) = (c.nodes[b] - c.nodes[p], c.reference[b] - c.reference[p]);
                new.node += xi * share;
                new.reference += x * share;
                new.second_moment += x * x.transpose() * share;
            }
        }
        if p < c.len {
            new.gradient = c.correction[p] * c.first_gradient[p];
            new.reference_share = c.reference_volume[p] / c.volume[p];
        }
        new
    }
}

/// The points of a configuration, packed, with what the two sweeps hand on.
#[derive(Clone, Debug)]
pub struct Points {
    pub(super) list: Vec<Point>,
    pub(super) constants: Vec<Constants>,
    pub(super) sources: Vec<Source>,
    /// The particle nearest to the middle of the body.
    pub(super) middle: usize,
}

impl Points {
    /// The points of `c`, all at the origin.
    pub fn new<const D: usize>(c: &Configuration<D>) -> Self {
        let centre = c.nodes[..c.len].iter().sum::<Vec3>() / c.len.max(1) as f64;
        let distance = |a: &usize| (c.nodes[*a] - centre).norm_squared();
        let middle = (0..c.len).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
        let at = |p: usize| Point {
            moving: [0.0; 8],
            place: lanes(&(c.nodes[p] - c.nodes[middle]), &(c.reference[p] - c.reference[middle])),
        };
        let none = Source::new(&Mat3::zeros(), &Mat3::zeros(), &Vec3::zeros(), &Vec3::zeros());
        let len = c.nodes.len();
        Self {
            list: (0..len).into_par_iter().map(at).collect(),
            constants: (0..len).into_par_iter().map(|p| Constants::new(c, p)).collect(),
            sources: vec![none; len],
            middle,
        }
    }

    /// Moves the particles of `c` to x with velocities v, `to(a)` = (x, v), and the ghosts with them.
    pub fn set<const D: usize>(&mut self, c: &Configuration<D>, to: impl Fn(usize) -> (Vec3, Vec3) + Sync) {
        let (particles, images) = self.list.split_at_mut(c.len);
        particles.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(a, point)| {
            let (x, v) = to(a);
            point.moving = lanes(&x, &v);
        });
        images.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(i, image)| {
            let partner = &particles[c.ghosts.list[i].partner];
            let x = c.ghosts.position(i, &c.nodes, partner.position());
            image.moving = lanes(&x, &c.ghosts.velocity(i, partner.companion()));
        });
    }

    /// Gives the points of `c` the changes of place `dx` of particles while the planes rest, where they are.
    pub fn set_changes<const D: usize>(&mut self, c: &Configuration<D>, dx: &[Vec3]) {
        let (particles, images) = self.list.split_at_mut(c.len);
        particles.par_iter_mut().zip(dx).with_min_len(CHUNK).for_each(|(point, dx)| {
            point.moving = lanes(&point.position(), dx);
        });
        for (i, (image, ghost)) in images.iter_mut().zip(&c.ghosts.list).enumerate() {
            image.moving = lanes(&image.position(), &c.ghosts.change(i, dx[ghost.partner]));
        }
    }

    /// x of all points.
    pub fn positions(&self) -> Vec<Vec3> {
        self.list.iter().map(Point::position).collect()
    }

    /// v of all points.
    pub fn velocities(&self) -> Vec<Vec3> {
        self.list.iter().map(Point::companion).collect()
    }
}
