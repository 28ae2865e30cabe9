//! The correction of the gradient near the surface by which a constant stress balances its tractions.
//!
//! The force of a constant stress sigma is -sigma A_b with A_b = sum_a V_a g_ab, while its tractions act by
//! B_b = int phi_b n dS, with the weights phi of the surface. To rows near the surface (z_a = 1, else 0) the gradient gets
//!
//! ```text
//! z_a sum_b V_b w (f_b - f_a) (gamma_b - gamma_a - Gamma_a X),       Gamma_a = grad gamma,
//! ```
//!
//! the least change dg, in the norm sum_a V_a sum_b |dg_ab|^2 / (V_b w), that keeps constants and linear fields exact and makes A = B. gamma
//! solves H gamma^i = (B - A)^i with H the operator of the hourglass term, V_a replaced by z_a V_a.
//! (J.-S. Chen, M. Hillman, M. Rueter, Int. J. Numer. Meth. Eng. 95, 2013: integration constraints.)

use super::constants::{Constants, scatter};
use crate::boundary::fold::{Folds, Following};
use crate::lattice::{Lattice, reflection};
use crate::moments::{Moments, area_vectors};
use crate::ops::{self, EvenField, PAIR_COMPONENTS, Part, Pointwise, Results};
use crate::tensor::lanes::{Lanes, Real, Tensor};
use crate::tensor::{Mat3, Vec3};
use crate::tiles::{LANES, Tile};
use nalgebra::{Matrix4, Vector4};
use pulp::Simd;
use rayon::prelude::*;

/// |B - A| at which gamma is good enough, as a share of that without the correction. Linear exactness and symmetry do not
/// depend on it.
const TOLERANCE: f64 = 5e-5;
/// Iterations after which gamma is good enough in any case.
const MAX_ITERATIONS: usize = 1000;
/// Growth of |B - A| over the least so far at which a component is given up.
const LOST: f64 = 30.0;
/// Layers of cells whose rows are corrected. With one a pulled box is off by up to 3e-7 instead of 1e-10 and clamped cubes
/// are less accurate; with three or four at h = 1.25 dx nothing gets better.
const LAYERS: usize = 2;
/// Particles that one partial sum covers.
const PARTICLES_PER_SUM: usize = 4096;

/// Numbers of a corrected row: z, z gamma, z sum V_b w gamma_b / V, the nine of z Gamma.
pub(super) const ROW: usize = 16;
/// Components of a symmetric tensor: strain and stress of a linear law.
pub(super) const SYMMETRIC: usize = 6;
/// Components of any tensor: displacement gradient and first Piola-Kirchhoff stress.
pub(super) const GENERAL: usize = 9;
/// Row and column of the components of a symmetric tensor.
pub(super) const PLACES: [(usize, usize); SYMMETRIC] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];

/// Place of component (i, j) among the six of a symmetric tensor.
pub(super) const SYM: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// Place of component (i, j) among the `C` of a tensor.
#[inline(always)]
const fn component<const C: usize>(i: usize, j: usize) -> usize {
    if C == SYMMETRIC { SYM[i][j] } else { 3 * i + j }
}

/// gamma with the constants of the rows that it corrects.
#[derive(Clone, Debug, Default)]
pub(super) struct Correction {
    /// Tiles with rows that are corrected or that a held face is lifted into.
    pub(super) rows: Part,
    /// Tiles with particles that those rows see.
    pub(super) reach: Part,
    /// gamma, on `reach`.
    pub(super) gamma: Vec<Tile>,
    /// Constants of `rows`.
    pub(super) constants: Vec<Tile>,
}

