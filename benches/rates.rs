//! Speed as JSON, for scripts. `cargo bench -p rsph-core --bench rates -- cube 20 37 58` measures cubes of so many
//! particles along an edge, `-- neo_hookean 37` and `-- remeshed 37` the same of that law before and after a remesh,
//! `-- liver 50000` livers of about so many particles and `-- sums 37` the kernel sums alone, in particle updates a
//! second: an update is one right-hand side of one particle. `-- static 20000` takes livers to rest and `-- frames 5000` moves a load over them, in seconds. The best of
//! what fits into a second counts: other programs can only make it slower. Rates are those of one thread and of all.

mod common;

use common::liver::{CYCLE, FRAME, liver, press};
use common::sums::Sums;
use common::{NARROW, WIDE, cube, cycle::Cycle, neo_hookean_cube, run_step};
use rayon::{ThreadPool, ThreadPoolBuilder};
use rsph_core::setup::{Scheme, Solver};
use rsph_core::simulation::Simulation;
use std::time::{Duration, Instant};

/// Time spent on each figure with each number of threads.
const SPEND: Duration = Duration::from_secs(1);
/// A turn of one number of threads.
const TURN: Duration = Duration::from_millis(200);
/// Turns of a figure at least, or runs.
const LEAST_RUNS: u32 = 3;

/// Pools of one thread and of all.
struct Pools([ThreadPool; 2]);

impl Pools {
    fn new() -> Self {
        let all = rayon::current_num_threads();
        Self([1, all].map(|n| ThreadPoolBuilder::new().num_threads(n).build().expect("threads")))
    }

    /// Shortest times of `run` in seconds, with one thread and with all. They take turns, so that both see the same
    /// machine, but not after every run: each finds in its caches what the other left there.
    fn best(&self, mut run: impl FnMut() + Send) -> [f64; 2] {
        run();
        let (begin, mut best, mut rounds) = (Instant::now(), [f64::INFINITY; 2], 0);
        while rounds < LEAST_RUNS || begin.elapsed() < 2 * SPEND {
            for (best, pool) in best.iter_mut().zip(&self.0) {
                pool.install(|| {
                    let mut left = TURN.as_secs_f64();
                    while left > 0.0 {
                        let start = Instant::now();
                        run();
                        let spent = start.elapsed().as_secs_f64();
                        *best = best.min(spent);
                        left -= spent;
                    }
                });
            }
            rounds += 1;
        }
        best
    }
}

/// Steps of a run from one look of the watchdog to the next.
const LOOKS: f64 = 20.0;

/// The figures of one body.
struct Row(Vec<String>);

impl Row {
    fn new(body: &str, size: usize) -> Self {
        Self(vec![format!("\"body\": \"{body}\", \"size\": {size}")])
    }

    fn add(&mut self, name: &str, value: f64) {
        self.0.push(format!("\"{name}\": {value:.4e}"));
    }

    /// Rates of `count` things with one thread and with all.
    fn add_rates(&mut self, name: &str, count: f64, [one, all]: [f64; 2]) {
        self.0.push(format!("\"{name}\": [{:.4e}, {:.4e}]", count / one, count / all));
    }

    /// Right-hand sides and RK4 steps of a body with that many neighbours.
    fn add_steps(&mut self, pools: &Pools, neighbours: usize, mut body: Simulation) {
        let particles = body.description().particles as f64;
        if self.0.len() == 1 {
            self.add("particles", particles);
        }
        let side = pools.best(|| _ = body.evaluate());
        self.add_rates(&format!("right_hand_side_{neighbours}"), particles, side);
        let step = pools.best(|| run_step(&mut body));
        let looked = pools.best(|| body.step().expect("a stable step"));
        let mean = [0, 1].map(|p| step[p] + (looked[p] - step[p]).max(0.0) / LOOKS);
        self.add_rates(&format!("rk4_{neighbours}"), 4.0 * particles, mean);
    }
}

/// Smoothing lengths with their numbers of neighbours.
const STENCILS: [(Solver, usize); 2] = [(WIDE, 122), (NARROW, 26)];

