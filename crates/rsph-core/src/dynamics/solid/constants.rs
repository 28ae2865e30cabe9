//! Constants of the sums on the lattice, the moments of every particle, and fields spread over its tiles.

use crate::boundary::fold::Following;
use crate::lattice::Lattice;
use crate::moments::Moments;
use crate::tensor::lanes::{Lanes, Tensor};
use crate::tensor::{Mat3, SymTensor, Vec3};
use crate::tiles::{LANES, Tile};
use pulp::Simd;
use rayon::prelude::*;

/// Numbers of a particle that the sweep needs: V, the six of L (VTK order),
/// sum V_b w X / V and sum V_b w / V.
const CONSTANTS: usize = 11;
/// Constants of the sums, as a tiled field.
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

/// Constants of the particles in some lanes of a tile.
pub(super) struct Local<S: Simd> {
    pub(super) volume: Lanes<S>,
    /// L.
    pub(super) correction: Tensor<Lanes<S>>,
    /// sum V_b w X / V.
    pub(super) first: [Lanes<S>; 3],
    /// sum V_b w / V.
    pub(super) zeroth: Lanes<S>,
}

impl<S: Simd> Local<S> {
    /// The product of a tensor with L, a number where the neighbourhood is full.
    #[inline(always)]
    pub(super) fn corrected<const FULL: bool>(&self, t: &Tensor<Lanes<S>>) -> Tensor<Lanes<S>> {
        if FULL { t.scaled(self.correction.0[0][0]) } else { t.times(&self.correction) }
    }
}

/// Constants of a particle with these moments.
fn packed(m: &Moments) -> [f64; CONSTANTS] {
    let l = SymTensor::symmetric_part(&m.correction).0;
    let first = m.first / m.volume;
    [m.volume, l[0], l[1], l[2], l[3], l[4], l[5], first.x, first.y, first.z, m.zeroth / m.volume]
}

/// Tiles that one task spreads.
const TILES_PER_TASK: usize = 128;
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

    /// Whether the particles of tile `t` have full cells and neighbourhoods.
    #[inline(always)]
    pub(super) fn is_full(&self, t: usize) -> bool {
        self.kind[t] == 0
    }

    /// Constants in the lanes from `lane` on of a tile, which is full or not as `FULL` says.
    #[inline(always)]
    pub(super) fn local<S: Simd, const FULL: bool>(&self, simd: S, tile: usize, lane: usize) -> Local<S> {
        let zero = Lanes::splat(simd, 0.0);
        if FULL {
            let Bulk { volume, correction, zeroth } = self.bulk;
            let [volume, l, zeroth] = [volume, correction, zeroth].map(
                #[inline(always)]
                |x| Lanes::splat(simd, x),
            );
            let correction = Tensor([[l, zero, zero], [zero, l, zero], [zero, zero, l]]);
            return Local { volume, correction, first: [zero; 3], zeroth };
        }
        let mut constant = [zero; CONSTANTS];
        for (constant, value) in constant.iter_mut().zip(self.of(tile)) {
            *constant = Lanes::load(simd, &value.0[lane..]);
        }
        let [volume, xx, yy, zz, xy, yz, xz, first @ .., zeroth] = constant;
        Local { volume, correction: Tensor([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), first, zeroth }
    }
}

/// Spreads V (u + T v - `origin`) over the tiles, of fields component by component; v with T, if it is there. Images follow
/// their particles.
pub(super) fn scatter(
    lattice: &Lattice,
    following: &Following,
    constants: &Constants,
    u: &[f64],
    v: Option<(&[f64], f64)>,
    origin: &Vec3,
    q: &mut [Tile],
) {
    let (n, tiles) = (u.len() / 3, &lattice.tiles);
    q.par_chunks_mut(3).with_min_len(TILES_PER_TASK).enumerate().for_each(|(t, q)| {
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
        for image in lattice.images_in(t) {
            let (a, set) = (image.particle as usize, image.mirrors as usize);
            let (tile, lane) = tiles.place(a);
            let volume = constants.volume(tile)[lane];
            for i in 0..3 {
                let z = u[i * n + a] + v.map_or(0.0, |(v, relaxation_time)| relaxation_time * v[i * n + a]);
                let mirrored = following.signs[set][i] * z + following.offsets[set][i];
                q[i].0[image.place().1] = volume * (mirrored - origin[i]);
            }
        }
    });
}