/// What a correction is made from.
pub(super) struct Surroundings<'a> {
    pub(super) lattice: &'a Lattice,
    pub(super) constants: &'a Constants,
    /// Moments of each particle.
    pub(super) moments: &'a [Moments],
    /// d xi / d X at the last remesh, or nothing.
    pub(super) remesh_gradients: &'a [Mat3],
    /// Whether each row is corrected.
    pub(super) flagged: &'a [bool],
    /// B, component by component.
    pub(super) wanted: &'a [f64],
    /// Particles that held faces are lifted into.
    pub(super) lifted: &'a [u32],
    /// The folds, where gamma is mirrored.
    pub(super) folds: &'a Folds,
}

/// Whether each cell lies in one of the first [`LAYERS`] from the surface: the first are those that the surface cuts or that
/// miss one of their 26 neighbours or do not see it across a gap.
pub(super) fn near_surface(lattice: &Lattice, cut: &[bool]) -> Vec<bool> {
    let around = |a: usize| {
        let c = lattice.coordinates(a).map(|x| x as isize);
        (0..27).filter(|k| *k != 13).map(move |k| {
            let o = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            lattice.particle(std::array::from_fn(|i| c[i] + o[i])).filter(|b| !lattice.cuts.part(a, *b))
        })
    };
    let mut near: Vec<bool> =
        (0..lattice.len()).into_par_iter().map(|a| cut[a] || around(a).any(|b| b.is_none())).collect();
    for _ in 1..LAYERS {
        near = (0..lattice.len())
            .into_par_iter()
            .map(|a| near[a] || around(a).flatten().any(|b| near[b]))
            .collect();
    }
    near
}

impl Correction {
    /// Solves for gamma.
    pub(super) fn new(body: &Surroundings<'_>) -> Self {
        let Surroundings { lattice, constants, flagged, lifted, .. } = *body;
        let tiles = &lattice.tiles;
        let (mut has_row, mut is_reached) = (vec![false; tiles.len()], vec![false; tiles.len()]);
        for a in (0..lattice.len()).filter(|a| flagged[*a]) {
            let t = tiles.place(a).0;
            (has_row[t], is_reached[t]) = (true, true);
            for neighbour in &lattice.neighbours {
                if let Some(seen) = lattice.seen(a, neighbour) {
                    is_reached[seen.tile] = true;
                }
            }
        }
        for a in lifted {
            has_row[tiles.place(*a as usize).0] = true;
        }
        let rows = Part::new(lattice, |t| has_row[t]);
        let reach = Part::new(lattice, |t| is_reached[t]);
        let mut solver = Solver::new(body, &rows, &reach);
        let gamma = solver.solve(body);
        let mut tiled = vec![Tile::default(); 3 * reach.len()];
        for (a, gamma) in gamma.iter().enumerate() {
            let (t, lane) = tiles.place(a);
            if let Some(number) = reach.number(t) {
                for i in 0..3 {
                    tiled[3 * number + i].0[lane] = gamma[i];
                }
            }
        }
        for image in &lattice.images {
            let (t, lane) = image.place();
            if let Some(number) = reach.number(t) {
                let gamma = gamma[image.particle as usize].component_mul(&reflection(image.mirrors));
                (0..3).for_each(|i| tiled[3 * number + i].0[lane] = gamma[i]);
            }
        }
        let mut row_constants = vec![Tile::default(); ROW * rows.len()];
        for a in (0..lattice.len()).filter(|a| flagged[*a]) {
            let (t, lane) = tiles.place(a);
            let Some(number) = rows.number(t) else { continue };
            let m = &body.moments[a];
            let (mut zeroth, mut first) = (Vec3::zeros(), Mat3::zeros());
            for neighbour in &lattice.neighbours {
                if let Some(seen) = lattice.seen(a, neighbour) {
                    let b = seen.particle;
                    let (t, lane) = tiles.place(b);
                    let vw = constants.volume(t)[lane] * neighbour.w;
                    let other = gamma[b].component_mul(&reflection(seen.mirrors));
                    zeroth += vw * other;
                    first += vw * (other - gamma[a]) * neighbour.x.transpose();
                }
            }
            let slope = first * m.correction;
            let mut values = [0.0; ROW];
            values[0] = 1.0;
            for i in 0..3 {
                values[1 + i] = gamma[a][i];
                values[4 + i] = zeroth[i] / m.volume;
                for j in 0..3 {
                    values[7 + 3 * i + j] = slope[(i, j)];
                }
            }
            for (tile, value) in row_constants[ROW * number..][..ROW].iter_mut().zip(values) {
                tile.0[lane] = value;
            }
        }
        Self { rows, reach, gamma: tiled, constants: row_constants }
    }

