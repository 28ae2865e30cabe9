//! Stress in each particle from the gradient of the field that was spread, as many particles at once as a vector register holds.

use super::correction::GENERAL;
use super::materials::{Kind, Materials, Places, STIFFNESS};
use super::relaxation::Relaxation;
use super::sweeps::{At, Body, Sums};
use crate::material::Stiffness;
use crate::ops::{PAIR_COMPONENTS, Pointwise};
use crate::tensor::Mat3;
use crate::tensor::lanes::{Lanes, MAX_LANES, Real, Tensor, Tensors};
use crate::tiles::{Tile, Tiles};
use pulp::Simd;
use std::cmp::Ordering;
use std::sync::atomic::{AtomicUsize, Ordering as Memory};

/// P as a function of a gradient.
pub(super) trait Stress: Sync {
    /// P in the particles at `at` with the gradient grad z.
    fn piola<S: Simd>(&self, at: &At<S>, gradient: &Tensor<Lanes<S>>) -> Tensor<Lanes<S>>;
}

/// C : sym(grad z), Eq. (5).
#[derive(Clone, Copy, Debug)]
pub(super) struct Hooke {
    stiffness: Stiffness,
    /// Whether no shear strain goes with a normal stress or with another shear stress.
    decoupled: bool,
}

impl Hooke {
    pub(super) fn new(stiffness: &Stiffness) -> Self {
        let coupled = |k: usize, j: usize| k != j && (k >= 3 || j >= 3) && stiffness.0[k][j] != 0.0;
        Self { stiffness: *stiffness, decoupled: !(0..36).any(|c| coupled(c / 6, c % 6)) }
    }

    /// C : sym(G).
    #[inline(always)]
    fn stress<T: Real>(&self, gradient: &Tensor<T>) -> Tensor<T> {
        let [[xx, _, _], [xy, yy, _], [xz, yz, zz]] = gradient.symmetric_part().0;
        let strain = [xx, yy, zz, xy, yz, xz];
        let mut sigma = strain;
        for (k, sigma) in sigma.iter_mut().enumerate() {
            let stiffness = &self.stiffness.0[k];
            if self.decoupled && k >= 3 {
                *sigma = strain[k] * stiffness[k];
                continue;
            }
            *sigma = strain[0] * stiffness[0];
            for j in 1..if self.decoupled { 3 } else { 6 } {
                *sigma = strain[j].scaled_add(stiffness[j], *sigma);
            }
        }
        let [xx, yy, zz, xy, yz, xz] = sigma;
        Tensor([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    }
}

impl Stress for Hooke {
    #[inline(always)]
    fn piola<S: Simd>(&self, _: &At<S>, gradient: &Tensor<Lanes<S>>) -> Tensor<Lanes<S>> {
        self.stress(gradient)
    }
}

/// C : sym(grad z) of materials by place.
pub(super) struct HookeByPlace<'a>(pub(super) &'a Places);

impl Stress for HookeByPlace<'_> {
    #[inline(always)]
    fn piola<S: Simd>(&self, at: &At<S>, gradient: &Tensor<Lanes<S>>) -> Tensor<Lanes<S>> {
        let Self(places) = self;
        match places.kind(at.tile) {
            Kind::Pure(material) => {
                places.hooke(material).stress(gradient).scaled(at.load(places.factor(at.tile)))
            }
            Kind::Mixed(number) => {
                let stiffness = &places.stiffness[number as usize * STIFFNESS..][..STIFFNESS];
                let [[xx, _, _], [xy, yy, _], [xz, yz, zz]] = gradient.symmetric_part().0;
                let strain = [xx, yy, zz, xy, yz, xz];
                let mut sigma = strain;
                for (sigma, row) in sigma.iter_mut().zip(stiffness.chunks_exact(6)) {
                    *sigma = strain[0] * at.load(&row[0]);
                    for j in 1..6 {
                        *sigma = strain[j].mul_add(at.load(&row[j]), *sigma);
                    }
                }
                let [xx, yy, zz, xy, yz, xz] = sigma;
                Tensor([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            }
        }
    }
}

/// P(F, dF/dt) of laws for any deformation, of the field u + T v.
pub(super) struct Total<'a> {
    pub(super) materials: &'a Materials,
    pub(super) tiles: &'a Tiles,
    /// dF/dt with T, if there is damping.
    pub(super) rate: Option<(&'a [Tile], f64)>,
    /// beta and K, if the body relaxes.
    pub(super) relaxation: Option<&'a Relaxation>,
    /// The first particle that is turned inside out.
    pub(super) inverted: AtomicUsize,
}

impl Stress for Total<'_> {
    #[inline(always)]
    fn piola<S: Simd>(&self, at: &At<S>, gradient: &Tensor<Lanes<S>>) -> Tensor<Lanes<S>> {
        let mut f = gradient.plus_number(1.0);
        let (mut of, mut rate, mut piola) = (Tensors::ZERO, None, Tensors::ZERO);
        if let Some((values, relaxation_time)) = self.rate {
            let of_rate = at.tensor::<PAIR_COMPONENTS>(values, at.tile);
            f = f - of_rate * relaxation_time;
            let mut tensors = Tensors::ZERO;
            tensors.store(&of_rate);
            rate = Some(tensors);
        }
        of.store(&f);
        self.materials.stresses((self.tiles, at.tile, at.lane), S::F64_LANES, &of, rate.as_ref(), &mut piola);
        self.watch(at, &f);
        let piola = piola.load(at.simd);
        self.relaxation.map_or(piola, |relaxation| relaxation.general(at, &piola, &f))
    }
}

impl Total<'_> {
    /// Notes the first of the particles that is turned inside out.
    #[inline(always)]
    fn watch<S: Simd>(&self, at: &At<S>, f: &Tensor<Lanes<S>>) {
        let mut volume = [0.0; MAX_LANES];
        f.determinant().store(&mut volume);
        for (l, j) in volume[..S::F64_LANES].iter().enumerate() {
            // What is not a number was turned inside out a stage before.
            let is_inverted = j.partial_cmp(&0.0) != Some(Ordering::Greater);
            if let (true, Some(a)) = (is_inverted, self.tiles.particle(at.tile, at.lane + l)) {
                self.inverted.fetch_min(a, Memory::Relaxed);
            }
        }
    }

