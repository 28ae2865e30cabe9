//! Stress of particles that relaxes by Prony series: S = beta S^e - K with beta = 1 + sum_i gamma_i and K = sum_i gamma_i A_i, where the
//! stresses A_i are columns of the particles with dA_i/dt = (S^e - A_i)/tau_i.
//!
//! P = F S of a law for any strain; sigma under a linear law. At given A_i it is the derivative of beta W - K : E. In a step of an
//! implicit scheme A_i is found for a stress that goes straight from the start of the step to the end of a stage, so that c_i of
//! S^e at the end of the stage is in it: the stress is of the same form with other beta and K.

use super::Solid;
use super::correction::SYMMETRIC;
use super::materials::Materials;
use super::stress::{Hooke, HookeByPlace, Stress, Total};
use super::sweeps::{At, Body};
use crate::material::{MAX_TERMS, PronyTerm};
use crate::ops::{PAIR_COMPONENTS, Pointwise};
use crate::particles::{Column, Field, Particles, RELAXED_STRESSES};
use crate::tensor::lanes::{Lanes, Tensor};
use crate::tensor::{Mat3, SymTensor};
use crate::tiles::{LANES, Tile, Tiles};
use pulp::Simd;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

/// The columns of the stresses A_i.
const COLUMNS: [Field; MAX_TERMS] = RELAXED_STRESSES;

/// What is integrated in time: the first columns of them.
const INTEGRATED: [Field; 2 + MAX_TERMS] = [
    Field::Displacement,
    Field::Velocity,
    COLUMNS[0],
    COLUMNS[1],
    COLUMNS[2],
    COLUMNS[3],
    COLUMNS[4],
    COLUMNS[5],
];

/// Components of a stress.
const COMPONENTS: usize = 6;

/// beta and K of every particle.
#[derive(Clone, Debug)]
pub(super) struct Relaxation {
    /// Terms of the longest series.
    terms: usize,
    /// beta, a tile for each tile.
    factor: Vec<Tile>,
    /// The largest of them in a material.
    largest_factor: f64,
    /// K, tiled field of 6.
    relaxed: Vec<Tile>,
    /// S^e at the start of the step, component by component.
    start: Vec<f64>,
    /// Whether beta and K are those of a stage of an implicit step.
    is_stage: bool,
}

impl Relaxation {
    /// Of a body that has not relaxed yet, K = 0; `None` if no material relaxes.
    pub(super) fn new(materials: &Materials, tiles: &Tiles) -> Option<Self> {
        let terms = materials.most_prony_terms();
        if terms == 0 {
            return None;
        }
        let mut new = Self {
            terms,
            factor: tiles.field(1),
            largest_factor: 1.0,
            relaxed: tiles.field(COMPONENTS),
            start: Vec::new(),
            is_stage: false,
        };
        new.set_factors(materials, tiles, |_| 0.0);
        Some(new)
    }

    /// Sets beta, with the share of S^e at the end of the stage that is in A_i of a term.
    fn set_factors(&mut self, materials: &Materials, tiles: &Tiles, share: impl Fn(&PronyTerm) -> f64) {
        let factor = |terms: &[PronyTerm]| {
            1.0 + terms.iter().map(|term| term.share * (1.0 - share(term))).sum::<f64>()
        };
        let factors: Vec<f64> = materials.all_prony_terms().map(factor).collect();
        self.largest_factor = factors.iter().copied().fold(1.0, f64::max);
        self.factor.par_iter_mut().enumerate().for_each(|(t, tile)| {
            for l in 0..LANES {
                tile.0[l] = tiles.particle(t, l).map_or(1.0, |a| factors[materials.number(a)]);
            }
        });
    }

    /// Sets K, a sum over terms of what `part` makes of (number of the material, of the term, component, particle), times gamma.
    fn set_relaxed(
        &mut self,
        materials: &Materials,
        tiles: &Tiles,
        part: impl Fn([usize; 3], usize) -> f64 + Sync,
    ) {
        self.relaxed.par_chunks_mut(COMPONENTS).enumerate().for_each(|(t, tile)| {
            for l in 0..LANES {
                let Some(a) = tiles.particle(t, l) else { continue };
                let (number, terms) = (materials.number(a), materials.prony_terms(a));
                for (c, tile) in tile.iter_mut().enumerate() {
                    let terms = terms.iter().enumerate();
                    tile.0[l] = terms.map(|(i, term)| term.share * part([number, i, c], a)).sum();
                }
            }
        });
    }