    /// Whether there are neither corrected nor lifted rows.
    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Constants of the row of a particle: z gamma, z sum V_b w gamma_b, z Gamma; `None` for a row that is not corrected.
    pub(super) fn row(&self, tile: usize, lane: usize, volume: f64) -> Option<Row> {
        let values = &self.constants[ROW * self.rows.number(tile)?..][..ROW];
        let value = |c: usize| values[c].0[lane];
        (value(0) > 0.0).then(|| Row {
            gamma: Vec3::from_fn(|i, _| value(1 + i)),
            zeroth: Vec3::from_fn(|i, _| value(4 + i)) * volume,
            slope: Mat3::from_fn(|i, j| value(7 + 3 * i + j)),
        })
    }

    /// gamma of a particle; zero where no corrected row sees it.
    pub(super) fn gamma(&self, tile: usize, lane: usize) -> Vec3 {
        self.reach
            .number(tile)
            .map_or_else(Vec3::zeros, |n| Vec3::from_fn(|i, _| self.gamma[3 * n + i].0[lane]))
    }
}

/// What the sums of the first sweep are taken of: q (x) gamma, q = V z, or its symmetric part, as `C` says.
pub(super) struct GradientField<'a, const C: usize> {
    /// Where gamma is.
    pub(super) reach: &'a Part,
    pub(super) gamma: &'a [Tile],
    pub(super) q: &'a [Tile],
}

impl<const C: usize> EvenField<C> for GradientField<'_, C> {
    #[inline(always)]
    fn lanes<const N: usize>(&self, tile: usize, first: usize) -> Option<[[f64; N]; C]> {
        let number = self.reach.number(tile)?;
        let gamma = &self.gamma[3 * number..][..3];
        let q = &self.q[3 * tile..][..3];
        let mut values = [[0.0; N]; C];
        for (c, values) in values.iter_mut().enumerate() {
            let (i, j) = if C == SYMMETRIC { PLACES[c] } else { (c / 3, c % 3) };
            let [qi, qj, gi, gj] = [&q[i], &q[j], &gamma[i], &gamma[j]].map(|tile| &tile.0[first..first + N]);
            for l in 0..N {
                values[l] =
                    if C == SYMMETRIC { 0.5 * (qi[l] * gj[l] + qj[l] * gi[l]) } else { qi[l] * gj[l] };
            }
        }
        Some(values)
    }
}

/// What the sums of the second sweep are taken of: z Q and z Q gamma, of Q = V P on the rows, which has `C` components. To the
/// adjoint of the gradient is added what they make.
pub(super) struct ForceField<'a, const C: usize> {
    pub(super) correction: &'a Correction,
    /// Q.
    pub(super) stress: &'a [Tile],
}

