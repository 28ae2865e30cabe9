//! A real liver, from few to many particles: it runs stably at the automatic time step, and its
//! momentum is what load and clamp gave it.

use rsph_core::simulation::Simulation;
use rsph_scenario::scenario::LoadedScenario;
use std::path::Path;

#[test]
fn the_real_liver_runs_at_every_size_and_its_momentum_balances() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    if !root.join("../shared/data/meshes").is_dir() {
        println!("skipped: the organ meshes are not beside the repository");
        return;
    }
    for particles in [144, 1000, 5000, 20000] {
        let sets = [format!("body.particles={particles}")];
        let scenario =
            LoadedScenario::from_file(&root.join("scenarios/liver_visible_human.toml"), &sets).unwrap();
        let mut simulation = Simulation::new(scenario.lower().unwrap().setup).unwrap();
        let (volume, exact) = (simulation.description().volume, simulation.description().shape_volume);
        assert!((volume / exact - 1.0).abs() < 0.03, "{particles}: volume {volume} of {exact}");
        let snapshot = simulation.snapshot();
        let surface = simulation.surface(&snapshot).mesh;
        assert!(surface.is_closed() && surface.components() == 1 && surface.genus() == Some(0));
        for _ in 0..60 {
            simulation.step().unwrap();
        }
        let sums = simulation.conservation();
        // The load of the reference, -0.7052 N, pushes down; the clamp holds against it.
        assert!((sums.load.y / -0.7052 - 1.0).abs() < 0.005, "{particles}: load {}", sums.load.y);
        assert!(sums.momentum_error < 1e-12, "{particles}: momentum error {}", sums.momentum_error);
        assert!(sums.mass_error == 0.0);
        assert!(sums.dissipated > 0.0, "{particles}: dissipated {}", sums.dissipated);
    }
}

/// A transient of 0.01 s (with T = 0.02 s, so that the organ moves in it), remeshed every ten steps and
/// never: the surface is in the same place.
#[test]
fn the_real_liver_moves_the_same_remeshed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    if !root.join("../shared/data/meshes").is_dir() {
        println!("skipped: the organ meshes are not beside the repository");
        return;
    }
    let displacement = |every: u32| {
        let sets = [
            "body.particles=5000".to_owned(),
            "solver.smoothing=0.8".to_owned(),
            "material.relaxation_time=0.02".to_owned(),
            format!("remesh={{every={every}}}"),
        ];
        let scenario =
            LoadedScenario::from_file(&root.join("scenarios/liver_visible_human.toml"), &sets).unwrap();
        let mut simulation = Simulation::new(scenario.lower().unwrap().setup).unwrap();
        let snapshot = simulation.snapshot();
        let start = simulation.surface(&snapshot).mesh.vertices;
        simulation.advance_to(0.01, &mut |_| true).unwrap();
        let snapshot = simulation.snapshot();
        let end = simulation.surface(&snapshot).mesh.vertices;
        let u: Vec<_> = end.iter().zip(&start).map(|(x, x0)| x - x0).collect();
        (u, simulation.readings()[0].value, simulation.remesh_log())
    };
    let ((a, top, _), (b, its_top, log)) = (displacement(0), displacement(10));
    let log = log.unwrap();
    assert!(log.count > 50 && log.largest_mass_jump < 1e-12, "{log:?}");
    let norm = a.iter().map(rsph_core::tensor::Vec3::norm_squared).sum::<f64>();
    let difference = a.iter().zip(&b).map(|(a, b)| (a - b).norm_squared()).sum::<f64>();
    let difference = (difference / norm).sqrt();
    println!("difference of the surface's displacement {difference:.5}, top {top} {its_top}");
    assert!(difference < 0.01, "{difference}");
    assert!((its_top / top - 1.0).abs() < 0.01, "{top} {its_top}");
}
