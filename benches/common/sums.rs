//! The two kernel sums alone, on a cube without boundaries.

use rsph_core::grid::Grid;
use rsph_core::lattice::Lattice;
use rsph_core::ops::{self, PAIR_COMPONENTS, Plain};
use rsph_core::solve::sums::noise;
use rsph_core::tensor::Vec3;
use rsph_core::tiles::Tile;

/// A cube of particles with the fields that sums read and write.
pub struct Sums {
    lattice: Lattice,
    q: Vec<Tile>,
    pair: Vec<Tile>,
    adjoint: Vec<Tile>,
}

impl Sums {
    /// n^3 particles with h = `smoothing` dx and some numbers in the fields.
    pub fn new(n: usize, smoothing: f64) -> Self {
        let grid = Grid { origin: Vec3::zeros(), spacing: 1.0 / n as f64, cells: [n; 3] };
        let cells: Vec<[usize; 3]> = (0..n.pow(3)).map(|a| [a % n, a / n % n, a / n / n]).collect();
        let lattice = Lattice::new(&grid, &cells, smoothing, 3);
        let (mut q, mut pair) = (lattice.tiles.field(3), lattice.tiles.field(PAIR_COMPONENTS));
        let mut values = vec![0.0; PAIR_COMPONENTS * n.pow(3)];
        noise(&mut values);
        for a in 0..lattice.len() {
            let (t, lane) = lattice.tiles.place(a);
            for (c, value) in values[PAIR_COMPONENTS * a..][..PAIR_COMPONENTS].iter().enumerate() {
                pair[t * PAIR_COMPONENTS + c].0[lane] = *value;
                if c < 3 {
                    q[t * 3 + c].0[lane] = *value;
                }
            }
        }
        let adjoint = lattice.tiles.field(3);
        Self { lattice, q, pair, adjoint }
    }

    /// Sums of Eq. (10).
    pub fn gradient(&mut self) {
        ops::gradient_sums(&self.lattice, None, &self.q, &mut self.pair, [None, None], &Plain);
    }

    /// Sums of Eq. (12).
    pub fn adjoint(&mut self) {
        ops::adjoint_sums(&self.lattice, None, &self.pair, &mut self.adjoint);
    }
}
