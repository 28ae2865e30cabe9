//! The sums over neighbours: gradients, energy, and the exact adjoint of the gradient.

use super::columns::{Columns, Packed, Quad, Source};
use super::configuration::{Configuration, out_of_plane};
use crate::material::FiniteStrain;
use crate::tensor::{Mat3, Vec3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Points that a thread takes at once.
const CHUNK: usize = 64;

/// Stress at the particles and the field whose hourglass residual pulls at them.
#[derive(Clone, Copy, Debug)]
pub struct Stressed<'a> {
    /// First Piola-Kirchhoff stress of each particle.
    pub piola: &'a [Mat3],
    /// alpha (lambda + 2 mu).
    pub hourglass: f64,
    /// The field z at all points whose residual z_ba - G_a X_ba the hourglass term resists.
    pub field: &'a [Vec3],
    /// Its gradient G at the particles.
    pub gradient: &'a [Mat3],
}

/// Calls `set` with the number and the place of every result, with the widest vectors of the machine.
fn for_each<T: Send>(out: &mut [T], set: impl Fn(usize, &mut T) + Sync) {
    let arch = Arch::new();
    out.par_chunks_mut(CHUNK).enumerate().for_each(|(c, out)| {
        arch.dispatch(Chunk { first: c * CHUNK, out, set: &set });
    });
}

/// Some results. A closure in its place would not inherit the instruction set.
struct Chunk<'a, T, F> {
    first: usize,
    out: &'a mut [T],
    set: &'a F,
}

impl<T, F: Fn(usize, &mut T)> WithSimd for Chunk<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (k, out) in self.out.iter_mut().enumerate() {
            (self.set)(self.first + k, out);
        }
    }
}

impl<const D: usize> Configuration<D> {
    /// Gradients of a field of points with respect to X at all particles: sum (z_b - z_a) (x) g_ab F_0, the
    /// corrected gradient of Eqs. (10), (13).
    pub fn gradients(&self, z: &[Vec3], packed: &mut Packed, out: &mut [Mat3]) {
        let points = packed.samples(&self.nodes, &self.volume, z);
        for_each(
            out,
            #[inline(always)]
            |a, g| {
                let (mut sum, here) = (Columns::default(), &points[a]);
                for (b, w) in self.pairs.of(a).iter().zip(self.weights(a)) {
                    let there = &points[*b as usize];
                    let (xi, vw) = (there.place.minus(here.place).0, there.place.0[3] * w);
                    sum.add_product(there.value.minus(here.value), [xi[0] * vw, xi[1] * vw, xi[2] * vw]);
                }
                *g = sum.matrix() * self.correction[a] * self.first_gradient[a];
            },
        );
    }

    /// Deformation gradients F of positions x of points.
    pub fn deformation(&self, x: &[Vec3], packed: &mut Packed, out: &mut [Mat3]) {
        self.gradients(x, packed, out);
        let out_of_plane = out_of_plane::<D>();
        for g in out.iter_mut() {
            *g += out_of_plane;
        }
    }

