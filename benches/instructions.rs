//! Instructions under valgrind, which do not depend on how busy the machine is:
//! `cargo bench -p rsph-core --bench instructions`. Needs valgrind and `gungraun-runner` of the version in
//! Cargo.lock (CONTRIBUTING.md). Valgrind without AVX-512 sees the AVX2 code.

mod common;

use common::cycle::Cycle;
use common::irregular::Irregular;
use common::sums::Sums;
use gungraun::{library_benchmark, library_benchmark_group, main};

/// Particles along an edge.
const EDGE: usize = 20;

/// Runs everything on the thread that is measured.
fn alone() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    pool.build_global().expect("the first pool of this process");
}

fn sums(smoothing: f64) -> Sums {
    alone();
    Sums::new(EDGE, smoothing)
}

fn cycle() -> Cycle {
    alone();
    Cycle::new(EDGE)
}

fn irregular() -> Irregular {
    alone();
    Irregular::new(EDGE)
}

#[library_benchmark]
#[bench::neighbours_122(sums(1.25))]
#[bench::neighbours_26(sums(0.8))]
fn gradient_sums(mut sums: Sums) -> Sums {
    sums.gradient();
    sums
}

#[library_benchmark]
#[bench::neighbours_122(sums(1.25))]
#[bench::neighbours_26(sums(0.8))]
fn adjoint_sums(mut sums: Sums) -> Sums {
    sums.adjoint();
    sums
}

#[library_benchmark]
#[bench::cube(cycle())]
fn v_cycle(mut cycle: Cycle) -> Cycle {
    cycle.run();
    cycle
}

#[library_benchmark]
#[bench::cube(irregular())]
fn pairs(mut irregular: Irregular) -> Irregular {
    irregular.update(0.0);
    irregular
}

library_benchmark_group!(name = kernels, benchmarks = [gradient_sums, adjoint_sums, v_cycle, pairs]);
main!(library_benchmark_groups = kernels);
