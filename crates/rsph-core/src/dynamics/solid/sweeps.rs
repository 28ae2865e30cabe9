//! The two sweeps: gradients of a field from sums over neighbours, and the forces of stresses.

use super::constants::{Constants, Local, scatter};
use super::correction::{Correction, ForceField, GENERAL, GradientField, PLACES, ROW, SYM, SYMMETRIC};
use super::hourglass::Memory;
use super::materials::Materials;
use super::relaxation::Relaxed;
use super::stress::{Gradients, Hooke, HookeByPlace, Stress, StressSweep};
use super::{Solid, Workspace};
use crate::ops::{self, PAIR_COMPONENTS, Pointwise, Results, Side};
use crate::tensor::lanes::{Lanes, Real, Tensor};
use crate::tensor::{Mat3, SymTensor, Vec3};
use crate::tiles::{LANES, Tile, Tiles};
use pulp::Simd;
use std::ops::Range;
use std::sync::Arc;

/// Some lanes of a tile.
#[derive(Clone, Copy)]
pub(super) struct At<S: Simd> {
    pub(super) simd: S,
    pub(super) tile: usize,
    /// The first of the lanes.
    pub(super) lane: usize,
}

impl<S: Simd> At<S> {
    /// Their values in a tile of a field.
    #[inline(always)]
    pub(super) fn load(&self, tile: &Tile) -> Lanes<S> {
        Lanes::load(self.simd, &tile.0[self.lane..])
    }

    /// The first three components there of entry `n` of a field of `C` components.
    #[inline(always)]
    pub(super) fn vector<const C: usize>(&self, field: &[Tile], n: usize) -> [Lanes<S>; 3] {
        let of = &field[C * n..][..C];
        [self.load(&of[0]), self.load(&of[1]), self.load(&of[2])]
    }

    /// The tensor there in entry `n` of a field of `C` components: the six of a symmetric one, or its first nine row by row.
    #[inline(always)]
    pub(super) fn tensor<const C: usize>(&self, field: &[Tile], n: usize) -> Tensor<Lanes<S>> {
        let of = &field[C * n..][..C];
        let mut tensor = Tensor([[Lanes::splat(self.simd, 0.0); 3]; 3]);
        for i in 0..3 {
            for j in 0..3 {
                tensor.0[i][j] = self.load(&of[if C == SYMMETRIC { SYM[i][j] } else { 3 * i + j }]);
            }
        }
        tensor
    }

    /// Puts a tensor into the `C` components of a tile, if it has them.
    #[inline(always)]
    pub(super) fn store_tensor<const C: usize>(&self, tensor: &Tensor<Lanes<S>>, to: &mut [Tile]) {
        for (c, to) in to.iter_mut().enumerate() {
            let (i, j) = if C == SYMMETRIC { PLACES[c] } else { (c / 3, c % 3) };
            tensor.0[i][j].store(&mut to.0[self.lane..]);
        }
    }
}

/// Constants of the correction in a tile of its rows.
#[derive(Clone, Copy)]
pub(super) struct RowTile<'a>(&'a [Tile]);

impl RowTile<'_> {
    /// z, 1 in corrected rows and 0 in others.
    #[inline(always)]
    fn indicator<S: Simd>(&self, at: &At<S>) -> Lanes<S> {
        at.load(&self.0[0])
    }

    /// z gamma.
    #[inline(always)]
    pub(super) fn gamma<S: Simd>(&self, at: &At<S>) -> [Lanes<S>; 3] {
        [at.load(&self.0[1]), at.load(&self.0[2]), at.load(&self.0[3])]
    }

    /// z sum V_b w gamma_b / V.
    #[inline(always)]
    pub(super) fn zeroth<S: Simd>(&self, at: &At<S>) -> [Lanes<S>; 3] {
        [at.load(&self.0[4]), at.load(&self.0[5]), at.load(&self.0[6])]
    }

    /// z Gamma.
    #[inline(always)]
    pub(super) fn slope<S: Simd>(&self, at: &At<S>) -> Tensor<Lanes<S>> {
        at.tensor::<GENERAL>(&self.0[7..], 0)
    }
}

/// The sums of a field z at the particles of some lanes.
pub(super) struct Sums<'a, S: Simd> {
    pub(super) local: Local<S>,
    /// V z, less that of the first particle.
    pub(super) q: [Lanes<S>; 3],
    /// sum V_b w (z_b - z_a).
    pub(super) laplacian: [Lanes<S>; 3],
    /// grad z in the undeformed body, Eqs. (10), (13), without the correction near the surface.
    pub(super) gradient: Tensor<Lanes<S>>,
    /// grad z, corrected; under a linear law its antisymmetric part is not.
    pub(super) deformation: Tensor<Lanes<S>>,
    /// Constants of the correction, in its tiles.
    pub(super) row: Option<RowTile<'a>>,
    /// Of the hourglass term sum V_b w (z_b - z_a) (x) X_ba and the gradient that follows from it.
    pub(super) smooth: [Tensor<Lanes<S>>; 2],
}