    /// Energy of each particle, that of the hourglass term included: m/rho_0 W(F) +
    /// 1/2 sum k_ab |x_ba - F_a X_ba|^2, k_ab = alpha (lambda + 2 mu) V_a V_b w. As F_a X_ba =
    /// F_inc F_0 X_ba, the term remembers what it held before a remesh.
    pub fn energies(
        &self,
        material: &dyn FiniteStrain,
        hourglass: f64,
        x: &[Vec3],
        f: &[Mat3],
        out: &mut [f64],
    ) {
        out.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(a, e)| {
            let mut springs = 0.0;
            for q in self.pairs.numbers(a) {
                let b = self.pairs.neighbour(q);
                let residual = x[b] - x[a] - f[a] * (self.reference[b] - self.reference[a]);
                springs += self.volume[b] * self.weight[q] * residual.norm_squared();
            }
            *e = self.reference_volume[a] * material.energy(&f[a])
                + 0.5 * hourglass * self.volume[a] * springs;
        });
    }

    /// A_a = (m/rho_0 P - sum k_ab (z_ba - G_a X_ba) (x) X_ba) F_0^T L_a, which the adjoint of the gradient
    /// takes.
    pub fn pair_tensors(&self, s: &Stressed<'_>, packed: &mut Packed, out: &mut [Mat3]) {
        let adjoint =
            |a: usize, stress: Mat3| stress * self.first_gradient[a].transpose() * self.correction[a];
        if s.hourglass <= 0.0 {
            out.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(a, t)| {
                *t = adjoint(a, s.piola[a] * self.reference_volume[a]);
            });
            return;
        }
        let points = packed.samples(&self.reference, &self.volume, s.field);
        for_each(
            out,
            #[inline(always)]
            |a, t| {
                let (mut springs, here) = (Columns::default(), &points[a]);
                let g = Columns::new(&s.gradient[a], &Vec3::zeros());
                for (b, w) in self.pairs.of(a).iter().zip(self.weights(a)) {
                    let there = &points[*b as usize];
                    let (x, vw) = (there.place.minus(here.place).0, there.place.0[3] * w);
                    let mut residual = there.value.minus(here.value);
                    for j in 0..3 {
                        residual.add(-x[j], g.0[j]);
                    }
                    springs.add_product(residual, [x[0] * vw, x[1] * vw, x[2] * vw]);
                }
                let springs = springs.matrix() * (s.hourglass * self.volume[a]);
                *t = adjoint(a, s.piola[a] * self.reference_volume[a] - springs);
            },
        );
    }

    /// Internal force on all points, Eq. (12) in adjoint form: minus the derivative of the energy for
    /// P = dW/dF. `tensors` are those of [`Self::pair_tensors`].
    ///
    /// Ghosts have no energy: their T and G are zero, and so is what two of them do to each other.
    pub fn forces(&self, s: &Stressed<'_>, tensors: &[Mat3], packed: &mut Packed, out: &mut [Vec3]) {
        let n = self.len;
        let source = |p: usize| Source {
            tensor: Columns::new(tensors.get(p).unwrap_or(&Mat3::zeros()), &self.nodes[p]),
            value: Quad::new(&s.field[p], self.volume[p]),
        };
        let spring = |p: usize| Columns::new(s.gradient.get(p).unwrap_or(&Mat3::zeros()), &self.reference[p]);
        let springs = (s.hourglass > 0.0).then_some(spring);
        let (sources, springs) = packed.sources(self.nodes.len(), source, springs);
        for_each(
            out,
            #[inline(always)]
            |p, force| {
                let here = &sources[p];
                // sum w T_b xi_bp, and sum V_b w xi_bp, which T_p takes.
                let (mut theirs, mut own) = (Quad::default(), [0.0; 3]);
                for (b, w) in self.pairs.of(p).iter().zip(self.weights(p)) {
                    let there = &sources[*b as usize];
                    let vw = there.value.0[3] * w;
                    for j in 0..3 {
                        let xi = there.tensor.0[j].0[3] - here.tensor.0[j].0[3];
                        theirs.add(xi * w, there.tensor.0[j]);
                        own[j] += xi * vw;
                    }
                }
                *force = here.tensor.matrix() * Vec3::from(own) + theirs.vector() * self.volume[p];
                if springs.is_empty() {
                    return;
                }
                // sum k_pb times the residuals of both sides.
                let (mut residuals, spring) = (Quad::default(), &springs[p]);
                let sides = f64::from(u8::from(p < n));
                for (b, w) in self.pairs.of(p).iter().zip(self.weights(p)) {
                    let b = *b as usize;
                    let (value, other) = (sources[b].value, &springs[b]);
                    let vw = value.0[3] * w;
                    residuals.add(vw * (sides + f64::from(u8::from(b < n))), value.minus(here.value));
                    for j in 0..3 {
                        let mut shared = other.0[j];
                        shared.add(1.0, spring.0[j]);
                        residuals.add(-vw * (other.0[j].0[3] - spring.0[j].0[3]), shared);
                    }
                }
                *force += residuals.vector() * (s.hourglass * self.volume[p]);
            },
        );
    }
}
