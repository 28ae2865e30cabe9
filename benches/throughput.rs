//! Particle updates a second: the right-hand side alone and whole RK4 time steps, on cubes whose
//! particles have 122 neighbours (h = 1.25 dx). `cargo bench -p rsph-core`.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rsph_core::material::KelvinVoigt;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Boundary, Initial, Integration, Load, LoadKind, Mechanics, Ramp, Remesh, Scheme, Setup, Solver, TimeStep,
    Units,
};
use rsph_core::shape::BoxShape;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// The tensile cube of section 5.2 with n^3 particles.
fn cube(n: usize, smoothing: f64) -> Simulation {
    let face = |at, side| Region::Plane { axis: Axis::Z, at, side };
    Simulation::new(Setup {
        units: Units::Normalised,
        shape: Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).expect("a unit cube")),
        resolution: Resolution::Spacing(1.0 / n as f64),
        material: Arc::new(KelvinVoigt::new(1.0, 100.0, 0.3, 0.2).expect("liver")),
        initial: Initial::default(),
        boundaries: vec![Boundary { region: face(0.0, Side::Below), fix: [true; 3], motion: None }],
        loads: vec![Load {
            kind: LoadKind::Traction { region: face(1.0, Side::Above), traction: Vec3::z() },
            ramp: Ramp::default(),
        }],
        mechanics: Mechanics::Solid,
        remesh: Remesh::default(),
        solver: Solver { smoothing, ..Solver::default() },
        time_step: TimeStep::Auto,
        integration: Integration { scheme: Scheme::Rk4, ..Integration::default() },
        allow_unstable: false,
        probes: Vec::new(),
    })
    .expect("a cube")
}

fn throughput(c: &mut Criterion) {
    let mut group = c.benchmark_group("updates");
    group.sample_size(10);
    for (n, smoothing) in [(20, 1.25), (37, 1.25), (58, 1.25), (37, 0.8)] {
        let mut simulation = cube(n, smoothing);
        let particles = simulation.description().particles as u64;
        let name = format!("h = {smoothing} dx");
        group.throughput(Throughput::Elements(particles));
        group.bench_function(BenchmarkId::new(format!("right-hand side, {name}"), particles), |b| {
            b.iter(|| simulation.evaluate());
        });
        group.throughput(Throughput::Elements(4 * particles));
        group.bench_function(BenchmarkId::new(format!("RK4 step, {name}"), particles), |b| {
            b.iter(|| simulation.step().expect("a stable step"));
        });
    }
    group.finish();
}

criterion_group!(benches, throughput);
criterion_main!(benches);