/// Seconds to rest, from rest under the opposite load: the set-up of the solver, and its iterations.
fn add_rest(row: &mut Row, mut body: Simulation) {
    row.add("particles", body.description().particles as f64);
    let (begin, mut pressure, mut runs, mut iterations) = (Instant::now(), 270.0, 0, 0);
    let (mut set_up, mut solve) = (f64::INFINITY, f64::INFINITY);
    while runs < LEAST_RUNS || begin.elapsed() < SPEND {
        pressure = -pressure;
        body.set_loads(vec![press(0, pressure)]).expect("a load on the surface");
        let (start, mut ready) = (Instant::now(), None);
        let watch = &mut |_, _| {
            ready.get_or_insert_with(Instant::now);
            true
        };
        iterations = body.solve_static(1.0, watch).expect("equilibrium").iterations;
        let end = Instant::now();
        let ready = ready.expect("at least one iteration");
        set_up = set_up.min((ready - start).as_secs_f64());
        solve = solve.min((end - ready).as_secs_f64());
        runs += 1;
    }
    row.add("iterations", iterations as f64);
    row.add("set_up", set_up);
    row.add("solve", solve);
}

/// Seconds a frame with SDIRK2 while the load goes to and fro, and of that for the new load.
fn add_frames(row: &mut Row, mut body: Simulation) {
    row.add("particles", body.description().particles as f64);
    let (mut frame, mut best) = (0, [f64::INFINITY; 2]);
    for _ in 0..LEAST_RUNS {
        let mut spent = [Duration::ZERO; 2];
        for _ in 0..CYCLE {
            frame += 1;
            let start = Instant::now();
            body.set_loads(vec![press(frame, 270.0)]).expect("a load on the surface");
            spent[1] += start.elapsed();
            body.advance_to(f64::from(frame) * FRAME, &mut |_| true).expect("a frame");
            spent[0] += start.elapsed();
        }
        for (best, spent) in best.iter_mut().zip(spent) {
            *best = best.min(spent.as_secs_f64() / f64::from(CYCLE));
        }
    }
    row.add("frame", best[0]);
    row.add("new_load", best[1]);
}

fn measure(pools: &Pools, body: &str, size: usize) -> Row {
    let mut row = Row::new(body, size);
    let count = size.pow(3) as f64;
    match body {
        "cube" => {
            for (solver, neighbours) in STENCILS {
                row.add_steps(pools, neighbours, cube(size, solver));
            }
        }
        "neo_hookean" | "remeshed" => {
            for (solver, neighbours) in STENCILS {
                let mut cube = neo_hookean_cube(size, solver);
                if body == "remeshed" {
                    cube.remesh().expect("a cube");
                }
                row.add_steps(pools, neighbours, cube);
            }
        }
        "liver" => {
            for (solver, neighbours) in STENCILS {
                row.add_steps(pools, neighbours, liver(size, solver, Scheme::Rk4));
            }
        }
        "sums" => {
            for (solver, neighbours) in STENCILS {
                let mut sums = Sums::new(size, solver.smoothing);
                row.add_rates(&format!("gradient_{neighbours}"), count, pools.best(|| sums.gradient()));
                row.add_rates(&format!("adjoint_{neighbours}"), count, pools.best(|| sums.adjoint()));
            }
            let mut cycle = Cycle::new(size);
            row.add_rates("v_cycle", count, pools.best(|| cycle.run()));
        }
        "static" => add_rest(&mut row, liver(size, NARROW, Scheme::Sdirk2)),
        "frames" => add_frames(&mut row, liver(size, NARROW, Scheme::Sdirk2)),
        other => panic!("no body `{other}`: cube, neo_hookean, remeshed, liver, sums, static, frames"),
    }
    row
}

fn main() {
    let (mut body, mut rows, pools) = ("cube".to_string(), Vec::new(), Pools::new());
    // cargo adds `--bench`.
    for word in std::env::args().skip(1).filter(|a| !a.starts_with('-')) {
        match word.parse() {
            Ok(size) => rows.push(format!("{{{}}}", measure(&pools, &body, size).0.join(", "))),
            Err(_) => body = word,
        }
    }
    println!("{{\"threads\": {}, \"rows\": [{}]}}", rayon::current_num_threads(), rows.join(", "));
}