/// What the gradient of a field that was spread depends on.
#[derive(Clone, Copy)]
pub(super) struct Body<'a> {
    pub(super) constants: &'a Constants,
    /// d xi / d X at the last remesh, if there was one.
    pub(super) remesh_gradient: &'a [Tile],
    /// V z.
    pub(super) q: &'a [Tile],
    pub(super) correction: &'a Correction,
    pub(super) lifted: &'a [Tile],
    pub(super) memory: Option<&'a Memory>,
}

impl<'a> Body<'a> {
    /// Whether all particles of a tile have full cells and neighbourhoods, on the lattice of the undeformed body, and no
    /// correction: the tile has no sums for it in `beside`.
    #[inline(always)]
    pub(super) fn is_full(&self, tile: usize, beside: &[Tile]) -> bool {
        beside.is_empty() && self.constants.is_full(tile) && self.remesh_gradient.is_empty()
    }

    /// A gradient on the lattice as one in the undeformed body, G F with F = d xi / d X.
    #[inline(always)]
    fn in_undeformed<S: Simd>(&self, at: &At<S>, g: &Tensor<Lanes<S>>) -> Tensor<Lanes<S>> {
        if self.remesh_gradient.is_empty() {
            return *g;
        }
        g.times(&at.tensor::<GENERAL>(self.remesh_gradient, at.tile))
    }

    /// What works on a gradient in the undeformed body as what works on one on the lattice, P F^T.
    #[inline(always)]
    pub(super) fn on_lattice<S: Simd>(&self, at: &At<S>, p: &Tensor<Lanes<S>>) -> Tensor<Lanes<S>> {
        if self.remesh_gradient.is_empty() {
            return *p;
        }
        p.times(&at.tensor::<GENERAL>(self.remesh_gradient, at.tile).transpose())
    }

    /// Completes the lattice sums in some lanes to sum V_b w (z_b - z_a) (x) X, to the Laplacian sum V_b w (z_b - z_a) and to
    /// the gradient, Eqs. (10), (13); `sides` are the sums of the correction, of `C` components, and of the hourglass term.
    #[inline(always)]
    pub(super) fn complete<S: Simd, const FULL: bool, const C: usize>(
        &self,
        at: &At<S>,
        sums: &[S::f64s; PAIR_COMPONENTS],
        sides: [&[Tile]; 2],
    ) -> Sums<'a, S> {
        let local = self.constants.local::<S, FULL>(at.simd, at.tile, at.lane);
        let q = at.vector::<3>(self.q, at.tile);
        let mut first = Tensor([[local.volume; 3]; 3]);
        let mut laplacian = q;
        for i in 0..3 {
            for j in 0..3 {
                let h = Lanes(at.simd, sums[3 * i + j]);
                first.0[i][j] = if FULL { h } else { (-q[i]).mul_add(local.first[j], h) };
            }
            laplacian[i] = (-q[i]).mul_add(local.zeroth, Lanes(at.simd, sums[9 + i]));
        }
        let on_lattice = local.corrected::<FULL>(&first);
        let gradient = if FULL { on_lattice } else { self.in_undeformed(at, &on_lattice) };
        let mut sums = Sums {
            local,
            q,
            laplacian,
            gradient,
            deformation: gradient,
            row: None,
            smooth: [first, on_lattice],
        };
        if FULL {
            return sums;
        }
        let [beside, products] = sides;
        let number = if beside.is_empty() { None } else { self.correction.rows.number(at.tile) };
        if let Some(number) = number {
            let row = RowTile(&self.correction.constants[ROW * number..][..ROW]);
            // S[V z (x) gamma] - Laplacian (x) gamma - V z (x) S[V gamma] / V - A Gamma^T
            let (gamma, zeroth, slope) = (row.gamma(at), row.zeroth(at), row.slope(at));
            let mut own = first.times(&slope.transpose());
            for k in 0..3 {
                for i in 0..3 {
                    let sum = laplacian[k].mul_add(gamma[i], own.0[k][i]);
                    own.0[k][i] = q[k].mul_add(zeroth[i], sum);
                }
            }
            let neighbours = at.tensor::<C>(beside, 0).scaled(row.indicator(at));
            sums.deformation = sums.deformation + (neighbours - own);
            if !self.lifted.is_empty() {
                sums.deformation = sums.deformation + at.tensor::<C>(self.lifted, number);
            }
            sums.row = Some(row);
        }
        if let Some(memory) = self.memory {
            let of = memory.local(at.simd, at.tile, at.lane);
            let mut residual = first - at.tensor::<GENERAL>(products, 0);
            for i in 0..3 {
                for j in 0..3 {
                    let moved = laplacian[i].mul_add(of.displacement[j], residual.0[i][j]);
                    residual.0[i][j] = q[i].mul_add(of.zeroth[j], moved);
                }
            }
            sums.smooth = [residual, residual.times(&of.inverse)];
        }
        sums
    }
}

