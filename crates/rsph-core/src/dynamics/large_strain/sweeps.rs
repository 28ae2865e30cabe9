//! The sums over neighbours, two sweeps for each evaluation: gradients with all that a particle makes of them,
//! and the force, the exact adjoint of the gradient. Between them each particle folds what it does to its
//! neighbours into a few numbers, so that a pair costs a few multiply-adds of whole vectors.

use super::configuration::{Configuration, out_of_plane};
use super::points::{Constants, Point, Points, Source, vectors, vectors_mut};
use crate::tensor::{Mat3, Vec3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Points that a thread takes at once.
const CHUNK: usize = 64;

/// What resists the residual z_ba - G_a X_ba of the field z = `of_position` x + `of_companion` v, G its gradient.
#[derive(Clone, Copy, Debug)]
pub struct Hourglass {
    /// k = alpha (lambda + 2 mu)
    pub stiffness: f64,
    /// Share of x in z.
    pub of_position: f64,
    /// Share of the companion of x in z.
    pub of_companion: f64,
}

impl Hourglass {
    fn field(&self, point: &Point) -> Vec3 {
        point.position() * self.of_position + point.companion() * self.of_companion
    }
}

/// Gradients with respect to X at the particles.
#[derive(Debug)]
pub struct Gradients<'a> {
    /// F
    pub f: &'a mut [Mat3],
    /// The gradient of the companion of x, dF/dt if that is the velocity.
    pub f_rate: &'a mut [Mat3],
}

/// The sums of the first sweep at a particle; lanes as in [`Point::moving`].
#[derive(Debug, Default)]
#[repr(C, align(64))]
struct FirstSums {
    /// sum c z_ba
    plain: [f64; 8],
    /// Column k of the gradient with respect to X.
    gradient: [[f64; 8]; 3],
    /// Column j of sum c z_ba (x) X_ba.
    with_reference: [[f64; 8]; 3],
}

/// Vectors of three that begin at lane `first` of each column, as a matrix.
#[inline(always)]
fn matrix(columns: &[[f64; 8]; 3], first: usize) -> Mat3 {
    Mat3::from_fn(|i, j| columns[j][first + i])
}

#[inline(always)]
fn vector(numbers: &[f64; 8], first: usize) -> Vec3 {
    Vec3::from_column_slice(&numbers[first..first + 3])
}

/// The first sweep over some particles.
struct First<'a, const D: usize, L> {
    configuration: &'a Configuration<D>,
    list: &'a [Point],
    constants: &'a [Constants],
    hourglass: Hourglass,
    /// z of the particle in the middle.
    middle: Vec3,
    law: &'a L,
}