    /// Forgets the stages of a step.
    fn end_stages(&mut self, materials: &Materials, tiles: &Tiles) {
        if std::mem::take(&mut self.is_stage) {
            self.set_factors(materials, tiles, |_| 0.0);
        }
    }

    /// The stress of a law for any strain, or its change: beta P - F K.
    #[inline(always)]
    pub(super) fn general<S: Simd>(
        &self,
        at: &At<S>,
        elastic: &Tensor<Lanes<S>>,
        f: &Tensor<Lanes<S>>,
    ) -> Tensor<Lanes<S>> {
        self.scaled(at, elastic) - f.times(&self.relaxed(at))
    }

    /// beta P.
    #[inline(always)]
    fn scaled<S: Simd>(&self, at: &At<S>, elastic: &Tensor<Lanes<S>>) -> Tensor<Lanes<S>> {
        elastic.scaled(at.load(&self.factor[at.tile]))
    }

    /// K.
    #[inline(always)]
    fn relaxed<S: Simd>(&self, at: &At<S>) -> Tensor<Lanes<S>> {
        at.tensor::<SYMMETRIC>(&self.relaxed, at.tile)
    }

    /// Cauchy stress of a particle, beta sigma^e - F K F^T / det F, with sigma^e by its law.
    pub(super) fn cauchy(
        &self,
        (tile, lane): (usize, usize),
        elastic: SymTensor,
        gradient: &Mat3,
        is_linear: bool,
    ) -> SymTensor {
        let k = SymTensor(std::array::from_fn(|c| self.relaxed[tile * COMPONENTS + c].0[lane]));
        let whole = elastic * self.factor[tile].0[lane];
        if is_linear {
            return whole - k;
        }
        let f = Mat3::identity() + gradient;
        whole - SymTensor::symmetric_part(&(f * k.to_matrix() * f.transpose() / f.determinant()))
    }
}

/// A linear law, or the positive tangent of any other, that relaxes.
pub(super) struct Relaxed<'a, P> {
    pub(super) stress: P,
    pub(super) relaxation: &'a Relaxation,
    /// Whether it is the whole stress and not its change.
    pub(super) whole: bool,
}

impl<P: Stress> Stress for Relaxed<'_, P> {
    #[inline(always)]
    fn piola<S: Simd>(&self, at: &At<S>, gradient: &Tensor<Lanes<S>>) -> Tensor<Lanes<S>> {
        let stress = self.relaxation.scaled(at, &self.stress.piola(at, gradient));
        if self.whole { stress - self.relaxation.relaxed(at) } else { stress }
    }
}

/// S^e = F^-1 P^e; sigma^e under a linear law.
struct ElasticStress<'a, P, const C: usize> {
    body: Body<'a>,
    stress: P,
}

impl<P: Stress, const C: usize> Pointwise for ElasticStress<'_, P, C> {
    #[inline(always)]
    fn transform<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        lane: usize,
        results: &mut [S::f64s; PAIR_COMPONENTS],
        [side, memory]: [&mut [Tile]; 2],
    ) {
        let at = At { simd, tile, lane };
        let sums = self.body.complete::<S, false, C>(&at, results, [side, memory]);
        let mut stress = self.stress.piola(&at, &sums.deformation);
        if C != SYMMETRIC {
            let (inverse_transpose, _) = sums.deformation.plus_number(1.0).inverse_transpose();
            stress = inverse_transpose.transpose().times(&stress).symmetric_part();
        }
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = stress.0;
        for (result, s) in results.iter_mut().zip([xx, yy, zz, xy, yz, xz]) {
            *result = s.1;
        }
    }
}