impl<const C: usize> ForceField<'_, C> {
    #[inline(always)]
    fn values<const SUMS: usize, const N: usize>(
        &self,
        tile: usize,
        first: usize,
    ) -> Option<[[f64; N]; SUMS]> {
        let number = self.correction.rows.number(tile)?;
        let row = &self.correction.constants[ROW * number..][..ROW];
        let stress = &self.stress[C * number..][..C];
        let mut values = [[0.0; N]; SUMS];
        for (values, stress) in values.iter_mut().zip(stress) {
            for l in 0..N {
                values[l] = row[0].0[first + l] * stress.0[first + l];
            }
        }
        for i in 0..3 {
            let [x, y, z] = std::array::from_fn(|j| component::<C>(i, j));
            for l in 0..N {
                // z is in these constants.
                let at = first + l;
                values[C + i][l] = stress[x].0[at] * row[1].0[at]
                    + stress[y].0[at] * row[2].0[at]
                    + stress[z].0[at] * row[3].0[at];
            }
        }
        Some(values)
    }

    /// Adds S[z Q gamma] - S[z Q] gamma.
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, tile: usize, lane: usize, sums: &[S::f64s], adjoint: &mut [Tile]) {
        let Some(number) = self.correction.reach.number(tile) else { return };
        add_adjoint::<S, C>(simd, &self.correction.gamma[3 * number..][..3], lane, sums, adjoint);
    }
}

/// Adds S[Q gamma] - S[Q] gamma to the adjoint of the gradient, from the sums of Q, which has `C` components, and of Q gamma.
#[inline(always)]
pub(super) fn add_adjoint<S: Simd, const C: usize>(
    simd: S,
    gamma: &[Tile],
    lane: usize,
    sums: &[S::f64s],
    adjoint: &mut [Tile],
) {
    for (i, adjoint) in adjoint.iter_mut().enumerate() {
        let mut sum = simd.add_f64s(ops::load(simd, &adjoint.0, lane), sums[C + i]);
        for j in 0..3 {
            let stress = sums[component::<C>(i, j)];
            sum = simd.negate_mul_add_e_f64s(stress, ops::load(simd, &gamma[j].0, lane), sum);
        }
        S::as_mut_simd_f64s(&mut adjoint.0[lane..lane + S::F64_LANES]).0[0] = sum;
    }
}

impl EvenField<{ SYMMETRIC + 3 }> for ForceField<'_, SYMMETRIC> {
    #[inline(always)]
    fn lanes<const N: usize>(&self, tile: usize, first: usize) -> Option<[[f64; N]; SYMMETRIC + 3]> {
        self.values(tile, first)
    }

    #[inline(always)]
    fn keep<S: Simd>(&self, simd: S, tile: usize, lane: usize, sums: &[S::f64s], adjoint: &mut [Tile]) {
        self.add(simd, tile, lane, sums, adjoint);
    }
}

impl EvenField<{ GENERAL + 3 }> for ForceField<'_, GENERAL> {
    #[inline(always)]
    fn lanes<const N: usize>(&self, tile: usize, first: usize) -> Option<[[f64; N]; GENERAL + 3]> {
        self.values(tile, first)
    }

    #[inline(always)]
    fn keep<S: Simd>(&self, simd: S, tile: usize, lane: usize, sums: &[S::f64s], adjoint: &mut [Tile]) {
        self.add(simd, tile, lane, sums, adjoint);
    }
}

/// Constants of a corrected row.
pub(crate) struct Row {
    pub(crate) gamma: Vec3,
    /// sum V_b w gamma_b.
    pub(crate) zeroth: Vec3,
    /// Gamma.
    pub(crate) slope: Mat3,
}

/// Conjugate gradients for gamma.
struct Solver<'a> {
    lattice: &'a Lattice,
    constants: &'a Constants,
    rows: &'a Part,
    reach: &'a Part,
    /// z V, on the rows.
    zv: Vec<Tile>,
    /// z V_a S[V] + V_a S[z V], the diagonal of the graph, of each particle.
    graph: Vec<f64>,
    /// The diagonal of H; zero where no corrected row sees a particle.
    diagonal: Vec<f64>,
    q: Vec<Tile>,
    pair: Vec<Tile>,
    adjoint: Vec<Tile>,
    /// Sums of z V f, on `reach`.
    beside: Vec<Tile>,
}