impl<const D: usize, L: Fn(&Mat3, &Mat3) -> Mat3> First<'_, D, L> {
    #[inline(always)]
    fn sums<S: Simd>(&self, simd: S, a: usize) -> FirstSums {
        let (here, map) = (&self.list[a], &self.constants[a].gradient);
        let (neighbours, shares) = self.configuration.row(a);
        let mut out = FirstSums::default();
        for part in 0..8 / S::F64_LANES {
            let z = vectors::<S>(&here.moving)[part];
            let zero = simd.splat_f64s(0.0);
            let (mut plain, mut with_node, mut with_reference) = (zero, [zero; 3], [zero; 3]);
            for (b, share) in neighbours.iter().zip(shares) {
                let there = &self.list[*b as usize];
                // Differences of what moves only: xi_a and X_a come out of the sum, and a product with a number in
                // memory is one instruction.
                let d = simd.sub_f64s(vectors::<S>(&there.moving)[part], z);
                let d = simd.mul_f64s(d, simd.splat_f64s(*share));
                plain = simd.add_f64s(plain, d);
                for j in 0..3 {
                    let (xi, x) = (simd.splat_f64s(there.place[j]), simd.splat_f64s(there.place[4 + j]));
                    with_node[j] = simd.mul_add_e_f64s(d, xi, with_node[j]);
                    with_reference[j] = simd.mul_add_e_f64s(d, x, with_reference[j]);
                }
            }
            vectors_mut::<S>(&mut out.plain)[part] = plain;
            for j in 0..3 {
                let (xi, x) = (simd.splat_f64s(-here.place[j]), simd.splat_f64s(-here.place[4 + j]));
                with_node[j] = simd.mul_add_e_f64s(plain, xi, with_node[j]);
                let with_reference = simd.mul_add_e_f64s(plain, x, with_reference[j]);
                vectors_mut::<S>(&mut out.with_reference[j])[part] = with_reference;
            }
            for k in 0..3 {
                let mut column = zero;
                for (j, with_node) in with_node.iter().enumerate() {
                    column = simd.mul_add_e_f64s(*with_node, simd.splat_f64s(map[(j, k)]), column);
                }
                vectors_mut::<S>(&mut out.gradient[k])[part] = column;
            }
        }
        out
    }

    /// F, its rate, and what the particle does to its neighbours.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, a: usize) -> (Mat3, Mat3, Source) {
        let sums = self.sums(simd, a);
        let f = matrix(&sums.gradient, 0) + out_of_plane::<D>();
        let f_rate = matrix(&sums.gradient, 4);
        let piola = (self.law)(&f, &f_rate);

        let (c, h, point) = (&self.constants[a], &self.hourglass, &self.list[a]);
        let blend = |position: Mat3, companion: Mat3| position * h.of_position + companion * h.of_companion;
        let g = blend(f, f_rate);
        let products = blend(matrix(&sums.with_reference, 0), matrix(&sums.with_reference, 4));
        let plain = vector(&sums.plain, 0) * h.of_position + vector(&sums.plain, 4) * h.of_companion;
        // sum c (z_ba - G X_ba) (x) X_ba
        let springs = products - g * c.second_moment;
        let tensor = (piola * c.reference_share - springs * h.stiffness) * c.gradient.transpose();
        let (z, spring) = (h.field(point) - self.middle, g * h.stiffness);
        let pull = z * h.stiffness - spring * point.reference();
        let own = tensor * c.node + (plain - z * c.springs) * h.stiffness - spring * c.reference;
        (f, f_rate, Source::new(&tensor, &spring, &(tensor * point.node() + pull), &own))
    }
}

/// Some results of the first sweep. A closure in its place would not inherit the instruction set.
struct FirstChunk<'a, const D: usize, L> {
    sweep: &'a First<'a, D, L>,
    first: usize,
    out: Gradients<'a>,
    sources: &'a mut [Source],
}

impl<const D: usize, L: Fn(&Mat3, &Mat3) -> Mat3> WithSimd for FirstChunk<'_, D, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let out = self.out.f.iter_mut().zip(self.out.f_rate).zip(self.sources).enumerate();
        for (k, ((f, f_rate), source)) in out {
            (*f, *f_rate, *source) = self.sweep.at(simd, self.first + k);
        }
    }
}

/// Forces on some points.
struct SecondChunk<'a, const D: usize> {
    configuration: &'a Configuration<D>,
    points: &'a Points,
    first: usize,
    out: &'a mut [Vec3],
}

/// sum += share source
#[inline(always)]
fn add<S: Simd>(simd: S, sum: &mut [S::f64s; Source::LEN], source: &Source, share: f64) {
    let share = simd.splat_f64s(share);
    for (sum, there) in sum.iter_mut().zip(vectors::<S>(&source.0)) {
        *sum = simd.mul_add_e_f64s(share, *there, *sum);
    }
}

