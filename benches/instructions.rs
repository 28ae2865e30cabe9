//! Instructions that the pieces of a simulation take, counted by valgrind: they do not depend on what else runs.
//! `cargo bench -p rsph-core --bench instructions`, on cubes of 20^3 particles and one thread. Needs valgrind and
//! gungraun-runner; `benches/measure.py instructions` installs the latter and says what is missing.
//!
//! A program sees a processor without AVX-512 in valgrind, so vectors are those of AVX2 if the processor
//! has them: four numbers.

// Made by the macros of gungraun.
#![allow(missing_docs, clippy::pedantic)]

mod common;

use common::remeshing::Remeshing;
use common::sums::Sums;
use common::{NARROW, WIDE, cube, cycle::Cycle, run_step};
use gungraun::{Callgrind, LibraryBenchmarkConfig, library_benchmark, library_benchmark_group, main};
use rsph_core::remesh::Remeshed;
use rsph_core::setup::Solver;
use rsph_core::simulation::Simulation;
use std::hint::black_box;

/// Particles along an edge.
const EDGE: usize = 20;
/// Without a hourglass term: what it takes is the difference.
const PLAIN: Solver = Solver { hourglass: 0.0, ..WIDE };

/// What is measured after it has run once: what it keeps is allocated then. Everything runs on this thread, the only
/// one that valgrind counts.
fn warm<T>(make: impl FnOnce() -> T, run: impl FnOnce(&mut T)) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().expect("one thread");
    let mut body = make();
    run(&mut body);
    body
}

fn sums_gradient(smoothing: f64) -> Sums {
    warm(|| Sums::new(EDGE, smoothing), Sums::gradient)
}

#[library_benchmark(setup = sums_gradient)]
#[bench::neighbours_122(1.25)]
#[bench::neighbours_26(0.8)]
fn gradient(mut sums: Sums) -> Sums {
    sums.gradient();
    black_box(sums)
}

fn sums_adjoint(smoothing: f64) -> Sums {
    warm(|| Sums::new(EDGE, smoothing), Sums::adjoint)
}

#[library_benchmark(setup = sums_adjoint)]
#[bench::neighbours_122(1.25)]
#[bench::neighbours_26(0.8)]
fn adjoint(mut sums: Sums) -> Sums {
    sums.adjoint();
    black_box(sums)
}

fn evaluated(solver: Solver) -> Simulation {
    warm(|| cube(EDGE, solver), |cube| _ = cube.evaluate())
}

#[library_benchmark(setup = evaluated)]
#[bench::neighbours_122(PLAIN)]
#[bench::neighbours_122_hourglass(WIDE)]
#[bench::neighbours_26_hourglass(NARROW)]
fn right_hand_side(mut cube: Simulation) -> Simulation {
    cube.evaluate();
    black_box(cube)
}

fn stepped(solver: Solver) -> Simulation {
    // The watchdog looks after the second step, not after the one that counts.
    warm(|| cube(EDGE, solver), |cube| (0..2).for_each(|_| run_step(cube)))
}

#[library_benchmark(setup = stepped)]
#[bench::neighbours_122_hourglass(WIDE)]
#[bench::neighbours_26_hourglass(NARROW)]
fn rk4_step(mut cube: Simulation) -> Simulation {
    run_step(&mut cube);
    black_box(cube)
}

fn remeshed() -> Remeshing {
    warm(|| Remeshing::new(EDGE), |cube| _ = cube.run())
}

#[library_benchmark(setup = remeshed)]
#[bench::eight_columns()]
fn remesh(mut cube: Remeshing) -> (Remeshed, Remeshing) {
    let outcome = cube.run();
    black_box((outcome, cube))
}

fn cycled() -> Cycle {
    warm(|| Cycle::new(EDGE), Cycle::run)
}

#[library_benchmark(setup = cycled)]
#[bench::neighbours_26()]
fn v_cycle(mut cycle: Cycle) -> Cycle {
    cycle.run();
    black_box(cycle)
}

library_benchmark_group!(
    name = instructions,
    benchmarks = [gradient, adjoint, right_hand_side, rk4_step, remesh, v_cycle]
);
main!(
    config = LibraryBenchmarkConfig::default().tool(Callgrind::with_args(["--cache-sim=no"])),
    library_benchmark_groups = instructions
);
