//! The stress sweep of a linear material: as many particles at once as a vector register holds.

use super::{Elastic, Spread};
use crate::boundary::mirror::Mirror;
use crate::lattice::Lattice;
use crate::material::Tangent;
use crate::moments::Moments;
use crate::ops::{self, PAIR_COMPONENTS, Pointwise};
use crate::tensor::{Mat3, SymTensor, Vec3};
use crate::tiles::{LANES, Tile};
use pulp::Simd;
use rayon::prelude::*;

/// Numbers of a particle that the sweep needs: V, the six of L (VTK order),
/// sum V_b w X / V and sum V_b w / V.
const CONSTANTS: usize = 11;
/// Place of L_ij among the six of a symmetric tensor.
const SYM: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// Constants of the sweep, as a tiled field.
#[derive(Clone, Debug)]
pub(super) struct Constants {
    /// Constants of tiles, those of a tile of full neighbourhoods first.
    values: Vec<Tile>,
    /// Which of them every tile has; 0 is that of full neighbourhoods, where first moments vanish and L is a
    /// number.
    kind: Vec<u32>,
    /// Tiles in which a particle sees a mirror ghost.
    near_wall: Vec<bool>,
    bulk: Bulk,
}

/// Constants of a particle whose cell and neighbourhood are full.
#[derive(Clone, Copy, Debug)]
struct Bulk {
    volume: f64,
    /// L = this times the unit tensor.
    correction: f64,
    /// sum V_b w / V.
    zeroth: f64,
}

/// Constants of a particle with these moments, which some sum sees.
fn packed(m: &Moments) -> [f64; CONSTANTS] {
    let l = SymTensor::symmetric_part(&m.correction).0;
    let first = m.first / m.volume;
    [m.volume, l[0], l[1], l[2], l[3], l[4], l[5], first.x, first.y, first.z, m.zeroth / m.volume]
}

/// Share by which the constants of a full neighbourhood may differ from those of the lattice.
const ROUNDING: f64 = 1e-12;

impl Bulk {
    fn new(lattice: &Lattice) -> Self {
        Self {
            volume: lattice.spacing.powi(3),
            correction: 1.0 / lattice.full_moment,
            zeroth: lattice.neighbours.iter().map(|n| n.w).sum(),
        }
    }

    /// Whether the constants of a particle are these, to rounding.
    fn fits(&self, m: &Moments, spacing: f64) -> bool {
        let near = |value: f64, expected: f64| (value / expected - 1.0).abs() < ROUNDING;
        let l = m.correction / self.correction;
        near(m.volume, self.volume)
            && near(m.zeroth, self.volume * self.zeroth)
            && (l - Mat3::identity()).amax() < ROUNDING
            && m.first.amax() < ROUNDING * m.zeroth * spacing
    }
}

impl Constants {
    /// Of particles with these volumes, those that no sum sees without.
    pub(super) fn new(lattice: &Lattice, volume: &[f64], mirror: &Mirror) -> Self {
        let tiles = &lattice.tiles;
        let bulk = Bulk::new(lattice);
        let mut near_wall = vec![false; tiles.len()];
        for a in (0..lattice.len()).filter(|a| mirror.has_ghosts(*a)) {
            near_wall[tiles.place(a).0] = true;
        }
        let of_tiles: Vec<_> = (0..tiles.len())
            .into_par_iter()
            .map(|t| {
                let (first, mask) = tiles.particles(t);
                let mut inside = mask == u8::MAX;
                let mut constants = Box::new([Tile::default(); CONSTANTS]);
                for (a, lane) in (first..).zip((0..LANES).filter(|l| mask >> l & 1 == 1)) {
                    let m = Moments::new(lattice, volume, mirror, a);
                    inside &= bulk.fits(&m, lattice.spacing);
                    if m.volume > 0.0 {
                        for (tile, constant) in constants.iter_mut().zip(packed(&m)) {
                            tile.0[lane] = constant;
                        }
                    }
                }
                (!inside).then_some(constants)
            })
            .collect();
        let l = bulk.correction;
        let of_bulk = [bulk.volume, l, l, l, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, bulk.zeroth];
        let mut values = of_bulk.map(|constant| Tile([constant; LANES])).to_vec();
        values.reserve_exact(of_tiles.iter().flatten().count() * CONSTANTS);
        let mut kind = Vec::with_capacity(tiles.len());
        for constants in of_tiles {
            kind.push(constants.as_ref().map_or(0, |_| (values.len() / CONSTANTS) as u32));
            values.extend(constants.iter().flat_map(|c| c.iter()));
        }
        Self { values, kind, near_wall, bulk }
    }