impl<const D: usize> WithSimd for SecondChunk<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (c, sources) = (self.configuration, &self.points.sources);
        for (k, force) in self.out.iter_mut().enumerate() {
            let p = self.first + k;
            let (neighbours, shares) = c.row(p);
            let (pairs, last) = neighbours.as_chunks::<2>();
            let (pair_shares, last_share) = shares.as_chunks::<2>();
            // Two neighbours at once: one waits for its sum while the other is added.
            let mut sums = [[simd.splat_f64s(0.0); Source::LEN]; 2];
            for ([b, d], [b_share, d_share]) in pairs.iter().zip(pair_shares) {
                add(simd, &mut sums[0], &sources[*b as usize], *b_share);
                add(simd, &mut sums[1], &sources[*d as usize], *d_share);
            }
            for (b, share) in last.iter().zip(last_share) {
                add(simd, &mut sums[0], &sources[*b as usize], *share);
            }
            let mut total = Source([0.0; Source::LEN]);
            for (i, total) in vectors_mut::<S>(&mut total.0).iter_mut().enumerate() {
                *total = simd.add_f64s(sums[0][i], sums[1][i]);
            }
            let (here, total) = (&self.points.list[p], &total.0);
            let tensor = Mat3::from_column_slice(&total[..9]);
            let spring = Mat3::from_column_slice(&total[9..18]);
            let vector = Vec3::from_column_slice(&total[18..21]);
            let theirs = vector - tensor * here.node() + spring * here.reference();
            *force = (theirs + sources[p].own()) * c.volume[p];
        }
    }
}

impl Points {
    /// Gradients of what moves at all particles: sum (z_b - z_a) (x) g_ab F_0, the corrected gradient of
    /// Eqs. (10), (13). Of them, of the stress P = `law`(F, dF/dt) and of the hourglass term
    /// k_ab = k V_a V_b w, what [`Self::forces`] sums is made: with c = V_b w
    ///
    /// T_a = (m/rho_0 P / V - k sum c (z_ba - G_a X_ba) (x) X_ba) F_0^T L_a.
    pub fn gradients<const D: usize>(
        &mut self,
        c: &Configuration<D>,
        hourglass: Hourglass,
        law: &(impl Fn(&Mat3, &Mat3) -> Mat3 + Sync),
        out: Gradients<'_>,
    ) {
        let middle = self.list.get(self.middle).map_or_else(Vec3::zeros, |point| hourglass.field(point));
        let (list, constants) = (&self.list[..], &self.constants[..]);
        let sweep = First { configuration: c, list, constants, hourglass, middle, law };
        let (sources, images) = self.sources.split_at_mut(c.len);
        let arch = Arch::new();
        let Gradients { f, f_rate } = out;
        (f.par_chunks_mut(CHUNK), f_rate.par_chunks_mut(CHUNK), sources.par_chunks_mut(CHUNK))
            .into_par_iter()
            .enumerate()
            .for_each(|(i, (f, f_rate, sources))| {
                let out = Gradients { f, f_rate };
                arch.dispatch(FirstChunk { sweep: &sweep, first: i * CHUNK, out, sources });
            });
        // A ghost has no energy: it only feels the springs of the particles around.
        images.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(i, source)| {
            let p = c.len + i;
            let own = (hourglass.field(&list[p]) - middle) * (-hourglass.stiffness * constants[p].springs);
            *source = Source::new(&Mat3::zeros(), &Mat3::zeros(), &Vec3::zeros(), &own);
        });
    }

    /// Internal force on all points, Eq. (12) in adjoint form: minus the derivative of the energy for
    /// P = dW/dF, of what the last [`Self::gradients`] found. With c = V_b w and s = 1 for particles, 0 for ghosts
    ///
    /// f_p = V_p sum c [(T_p + T_b) xi_bp + k (s_p (z_bp - G_p X_bp) + s_b (z_bp - G_b X_bp))],
    ///
    /// where all that carries an index p comes out of the sum.
    pub fn forces<const D: usize>(&self, c: &Configuration<D>, out: &mut [Vec3]) {
        let arch = Arch::new();
        out.par_chunks_mut(CHUNK).enumerate().for_each(|(i, out)| {
            arch.dispatch(SecondChunk { configuration: c, points: self, first: i * CHUNK, out });
        });
    }
}