/// The sums of a field z at one particle, as [`Sums`].
pub(super) struct ParticleSums {
    pub(super) volume: f64,
    /// z, less that of the first particle.
    pub(super) value: Vec3,
    pub(super) laplacian: Vec3,
    pub(super) gradient: Mat3,
    pub(super) deformation: Mat3,
    pub(super) smooth: [Mat3; 2],
}

/// A function of (particle, its tile and lane, sums) for one particle at a time.
struct EachParticle<'a, F, const C: usize> {
    tiles: &'a Tiles,
    body: Body<'a>,
    function: F,
}

/// Numbers of [`ParticleSums`].
const PARTICLE_SUMS: usize = 1 + 3 + 3 + 4 * 9;

impl<F, const C: usize> Pointwise for EachParticle<'_, F, C>
where
    F: Fn(usize, (usize, usize), &ParticleSums) -> [f64; PAIR_COMPONENTS] + Sync,
{
    #[inline(always)]
    fn transform<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        lane: usize,
        results: &mut [S::f64s; PAIR_COMPONENTS],
        [beside, products]: [&mut [Tile]; 2],
    ) {
        let at = At { simd, tile, lane };
        let sums = self.body.complete::<S, false, C>(&at, results, [beside, products]);
        let mut values = [[0.0; LANES]; PARTICLE_SUMS];
        let (vectors, tensors) = values.split_at_mut(7);
        sums.local.volume.store(&mut vectors[0]);
        for i in 0..3 {
            sums.q[i].store(&mut vectors[1 + i]);
            sums.laplacian[i].store(&mut vectors[4 + i]);
        }
        let [first, second] = sums.smooth;
        for (tensor, to) in
            [sums.gradient, sums.deformation, first, second].iter().zip(tensors.chunks_exact_mut(9))
        {
            for (x, to) in tensor.0.as_flattened().iter().zip(to) {
                x.store(to);
            }
        }
        let mut out = [[0.0; LANES]; PAIR_COMPONENTS];
        for l in 0..S::F64_LANES {
            let Some(a) = self.tiles.particle(tile, lane + l) else { continue };
            let of = values.each_ref().map(|lanes| lanes[l]);
            let (vector, tensor) = (
                |c: usize| Vec3::from_row_slice(&of[c..c + 3]),
                |n: usize| Mat3::from_row_slice(&of[7 + 9 * n..][..9]),
            );
            let sums = ParticleSums {
                volume: of[0],
                value: vector(1) / of[0],
                laplacian: vector(4),
                gradient: tensor(0),
                deformation: tensor(1),
                smooth: [tensor(2), tensor(3)],
            };
            for (out, result) in out.iter_mut().zip((self.function)(a, (tile, lane + l), &sums)) {
                out[l] = result;
            }
        }
        for (result, out) in results.iter_mut().zip(&out) {
            *result = Lanes::load(simd, out).1;
        }
    }
}