impl<'a> Solver<'a> {
    fn new(body: &Surroundings<'a>, rows: &'a Part, reach: &'a Part) -> Self {
        let Surroundings { lattice, constants, moments, flagged, .. } = *body;
        let tiles = &lattice.tiles;
        let mut zv = vec![Tile::default(); rows.len()];
        for a in (0..lattice.len()).filter(|a| flagged[*a]) {
            let (t, lane) = tiles.place(a);
            if let Some(number) = rows.number(t) {
                zv[number].0[lane] = constants.volume(t)[lane];
            }
        }
        let (graph, diagonal): (Vec<f64>, Vec<f64>) = (0..lattice.len())
            .into_par_iter()
            .map(|a| {
                let m = &moments[a];
                let own = m.first.dot(&(m.correction * m.first));
                let z = f64::from(u8::from(flagged[a]));
                let (mut graph, mut slope) = (z * m.volume * m.zeroth, z * m.volume * own);
                for neighbour in &lattice.neighbours {
                    if let Some(seen) = lattice.seen(a, neighbour).filter(|s| flagged[s.particle]) {
                        let other = &moments[seen.particle];
                        let vw = m.volume * neighbour.w;
                        let x = neighbour.x.component_mul(&reflection(seen.mirrors));
                        graph += other.volume * vw;
                        slope += other.volume * vw * vw * x.dot(&(other.correction * x));
                    }
                }
                (graph, graph - slope)
            })
            .unzip();
        Self {
            lattice,
            constants,
            rows,
            reach,
            zv,
            graph,
            diagonal,
            q: tiles.field(3),
            pair: tiles.field(PAIR_COMPONENTS),
            adjoint: tiles.field(3),
            beside: vec![Tile::default(); 3 * reach.len()],
        }
    }

    /// gamma of every particle.
    fn solve(&mut self, body: &Surroundings<'_>) -> Vec<Vec3> {
        let n = self.lattice.len();
        let area = area_vectors(self.lattice, body.moments, body.remesh_gradients);
        let least = 1e-9 * self.diagonal.iter().copied().fold(0.0, f64::max);
        let is_free = |a: usize| self.diagonal[a] > least;
        let mut r: Vec<f64> = (0..3 * n)
            .map(|k| if is_free(k % n) { body.wanted[k] - area[k % n][k / n] } else { 0.0 })
            .collect();
        let inverse: Vec<f64> =
            (0..n).map(|a| if is_free(a) { 1.0 / self.diagonal[a] } else { 0.0 }).collect();
        self.project(&mut r, &is_free, body.folds);
        let following = Following::mirrored();
        let (mut gamma, mut p, mut y) = (vec![0.0; 3 * n], vec![0.0; 3 * n], vec![0.0; 3 * n]);
        let start = dots(&r, &r);
        // What R has of motions that no row feels, other than linear ones, no gamma takes away: the best one so far stands.
        let (mut best, mut least) = (gamma.clone(), start);
        let mut before = [0.0; 3];
        for iteration in 0..MAX_ITERATIONS {
            let left = dots(&r, &r);
            for i in 0..3 {
                if left[i] < least[i] {
                    best[i * n..(i + 1) * n].copy_from_slice(&gamma[i * n..(i + 1) * n]);
                    least[i] = left[i];
                }
            }
            let is_done =
                |i: usize| left[i] <= start[i] * TOLERANCE * TOLERANCE || left[i] > least[i] * LOST * LOST;
            if (0..3).all(is_done) {
                break;
            }
            let rz: [f64; 3] = std::array::from_fn(|i| weighted(&r[i * n..(i + 1) * n], &inverse));
            for i in 0..3 {
                let beta = if iteration == 0 || before[i] <= 0.0 { 0.0 } else { rz[i] / before[i] };
                let part = i * n..(i + 1) * n;
                for ((p, r), inverse) in p[part.clone()].iter_mut().zip(&r[part]).zip(&inverse) {
                    *p = inverse * r + beta * *p;
                }
            }
            self.apply(&p, &mut y, &following);
            let py = dots(&p, &y);
            for i in (0..3).filter(|&i| py[i] > 0.0) {
                let alpha = rz[i] / py[i];
                for k in i * n..(i + 1) * n {
                    gamma[k] += alpha * p[k];
                    r[k] -= if inverse[k - i * n] > 0.0 { alpha * y[k] } else { 0.0 };
                }
            }
            before = rz;
        }
        (0..n).map(|a| Vec3::from_fn(|i, _| best[i * n + a])).collect()
    }

