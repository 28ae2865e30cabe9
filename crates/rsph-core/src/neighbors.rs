//! Neighbours in an irregular set of particles: a cell list for searches around any place, and all pairs as
//! compressed sparse rows.

use crate::tensor::Vec3;
use rayon::prelude::*;

/// Points sorted into cubic cells.
#[derive(Clone, Debug)]
pub struct CellList {
    low: Vec3,
    width: f64,
    count: [usize; 3],
    first: Vec<usize>,
    sorted: Vec<u32>,
}

impl CellList {
    /// The finite ones of `positions` in cells that are at least `width` wide, and not many more than
    /// points.
    pub fn new(positions: &[Vec3], width: f64) -> Self {
        let finite = |x: &&Vec3| x.iter().all(|c| c.is_finite());
        let low = positions.iter().filter(finite).fold(Vec3::repeat(f64::INFINITY), |m, x| m.inf(x));
        let high = positions.iter().filter(finite).fold(Vec3::repeat(f64::NEG_INFINITY), |m, x| m.sup(x));
        if low.x > high.x {
            return Self { low: Vec3::zeros(), width, count: [1; 3], first: vec![0, 0], sorted: Vec::new() };
        }
        let extent = high - low;
        let budget = (4 * positions.len() + 64) as f64;
        let mut width = width;
        while extent.iter().map(|e| (e / width).floor() + 1.0).product::<f64>() > budget {
            width *= 1.5;
        }
        let count = std::array::from_fn(|i| (extent[i] / width).floor() as usize + 1);
        let mut cells = Self { low, width, count, first: Vec::new(), sorted: Vec::new() };

        // Counting sort of the points by cell.
        let mut first = vec![0_usize; count.iter().product::<usize>() + 1];
        for x in positions.iter().filter(finite) {
            first[cells.index(cells.cell(x)) + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut sorted = vec![0_u32; first[first.len() - 1]];
        let mut next = first.clone();
        for (a, x) in positions.iter().enumerate().filter(|(_, x)| finite(x)) {
            let c = cells.index(cells.cell(x));
            sorted[next[c]] = a as u32;
            next[c] += 1;
        }
        (cells.first, cells.sorted) = (first, sorted);
        cells
    }

    fn cell(&self, x: &Vec3) -> [usize; 3] {
        // A coordinate below the lowest saturates to 0.
        std::array::from_fn(|i| (((x[i] - self.low[i]) / self.width) as usize).min(self.count[i] - 1))
    }

    fn index(&self, c: [usize; 3]) -> usize {
        (c[2] * self.count[1] + c[1]) * self.count[0] + c[0]
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.sorted.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.sorted.is_empty()
    }

    /// Calls `visit` with every point of the cells that the ball of `radius` around `x` touches.
    #[inline]
    pub fn visit_near(&self, x: &Vec3, radius: f64, mut visit: impl FnMut(u32)) {
        let (low, high) = (self.cell(&(x - Vec3::repeat(radius))), self.cell(&(x + Vec3::repeat(radius))));
        for k in low[2]..=high[2] {
            for j in low[1]..=high[1] {
                for i in low[0]..=high[0] {
                    let c = self.index([i, j, k]);
                    self.sorted[self.first[c]..self.first[c + 1]].iter().for_each(|b| visit(*b));
                }
            }
        }
    }

    /// The point nearest to `x` and its distance, the first of equals; `positions` are those that the
    /// cells were made of. `None` if there is none within `reach`.
    pub fn nearest(&self, positions: &[Vec3], x: &Vec3, reach: f64) -> Option<(usize, f64)> {
        let mut radius = self.width.min(reach);
        loop {
            let mut best: Option<(usize, f64)> = None;
            self.visit_near(x, radius, |b| {
                let (b, d) = (b as usize, (positions[b as usize] - x).norm());
                if d <= radius && best.is_none_or(|(n, e)| d.total_cmp(&e).then(b.cmp(&n)).is_lt()) {
                    best = Some((b, d));
                }
            });
            if best.is_some() || radius >= reach {
                return best;
            }
            radius = (2.0 * radius).min(reach);
        }
    }
}

/// Particles within a radius of each particle, itself excluded, in ascending order.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    starts: Vec<usize>,
    neighbours: Vec<u32>,
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
                    cells.visit_near(x, radius, |b| {
                        if b as usize != a && (positions[b as usize] - x).norm_squared() < r2 {
                            row.push(b);
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

    proptest! {
        #[test]
        fn the_nearest_point_is_that_of_all(
            points in prop::collection::vec(prop::array::uniform3(-2.0..2.0_f64), 1..60),
            x in prop::array::uniform3(-3.0..3.0_f64),
        ) {
            let positions: Vec<Vec3> = points.into_iter().map(Vec3::from).collect();
            let (x, cells) = (Vec3::from(x), CellList::new(&positions, 0.3));
            let mut all: Vec<(u32, f64)> =
                positions.iter().enumerate().map(|(a, p)| (a as u32, (p - x).norm())).collect();
            all.sort_by(|p, q| p.1.total_cmp(&q.1).then(p.0.cmp(&q.0)));
            let (nearest, d) = (all[0].0 as usize, all[0].1);
            prop_assert_eq!(cells.nearest(&positions, &x, 20.0), Some((nearest, d)));
            prop_assert_eq!(cells.nearest(&positions, &x, 0.99 * d), None);
        }
    }

    #[test]
    fn survives_points_that_are_not_finite() {
        let pairs = Pairs::new(&[Vec3::zeros(), Vec3::repeat(f64::NAN), Vec3::new(0.1, 0.0, 0.0)], 1.0);
        assert_eq!(pairs.of(0), [2]);
        assert_eq!(pairs.of(1), [0_u32; 0]);
    }
}
