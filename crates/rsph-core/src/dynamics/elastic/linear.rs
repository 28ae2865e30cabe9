//! The stress sweep of a linear material: as many particles at once as a vector register holds.

use super::correction::{Correction, PLACES, ROW, SYMMETRIC};
use super::{Elastic, Workspace};
use crate::lattice::Lattice;
use crate::material::Stiffness;
use crate::moments::Moments;
use crate::ops::{self, PAIR_COMPONENTS, Pointwise, Side};
use crate::tensor::{Mat3, SymTensor, Vec3};
use crate::tiles::{LANES, Tile, Tiles};
use pulp::Simd;
use rayon::prelude::*;

/// Numbers of a particle that the sweep needs: V, the six of L (VTK order),
/// sum V_b w X / V and sum V_b w / V.
const CONSTANTS: usize = 11;
/// Place of L_ij among the six of a symmetric tensor.
pub(super) const SYM: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// Constants of the sweep, as a tiled field.
#[derive(Clone, Debug)]
pub(super) struct Constants {
    /// Constants of tiles, those of a tile of full neighbourhoods first.
    values: Vec<Tile>,
    /// Which of them every tile has; 0 is that of full neighbourhoods, where first moments vanish and L is a
    /// number.
    kind: Vec<u32>,
    bulk: Bulk,
}

/// Constants of a particle whose cell and neighbourhood are full.
#[derive(Clone, Copy, Debug)]
struct Bulk {
    volume: f64,
    /// L = this times the unit tensor (of the plane).
    correction: f64,
    /// sum V_b w / V.
    zeroth: f64,
}

/// Constants of a particle with these moments.
fn packed(m: &Moments) -> [f64; CONSTANTS] {
    let l = SymTensor::symmetric_part(&m.correction).0;
    let first = m.first / m.volume;
    [m.volume, l[0], l[1], l[2], l[3], l[4], l[5], first.x, first.y, first.z, m.zeroth / m.volume]
}

/// Tiles that one task spreads.
const TILES_A_TASK: usize = 128;
/// Share by which the constants of a full neighbourhood may differ from those of the lattice.
const ROUNDING: f64 = 1e-12;

impl Bulk {
    fn new(lattice: &Lattice) -> Self {
        Self {
            volume: lattice.cell_volume(),
            correction: 1.0 / lattice.full_moment,
            zeroth: lattice.neighbours.iter().map(|n| n.w).sum(),
        }
    }

    /// Whether the constants of a particle are these, to rounding.
    fn fits(&self, m: &Moments, lattice: &Lattice) -> bool {
        let near = |value: f64, expected: f64| (value / expected - 1.0).abs() < ROUNDING;
        let mut l = m.correction / self.correction;
        // Sums have no component along an axis that is not there: any number would do.
        for i in lattice.dimension..3 {
            l[(i, i)] = 1.0;
        }
        near(m.volume, self.volume)
            && near(m.zeroth, self.volume * self.zeroth)
            && (l - Mat3::identity()).amax() < ROUNDING
            && m.first.amax() < ROUNDING * m.zeroth * lattice.spacing
    }
}

