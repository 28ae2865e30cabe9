//! Neighbours in an irregular set of particles: a cell list for searches around any place, and all pairs as
//! compressed sparse rows.

use crate::tensor::Vec3;
use rayon::prelude::*;

/// Particles within a radius of each particle, itself excluded, in ascending order.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    starts: Vec<usize>,
    neighbours: Vec<u32>,
}

/// An irregular set of points sorted into cells, for searches around any place.
#[derive(Clone, Debug)]
pub struct CellList {
    low: Vec3,
    width: f64,
    count: [usize; 3],
    first: Vec<usize>,
    sorted: Vec<u32>,
}

impl CellList {
    /// Sorts `positions` into cells at least `width` wide (and not many more than points). Positions
    /// that are not finite are in no cell.
    pub fn new(positions: &[Vec3], width: f64) -> Self {
        let finite = |x: &&Vec3| x.iter().all(|c| c.is_finite());
        let low = positions.iter().filter(finite).fold(Vec3::repeat(f64::INFINITY), |m, x| m.inf(x));
        let high = positions.iter().filter(finite).fold(Vec3::repeat(f64::NEG_INFINITY), |m, x| m.sup(x));
        if low.x > high.x {
            return Self { low: Vec3::zeros(), width, count: [0; 3], first: vec![0], sorted: Vec::new() };
        }
        let extent = high - low;
        let budget = (4 * positions.len() + 64) as f64;
        let mut width = width;
        while extent.iter().map(|e| (e / width).floor() + 1.0).product::<f64>() > budget {
            width *= 1.5;
        }
        let count: [usize; 3] = std::array::from_fn(|i| (extent[i] / width).floor() as usize + 1);
        let mut list = Self { low, width, count, first: Vec::new(), sorted: Vec::new() };

        // Counting sort of the points by cell.
        let mut first = vec![0_usize; count.iter().product::<usize>() + 1];
        for x in positions.iter().filter(finite) {
            first[list.cell(x) + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        list.sorted = vec![0_u32; first[first.len() - 1]];
        let mut next = first.clone();
        for (a, x) in positions.iter().enumerate().filter(|(_, x)| finite(x)) {
            let c = list.cell(x);
            list.sorted[next[c]] = a as u32;
            next[c] += 1;
        }
        list.first = first;
        list
    }

    fn cell(&self, x: &Vec3) -> usize {
        let c: [usize; 3] =
            std::array::from_fn(|i| (((x[i] - self.low[i]) / self.width) as usize).min(self.count[i] - 1));
        self.index(c)
    }

    fn index(&self, c: [usize; 3]) -> usize {
        (c[2] * self.count[1] + c[1]) * self.count[0] + c[0]
    }

    /// Calls `visit` with every point that may lie within `radius` of `x`, and some farther ones, in a
    /// fixed order.
    pub fn around(&self, x: &Vec3, radius: f64, mut visit: impl FnMut(usize)) {
        let range = |i: usize| {
            let at = |d: f64| ((x[i] + d - self.low[i]) / self.width).floor();
            // A cast from a negative number gives 0; an empty list has no cells.
            let end = (at(radius) + 1.0).max(0.0) as usize;
            at(-radius) as usize..end.min(self.count[i])
        };
        for k in range(2) {
            for j in range(1) {
                for i in range(0) {
                    let c = self.index([i, j, k]);
                    self.sorted[self.first[c]..self.first[c + 1]].iter().for_each(|&b| visit(b as usize));
                }
            }
        }
    }
}

impl Pairs {
    /// All pairs of `positions` closer than `radius`. Not-finite positions have no neighbours.
    pub fn new(positions: &[Vec3], radius: f64) -> Self {
        let cells = CellList::new(positions, radius);
        let r2 = radius * radius;
        let rows: Vec<Vec<u32>> = positions
            .par_iter()
            .enumerate()
            .map(|(a, x)| {
                let mut row = Vec::new();
                if x.iter().all(|c| c.is_finite()) {
                    cells.around(x, radius, |b| {
                        if b != a && (positions[b] - x).norm_squared() < r2 {
                            row.push(b as u32);
                        }
                    });
                }
                row.sort_unstable();
                row
            })
            .collect();
        let mut starts = Vec::with_capacity(rows.len() + 1);
        starts.push(0);
        for row in &rows {
            starts.push(starts[starts.len() - 1] + row.len());
        }
        Self { starts, neighbours: rows.concat() }
    }

    /// Neighbours of particle `a`.
    #[inline(always)]
    pub fn of(&self, a: usize) -> &[u32] {
        &self.neighbours[self.starts[a]..self.starts[a + 1]]
    }

    /// Number of ordered pairs.
    pub fn len(&self) -> usize {
        self.neighbours.len()
    }

    /// Whether no particle has a neighbour.
    pub fn is_empty(&self) -> bool {
        self.neighbours.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_all_pairs(
            points in prop::collection::vec(prop::array::uniform3(-2.0..2.0_f64), 0..80),
            radius in 0.05..3.0_f64,
        ) {
            let x: Vec<Vec3> = points.into_iter().map(Vec3::from).collect();
            let pairs = Pairs::new(&x, radius);
            for a in 0..x.len() {
                let expected: Vec<u32> = (0..x.len())
                    .filter(|&b| b != a && (x[b] - x[a]).norm_squared() < radius * radius)
                    .map(|b| b as u32)
                    .collect();
                prop_assert_eq!(pairs.of(a), &expected[..]);
            }
        }
    }

    #[test]
    fn survives_points_that_are_not_finite() {
        let pairs = Pairs::new(&[Vec3::zeros(), Vec3::repeat(f64::NAN), Vec3::new(0.1, 0.0, 0.0)], 1.0);
        assert_eq!(pairs.of(0), [2]);
        assert_eq!(pairs.of(1), [0_u32; 0]);
    }
}
