//! The kernel sums of Eqs. (10) and (12) on the lattice; no physics.

mod adjoint;
mod blocks;
mod even;
mod gradient;
mod part;
mod stencil;
mod sweep;

use crate::lattice::{Cut, Cuts, Lattice, Weights};
use crate::tiles::{LANES, Tile};
use adjoint::Adjoint;
pub use blocks::Results;
use blocks::{Block, Sum, for_each_block};
use even::Even;
use gradient::Gradient;
pub use part::Part;
use pulp::Simd;
use stencil::Stencil;
use sweep::sweep;

/// Components that [`gradient_sums`] writes for each particle: nine of a matrix T (row by row) for
/// [`adjoint_sums`], and a vector.
pub const PAIR_COMPONENTS: usize = 12;

/// What a sweep does at each particle with its sums: the nine of H = sum w q_b (x) X (row by row), then
/// Q = sum w q_b. It runs on several lanes of a tile at once, a particle a lane.
pub trait Pointwise: Sync {
    /// Replaces the sums in the lanes from `lane` on of `tile` by its results, zero where there is no
    /// particle. `sides` are the components of the tile in two more fields, as far as it has any.
    fn transform<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        lane: usize,
        sums: &mut [S::f64s; PAIR_COMPONENTS],
        sides: [&mut [Tile]; 2],
    );
}

/// The sums as they are.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

impl Pointwise for Plain {
    #[inline(always)]
    fn transform<S: Simd>(
        &self,
        _: S,
        _: usize,
        _: usize,
        _: &mut [S::f64s; PAIR_COMPONENTS],
        _: [&mut [Tile]; 2],
    ) {
    }
}

/// A field on a part of the body, which a sweep reads and replaces.
#[derive(Debug)]
pub struct Side<'a> {
    /// The part.
    pub part: &'a Part,
    /// Its components.
    pub components: usize,
    /// The field.
    pub values: &'a mut [Tile],
}

/// For every particle a the sums over its neighbours b, with q_b = V_b A_b from a tiled field,
///
/// * H = sum_b w q_b (x) X (a matrix: Eq. (10) before the subtraction of A_a),
/// * Q = sum_b w q_b,
///
/// handed to `pointwise`, whose twelve results go to the tiled field `out`; only in a `part` of the body, if there is
/// one.
pub fn gradient_sums(
    lattice: &Lattice,
    part: Option<&Part>,
    q: &[Tile],
    out: &mut [Tile],
    sides: [Option<Side<'_>>; 2],
    pointwise: &impl Pointwise,
) {
    let sides = sides.map(|side| match side {
        Some(side) => Results::new(Some(side.part), side.components, side.values),
        None => Results::none(),
    });
    let sums = GradientSums { weights: &lattice.weights, cuts: &lattice.cuts, part, q, pointwise };
    for_each_block(lattice, part, Results::new(None, PAIR_COMPONENTS, out), sides, &sums);
}

/// For every particle a the sum over its neighbours b of w T_b X, the adjoint of the gradient sum;
/// T is the matrix in the first nine components of `t`. Results go to the tiled field `out`; only in a `part` of the
/// body, if there is one.
pub fn adjoint_sums(lattice: &Lattice, part: Option<&Part>, t: &[Tile], out: &mut [Tile]) {
    let sums = AdjointSums { weights: &lattice.weights, cuts: &lattice.cuts, part, t };
    for_each_block(lattice, part, Results::new(None, 3, out), [Results::none(), Results::none()], &sums);
}

/// A field of `C` components that sums without an offset are taken of, and what becomes of them.
pub trait EvenField<const C: usize>: Sync {
    /// Its values in `N` lanes of a tile of the body from `first` on; `None` where all of them are zero.
    fn lanes<const N: usize>(&self, tile: usize, first: usize) -> Option<[[f64; N]; C]>;

    /// Puts the sums in the lanes from `lane` on of `tile` into the results of that tile: as they are, if not said
    /// otherwise.
    #[inline(always)]
    fn keep<S: Simd>(&self, _: S, _tile: usize, lane: usize, sums: &[S::f64s], results: &mut [Tile]) {
        store::<S>(results, lane, sums);
    }
}

/// For every particle of `part` the sums S = sum_b w q_b over its neighbours, of a `field`, which keeps them in `out`.
pub fn even_sums<const C: usize>(
    lattice: &Lattice,
    part: &Part,
    field: &impl EvenField<C>,
    out: Results<'_>,
) {
    let sums = EvenSums::<_, C> { weights: &lattice.weights, cuts: &lattice.cuts, part, field };
    for_each_block(lattice, Some(part), out, [Results::none(), Results::none()], &sums);
}

struct GradientSums<'a, P> {
    weights: &'a Weights,
    cuts: &'a Cuts,
    part: Option<&'a Part>,
    q: &'a [Tile],
    pointwise: &'a P,
}

