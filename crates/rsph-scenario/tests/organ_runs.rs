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
