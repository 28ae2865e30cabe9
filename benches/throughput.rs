//! How long the pieces of a simulation take: kernel sums, right-hand sides, time steps, remeshing, sampling,
//! static solves and frames. `cargo bench -p rsph-core --bench throughput [filter]`; with `RSPH_LARGE=1` the
//! static solve of a million particles too.
//!
//! An element of the throughput is a particle: of one sum, one right-hand side (of which a step of RK4 has
//! four), one solve.

mod common;

use common::cycle::Cycle;
use common::liver::{FRAME, liver, press};
use common::remeshing::Remeshing;
use common::sums::Sums;
use common::{NARROW, WIDE, cube, run_step};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use rsph_core::sample::{Resolution, sample};
use rsph_core::setup::{Scheme, Solver};
use rsph_core::shape::organ;
use rsph_core::simulation::Simulation;
use std::time::{Duration, Instant};

/// A group of short measurements.
fn group<'a>(c: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = c.benchmark_group(name);
    group.sample_size(10).warm_up_time(Duration::from_millis(200));
    group.measurement_time(Duration::from_secs(1)).sampling_mode(SamplingMode::Flat);
    group
}

fn sums(c: &mut Criterion) {
    let mut group = group(c, "sums");
    for Solver { smoothing, .. } in [WIDE, NARROW] {
        for n in [20, 37, 58_usize] {
            let mut sums = Sums::new(n, smoothing);
            group.throughput(Throughput::Elements(n.pow(3) as u64));
            group
                .bench_function(format!("gradient, cube {n}, h {smoothing}"), |b| b.iter(|| sums.gradient()));
            group.bench_function(format!("adjoint, cube {n}, h {smoothing}"), |b| b.iter(|| sums.adjoint()));
        }
    }
}

fn steps(c: &mut Criterion) {
    for solver in [WIDE, NARROW] {
        for n in [20, 37, 58] {
            measure_steps(c, &format!("cube {n}, h {}", solver.smoothing), cube(n, solver));
        }
        let name = format!("liver 50k, h {}", solver.smoothing);
        measure_steps(c, &name, liver(50_000, solver, Scheme::Rk4));
    }
}

/// The right-hand side and the whole step of RK4.
fn measure_steps(c: &mut Criterion, name: &str, mut simulation: Simulation) {
    let particles = simulation.description().particles as u64;
    let mut group = group(c, "updates");
    group.throughput(Throughput::Elements(particles));
    group.bench_function(format!("right-hand side, {name}"), |b| b.iter(|| simulation.evaluate()));
    group.throughput(Throughput::Elements(4 * particles));
    group.bench_function(format!("RK4 step, {name}"), |b| {
        b.iter(|| run_step(&mut simulation));
    });
}

fn remeshing(c: &mut Criterion) {
    let n = 47_usize;
    let mut remeshing = Remeshing::new(n);
    let mut group = group(c, "set-up");
    group.throughput(Throughput::Elements(n.pow(3) as u64));
    group.bench_function(format!("remesh, cube {n}, 8 columns"), |b| b.iter(|| remeshing.run()));
}

fn sampling(c: &mut Criterion) {
    let shape = organ("liver").expect("an organ");
    let mut group = group(c, "set-up");
    for particles in [50_000, 1_000_000] {
        group.throughput(Throughput::Elements(particles as u64));
        group.bench_function(format!("sample, liver {}k", particles / 1000), |b| {
            b.iter(|| sample(&shape, Resolution::Particles(particles), &[]).expect("a body"));
        });
    }
}

/// The whole solve, hierarchy and all, from rest under one load to rest under the opposite one: from zero it
/// would take the same iterations.
fn statics(c: &mut Criterion) {
    let mut group = group(c, "static");
    let mut sizes = vec![20_000, 60_000];
    if std::env::var_os("RSPH_LARGE").is_some() {
        sizes.push(1_000_000);
    }
    for particles in sizes {
        // Made only if the filter asks for it.
        let (mut body, mut pressure) = (None, 270.0);
        group.throughput(Throughput::Elements(particles as u64));
        group.bench_function(format!("solve, liver {}k", particles / 1000), |b| {
            let body = body.get_or_insert_with(|| liver(particles, NARROW, Scheme::Sdirk2));
            b.iter_custom(|count| {
                let mut spent = Duration::ZERO;
                for _ in 0..count {
                    pressure = -pressure;
                    body.set_loads(vec![press(0, pressure)]).expect("a load on the surface");
                    let start = Instant::now();
                    body.solve_static(1.0, &mut |_, _| true).expect("equilibrium");
                    spent += start.elapsed();
                }
                spent
            });
        });
    }
    let n = 37_usize;
    let mut cycle = None;
    group.throughput(Throughput::Elements(n.pow(3) as u64));
    group.bench_function(format!("V-cycle, cube {n}"), |b| {
        let cycle = cycle.get_or_insert_with(|| Cycle::new(n));
        b.iter(|| cycle.run());
    });
}

/// A frame of 1/30 s with SDIRK2 while the load moves.
fn frames(c: &mut Criterion) {
    let mut group = group(c, "frames");
    for particles in [5_000, 20_000, 40_000] {
        let (mut body, mut frame) = (None, 0);
        group.bench_function(format!("touched liver {}k", particles / 1000), |b| {
            let body = body.get_or_insert_with(|| liver(particles, NARROW, Scheme::Sdirk2));
            b.iter_custom(|count| {
                let start = Instant::now();
                for _ in 0..count {
                    frame += 1;
                    body.set_loads(vec![press(frame, 270.0)]).expect("a load on the surface");
                    let end = f64::from(frame) * FRAME;
                    body.advance_to(end, &mut |_| true).expect("a frame");
                }
                start.elapsed()
            });
        });
    }
}

criterion_group!(benches, sums, steps, remeshing, sampling, statics, frames);
criterion_main!(benches);
