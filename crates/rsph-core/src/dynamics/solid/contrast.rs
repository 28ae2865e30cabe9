//! The hourglass term between particles of different moduli.
//!
//! With a modulus kappa_a of its own for every particle the term's energy is sum_a kappa_a V_a sum_b V_b w |r_ab|^2 / 2, and its springs
//! pull at particle a by V_a sum_b (kappa_a + kappa_b) V_b w z_ba. The sweeps take 2 kappa_a for the sum; the rest,
//! V_a sum_b (kappa_b - kappa_a) V_b w z_ba, is summed here, only where moduli differ.

use super::constants::Constants;
use crate::lattice::Lattice;
use crate::ops::{self, EvenField, Part, Results};
use crate::tensor::Vec3;
use crate::tiles::{LANES, Tile};
use rayon::prelude::*;

/// Relative difference below which moduli are the same.
const SAME: f64 = 1e-12;
/// Tiles in a task.
const TILES_PER_TASK: usize = 64;

/// The springs between particles of different moduli.
#[derive(Clone, Debug)]
pub(super) struct Contrast {
    /// Tiles with particles that see another modulus, and which of all tiles they are.
    part: Part,
    tiles: Vec<u32>,
    /// Modulus of every particle and image, in units of kappa.
    modulus: Vec<Tile>,
    /// On the part: sum_b (kappa_b - kappa_a) V_b w.
    zeroth: Vec<Tile>,
    /// On the part: sums of q_b and kappa_b q_b, then the pull of the springs over V_a in the first three.
    pull: Vec<Tile>,
}

impl Contrast {
    /// Between particles with those moduli; `None` if they are all the same.
    pub(super) fn new(lattice: &Lattice, constants: &Constants, modulus: &[Tile]) -> Option<Self> {
        let tiles = &lattice.tiles;
        let of = |a: usize| {
            let (t, lane) = tiles.place(a);
            (modulus[t].0[lane], constants.volume(t)[lane])
        };
        let zeroth: Vec<(f64, bool)> = (0..lattice.len())
            .into_par_iter()
            .map(|a| {
                let (own, (mut sum, mut differs)) = (of(a).0, (0.0, false));
                for neighbour in &lattice.neighbours {
                    if let Some(seen) = lattice.seen(a, neighbour) {
                        let (other, volume) = of(seen.particle);
                        sum += (other - own) * volume * neighbour.w;
                        differs |= (other - own).abs() > SAME * own;
                    }
                }
                (sum, differs)
            })
            .collect();
        let mut belongs = vec![false; tiles.len()];
        for a in (0..lattice.len()).filter(|a| zeroth[*a].1) {
            belongs[tiles.place(a).0] = true;
        }
        let part = Part::new(lattice, |t| belongs[t]);
        if part.is_empty() {
            return None;
        }
        let mut modulus = modulus.to_vec();
        for image in &lattice.images {
            let ((t, lane), own) = (image.place(), of(image.particle as usize).0);
            modulus[t].0[lane] = own;
        }
        let mut new = Self {
            zeroth: vec![Tile::default(); part.len()],
            pull: vec![Tile::default(); 6 * part.len()],
            modulus,
            tiles: (0..tiles.len()).filter(|t| belongs[*t]).map(|t| t as u32).collect(),
            part,
        };
        for (a, (sum, _)) in zeroth.iter().enumerate() {
            let (t, lane) = tiles.place(a);
            if let Some(number) = new.part.number(t) {
                new.zeroth[number].0[lane] = *sum;
            }
        }
        Some(new)
    }

    /// Takes the pull of the springs from V z in the tiled field `q`.
    pub(super) fn stretch(&mut self, lattice: &Lattice, constants: &Constants, q: &[Tile]) {
        let field = Weighted { modulus: &self.modulus, q };
        ops::even_sums(lattice, &self.part, &field, Results::new(Some(&self.part), 6, &mut self.pull));
        let Self { modulus, tiles, zeroth, pull, .. } = self;
        let each = (pull.par_chunks_mut(6), &*tiles, &*zeroth).into_par_iter().with_min_len(TILES_PER_TASK);
        each.for_each(|(pull, t, zeroth)| {
            let t = *t as usize;
            let volume = constants.volume(t);
            for l in 0..LANES {
                let (own, is_particle) = (modulus[t].0[l], lattice.tiles.particle(t, l).is_some());
                for i in 0..3 {
                    let z = q[3 * t + i].0[l] / volume[l];
                    let sum = pull[3 + i].0[l] - own * pull[i].0[l] - z * zeroth.0[l];
                    // Images take no part in it: what they would get goes to the faces.
                    pull[i].0[l] = if is_particle { sum } else { 0.0 };
                }
            }
        });
    }

    /// Adds the pull of the springs, times kappa, to the sums of the second sweep.
    pub(super) fn add(&self, kappa: f64, sums: &mut [Tile]) {
        let each = sums.par_chunks_mut(3).enumerate().with_min_len(TILES_PER_TASK);
        each.for_each(|(t, sums)| {
            let Some(number) = self.part.number(t) else { return };
            for (sum, pull) in sums.iter_mut().zip(&self.pull[6 * number..]) {
                sum.0.iter_mut().zip(&pull.0).for_each(|(sum, pull)| *sum += kappa * pull);
            }
        });
    }

    /// The pull of the springs on a particle over its volume, in units of kappa.
    pub(super) fn pull(&self, (tile, lane): (usize, usize)) -> Vec3 {
        let Some(number) = self.part.number(tile) else { return Vec3::zeros() };
        Vec3::from_fn(|i, _| self.pull[6 * number + i].0[lane])
    }
}

/// q and kappa q.
struct Weighted<'a> {
    modulus: &'a [Tile],
    q: &'a [Tile],
}

impl EvenField<6> for Weighted<'_> {
    #[inline(always)]
    fn lanes<const N: usize>(&self, tile: usize, first: usize) -> Option<[[f64; N]; 6]> {
        let modulus = &self.modulus[tile].0[first..first + N];
        let mut values = [[0.0; N]; 6];
        for (i, q) in self.q[3 * tile..][..3].iter().enumerate() {
            for l in 0..N {
                values[i][l] = q.0[first + l];
                values[3 + i][l] = q.0[first + l] * modulus[l];
            }
        }
        Some(values)
    }
}