impl Solid {
    /// Prepares V_b (z_b - z_0) of the field z = u + T v, whose gradient is the effective strain of Eq. (5), and what held faces
    /// and the correction near the surface make of it.
    pub(super) fn spread(&mut self, u: &[f64], v: Option<(&[f64], f64)>) {
        let n = self.len();
        let value = |a: usize| Vec3::from_fn(|i, _| u[i * n + a] + v.map_or(0.0, |(v, t)| t * v[i * n + a]));
        // Nothing but differences of z counts: without its translation a body far from where it started rounds no worse.
        let origin = if n > 0 { value(0) } else { Vec3::zeros() };
        scatter(&self.lattice, &self.lift.folds.following, &self.constants, u, v, &origin, &mut self.work.q);
        self.lift.folds.stretch(value, &origin);
        if let Some(contrast) = &mut self.contrast {
            contrast.stretch(&self.lattice, &self.constants, &self.work.q);
        }
        let components = self.components();
        let Workspace { q, side, lifted, .. } = &mut self.work;
        if !self.lift.is_empty() {
            let tiles = &self.lattice.tiles;
            let constants = &self.constants;
            self.lift.lift(value, |a| {
                let (t, lane) = tiles.place(a);
                constants.volume(t)[lane]
            });
            for (a, gradient) in self.lift.particles().iter().zip(self.lift.gradients()) {
                let (t, lane) = tiles.place(*a as usize);
                if let Some(number) = self.correction.rows.number(t) {
                    let tiles = lifted[components * number..][..components].iter_mut();
                    if components == SYMMETRIC {
                        let strain = SymTensor::symmetric_part(gradient);
                        tiles.zip(strain.0).for_each(|(tile, e)| tile.0[lane] = e);
                    } else {
                        // Row by row.
                        tiles.zip(gradient.transpose().iter()).for_each(|(tile, g)| tile.0[lane] = *g);
                    }
                }
            }
        }
        if !self.correction.is_empty() {
            let (lattice, correction) = (&self.lattice, &self.correction);
            let (reach, gamma) = (&correction.reach, &correction.gamma[..]);
            let results = Results::new(Some(&correction.rows), components, side);
            if components == SYMMETRIC {
                let field = GradientField::<SYMMETRIC> { reach, gamma, q };
                ops::even_sums(lattice, &correction.rows, &field, results);
            } else {
                let field = GradientField::<GENERAL> { reach, gamma, q };
                ops::even_sums(lattice, &correction.rows, &field, results);
            }
        }
    }