    /// Moments of the particle in that lane of tile `t`.
    #[inline(always)]
    pub(super) fn moments(&self, t: usize, lane: usize) -> Moments {
        let constant: [f64; CONSTANTS] = {
            let values = self.of(t);
            std::array::from_fn(|c| values[c].0[lane])
        };
        let [volume, l @ .., first_x, first_y, first_z, zeroth] = constant;
        Moments {
            volume,
            correction: SymTensor(l).to_matrix(),
            first: Vec3::new(first_x, first_y, first_z) * volume,
            zeroth: zeroth * volume,
        }
    }

    /// Constants of tile `t`.
    #[inline(always)]
    fn of(&self, t: usize) -> &[Tile] {
        &self.values[self.kind[t] as usize * CONSTANTS..][..CONSTANTS]
    }

    /// V in the lanes of tile `t`.
    #[inline(always)]
    pub(super) fn volume(&self, t: usize) -> &[f64; LANES] {
        &self.of(t)[0].0
    }

    /// Whether a particle of tile `t` sees a mirror ghost.
    #[inline(always)]
    pub(super) fn near_wall(&self, t: usize) -> bool {
        self.near_wall[t]
    }
}

/// From sums to T_a and the part of the force that needs no neighbour's T.
struct LinearStress<'a> {
    constants: &'a Constants,
    mirror: &'a Mirror,
    tangent: &'a Tangent,
    /// Whether no shear strain goes with a normal stress or with another shear stress.
    decoupled: bool,
    kappa: f64,
    spread: Spread<'a>,
    offset: &'a [Vec3],
    /// Whether the sums of the lattice lack something of the ghosts.
    lacking: bool,
}

impl LinearStress<'_> {
    /// Adds what the mirror ghosts of the particles in the lanes from `lane` on put into their sums.
    #[inline(never)]
    fn add_ghosts<S: Simd>(&self, tile: usize, lane: usize, sums: &mut [S::f64s; PAIR_COMPONENTS]) {
        let mut lanes = [[0.0; LANES]; PAIR_COMPONENTS];
        let (mut a, mask) = self.spread.tiles.particles(tile);
        for l in (0..LANES).filter(|l| mask >> l & 1 == 1) {
            for ghost in self.mirror.ghosts_of(a) {
                let z = self.spread.lacking(self.mirror, &ghost, self.offset)
                    * (self.spread.volume(ghost.partner as usize) * ghost.w);
                for i in 0..3 {
                    for j in 0..3 {
                        lanes[3 * i + j][l] += z[i] * ghost.x[j];
                    }
                    lanes[9 + i][l] += z[i];
                }
            }
            a += 1;
        }
        for (sum, lanes) in sums.iter_mut().zip(&lanes) {
            let mut together = [0.0; LANES];
            S::as_mut_simd_f64s(&mut together[..S::F64_LANES]).0[0] = *sum;
            for (t, l) in together.iter_mut().zip(&lanes[lane..lane + S::F64_LANES]) {
                *t += l;
            }
            *sum = S::as_simd_f64s(&together[..S::F64_LANES]).0[0];
        }
    }
}

// No closures in what follows: they would not inherit the instruction set.
impl LinearStress<'_> {
    /// V sigma of the gradient G, Eq. (5).
    #[inline(always)]
    fn stress<S: Simd>(&self, simd: S, g: &[[S::f64s; 3]; 3], volume: S::f64s) -> [S::f64s; 6] {
        let half = simd.splat_f64s(0.5);
        let strain = [
            g[0][0],
            g[1][1],
            g[2][2],
            simd.mul_f64s(half, simd.add_f64s(g[0][1], g[1][0])),
            simd.mul_f64s(half, simd.add_f64s(g[1][2], g[2][1])),
            simd.mul_f64s(half, simd.add_f64s(g[0][2], g[2][0])),
        ];
        let mut sigma = [simd.splat_f64s(0.0); 6];
        if self.decoupled {
            for k in 0..3 {
                for j in 0..3 {
                    sigma[k] =
                        simd.mul_add_e_f64s(simd.splat_f64s(self.tangent.0[k][j]), strain[j], sigma[k]);
                }
                sigma[k + 3] = simd.mul_f64s(simd.splat_f64s(self.tangent.0[k + 3][k + 3]), strain[k + 3]);
            }
        } else {
            for (k, sigma) in sigma.iter_mut().enumerate() {
                for (j, e) in strain.into_iter().enumerate() {
                    *sigma = simd.mul_add_e_f64s(simd.splat_f64s(self.tangent.0[k][j]), e, *sigma);
                }
            }
        }
        for sigma in &mut sigma {
            *sigma = simd.mul_f64s(*sigma, volume);
        }
        sigma
    }

    /// [`Pointwise::transform`] in a tile of full neighbourhoods.
    #[inline(always)]
    fn inside<S: Simd>(&self, simd: S, tile: usize, lane: usize, sums: &mut [S::f64s; PAIR_COMPONENTS]) {
        let Bulk { volume, correction, zeroth } = self.constants.bulk;
        let l = simd.splat_f64s(correction);
        let mut g = [[l; 3]; 3]; // G = H L
        for i in 0..3 {
            for j in 0..3 {
                g[i][j] = simd.mul_f64s(sums[3 * i + j], l);
            }
        }
        let sigma = self.stress(simd, &g, simd.splat_f64s(volume * correction));
        let stiff = simd.splat_f64s(self.kappa * volume);
        let (twice, zeroth) = (simd.splat_f64s(2.0 * self.kappa * volume), simd.splat_f64s(zeroth));
        for i in 0..3 {
            for j in 0..3 {
                sums[3 * i + j] = simd.negate_mul_add_e_f64s(stiff, g[i][j], sigma[SYM[i][j]]);
            }
            let q = ops::load(simd, &self.spread.q[tile * 3 + i].0, lane);
            sums[9 + i] = simd.mul_f64s(twice, simd.negate_mul_add_e_f64s(q, zeroth, sums[9 + i]));
        }
    }
}

