//! The two sweeps of the adjoint formulation: gradient and stress, then the adjoint of the gradient.

use super::correction::{Correction, ForceField, GENERAL, GradientField, Row, SYMMETRIC};
use super::hourglass::Memory;
use super::linear::{Constants, scatter};
use super::{Elastic, Workspace};
use crate::moments::Moments;
use crate::ops::{self, EachParticle, MAX_SIDE, PAIR_COMPONENTS, Results, Side};
use crate::tensor::{Mat3, SymTensor, Vec3};
use crate::tiles::{LANES, Tile, Tiles};
use std::ops::Range;

/// A field z, less its value at the first particle, that was spread over the tiles as V z.
#[derive(Clone, Copy)]
pub(super) struct Spread<'a> {
    pub(super) tiles: &'a Tiles,
    pub(super) q: &'a [Tile],
    pub(super) constants: &'a Constants,
}

impl Spread<'_> {
    /// Moments of a particle.
    #[inline(always)]
    pub(super) fn moments(&self, a: usize) -> Moments {
        let (t, lane) = self.tiles.place(a);
        self.constants.moments(t, lane)
    }

    /// z of a particle, less that of the first.
    #[inline(always)]
    pub(super) fn value(&self, a: usize) -> Vec3 {
        let (t, lane) = self.tiles.place(a);
        let inverse = 1.0 / self.constants.volume(t)[lane];
        Vec3::from_fn(|i, _| self.q[t * 3 + i].0[lane] * inverse)
    }
}

/// The sums of a field z at a particle a.
pub(super) struct Sums {
    /// G_a = sum V_b w (z_b - z_a) (x) L_a X, on the lattice, without the correction near the surface.
    pub(super) gradient: Mat3,
    /// grad z in the undeformed body, Eqs. (10), (13), corrected; under a linear law its antisymmetric part is not.
    pub(super) deformation: Mat3,
    /// sum V_b w (z_b - z_a).
    pub(super) laplacian: Vec3,
    pub(super) moments: Moments,
    /// z_a, less that of the first particle.
    pub(super) value: Vec3,
    /// Constants of the correction, where there is one.
    pub(super) row: Option<Row>,
    /// Of the hourglass term sum V_b w (z_b - z_a) (x) X_ba, before a remesh the sum that `gradient` is made of, and the gradient
    /// that follows from it.
    pub(super) smooth: [Mat3; 2],
}

/// What the gradient of a field that was spread depends on.
pub(super) struct Body<'a> {
    pub(super) stretch: &'a [Mat3],
    pub(super) spread: Spread<'a>,
    pub(super) correction: &'a Correction,
    pub(super) lifted: &'a [Tile],
    pub(super) memory: Option<&'a Memory>,
    /// Components of what is lifted and of the sums of the correction: [`SYMMETRIC`] or [`GENERAL`].
    pub(super) components: usize,
}

impl Body<'_> {
    /// Completes the lattice sums of particle a to G_a = sum V_b w (z_b - z_a) (x) L_a X, Eqs. (10),
    /// (13), to the Laplacian sum V_b w (z_b - z_a) and to the gradient in the undeformed body; `beside` are the sums of the
    /// correction and of the hourglass term.
    #[inline(always)]
    fn complete(&self, a: usize, h: &Mat3, q: &Vec3, [beside, products]: &[[f64; MAX_SIDE]; 2]) -> Sums {
        let (t, lane) = self.spread.tiles.place(a);
        let m = self.spread.constants.moments(t, lane);
        let value = self.spread.value(a);
        let (first, laplacian) = (h - value * m.first.transpose(), q - value * m.zeroth);
        let gradient = first * m.correction;
        let mut deformation = undeformed(self.stretch, a, &gradient);
        let mut row = None;
        if let Some(number) = self.correction.rows.number(t) {
            row = self.correction.row(t, lane, m.volume);
            if let Some(row) = &row {
                let own = laplacian * row.gamma.transpose()
                    + value * row.zeroth.transpose()
                    + first * row.slope.transpose();
                deformation += self.tensor(beside) - own;
            }
            if !self.lifted.is_empty() {
                let lifted = &self.lifted[self.components * number..][..self.components];
                deformation +=
                    self.tensor(&std::array::from_fn(|c| lifted.get(c).map_or(0.0, |tile| tile.0[lane])));
            }
        }
        let mut smooth = [first, gradient];
        if let Some(memory) = self.memory {
            let of = memory.of((t, lane));
            let moved = laplacian * of.displacement.transpose() + value * of.zeroth.transpose();
            smooth[0] -= Mat3::from_row_slice(products) - moved;
            smooth[1] = smooth[0] * of.inverse;
        }
        Sums { gradient, deformation, laplacian, moments: m, value, row, smooth }
    }
}

impl Body<'_> {
    /// The tensor with these components.
    #[inline(always)]
    fn tensor(&self, values: &[f64; MAX_SIDE]) -> Mat3 {
        if self.components == SYMMETRIC {
            let [xx, yy, zz, xy, yz, xz, ..] = *values;
            SymTensor([xx, yy, zz, xy, yz, xz]).to_matrix()
        } else {
            Mat3::from_row_slice(values)
        }
    }
}