    /// Runs a sweep of `pointwise`, which is made of the body, over the field that was spread; its results go to the tiled field
    /// `pair`. Only for the hourglass term (`hourglass`) what it remembers is summed.
    pub(super) fn sweep<'a, P: Pointwise>(
        &'a mut self,
        hourglass: bool,
        pointwise: impl FnOnce(&'a Tiles, Body<'a>) -> P,
    ) -> P {
        let components = self.components();
        let Workspace { q, pair, side, lifted, products, .. } = &mut self.work;
        let memory = self.memory.as_ref().filter(|_| hourglass);
        if let Some(memory) = memory {
            memory.spread(&self.lattice, q, products);
        }
        let pointwise = pointwise(
            &self.lattice.tiles,
            Body {
                constants: &self.constants,
                remesh_gradient: &self.remesh_gradient,
                q,
                correction: &self.correction,
                lifted,
                memory,
            },
        );
        let side =
            (!side.is_empty()).then_some(Side { part: &self.correction.rows, components, values: side });
        let products =
            memory.map(|memory| Side { part: &memory.whole, components: GENERAL, values: products });
        ops::gradient_sums(&self.lattice, None, q, pair, [side, products], &pointwise);
        pointwise
    }

    /// Leaves `function(particle, its tile and lane, sums)` of every particle of the field that was spread in the tiled field `pair`. Only for the
    /// hourglass term (`hourglass`) what it remembers is summed.
    pub(super) fn visit_sums(
        &mut self,
        hourglass: bool,
        function: impl Fn(usize, (usize, usize), &ParticleSums) -> [f64; PAIR_COMPONENTS] + Sync,
    ) {
        if self.is_linear() {
            self.sweep(hourglass, |tiles, body| EachParticle::<_, SYMMETRIC> { tiles, body, function });
        } else {
            self.sweep(hourglass, |tiles, body| EachParticle::<_, GENERAL> { tiles, body, function });
        }
    }

    /// Leaves the gradient of the field that was spread in the tiled field `pair`.
    pub(super) fn gradient_sweep(&mut self) {
        if self.is_linear() {
            self.sweep(false, |_, body| Gradients::<SYMMETRIC> { body });
        } else {
            self.sweep(false, |_, body| Gradients::<GENERAL> { body });
        }
    }

    /// From the field that was spread to T_a and the part of the force that needs no neighbour's T, with P of a law for any
    /// deformation; returns that law.
    pub(super) fn stress_sweep<'a, P: Stress>(
        &'a mut self,
        materials: &'a Materials,
        stress: impl FnOnce(&'a Tiles) -> P,
    ) -> P {
        let (hourglass, modulus) = (self.hourglass, materials.places().map(|places| &places.modulus[..]));
        let sweep =
            |tiles, body| StressSweep::<_, GENERAL> { body, hourglass, modulus, stress: stress(tiles) };
        self.sweep(true, sweep).stress
    }

    /// [`Self::stress_sweep`] with P of linear laws, or with its change: what has relaxed is then left out (`whole` is false).
    pub(super) fn linear_stress_sweep(&mut self, whole: bool) {
        let materials = Arc::clone(&self.materials);
        match materials.places() {
            None => self.hooke_sweep(Hooke::new(materials.first_stiffness()), None, whole),
            Some(places) => self.hooke_sweep(HookeByPlace(places), Some(&places.modulus), whole),
        }
    }

    /// [`Self::linear_stress_sweep`] of a stress without relaxation.
    fn hooke_sweep(&mut self, stress: impl Stress, modulus: Option<&[Tile]>, whole: bool) {
        let hourglass = self.hourglass;
        let relaxation = self.relaxation.take();
        if let Some(relaxation) = &relaxation {
            let stress = Relaxed { stress, relaxation, whole };
            self.sweep(true, |_, body| StressSweep::<_, SYMMETRIC> { body, hourglass, modulus, stress });
        } else {
            self.sweep(true, |_, body| StressSweep::<_, SYMMETRIC> { body, hourglass, modulus, stress });
        }
        self.relaxation = relaxation;
    }

    /// From T_a and V P to the sums of the second sweep, the adjoint of the gradient.
    pub(super) fn adjoint_sweep(&mut self) {
        let components = self.components();
        let Workspace { q, pair, side, products, .. } = &mut self.work;
        ops::adjoint_sums(&self.lattice, None, pair, q);
        if let Some(memory) = &self.memory {
            memory.add_adjoint(&self.lattice, products, q);
        }
        if !self.correction.is_empty() {
            let (lattice, correction, results) = (&self.lattice, &self.correction, Results::new(None, 3, q));
            if components == SYMMETRIC {
                let field = ForceField::<SYMMETRIC> { correction, stress: side };
                ops::even_sums(lattice, &correction.reach, &field, results);
            } else {
                let field = ForceField::<GENERAL> { correction, stress: side };
                ops::even_sums(lattice, &correction.reach, &field, results);
            }
        }
        if let Some(contrast) = &self.contrast {
            contrast.add(self.hourglass, q);
        }
        self.lift.folds.react(self.hourglass, q);
        if !self.lift.is_empty() {
            let (tiles, rows, constants) = (&self.lattice.tiles, &self.correction.rows, &self.constants);
            self.lift.react(|a| {
                let (t, lane) = tiles.place(a);
                let volume = constants.volume(t)[lane];
                let stress = rows.number(t).map_or(&[][..], |n| &side[components * n..][..components]);
                let value = |c: usize| stress.get(c).map_or(0.0, |s| s.0[lane] / volume);
                if components == SYMMETRIC {
                    SymTensor(std::array::from_fn(value)).to_matrix()
                } else {
                    Mat3::from_fn(|i, j| value(3 * i + j))
                }
            });
        }
    }

    /// Internal forces on the particles from `first` on after both sweeps, Eq. (12) in adjoint form,
    /// component by component, those of held faces included.
    #[inline(always)]
    pub(super) fn internal_forces(&self, first: usize, force: [&mut [f64]; 3]) {
        let [fx, fy, fz] = force;
        let Workspace { q, pair, .. } = &self.work;
        self.lattice.tiles.for_each_run(first..first + fx.len(), |a, t, lane, count| {
            let at = a - first;
            let volume = self.constants.volume(t);
            for (i, f) in [&mut *fx, &mut *fy, &mut *fz].into_iter().enumerate() {
                let (own, adjoint) = (&pair[t * PAIR_COMPONENTS + 9 + i].0, &q[t * 3 + i].0);
                let f = &mut f[at..at + count];
                if let Ok(f) = <&mut [f64; LANES]>::try_from(&mut *f) {
                    for l in 0..LANES {
                        f[l] = own[l] + volume[l] * adjoint[l];
                    }
                } else {
                    for (l, f) in (lane..).zip(f) {
                        *f = own[l] + volume[l] * adjoint[l];
                    }
                }
            }
        });
        let folded = self.lift.folds.forces(first..first + fx.len(), q);
        for (a, lifted) in self.lift.forces(first..first + fx.len()).chain(folded) {
            let at = a - first;
            (fx[at], fy[at], fz[at]) = (fx[at] + lifted.x, fy[at] + lifted.y, fz[at] + lifted.z);
        }
    }

    /// Those components of the tiled field `pair`, component by component.
    pub(super) fn gather_pair(&self, components: Range<usize>) -> Vec<f64> {
        let n = self.len();
        let mut values = vec![0.0; components.len() * n];
        for a in 0..n {
            let (t, lane) = self.lattice.tiles.place(a);
            for (k, c) in components.clone().enumerate() {
                values[k * n + a] = self.work.pair[t * PAIR_COMPONENTS + c].0[lane];
            }
        }
        values
    }
}
