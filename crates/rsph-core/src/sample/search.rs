//! The spacing at which a body has a given number of particles.

use super::Alignment;
use super::lattice::{MAX_CELLS, cells_around, lattice};
use super::occupy::{Occupied, occupy};
use super::pieces::particles;
use crate::error::InvalidInput;
use crate::shape::Shape;

/// Up to here a count is looked for exactly, beyond with this relative tolerance.
const EXACT: usize = 100_000;
const TOLERANCE: f64 = 2e-4;

/// Corrections of the spacing by the root of the ratio of counts.
const CORRECTIONS: usize = 6;

/// Particles that the search may count in all, and the limits of the number of lattices it tries.
const WORK: usize = 400_000;
const TRIES: (usize, usize) = (8, 200);

/// The cells of the body at the spacing where they number `count`, or come nearest to it.
///
/// # Errors
/// `body.particles` when it is 0 or more than memory holds.
pub(super) fn with_count(
    shape: &dyn Shape,
    count: usize,
    alignment: &[Alignment],
) -> Result<Occupied, InvalidInput> {
    let refuse =
        |problem: String, remedy: &str| Err(InvalidInput::new("body.particles", count, problem, remedy));
    if count == 0 {
        return refuse("a body needs at least one particle".into(), "give a count of 1 or more, e.g. 1000");
    }
    let start = (shape.volume() / count as f64).powf(1.0 / shape.dimension() as f64);
    let cells = cells_around(shape, start);
    if cells > MAX_CELLS {
        let most = count as f64 * MAX_CELLS / cells;
        return refuse(
            format!("the lattice would have {cells:.3e} cells, more than the {MAX_CELLS:.0e} that fit"),
            &format!("give at most about {:.1e} particles", 0.95 * most),
        );
    }
    match nearest(shape, count, start, alignment) {
        Some(best) => Ok(best),
        None => refuse(
            "no spacing was found at which the body has particles: it is too thin".into(),
            "give more particles, or `spacing` instead of `particles`",
        ),
    }
}

fn nearest(shape: &dyn Shape, count: usize, start: f64, alignment: &[Alignment]) -> Option<Occupied> {
    let mut search = Search { shape, count, alignment, best: None };
    search.run(start);
    search.best.map(|best| best.occupied)
}

struct Search<'a> {
    shape: &'a dyn Shape,
    count: usize,
    alignment: &'a [Alignment],
    best: Option<Candidate>,
}

struct Candidate {
    spacing: f64,
    occupied: Occupied,
}

impl Search<'_> {
    fn run(&mut self, start: f64) {
        if self.shape.is_box() {
            // A box is filled best by whole cells along its edges: those spacings come first.
            for &size in self.shape.bounds().size().iter().take(self.shape.dimension()) {
                let nearest = (size / start).round();
                for n in [nearest, nearest - 1.0, nearest + 1.0] {
                    if n >= 1.0 {
                        let found = self.attempt(size / n);
                        if self.is_met_by(found) {
                            return;
                        }
                    }
                }
            }
        }
        let power = 1.0 / self.shape.dimension() as f64;
        let mut spacing = start;
        for _ in 0..CORRECTIONS {
            let found = self.attempt(spacing);
            if self.is_met_by(found) {
                return;
            }
            spacing *= (found as f64 / self.count as f64).powf(power).clamp(0.7, 1.5);
        }
        let Some(centre) = self.best.as_ref().map(|b| b.spacing) else {
            return;
        };
        // Around the best so far in steps of half a particle: the count jumps where layers enter,
        // so that it has no slope to follow.
        let step = 1.0 / (6.0 * self.count as f64).max(50.0);
        for i in 0..(WORK / self.count).clamp(TRIES.0, TRIES.1) {
            let steps = (1 + i / 2) as f64;
            let factor = if i % 2 == 0 { 1.0 + steps * step } else { 1.0 / (1.0 + steps * step) };
            let found = self.attempt(centre * factor);
            if self.is_met_by(found) {
                return;
            }
        }
    }

    /// Whether that many particles are what was asked for.
    fn is_met_by(&self, found: usize) -> bool {
        let tolerance = if self.count > EXACT { TOLERANCE * self.count as f64 } else { 0.0 };
        found.abs_diff(self.count) as f64 <= tolerance
    }

    /// Number of particles at that spacing; keeps the lattice if it is the best so far.
    fn attempt(&mut self, spacing: f64) -> usize {
        if cells_around(self.shape, spacing) > MAX_CELLS {
            return 2 * self.count;
        }
        let occupied = occupy(self.shape, lattice(self.shape, spacing, self.alignment), None);
        let found = particles(&occupied);
        let is_better =
            |b: &Candidate| found.abs_diff(self.count) < particles(&b.occupied).abs_diff(self.count);
        if found > 0 && self.best.as_ref().is_none_or(is_better) {
            self.best = Some(Candidate { spacing, occupied });
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use crate::sample::{Resolution, sample};
    use crate::shape::{BoxShape, DiscShape, RectangleShape, Shape, SphereShape, organ};
    use crate::tensor::Vec3;

    fn count(shape: &dyn Shape, n: usize) -> usize {
        sample(shape, Resolution::Particles(n), &[]).unwrap().cells.len()
    }

    #[test]
    fn cubes_give_cubes_exactly() {
        let cube = BoxShape::new(Vec3::repeat(0.3), Vec3::repeat(-1.0)).unwrap();
        for k in [1, 2, 3, 7, 13, 20] {
            let body = sample(&cube, Resolution::Particles(k * k * k), &[]).unwrap();
            assert_eq!(body.grid.cells, [k; 3]);
        }
        let beam = BoxShape::new(Vec3::new(1.0, 1.0, 5.0), Vec3::zeros()).unwrap();
        assert_eq!(count(&beam, 40), 40);
    }

    #[test]
    fn curved_bodies_hit_the_count() {
        let ball = SphereShape::new(1.0, Vec3::zeros()).unwrap();
        for n in [1, 100, 900] {
            let found = count(&ball, n);
            assert!(found.abs_diff(n) <= 24, "{found} for {n}");
        }
        assert!(count(&organ("liver").unwrap(), 144).abs_diff(144) <= 2);
        assert!(count(&organ("kidney").unwrap(), 1000).abs_diff(1000) <= 2);
    }

    #[test]
    fn plane_bodies_have_one_layer() {
        let square = RectangleShape::new([2.0, 2.0], [0.0, 1.0]).unwrap();
        let body = sample(&square, Resolution::Particles(100), &[]).unwrap();
        assert_eq!(body.grid.cells, [10, 10, 1]);
        assert!(body.cells.iter().all(|c| body.grid.centre(*c).z.abs() < 1e-15));
        assert!((body.volume() - 4.0).abs() < 1e-12);
        assert!(count(&DiscShape::new(1.0, [0.0; 2]).unwrap(), 500).abs_diff(500) <= 8);
    }

    #[test]
    fn impossible_counts_are_refused() {
        let ball = SphereShape::new(1.0, Vec3::zeros()).unwrap();
        for n in [0, 1_000_000_000, usize::MAX] {
            let e = sample(&ball, Resolution::Particles(n), &[]).unwrap_err();
            assert_eq!(e.key, "body.particles");
        }
    }
}