    /// The first particle that was turned inside out.
    pub(super) fn first_inverted(self) -> Option<usize> {
        let first = self.inverted.into_inner();
        (first != usize::MAX).then_some(first)
    }
}

/// Change of P, about a state, for changes of F and dF/dt that are these shares of the gradient.
pub(super) struct Change<'a> {
    pub(super) materials: &'a Materials,
    pub(super) tiles: &'a Tiles,
    pub(super) state: &'a State,
    pub(super) shares: [f64; 2],
    /// beta and K, if the body relaxes.
    pub(super) relaxation: Option<&'a Relaxation>,
}

impl Stress for Change<'_> {
    #[inline(always)]
    fn piola<S: Simd>(&self, at: &At<S>, gradient: &Tensor<Lanes<S>>) -> Tensor<Lanes<S>> {
        let [mut f, mut df, mut change] = [Tensors::ZERO; 3];
        f.store(&self.state.local(at));
        df.store(gradient);
        let at_lanes = (self.tiles, at.tile, at.lane);
        let State { mixed, .. } = self.state;
        self.materials.tangents(at_lanes, S::F64_LANES, [&f, &df], self.shares, mixed, &mut change);
        let change = change.load(at.simd);
        self.relaxation
            .map_or(change, |relaxation| relaxation.general(at, &change, &(*gradient * self.shares[0])))
    }
}

/// The positive tangent F^-T C : sym(F^-1 dF) about a state.
pub(super) struct PositiveChange<'a, H> {
    pub(super) hooke: H,
    pub(super) state: &'a State,
}

impl<H: Stress> Stress for PositiveChange<'_, H> {
    #[inline(always)]
    fn piola<S: Simd>(&self, at: &At<S>, gradient: &Tensor<Lanes<S>>) -> Tensor<Lanes<S>> {
        let (inverse_transpose, _) = self.state.local(at).inverse_transpose();
        let turned_back = inverse_transpose.transpose().times(gradient);
        inverse_transpose.times(&self.hooke.piola(at, &turned_back))
    }
}

/// The state about which a tangent is taken: F times a number in each particle; that of the undeformed body if it is empty.
#[derive(Clone, Debug, Default)]
pub(super) struct State {
    /// grad u, then the number less one, as a tiled field of [`PAIR_COMPONENTS`].
    pub(super) values: Vec<Tile>,
    /// dP/dF of the particles in tiles of several laws.
    pub(super) mixed: Vec<Tile>,
    /// Whether the tangent there is replaced by [`PositiveChange`].
    pub(super) is_positive: bool,
}

impl State {
    /// Component of the number.
    pub(super) const FACTOR: usize = 9;

    /// F and the number of the particle in that lane of a tile.
    pub(super) fn get(&self, (tile, lane): (usize, usize)) -> (Mat3, f64) {
        if self.values.is_empty() {
            return (Mat3::identity(), 1.0);
        }
        let value = |c: usize| self.values[tile * PAIR_COMPONENTS + c].0[lane];
        (Mat3::identity() + Mat3::from_fn(|i, j| value(3 * i + j)), 1.0 + value(Self::FACTOR))
    }

