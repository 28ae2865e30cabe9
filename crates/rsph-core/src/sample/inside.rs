//! How much of a cell lies inside a body, wherever the cell is.

use super::occupy::neighbours;
use super::{Body, is_cut};
use crate::grid::Grid;
use crate::shape::Shape;
use crate::tensor::{Mat3, Vec3};

/// Fine cells along an edge of a cell.
const FINE: usize = 4;
/// Fine cells of a cell.
const BLOCK: usize = FINE * FINE * FINE;
/// Marks cells that are inside, and outside.
const FULL: u32 = u32::MAX;
const EMPTY: u32 = u32::MAX - 1;

/// Inside fraction of cells, at any place and deformed.
///
/// Cells that the surface cuts are filled on a lattice four times as fine. (Between the fractions of whole cells their
/// mean by overlap would be that of a surface smeared over two of them.)
#[derive(Clone, Debug)]
pub struct InsideFraction {
    /// The lattice of the body with one more layer of cells all around.
    grid: Grid,
    /// For each of its cells `FULL`, `EMPTY` or the number of its block.
    block: Vec<u32>,
    /// Inside fractions of the fine cells of cut ones, a block for each.
    fine: Vec<f64>,
}

impl InsideFraction {
    /// Fills the cut cells of `body`, the sample of `shape`; pieces of the shape that hold no particle count as outside.
    pub fn new(shape: &dyn Shape, body: &Body) -> Self {
        let spacing = body.grid.spacing;
        let grid = Grid {
            origin: body.grid.origin - Vec3::repeat(spacing),
            spacing,
            cells: body.grid.cells.map(|n| n + 2),
        };
        let particles: Vec<usize> = body.cells.iter().map(|c| grid.index(c.map(|i| i + 1))).collect();
        let mut block = vec![EMPTY; grid.len()];
        // What is cut or lies beside a particle is filled; the number follows.
        let mut filled = vec![false; grid.len()];
        for (&c, cell) in particles.iter().zip(&body.cells) {
            block[c] = FULL;
            for around in neighbours(&grid, cell.map(|i| i + 1)) {
                filled[around] = true;
            }
        }
        for (&c, fraction) in particles.iter().zip(&body.fraction) {
            filled[c] = is_cut(*fraction);
        }
        let mut fine = Vec::new();
        let [nx, ny, nz] = grid.cells;
        for z in 0..nz {
            let layer = z * nx * ny..(z + 1) * nx * ny;
            if !filled[layer.clone()].contains(&true) {
                continue;
            }
            let finer = Grid {
                origin: grid.origin + Vec3::new(0.0, 0.0, z as f64 * spacing),
                spacing: spacing / FINE as f64,
                cells: [nx * FINE, ny * FINE, FINE],
            };
            let fraction = shape.fill(&finer);
            for c in layer.filter(|c| filled[*c]) {
                let (x, y) = (c % nx * FINE, c / nx % ny * FINE);
                let first = fine.len();
                for k in 0..FINE {
                    for j in 0..FINE {
                        let row = finer.index([x, y + j, k]);
                        fine.extend_from_slice(&fraction[row..row + FINE]);
                    }
                }
                block[c] = match fine[first..].iter().sum::<f64>() {
                    none if none <= 0.0 => EMPTY,
                    all if all >= BLOCK as f64 => FULL,
                    _ => (first / BLOCK) as u32,
                };
                if block[c] >= EMPTY {
                    fine.truncate(first);
                }
            }
        }
        fine.shrink_to_fit();
        Self { grid, block, fine }
    }

    /// Inside fraction, 0 to 1, of the parallelepiped around `x` that is the image of a cell under a linear map; 0 where `x` is
    /// not finite.
    pub fn of_image(&self, x: &Vec3, map: &Mat3) -> f64 {
        let part = |k: usize| (k as f64 + 0.5) / FINE as f64 - 0.5;
        let mut sum = 0.0;
        for k in 0..BLOCK {
            let at = Vec3::new(part(k % FINE), part(k / FINE % FINE), part(k / FINE / FINE));
            sum += self.beside(&(x + map * at * self.grid.spacing));
        }
        sum / BLOCK as f64
    }

    /// Inside fraction of the cube as large as a fine cell around `x`.
    fn beside(&self, x: &Vec3) -> f64 {
        let corner = (x - self.grid.origin) / self.grid.spacing * FINE as f64 - Vec3::repeat(0.5);
        let last = self.grid.cells.map(|n| (n * FINE) as f64);
        if !(0..3).all(|i| corner[i] > -1.0 && corner[i] < last[i]) {
            return 0.0;
        }
        let low = corner.map(f64::floor);
        let part = corner - low;
        (0..8)
            .map(|c| {
                let upper = [c & 1, c >> 1 & 1, c >> 2];
                let share: f64 =
                    (0..3).map(|i| if upper[i] == 1 { part[i] } else { 1.0 - part[i] }).product();
                if share == 0.0 {
                    return 0.0;
                }
                share * self.fine(std::array::from_fn(|i| low[i] as isize + upper[i] as isize))
            })
            .sum()
    }

