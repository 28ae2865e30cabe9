//! Particle updates a second as JSON, for scripts. `cargo bench -p rsph-core --bench rates -- cube 20 37 58`
//! measures cubes of so many particles along an edge, `-- liver 50000` livers of about so many particles, and
//! `-- sums 37` the kernel sums alone. An update is one right-hand side of one particle. The best of what fits
//! into a second counts: other programs can only make it slower.

mod common;

use common::irregular::Irregular;
use common::liver::liver;
use common::sums::Sums;
use common::{NARROW, WIDE, cube, cycle::Cycle};
use rsph_core::setup::{Scheme, Solver};
use rsph_core::simulation::Simulation;
use std::time::{Duration, Instant};

/// Time spent on each figure.
const SPEND: Duration = Duration::from_secs(1);
/// Runs of a figure at least.
const LEAST_RUNS: u32 = 3;

/// Shortest time of `run`, in seconds.
fn best(mut run: impl FnMut()) -> f64 {
    run();
    let (begin, mut best, mut runs) = (Instant::now(), f64::INFINITY, 0);
    while runs < LEAST_RUNS || begin.elapsed() < SPEND {
        let start = Instant::now();
        run();
        best = best.min(start.elapsed().as_secs_f64());
        runs += 1;
    }
    best
}

/// The figures of one body.
struct Row(Vec<String>);

impl Row {
    fn new(body: &str, size: usize) -> Self {
        Self(vec![format!("\"body\": \"{body}\", \"size\": {size}")])
    }

    fn add(&mut self, name: &str, value: f64) {
        self.0.push(format!("\"{name}\": {value:.4e}"));
    }

    /// Right-hand sides and RK4 steps of a body with that many neighbours.
    fn add_steps(&mut self, neighbours: usize, mut body: Simulation) {
        let particles = body.description().particles as f64;
        if self.0.len() == 1 {
            self.add("particles", particles);
        }
        self.add(&format!("right_hand_side_{neighbours}"), particles / best(|| _ = body.evaluate()));
        let step = best(|| body.step().expect("a stable step"));
        self.add(&format!("rk4_{neighbours}"), 4.0 * particles / step);
    }
}

/// Smoothing lengths with their numbers of neighbours.
const STENCILS: [(Solver, usize); 2] = [(WIDE, 122), (NARROW, 26)];

fn measure(body: &str, size: usize) -> Row {
    let mut row = Row::new(body, size);
    let count = size.pow(3) as f64;
    match body {
        "cube" => STENCILS.iter().for_each(|(s, nb)| row.add_steps(*nb, cube(size, *s))),
        "liver" => STENCILS.iter().for_each(|(s, nb)| row.add_steps(*nb, liver(size, *s, Scheme::Rk4))),
        "sums" => {
            for (solver, neighbours) in STENCILS {
                let mut sums = Sums::new(size, solver.smoothing);
                row.add(&format!("gradient_{neighbours}"), count / best(|| sums.gradient()));
                row.add(&format!("adjoint_{neighbours}"), count / best(|| sums.adjoint()));
            }
            let mut cycle = Cycle::new(size);
            row.add("v_cycle", count / best(|| cycle.run()));
        }
        "pairs" => {
            let mut pairs = Irregular::new(size);
            row.add("neighbours", pairs.neighbours());
            row.add("pairs", count / best(|| pairs.update(0.0)));
            row.add("pairs_hourglass", count / best(|| pairs.update(0.2)));
        }
        other => panic!("no body `{other}`: cube, liver, sums, pairs"),
    }
    row
}

fn main() {
    let (mut body, mut rows) = ("cube".to_string(), Vec::new());
    // cargo adds `--bench`.
    for word in std::env::args().skip(1).filter(|a| !a.starts_with('-')) {
        match word.parse() {
            Ok(size) => rows.push(format!("{{{}}}", measure(&body, size).0.join(", "))),
            Err(_) => body = word,
        }
    }
    println!("{{\"threads\": {}, \"rows\": [{}]}}", rayon::current_num_threads(), rows.join(", "));
}