    /// Takes constants and linear fields on the lattice, which H does not feel, out of `r` in each piece of the body, as far as `folds`
    /// have them.
    fn project(&self, r: &mut [f64], is_free: &impl Fn(usize) -> bool, folds: &Folds) {
        for mut piece in self.lattice.pieces() {
            piece.sort_unstable();
            piece.retain(|a| is_free(*a));
            self.project_piece(r, &piece, folds);
        }
    }

    fn project_piece(&self, r: &mut [f64], free: &[usize], folds: &Folds) {
        let n = self.lattice.len();
        let mut middle =
            free.iter().map(|&a| self.lattice.position(a)).sum::<Vec3>() / free.len().max(1) as f64;
        folds.planes().for_each(|(axis, at)| middle[axis] = at);
        for (i, r) in r.chunks_exact_mut(n).enumerate() {
            // Odd fields vanish on a fold, even ones have no slope across it.
            let mut there = Vector4::repeat(1.0);
            for (axis, _) in folds.planes() {
                if folds.planes().filter(|p| p.0 == axis).count() > 1 {
                    there[axis + 1] = 0.0;
                }
                (0..4).filter(|k| (*k == axis + 1) != (i == axis)).for_each(|k| there[k] = 0.0);
            }
            let basis = |a: usize| {
                let x = (self.lattice.position(a) - middle) / self.lattice.spacing;
                Vector4::new(1.0, x.x, x.y, x.z).component_mul(&there)
            };
            let mut moment: Matrix4<f64> = free.iter().map(|&a| basis(a) * basis(a).transpose()).sum();
            (0..4).filter(|k| there[*k] == 0.0).for_each(|k| moment[(k, k)] = 1.0);
            let Some(inverse) = moment.try_inverse() else { continue };
            let share = inverse * free.iter().map(|&a| basis(a) * r[a]).sum::<Vector4<f64>>();
            for &a in free {
                r[a] -= share.dot(&basis(a));
            }
        }
    }

    /// y = H f, of fields component by component.
    fn apply(&mut self, f: &[f64], y: &mut [f64], following: &Following) {
        let n = self.lattice.len();
        scatter(self.lattice, following, self.constants, f, None, &Vec3::zeros(), &mut self.q);
        let residual = Residual { constants: self.constants, rows: self.rows, zv: &self.zv, q: &self.q };
        ops::gradient_sums(self.lattice, Some(self.rows), &self.q, &mut self.pair, [None, None], &residual);
        ops::adjoint_sums(self.lattice, Some(self.reach), &self.pair, &mut self.adjoint);
        let field = RowField { rows: self.rows, zv: &self.zv, q: &self.q };
        ops::even_sums(self.lattice, self.reach, &field, Results::new(Some(self.reach), 3, &mut self.beside));
        let (yx, yyz) = y.split_at_mut(n);
        let (yy, yz) = yyz.split_at_mut(n);
        let this = &*self;
        (yx, yy, yz).into_par_iter().enumerate().with_min_len(PARTICLES_PER_SUM).for_each(
            |(a, (x, y, z))| {
                let (t, lane) = this.lattice.tiles.place(a);
                let Some(number) = this.reach.number(t) else { return };
                let volume = this.constants.volume(t)[lane];
                let is_row = this.rows.number(t).is_some();
                for (i, y) in [x, y, z].into_iter().enumerate() {
                    let own = if is_row { this.pair[t * PAIR_COMPONENTS + 9 + i].0[lane] } else { 0.0 };
                    *y = f[i * n + a] * this.graph[a]
                        + own
                        + volume * (this.adjoint[3 * t + i].0[lane] - this.beside[3 * number + i].0[lane]);
                }
            },
        );
        for image in &self.lattice.images {
            let (a, (t, lane)) = (image.particle as usize, image.place());
            let Some(number) = self.reach.number(t) else { continue };
            let (of, at) = self.lattice.tiles.place(a);
            let volume = self.constants.volume(of)[at];
            for (i, sign) in following.signs[image.mirrors as usize].iter().enumerate() {
                let sum = self.adjoint[3 * t + i].0[lane] - self.beside[3 * number + i].0[lane];
                y[i * n + a] += sign * volume * sum;
            }
        }
    }
}