impl Constants {
    /// Of particles with these volumes.
    pub(super) fn new(lattice: &Lattice, volume: &[f64]) -> Self {
        let tiles = &lattice.tiles;
        let bulk = Bulk::new(lattice);
        let of_tiles: Vec<_> = (0..tiles.len())
            .into_par_iter()
            .map(|t| {
                let (first, mask) = tiles.particles(t);
                let mut inside = mask == u8::MAX;
                let mut constants = Box::new([Tile::default(); CONSTANTS]);
                for (a, lane) in (first..).zip((0..LANES).filter(|l| mask >> l & 1 == 1)) {
                    let m = Moments::new(lattice, volume, a);
                    inside &= bulk.fits(&m, lattice);
                    for (tile, constant) in constants.iter_mut().zip(packed(&m)) {
                        tile.0[lane] = constant;
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
        Self { values, kind, bulk }
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

    /// L, sum V_b w X / V and V in the lanes from `lane` on of a tile.
    #[inline(always)]
    pub(super) fn gradient_constants<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        lane: usize,
    ) -> ([S::f64s; 6], [S::f64s; 3], S::f64s) {
        let values = self.of(tile);
        let mut constant = [simd.splat_f64s(0.0); 10];
        for (constant, value) in constant.iter_mut().zip(values) {
            *constant = ops::load(simd, &value.0, lane);
        }
        let [volume, l0, l1, l2, l3, l4, l5, x, y, z] = constant;
        ([l0, l1, l2, l3, l4, l5], [x, y, z], volume)
    }
}

/// From sums to T_a and the part of the force that needs no neighbour's T.
struct LinearStress<'a> {
    constants: &'a Constants,
    correction: &'a Correction,
    stiffness: &'a Stiffness,
    /// Whether no shear strain goes with a normal stress or with another shear stress.
    decoupled: bool,
    kappa: f64,
    q: &'a [Tile],
    /// Strain lifted from held faces, on the rows of the correction; empty if there is none.
    lifted: &'a [Tile],
}

// No closures in what follows: they would not inherit the instruction set.
impl LinearStress<'_> {
    /// V sigma of a strain, Eq. (5).
    #[inline(always)]
    fn stress<S: Simd>(&self, simd: S, strain: [S::f64s; 6], volume: S::f64s) -> [S::f64s; 6] {
        let mut sigma = [simd.splat_f64s(0.0); 6];
        if self.decoupled {
            for k in 0..3 {
                for j in 0..3 {
                    sigma[k] =
                        simd.mul_add_e_f64s(simd.splat_f64s(self.stiffness.0[k][j]), strain[j], sigma[k]);
                }
                sigma[k + 3] = simd.mul_f64s(simd.splat_f64s(self.stiffness.0[k + 3][k + 3]), strain[k + 3]);
            }
        } else {
            for (k, sigma) in sigma.iter_mut().enumerate() {
                for (j, e) in strain.into_iter().enumerate() {
                    *sigma = simd.mul_add_e_f64s(simd.splat_f64s(self.stiffness.0[k][j]), e, *sigma);
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
        let sigma = self.stress(simd, symmetric(simd, &g), simd.splat_f64s(volume * correction));
        let stiff = simd.splat_f64s(self.kappa * volume);
        let (twice, zeroth) = (simd.splat_f64s(2.0 * self.kappa * volume), simd.splat_f64s(zeroth));
        for i in 0..3 {
            for j in 0..3 {
                sums[3 * i + j] = simd.negate_mul_add_e_f64s(stiff, g[i][j], sigma[SYM[i][j]]);
            }
            let q = ops::load(simd, &self.q[tile * 3 + i].0, lane);
            sums[9 + i] = simd.mul_f64s(twice, simd.negate_mul_add_e_f64s(q, zeroth, sums[9 + i]));
        }
    }
}

impl Pointwise for LinearStress<'_> {
    #[inline(always)]
    fn transform<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        lane: usize,
        sums: &mut [S::f64s; PAIR_COMPONENTS],
        [side, _]: [&mut [Tile]; 2],
    ) {
        if self.constants.kind[tile] == 0 && side.is_empty() {
            self.inside(simd, tile, lane, sums);
            return;
        }
        let (l, first, volume) = self.constants.gradient_constants(simd, tile, lane);
        let zeroth = ops::load(simd, &self.constants.of(tile)[10].0, lane);
        let mut q = [volume; 3];
        for i in 0..3 {
            q[i] = ops::load(simd, &self.q[tile * 3 + i].0, lane);
            for j in 0..3 {
                sums[3 * i + j] = simd.negate_mul_add_e_f64s(q[i], first[j], sums[3 * i + j]);
            }
            sums[9 + i] = simd.negate_mul_add_e_f64s(q[i], zeroth, sums[9 + i]);
        }
        let mut g = [[volume; 3]; 3]; // G = H L
        for i in 0..3 {
            g[i] = times(simd, [sums[3 * i], sums[3 * i + 1], sums[3 * i + 2]], &l);
        }
        let mut strain = symmetric(simd, &g);
        let number = if side.is_empty() { None } else { self.correction.rows.number(tile) };
        let row = number.map(|n| &self.correction.constants[ROW * n..][..ROW]);
        if let (Some(row), Some(number)) = (row, number) {
            correct(simd, (row, lane), [&sums[..9], &sums[9..], &q], side, &mut strain);
            if !self.lifted.is_empty() {
                for (strain, lifted) in strain.iter_mut().zip(&self.lifted[SYMMETRIC * number..]) {
                    *strain = simd.add_f64s(*strain, ops::load(simd, &lifted.0, lane));
                }
            }
        }
        let sigma = self.stress(simd, strain, volume);
        let stiff = simd.mul_f64s(simd.splat_f64s(self.kappa), volume);
        let twice = simd.add_f64s(stiff, stiff);
        for i in 0..3 {
            let sigma = [sigma[SYM[i][0]], sigma[SYM[i][1]], sigma[SYM[i][2]]];
            let mut t = times(simd, sigma, &l);
            let mut beside = simd.splat_f64s(0.0);
            if let Some(row) = row {
                // T = Q (L - z Gamma), and z Q (S[V gamma] - S[V] gamma) on the row itself.
                for c in 0..3 {
                    let gamma = ops::load(simd, &row[1 + c].0, lane);
                    let sum = ops::load(simd, &row[4 + c].0, lane);
                    let own = simd.negate_mul_add_e_f64s(gamma, zeroth, sum);
                    beside = simd.mul_add_e_f64s(sigma[c], own, beside);
                    for (j, t) in t.iter_mut().enumerate() {
                        let slope = ops::load(simd, &row[7 + 3 * c + j].0, lane);
                        *t = simd.negate_mul_add_e_f64s(sigma[c], slope, *t);
                    }
                }
            }
            let mut own = beside;
            for j in 0..3 {
                let t = simd.negate_mul_add_e_f64s(stiff, g[i][j], t[j]);
                sums[3 * i + j] = t;
                own = simd.mul_add_e_f64s(t, first[j], own);
            }
            sums[9 + i] = simd.mul_add_e_f64s(own, volume, simd.mul_f64s(twice, sums[9 + i]));
        }
        for (side, sigma) in side.iter_mut().zip(sigma) {
            S::as_mut_simd_f64s(&mut side.0[lane..lane + S::F64_LANES]).0[0] = sigma;
        }
    }
}

/// Adds what the correction and held faces add to the strain of a row, to `side` as far as neighbours decide it;
/// `a` and `laplacian` are sum V_b w (z_b - z_a) (x) X and sum V_b w (z_b - z_a), `q` is V z.
#[inline(always)]
fn correct<S: Simd>(
    simd: S,
    (row, lane): (&[Tile], usize),
    [a, laplacian, q]: [&[S::f64s]; 3],
    side: &[Tile],
    strain: &mut [S::f64s; 6],
) {
    let constant = |c: usize| ops::load(simd, &row[c].0, lane);
    let z = constant(0);
    let half = simd.splat_f64s(0.5);
    // D_ki = S[V u_k gamma_i] - Laplacian_k gamma_i - u_k S[V gamma_i] - A_kj Gamma_ij
    let mut d = [[z; 3]; 3];
    for i in 0..3 {
        let (gamma, zeroth) = (constant(1 + i), constant(4 + i));
        let slope = [constant(7 + 3 * i), constant(8 + 3 * i), constant(9 + 3 * i)];
        for k in 0..3 {
            let mut sum = simd.mul_f64s(laplacian[k], gamma);
            sum = simd.mul_add_e_f64s(q[k], zeroth, sum);
            for j in 0..3 {
                sum = simd.mul_add_e_f64s(a[3 * k + j], slope[j], sum);
            }
            d[k][i] = sum;
        }
    }
    for c in 0..6 {
        let (i, j) = PLACES[c];
        let own = if i == j { d[i][i] } else { simd.mul_f64s(half, simd.add_f64s(d[i][j], d[j][i])) };
        let neighbours = simd.mul_f64s(z, ops::load(simd, &side[c].0, lane));
        strain[c] = simd.add_f64s(strain[c], simd.sub_f64s(neighbours, own));
    }
}

/// The symmetric part of a matrix.
#[inline(always)]
fn symmetric<S: Simd>(simd: S, g: &[[S::f64s; 3]; 3]) -> [S::f64s; 6] {
    let half = simd.splat_f64s(0.5);
    [
        g[0][0],
        g[1][1],
        g[2][2],
        simd.mul_f64s(half, simd.add_f64s(g[0][1], g[1][0])),
        simd.mul_f64s(half, simd.add_f64s(g[1][2], g[2][1])),
        simd.mul_f64s(half, simd.add_f64s(g[0][2], g[2][0])),
    ]
}

/// The row vector `a` times the symmetric tensor `l`.
#[inline(always)]
pub(super) fn times<S: Simd>(simd: S, a: [S::f64s; 3], l: &[S::f64s; 6]) -> [S::f64s; 3] {
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
    pub(super) fn linear_stress_sweep(&mut self, stiffness: &Stiffness) {
        let Workspace { q, pair, side, lifted, .. } = &mut self.work;
        let pointwise = LinearStress {
            constants: &self.constants,
            correction: &self.correction,
            stiffness,
            decoupled: (0..6).all(|k| (0..6).all(|j| k == j || (k < 3 && j < 3) || stiffness.0[k][j] == 0.0)),
            kappa: self.hourglass,
            q,
            lifted,
        };
        let side = (!side.is_empty()).then_some(Side {
            part: &self.correction.rows,
            components: SYMMETRIC,
            values: side,
        });
        ops::gradient_sums(&self.lattice, None, q, pair, [side, None], &pointwise);
    }
}

/// Spreads V (u + T v - `origin`) over the tiles, of fields component by component; v with T, if it is there.
pub(super) fn scatter(
    tiles: &Tiles,
    constants: &Constants,
    u: &[f64],
    v: Option<(&[f64], f64)>,
    origin: &Vec3,
    q: &mut [Tile],
) {
    let n = u.len() / 3;
    q.par_chunks_mut(3).with_min_len(TILES_A_TASK).enumerate().for_each(|(t, q)| {
        let (a, mask) = tiles.particles(t);
        let volume = constants.volume(t);
        let count = mask.count_ones() as usize;
        for (i, q) in q.iter_mut().enumerate() {
            let here = i * n + a..i * n + a + count;
            let mut z = [0.0; LANES];
            z[..count].copy_from_slice(&u[here.clone()]);
            if let Some((v, relaxation_time)) = v {
                for (z, v) in z.iter_mut().zip(&v[here]) {
                    *z += relaxation_time * v;
                }
            }
            z[..count].iter_mut().for_each(|z| *z -= origin[i]);
            if mask == u8::MAX {
                for l in 0..LANES {
                    q.0[l] = z[l] * volume[l];
                }
            } else if count > 0 && mask >> mask.trailing_zeros() == u8::MAX >> (LANES - count) {
                // Neighbouring lanes; V is zero in the others.
                let mut shifted = [0.0; 2 * LANES];
                let first = mask.trailing_zeros() as usize;
                shifted[first..first + LANES].copy_from_slice(&z);
                for l in 0..LANES {
                    q.0[l] = shifted[l] * volume[l];
                }
            } else {
                q.0 = [0.0; LANES];
                let occupied = (0..LANES).filter(|l| mask >> l & 1 == 1);
                occupied.zip(z).for_each(|(l, z)| q.0[l] = z * volume[l]);
            }
        }
    });
}