    /// F times the number.
    #[inline(always)]
    fn local<S: Simd>(&self, at: &At<S>) -> Tensor<Lanes<S>> {
        if self.values.is_empty() {
            return Tensor([[Lanes::splat(at.simd, 0.0); 3]; 3]).plus_number(1.0);
        }
        let number = at.load(&self.values[at.tile * PAIR_COMPONENTS + Self::FACTOR]) + 1.0;
        at.tensor::<PAIR_COMPONENTS>(&self.values, at.tile).plus_number(1.0).scaled(number)
    }
}

/// From sums to T_a and the part of the force that needs no neighbour's T:
/// T_a = V_a (P_a (F_a^T L_a - z Gamma_a) - kappa G_a), with F = d xi / d X and G on the lattice.
pub(super) struct StressSweep<'a, P, const C: usize> {
    pub(super) body: Body<'a>,
    /// kappa.
    pub(super) hourglass: f64,
    /// What kappa is multiplied by in every tile, where it is not the same everywhere.
    pub(super) modulus: Option<&'a [Tile]>,
    pub(super) stress: P,
}

impl<P: Stress, const C: usize> Pointwise for StressSweep<'_, P, C> {
    #[inline(always)]
    fn transform<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        lane: usize,
        sums: &mut [S::f64s; PAIR_COMPONENTS],
        sides: [&mut [Tile]; 2],
    ) {
        let at = At { simd, tile, lane };
        if self.body.is_full(tile, sides[0]) {
            self.finish::<S, true>(&at, sums, sides);
        } else {
            self.finish::<S, false>(&at, sums, sides);
        }
    }
}

impl<P: Stress, const C: usize> StressSweep<'_, P, C> {
    #[inline(always)]
    fn finish<S: Simd, const FULL: bool>(
        &self,
        at: &At<S>,
        results: &mut [S::f64s; PAIR_COMPONENTS],
        [stress, change]: [&mut [Tile]; 2],
    ) {
        let sums: Sums<S> = self.body.complete::<S, FULL, C>(at, results, [stress, change]);
        let local = &sums.local;
        let piola = self.stress.piola(at, &sums.deformation);
        let force = piola.scaled(local.volume);
        at.store_tensor::<C>(&force, stress);
        let mut stiff = local.volume * self.hourglass;
        if let Some(modulus) = self.modulus {
            stiff = stiff * at.load(&modulus[at.tile]);
        }
        let on_lattice = if FULL { force } else { self.body.on_lattice(at, &force) };
        let mut t = local.corrected::<FULL>(&on_lattice).plus(-stiff, &sums.smooth[1]);
        let twice = stiff + stiff;
        let mut own = sums.laplacian;
        for own in &mut own {
            *own = *own * twice;
        }
        if !FULL {
            let mut beside = [stiff * 0.0; 3];
            if let Some(row) = sums.row {
                // T = V P (L - z Gamma), and z V P (S[V gamma] - S[V] gamma) on the row itself.
                let (gamma, zeroth, slope) = (row.gamma(at), row.zeroth(at), row.slope(at));
                t = t - force.times(&slope);
                for i in 0..3 {
                    for c in 0..3 {
                        let change = (-gamma[c]).mul_add(local.zeroth, zeroth[c]);
                        beside[i] = force.0[i][c].mul_add(change, beside[i]);
                    }
                }
            }
            if let Some(memory) = self.body.memory {
                let of = memory.local(at.simd, at.tile, at.lane);
                let w = sums.smooth[1].scaled(stiff);
                at.store_tensor::<GENERAL>(&w, change);
                for i in 0..3 {
                    for c in 0..3 {
                        let change = (-of.displacement[c]).mul_add(local.zeroth, of.zeroth[c]);
                        beside[i] = w.0[i][c].mul_add(change, beside[i]);
                    }
                }
            }
            for i in 0..3 {
                for c in 0..3 {
                    beside[i] = t.0[i][c].mul_add(local.first[c], beside[i]);
                }
                own[i] = beside[i].mul_add(local.volume, own[i]);
            }
        }
        for i in 0..3 {
            for j in 0..3 {
                results[3 * i + j] = t.0[i][j].1;
            }
            results[9 + i] = own[i].1;
        }
    }
}

/// The gradient grad z, corrected.
pub(super) struct Gradients<'a, const C: usize> {
    pub(super) body: Body<'a>,
}

impl<const C: usize> Pointwise for Gradients<'_, C> {
    #[inline(always)]
    fn transform<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        lane: usize,
        results: &mut [S::f64s; PAIR_COMPONENTS],
        sides: [&mut [Tile]; 2],
    ) {
        let at = At { simd, tile, lane };
        let [side, memory] = sides;
        let sums = if self.body.is_full(tile, side) {
            self.body.complete::<S, true, C>(&at, results, [side, memory])
        } else {
            self.body.complete::<S, false, C>(&at, results, [side, memory])
        };
        for c in 0..9 {
            results[c] = sums.deformation.0[c / 3][c % 3].1;
        }
    }
}