/// z V f, of V f in `q`.
struct RowField<'a> {
    rows: &'a Part,
    zv: &'a [Tile],
    q: &'a [Tile],
}

impl EvenField<3> for RowField<'_> {
    #[inline(always)]
    fn lanes<const N: usize>(&self, tile: usize, first: usize) -> Option<[[f64; N]; 3]> {
        let zv = &self.zv[self.rows.number(tile)?].0;
        let mut values = [[0.0; N]; 3];
        for (values, Tile(q)) in values.iter_mut().zip(&self.q[3 * tile..]) {
            for l in 0..N {
                values[l] = if zv[first + l] > 0.0 { q[first + l] } else { 0.0 };
            }
        }
        Some(values)
    }
}

/// T = z V grad f, and T . first - z V S[V f].
struct Residual<'a> {
    constants: &'a Constants,
    rows: &'a Part,
    zv: &'a [Tile],
    q: &'a [Tile],
}

impl Pointwise for Residual<'_> {
    #[inline(always)]
    fn transform<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        lane: usize,
        sums: &mut [S::f64s; PAIR_COMPONENTS],
        _: [&mut [Tile]; 2],
    ) {
        let zv = self.rows.number(tile).map_or([0.0; LANES], |number| self.zv[number].0);
        let zv = Lanes::load(simd, &zv[lane..]);
        let local = self.constants.local::<S, false>(simd, tile, lane);
        let mut h = Tensor([[zv; 3]; 3]);
        for i in 0..3 {
            let q = Lanes::load(simd, &self.q[tile * 3 + i].0[lane..]);
            for j in 0..3 {
                h.0[i][j] = (-q).mul_add(local.first[j], Lanes(simd, sums[3 * i + j]));
            }
        }
        let t = local.corrected::<false>(&h).scaled(zv);
        for i in 0..3 {
            let mut own = zv * 0.0;
            for j in 0..3 {
                own = t.0[i][j].mul_add(local.first[j], own);
                sums[3 * i + j] = t.0[i][j].1;
            }
            sums[9 + i] = (own * local.volume - zv * Lanes(simd, sums[9 + i])).1;
        }
    }
}

/// Inner products of the three components, in an order that does not depend on the number of threads.
fn dots(x: &[f64], y: &[f64]) -> [f64; 3] {
    let n = x.len() / 3;
    std::array::from_fn(|i| {
        let part = i * n..(i + 1) * n;
        let chunks = x[part.clone()].chunks(PARTICLES_PER_SUM).zip(y[part].chunks(PARTICLES_PER_SUM));
        chunks.map(|(x, y)| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>()).sum()
    })
}

/// r . D^-1 r.
fn weighted(r: &[f64], inverse: &[f64]) -> f64 {
    let chunks = r.chunks(PARTICLES_PER_SUM).zip(inverse.chunks(PARTICLES_PER_SUM));
    chunks.map(|(r, d)| r.iter().zip(d).map(|(r, d)| r * r * d).sum::<f64>()).sum()
}