impl Elastic {
    /// Prepares V_b (z_b - z_0) of the field z = u + T v, whose gradient is the effective strain of Eq. (5), and what held faces
    /// and the correction near the surface make of it.
    pub(super) fn spread(&mut self, u: &[f64], v: Option<(&[f64], f64)>) {
        let n = self.len();
        let value = |a: usize| Vec3::from_fn(|i, _| u[i * n + a] + v.map_or(0.0, |(v, t)| t * v[i * n + a]));
        // Nothing but differences of z counts: without its translation a body far from where it started rounds no worse.
        let origin = if n > 0 { value(0) } else { Vec3::zeros() };
        scatter(&self.lattice.tiles, &self.constants, u, v, &origin, &mut self.work.q);
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

    /// The field that was spread.
    pub(super) fn spread_field(&self) -> Spread<'_> {
        Spread { tiles: &self.lattice.tiles, q: &self.work.q, constants: &self.constants }
    }

    /// Leaves `visit(body, particle, sums, slopes)` of the field that was spread in the tiled field `pair`, and what it
    /// makes of `slopes`, V P and dE/dU of the hourglass term, where the second sweep wants them. Only for that term
    /// (`hourglass`) what it remembers is summed.
    pub(super) fn visit_sums(
        &mut self,
        hourglass: bool,
        visit: impl Fn(&Body<'_>, usize, &Sums, &mut [[f64; MAX_SIDE]; 2]) -> [f64; PAIR_COMPONENTS] + Sync,
    ) {
        let components = self.components();
        let Workspace { q, pair, side, lifted, products, .. } = &mut self.work;
        let memory = self.memory.as_ref().filter(|_| hourglass);
        if let Some(memory) = memory {
            memory.spread(&self.lattice, q, products);
        }
        let tiles = &self.lattice.tiles;
        let body = Body {
            stretch: &self.stretch,
            spread: Spread { tiles, q, constants: &self.constants },
            correction: &self.correction,
            lifted,
            memory,
            components,
        };
        let each = EachParticle {
            tiles,
            function: |a, h: &Mat3, q: &Vec3, beside: &mut [[f64; MAX_SIDE]; 2]| {
                let sums = body.complete(a, h, q, beside);
                visit(&body, a, &sums, beside)
            },
        };
        let side =
            (!side.is_empty()).then_some(Side { part: &self.correction.rows, components, values: side });
        let products =
            memory.map(|memory| Side { part: &memory.whole, components: GENERAL, values: products });
        ops::gradient_sums(&self.lattice, None, q, pair, [side, products], &each);
    }

    /// From the field that was spread to T_a and the part of the force that needs no neighbour's T:
    /// T_a = V_a (P_a (F_a^T L_a - z Gamma_a) - kappa G_a), with F = d xi / d X and G on the lattice; P of a linear law.
    pub(super) fn stress_sweep(&mut self) {
        let stiffness = self.stiffness;
        if self.stretch.is_empty() && self.is_linear() {
            self.linear_stress_sweep(&stiffness);
        } else {
            let hooke = |g: &Mat3| stiffness.stress(SymTensor::symmetric_part(g)).to_matrix(); // Eq. (5)
            self.general_stress_sweep(|_, _, g| hooke(g));
        }
    }

    /// [`Self::stress_sweep`] with P as a function of (tiles, particle, grad z).
    pub(super) fn general_stress_sweep(&mut self, first_piola: impl Fn(&Tiles, usize, &Mat3) -> Mat3 + Sync) {
        let kappa = self.hourglass;
        self.visit_sums(true, |body, a, sums, [stress, slope]| {
            let m = &sums.moments;
            let piola = first_piola(body.spread.tiles, a, &sums.deformation);
            let q = piola * m.volume;
            if body.components == SYMMETRIC {
                stress[..SYMMETRIC].copy_from_slice(&SymTensor::symmetric_part(&q).0);
            } else {
                *stress = std::array::from_fn(|c| q[(c / 3, c % 3)]);
            }
            let stretched = body.stretch.get(a).map_or(piola, |f| piola * f.transpose());
            let mut t = stretched * m.correction - sums.smooth[1] * kappa;
            let mut own = sums.laplacian * (2.0 * kappa * m.volume);
            if let Some(row) = &sums.row {
                t -= piola * row.slope;
                own += piola * (row.zeroth - row.gamma * m.zeroth) * m.volume;
            }
            t *= m.volume;
            own += t * m.first;
            if let Some(memory) = body.memory {
                let of = memory.of(body.spread.tiles.place(a));
                let w = sums.smooth[1] * (kappa * m.volume);
                own += w * (of.zeroth - of.displacement * m.zeroth);
                *slope = std::array::from_fn(|c| w[(c / 3, c % 3)]);
            }
            let mut out = [0.0; PAIR_COMPONENTS];
            for i in 0..3 {
                for j in 0..3 {
                    out[3 * i + j] = t[(i, j)];
                }
                out[9 + i] = own[i];
            }
            out
        });
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
        for (a, lifted) in self.lift.forces(first..first + fx.len()) {
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

/// A gradient on the lattice as one in the undeformed body, G F.
#[inline(always)]
pub(super) fn undeformed(stretch: &[Mat3], a: usize, g: &Mat3) -> Mat3 {
    stretch.get(a).map_or(*g, |f| g * f)
}