impl Solid {
    /// The columns that are integrated in time.
    pub(super) fn columns(&self) -> &'static [Field] {
        &INTEGRATED[..2 + self.relaxed_columns().len()]
    }

    /// The columns of the stresses to which the terms of Prony series have relaxed.
    pub(crate) fn relaxed_columns(&self) -> &'static [Field] {
        &COLUMNS[..self.relaxation.as_ref().map_or(0, |relaxation| relaxation.terms)]
    }

    /// The shortest time of the Prony series (s); infinite if there is none.
    pub(crate) fn shortest_prony_time(&self) -> f64 {
        self.materials.all_prony_terms().flatten().map(|term| term.time).fold(f64::INFINITY, f64::min)
    }

    /// By how much the body is stiffer than its laws, at most.
    pub(crate) fn stiffening(&self) -> f64 {
        self.relaxation.as_ref().map_or(1.0, |relaxation| relaxation.largest_factor)
    }

    /// What `visit` does with the body that has relaxed.
    pub(crate) fn fully_relaxed<R>(&mut self, visit: impl FnOnce(&mut Self) -> R) -> R {
        let relaxation = self.relaxation.take();
        let result = visit(self);
        self.relaxation = relaxation;
        result
    }

    /// Leaves S^e at time `t` with the displacement u in the first six components of the tiled field `pair`.
    fn elastic_stress_sweep(&mut self, t: f64, u: &[f64]) {
        self.spread_displacement(t, u);
        let materials = Arc::clone(&self.materials);
        let materials = &*materials;
        match (self.is_linear(), materials.places()) {
            (true, None) => {
                let stress = Hooke::new(materials.first_stiffness());
                self.sweep(false, |_, body| ElasticStress::<_, SYMMETRIC> { body, stress });
            }
            (true, Some(places)) => {
                let stress = HookeByPlace(places);
                self.sweep(false, |_, body| ElasticStress::<_, SYMMETRIC> { body, stress });
            }
            (false, _) => {
                let inverted = AtomicUsize::new(usize::MAX);
                self.sweep(false, |tiles, body| ElasticStress::<_, { super::GENERAL }> {
                    body,
                    stress: Total { materials, tiles, rate: None, relaxation: None, inverted },
                });
            }
        }
    }

    /// Calls `set(value, S^e there, component, particle)` for all values of a column, with S^e as the last sweep has left it.
    fn each_stress(&self, values: &mut [f64], set: impl Fn(&mut f64, f64, usize, usize) + Sync) {
        let (n, tiles, pair) = (self.len(), &self.lattice.tiles, &self.work.pair);
        let chunk = super::PARTICLES_PER_SUM;
        for (c, values) in values.chunks_mut(n.max(1)).enumerate() {
            values.par_chunks_mut(chunk).enumerate().for_each(|(k, values)| {
                for (i, value) in values.iter_mut().enumerate() {
                    let a = k * chunk + i;
                    let (t, lane) = tiles.place(a);
                    set(value, pair[t * PAIR_COMPONENTS + c].0[lane], c, a);
                }
            });
        }
    }

    /// Takes the stresses to which `particles` have relaxed, unless a stage of an implicit step has set them.
    pub(super) fn take_relaxed(&mut self, particles: &Particles) {
        let columns = columns_of(particles, self.relaxed_columns());
        let (materials, tiles) = (&self.materials, &self.lattice.tiles);
        let Some(relaxation) = self.relaxation.as_mut().filter(|relaxation| !relaxation.is_stage) else {
            return;
        };
        let relaxed = |[_, i, c]: [usize; 3], a: usize| columns[i].map_or(0.0, |of| of.component(c)[a]);
        relaxation.set_relaxed(materials, tiles, relaxed);
    }

    /// dA_i/dt of every term at time `t` into `rates`.
    pub(super) fn relaxed_rates(&mut self, t: f64, particles: &Particles, rates: &mut [Column]) {
        self.elastic_stress_sweep(t, particles.column(Field::Displacement).values());
        for (i, (rate, field)) in rates.iter_mut().zip(self.relaxed_columns()).enumerate() {
            let relaxed = particles.column(*field);
            self.each_stress(rate.values_mut(), |rate, stress, c, a| {
                let term = self.materials.prony_terms(a).get(i);
                *rate = term.map_or(0.0, |term| (stress - relaxed.component(c)[a]) / term.time);
            });
        }
    }

    /// Starts an implicit step at time `t`.
    pub(crate) fn start_step(&mut self, t: f64, particles: &Particles) {
        let Some(mut start) = self.relaxation.as_mut().map(|r| std::mem::take(&mut r.start)) else { return };
        self.elastic_stress_sweep(t, particles.column(Field::Displacement).values());
        start.resize(COMPONENTS * self.len(), 0.0);
        self.each_stress(&mut start, |start, stress, _, _| *start = stress);
        if let Some(relaxation) = &mut self.relaxation {
            relaxation.start = start;
        }
    }

    /// Starts a stage that ends a time `h` after the start of the step, whose stresses A_i are those of `particles`.
    pub(crate) fn start_stage(&mut self, h: f64, particles: &Particles) {
        let columns = columns_of(particles, self.relaxed_columns());
        let (n, materials, tiles) = (self.len(), &self.materials, &self.lattice.tiles);
        let Some(relaxation) = &mut self.relaxation else { return };
        let updates = updates(materials, h);
        relaxation.is_stage = true;
        relaxation.set_factors(materials, tiles, |term| term.exact_update(h)[2]);
        let start = std::mem::take(&mut relaxation.start);
        relaxation.set_relaxed(materials, tiles, |[number, i, c], a| {
            let [of_relaxed, of_start, _] = updates[number][i];
            of_relaxed * columns[i].map_or(0.0, |of| of.component(c)[a]) + of_start * start[c * n + a]
        });
        relaxation.start = start;
    }

    /// Ends a step of length `h` at time `t`, with the stresses A_i of `particles` as they were at its start.
    pub(crate) fn end_step(&mut self, t: f64, h: f64, particles: &mut Particles) {
        let Some(start) = self.relaxation.as_mut().map(|r| std::mem::take(&mut r.start)) else { return };
        self.elastic_stress_sweep(t, particles.column(Field::Displacement).values());
        let (n, updates) = (self.len(), updates(&self.materials, h));
        for (i, field) in self.relaxed_columns().iter().enumerate() {
            self.each_stress(particles.column_mut(*field).values_mut(), |relaxed, stress, c, a| {
                if let Some([of_relaxed, of_start, of_end]) = updates[self.materials.number(a)].get(i) {
                    *relaxed = of_relaxed * *relaxed + of_start * start[c * n + a] + of_end * stress;
                }
            });
        }
        if let Some(relaxation) = &mut self.relaxation {
            relaxation.start = start;
        }
        self.drop_step();
    }

    /// Gives up a step: its stages count no more.
    pub(crate) fn drop_step(&mut self) {
        if let Some(relaxation) = &mut self.relaxation {
            relaxation.end_stages(&self.materials, &self.lattice.tiles);
        }
    }

    /// Lets `particles` relax at time `t` for good: A_i = S^e.
    pub(crate) fn relax_fully(&mut self, t: f64, particles: &mut Particles) {
        if self.relaxation.is_none() {
            return;
        }
        self.elastic_stress_sweep(t, particles.column(Field::Displacement).values());
        for (i, field) in self.relaxed_columns().iter().enumerate() {
            self.each_stress(particles.column_mut(*field).values_mut(), |relaxed, stress, _, a| {
                *relaxed = if self.materials.prony_terms(a).len() > i { stress } else { 0.0 };
            });
        }
    }

    /// Energy in the springs of the Maxwell elements (J).
    pub(super) fn energy_of_elements(&mut self, t: f64, particles: &Particles) -> f64 {
        let columns = self.relaxed_columns();
        if columns.is_empty() {
            return 0.0;
        }
        self.spread_displacement(t, particles.column(Field::Displacement).values());
        let materials = Arc::clone(&self.materials);
        self.visit_sums(false, |a, _, sums| {
            let terms = materials.prony_terms(a).iter().zip(columns);
            let energy = terms.map(|(term, field)| {
                let relaxed = particles.column(*field).tensor(a);
                term.share * materials.energy_beyond(a, &sums.deformation, relaxed)
            });
            let mut out = [0.0; PAIR_COMPONENTS];
            out[0] = sums.volume * energy.sum::<f64>();
            out
        });
        self.sum_of_particles()
    }
}

/// [`PronyTerm::exact_update`] of the terms of every material.
fn updates(materials: &Materials, h: f64) -> Vec<Vec<[f64; 3]>> {
    let of = |terms: &[PronyTerm]| terms.iter().map(|term| term.exact_update(h)).collect();
    materials.all_prony_terms().map(of).collect()
}

/// The first of `columns` of `particles`.
fn columns_of<'a>(particles: &'a Particles, columns: &[Field]) -> [Option<&'a Column>; MAX_TERMS] {
    std::array::from_fn(|i| columns.get(i).map(|field| particles.column(*field)))
}