impl<P> GradientSums<'_, P> {
    /// What a neighbour adds to the sums.
    fn of(&self, cut: &Cut) -> [f64; PAIR_COMPONENTS] {
        let (tile, lane) = (cut.other.0 as usize, cut.other.1 as usize);
        let q: [f64; 3] = std::array::from_fn(|i| cut.w * self.q[3 * tile + i].0[lane]);
        std::array::from_fn(|c| if c < 9 { q[c / 3] * cut.x[c % 3] } else { q[c - 9] })
    }
}

impl<P: Pointwise> Sum for GradientSums<'_, P> {
    #[inline(always)]
    fn run<S: Simd, T: Stencil>(&self, simd: S, stencil: T, block: Block<'_>) {
        let Block { tiles, column, planes, mut out, mut sides } = block;
        let passes = Gradient { stencil, weights: self.weights, tiles, part: self.part, q: self.q };
        sweep(
            simd,
            &passes,
            column,
            planes,
            #[inline(always)]
            |t, lane, sums| {
                take_out(simd, self.cuts.of_tile(t), lane, sums, |cut| self.of(cut));
                let [first, second] = &mut sides;
                self.pointwise.transform(simd, t, lane, sums, [first.of(t), second.of(t)]);
                store::<S>(out.of(t), lane, sums);
            },
        );
    }
}

struct AdjointSums<'a> {
    weights: &'a Weights,
    cuts: &'a Cuts,
    part: Option<&'a Part>,
    t: &'a [Tile],
}

impl AdjointSums<'_> {
    /// What a neighbour adds to the sums.
    fn of(&self, cut: &Cut) -> [f64; 3] {
        let (tile, lane) = (cut.other.0 as usize, cut.other.1 as usize);
        let t = &self.t[PAIR_COMPONENTS * tile..][..PAIR_COMPONENTS];
        std::array::from_fn(|i| cut.w * (0..3).map(|j| t[3 * i + j].0[lane] * cut.x[j]).sum::<f64>())
    }
}

impl Sum for AdjointSums<'_> {
    #[inline(always)]
    fn run<S: Simd, T: Stencil>(&self, simd: S, stencil: T, block: Block<'_>) {
        let Block { tiles, column, planes, mut out, .. } = block;
        let passes = Adjoint { stencil, weights: self.weights, tiles, part: self.part, t: self.t };
        sweep(
            simd,
            &passes,
            column,
            planes,
            #[inline(always)]
            |t, lane, sums| {
                take_out(simd, self.cuts.of_tile(t), lane, sums, |cut| self.of(cut));
                store::<S>(out.of(t), lane, sums);
            },
        );
    }
}

struct EvenSums<'a, F, const C: usize> {
    weights: &'a Weights,
    cuts: &'a Cuts,
    part: &'a Part,
    field: &'a F,
}

impl<F: EvenField<C>, const C: usize> Sum for EvenSums<'_, F, C> {
    #[inline(always)]
    fn run<S: Simd, T: Stencil>(&self, simd: S, stencil: T, block: Block<'_>) {
        let Block { tiles, column, planes, mut out, .. } = block;
        let Self { weights, cuts, part, field } = *self;
        let passes = Even::<_, _, C> { stencil, weights, tiles, part, field };
        sweep(
            simd,
            &passes,
            column,
            planes,
            #[inline(always)]
            |t, lane, sums| {
                take_out(simd, cuts.of_tile(t), lane, sums, |cut| {
                    let (tile, lane) = cut.other;
                    let values = field.lanes::<1>(tile as usize, lane as usize);
                    values.map_or([0.0; C], |values| values.map(|v| cut.w * v[0]))
                });
                field.keep(simd, t, lane, &sums[..C], out.of(t));
            },
        );
    }
}

/// Takes what the particles in the lanes from `lane` on do not see out of their sums.
#[inline(always)]
fn take_out<S: Simd, const C: usize>(
    simd: S,
    cuts: &[Cut],
    lane: usize,
    sums: &mut [S::f64s],
    of: impl Fn(&Cut) -> [f64; C],
) {
    for cut in cuts {
        let Some(l) = (cut.lane as usize).checked_sub(lane).filter(|l| *l < S::F64_LANES) else { continue };
        for (sum, value) in sums.iter_mut().zip(of(cut)) {
            let mut lanes = [0.0; LANES];
            S::as_mut_simd_f64s(&mut lanes[..S::F64_LANES]).0[0] = *sum;
            lanes[l] -= value;
            *sum = load(simd, &lanes, 0);
        }
    }
}

/// Puts the vectors of a tile's components into its lanes from `lane` on.
#[inline(always)]
fn store<S: Simd>(tiles: &mut [Tile], lane: usize, values: &[S::f64s]) {
    for (tile, value) in tiles.iter_mut().zip(values) {
        S::as_mut_simd_f64s(&mut tile.0[lane..lane + S::F64_LANES]).0[0] = *value;
    }
}

/// The vector at `d` of `line`.
#[inline(always)]
pub(crate) fn load<S: Simd>(_: S, line: &[f64], d: usize) -> S::f64s {
    S::as_simd_f64s(&line[d..d + S::F64_LANES]).0[0]
}