    /// Inside fraction of a fine cell.
    fn fine(&self, cell: [isize; 3]) -> f64 {
        if (0..3).any(|i| cell[i] < 0 || cell[i] >= (self.grid.cells[i] * FINE) as isize) {
            return 0.0;
        }
        let cell = cell.map(|i| i as usize);
        match self.block[self.grid.index(cell.map(|i| i / FINE))] {
            FULL => 1.0,
            EMPTY => 0.0,
            number => {
                let [x, y, z] = cell.map(|i| i % FINE);
                self.fine[number as usize * BLOCK + (z * FINE + y) * FINE + x]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Resolution, sample};
    use super::*;
    use crate::shape::{BoxShape, SphereShape};
    use proptest::prelude::*;

    /// Of a cell as it was.
    fn at(inside: &InsideFraction, x: &Vec3) -> f64 {
        inside.of_image(x, &Mat3::identity())
    }

    /// Of one dimension: the overlap of a cell around `x` with the interval.
    fn overlap(x: f64, dx: f64, interval: (f64, f64)) -> f64 {
        ((x + 0.5 * dx).min(interval.1) - (x - 0.5 * dx).max(interval.0)).max(0.0) / dx
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        /// The overlap of two boxes, to what a fine cell hides.
        #[test]
        fn a_cell_in_a_box_holds_their_overlap(
            dx in 0.13..0.3_f64,
            x in prop::array::uniform3(-0.8..0.8_f64),
        ) {
            let shape = BoxShape::new(Vec3::repeat(1.0), Vec3::repeat(-0.5)).unwrap();
            let body = sample(&shape, Resolution::Spacing(dx), &[]).unwrap();
            let inside = InsideFraction::new(&shape, &body);
            let exact: f64 = x.iter().map(|x| overlap(*x, dx, (-0.5, 0.5))).product();
            let found = at(&inside, &Vec3::from(x));
            // What a face leaves of a fine cell is taken to be spread over it: a quarter of its length at most, for each
            // axis that has a face at the cell.
            let is_cut = |x: &&f64| x.abs() + 0.5 * dx > 0.5 - dx / FINE as f64;
            let cut = x.iter().filter(is_cut).count();
            let allowed = 1e-9 + 0.25 / FINE as f64 * cut as f64;
            prop_assert!((found - exact).abs() < allowed, "{} {} {}", found, exact, allowed);
        }

        /// Cells side by side, wherever the first is, fill the ball.
        #[test]
        fn cells_side_by_side_hold_the_volume(shift in prop::array::uniform3(-0.5..0.5_f64)) {
            let shape = SphereShape::new(0.5, Vec3::zeros()).unwrap();
            let dx = 0.11;
            let body = sample(&shape, Resolution::Spacing(dx), &[]).unwrap();
            let inside = InsideFraction::new(&shape, &body);
            let cells = -6..=6;
            let sum: f64 = cells.clone()
                .flat_map(|k| cells.clone().flat_map(move |j| (-6..=6).map(move |i| [i, j, k])))
                .map(|c: [i32; 3]| at(&inside, &Vec3::from_fn(|i, _| (f64::from(c[i]) + shift[i]) * dx)))
                .sum();
            let exact = std::f64::consts::PI / 6.0;
            prop_assert!((sum * dx.powi(3) / exact - 1.0).abs() < 2e-3, "{}", sum * dx.powi(3) / exact);
        }
    }

    #[test]
    fn whole_cells_and_places_far_away_are_exact() {
        let shape = BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap();
        let body = sample(&shape, Resolution::Spacing(0.25), &[]).unwrap();
        let inside = InsideFraction::new(&shape, &body);
        assert!(inside.fine.is_empty());
        assert!((at(&inside, &Vec3::new(0.3, 0.61, 0.5)) - 1.0).abs() < 1e-12);
        for x in [Vec3::repeat(1.2), Vec3::repeat(1e300), Vec3::repeat(f64::NAN), Vec3::new(0.5, 0.5, -7.0)] {
            assert!(at(&inside, &x) == 0.0);
        }
        assert!((at(&inside, &Vec3::new(0.5, 0.5, 1.05)) - 0.3).abs() < 1e-12);
    }
}