impl Pointwise for LinearStress<'_> {
    #[inline(always)]
    fn transform<S: Simd>(&self, simd: S, tile: usize, lane: usize, sums: &mut [S::f64s; PAIR_COMPONENTS]) {
        let lacking = self.lacking && self.constants.near_wall[tile];
        if self.constants.kind[tile] == 0 && !lacking {
            self.inside(simd, tile, lane, sums);
            return;
        }
        let mut constant = [simd.splat_f64s(0.0); CONSTANTS];
        let values = self.constants.of(tile);
        for (constant, value) in constant.iter_mut().zip(values) {
            *constant = ops::load(simd, &value.0, lane);
        }
        let [volume, l0, l1, l2, l3, l4, l5, first_x, first_y, first_z, zeroth] = constant;
        let (l, first) = ([l0, l1, l2, l3, l4, l5], [first_x, first_y, first_z]);
        for i in 0..3 {
            let q = ops::load(simd, &self.spread.q[tile * 3 + i].0, lane);
            for j in 0..3 {
                sums[3 * i + j] = simd.negate_mul_add_e_f64s(q, first[j], sums[3 * i + j]);
            }
            sums[9 + i] = simd.negate_mul_add_e_f64s(q, zeroth, sums[9 + i]);
        }
        if lacking {
            self.add_ghosts::<S>(tile, lane, sums);
        }
        let mut g = [[volume; 3]; 3]; // G = H L
        for i in 0..3 {
            g[i] = times(simd, [sums[3 * i], sums[3 * i + 1], sums[3 * i + 2]], &l);
        }
        let sigma = self.stress(simd, &g, volume);
        let stiff = simd.mul_f64s(simd.splat_f64s(self.kappa), volume);
        let twice = simd.add_f64s(stiff, stiff);
        for i in 0..3 {
            let t = times(simd, [sigma[SYM[i][0]], sigma[SYM[i][1]], sigma[SYM[i][2]]], &l);
            let mut own = simd.splat_f64s(0.0);
            for j in 0..3 {
                let t = simd.negate_mul_add_e_f64s(stiff, g[i][j], t[j]);
                sums[3 * i + j] = t;
                own = simd.mul_add_e_f64s(t, first[j], own);
            }
            sums[9 + i] = simd.mul_add_e_f64s(own, volume, simd.mul_f64s(twice, sums[9 + i]));
        }
    }
}

/// The row vector `a` times the symmetric tensor `l`.
#[inline(always)]
fn times<S: Simd>(simd: S, a: [S::f64s; 3], l: &[S::f64s; 6]) -> [S::f64s; 3] {
    let mut product = a;
    for (j, product) in product.iter_mut().enumerate() {
        let sum = simd.mul_f64s(a[0], l[SYM[0][j]]);
        let sum = simd.mul_add_e_f64s(a[1], l[SYM[1][j]], sum);
        *product = simd.mul_add_e_f64s(a[2], l[SYM[2][j]], sum);
    }
    product
}

impl Elastic {
    /// [`Elastic::stress_sweep`] for a linear material.
    pub(super) fn linear_stress_sweep(&mut self, tangent: &Tangent) {
        let work = &mut self.work;
        let pointwise = LinearStress {
            constants: &self.constants,
            mirror: &self.mirror,
            tangent,
            decoupled: (0..6).all(|k| (0..6).all(|j| k == j || (k < 3 && j < 3) || tangent.0[k][j] == 0.0)),
            kappa: self.hourglass,
            spread: Spread { tiles: &self.lattice.tiles, q: &work.q, constants: &self.constants },
            offset: &work.offset,
            lacking: self.mirror.has_others() || work.offset.iter().any(|o| *o != Vec3::zeros()),
        };
        ops::gradient_sums(&self.lattice, self.mirror.folds(), &work.q, &mut work.pair, &pointwise);
    }
}
