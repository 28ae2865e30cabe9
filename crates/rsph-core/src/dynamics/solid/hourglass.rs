//! The hourglass term of a body that was remeshed where it had been deformed.
//!
//! Its residual is what a linear field leaves of u: r_ab = u_ba - G_a X_ba. On the undeformed lattice X_ba is the offset on the
//! lattice; after a remesh at positions xi with the displacement d it is X_ba = xi_ba - d_ba, and
//!
//! ```text
//! G_a = (H_a - U_a) N_a,    H_a = sum c u_ba (x) xi_ba,    U_a = sum c u_ba (x) d_ba,    N_a = (sum c X_ba (x) X_ba)^-1
//! ```
//!
//! with c = V_b w. So the residual vanishes in a body that is turned or deformed uniformly, and remembers the undeformed body. U
//! is a sum of products of fields, as that of the correction near the surface.

use super::constants::Constants;
use super::correction::{GENERAL, GradientField, add_adjoint};
use crate::boundary::fold::Following;
use crate::lattice::Lattice;
use crate::moments::inverse_moment;
use crate::ops::{self, EvenField, Part, Results};
use crate::tensor::lanes::{Lanes, Tensor};
use crate::tensor::{Mat3, SymTensor, Vec3};
use crate::tiles::{Tile, Tiles};
use pulp::Simd;
use rayon::prelude::*;

/// Numbers of a particle: sum c d_b / V and the six of N.
const CONSTANTS: usize = 9;

/// The displacement at the last remesh, and what follows from it.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    /// All tiles.
    pub(super) whole: Part,
    /// d, less that of the first particle.
    displacement: Vec<Tile>,
    constants: Vec<Tile>,
}

/// What the term needs of the particles in some lanes.
pub(super) struct Remembered<S: Simd> {
    /// d.
    pub(super) displacement: [Lanes<S>; 3],
    /// sum c d_b / V.
    pub(super) zeroth: [Lanes<S>; 3],
    /// N.
    pub(super) inverse: Tensor<Lanes<S>>,
}

impl Memory {
    /// Of particles at the nodes of `lattice` that were at `positions` in the undeformed body; images follow them.
    pub(super) fn new(
        lattice: &Lattice,
        following: &Following,
        constants: &Constants,
        positions: &[Vec3],
    ) -> Self {
        let tiles = &lattice.tiles;
        let moved = |a: usize| lattice.position(a) - positions[a];
        let origin = if positions.is_empty() { Vec3::zeros() } else { moved(0) };
        let rows: Vec<(Vec3, Mat3)> = (0..lattice.len())
            .into_par_iter()
            .map(|a| {
                let (mut zeroth, mut second) = (Vec3::zeros(), Mat3::zeros());
                for neighbour in &lattice.neighbours {
                    if let Some(seen) = lattice.seen(a, neighbour) {
                        let (t, lane) = tiles.place(seen.particle);
                        let c = constants.volume(t)[lane] * neighbour.w;
                        let other = following.image(seen.mirrors, &moved(seen.particle));
                        let x = neighbour.x + moved(a) - other;
                        zeroth += c * (other - origin);
                        second += c * x * x.transpose();
                    }
                }
                (zeroth, inverse_moment(lattice, &second))
            })
            .collect();
        let mut memory = Self {
            whole: Part::new(lattice, |_| true),
            displacement: tiles.field(3),
            constants: tiles.field(CONSTANTS),
        };
        for (a, (zeroth, inverse)) in rows.iter().enumerate() {
            let (t, lane) = tiles.place(a);
            let d = moved(a) - origin;
            let inverse = SymTensor::symmetric_part(inverse).0;
            for i in 0..3 {
                memory.displacement[3 * t + i].0[lane] = d[i];
            }
            let zeroth = zeroth / constants.volume(t)[lane];
            for (c, value) in zeroth.iter().chain(&inverse).enumerate() {
                memory.constants[CONSTANTS * t + c].0[lane] = *value;
            }
        }
        for image in &lattice.images {
            let (t, lane) = image.place();
            let d = following.image(image.mirrors, &moved(image.particle as usize)) - origin;
            (0..3).for_each(|i| memory.displacement[3 * t + i].0[lane] = d[i]);
        }
        memory
    }

    /// Leaves sum c u_b (x) d_b in the tiled field `sums`, of the field u that is spread in `q`.
    pub(super) fn spread(&self, lattice: &Lattice, q: &[Tile], sums: &mut [Tile]) {
        let products = GradientField::<GENERAL> { reach: &self.whole, gamma: &self.displacement, q };
        ops::even_sums(lattice, &self.whole, &products, Results::new(None, GENERAL, sums));
    }

    /// What it holds of the particles in the lanes from `lane` on of a tile.
    #[inline(always)]
    pub(super) fn local<S: Simd>(&self, simd: S, tile: usize, lane: usize) -> Remembered<S> {
        let zero = Lanes::splat(simd, 0.0);
        let (mut displacement, mut constant) = ([zero; 3], [zero; CONSTANTS]);
        for (to, from) in displacement.iter_mut().zip(&self.displacement[3 * tile..]) {
            *to = Lanes::load(simd, &from.0[lane..]);
        }
        for (to, from) in constant.iter_mut().zip(&self.constants[CONSTANTS * tile..]) {
            *to = Lanes::load(simd, &from.0[lane..]);
        }
        let [x, y, z, xx, yy, zz, xy, yz, xz] = constant;
        let inverse = Tensor([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
        Remembered { displacement, zeroth: [x, y, z], inverse }
    }

    /// Adds the adjoint of U to the tiled field `adjoint`, from dE/dU.
    pub(super) fn add_adjoint(&self, lattice: &Lattice, slope: &[Tile], adjoint: &mut [Tile]) {
        let force = Force { tiles: &lattice.tiles, displacement: &self.displacement, slope };
        ops::even_sums(lattice, &self.whole, &force, Results::new(None, 3, adjoint));
    }
}

/// What the sums of the second sweep are taken of: W = dE/dU and W d.
struct Force<'a> {
    tiles: &'a Tiles,
    displacement: &'a [Tile],
    slope: &'a [Tile],
}

impl EvenField<{ GENERAL + 3 }> for Force<'_> {
    #[inline(always)]
    fn lanes<const N: usize>(&self, tile: usize, first: usize) -> Option<[[f64; N]; GENERAL + 3]> {
        let (w, d) = (&self.slope[GENERAL * tile..][..GENERAL], &self.displacement[3 * tile..][..3]);
        let mut values = [[0.0; N]; GENERAL + 3];
        // Cells without a particle hold sums that nothing has replaced.
        let (_, mask) = self.tiles.particles(tile);
        for l in (0..N).filter(|l| mask >> (first + l) & 1 == 1) {
            for c in 0..GENERAL {
                values[c][l] = w[c].0[first + l];
                values[GENERAL + c / 3][l] += w[c].0[first + l] * d[c % 3].0[first + l];
            }
        }
        Some(values)
    }

    #[inline(always)]
    fn keep<S: Simd>(&self, simd: S, tile: usize, lane: usize, sums: &[S::f64s], adjoint: &mut [Tile]) {
        add_adjoint::<S, GENERAL>(simd, &self.displacement[3 * tile..][..3], lane, sums, adjoint);
    }
}
