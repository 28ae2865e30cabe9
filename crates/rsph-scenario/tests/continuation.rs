//! A simulation that takes back the state of another goes on like that one, to the last bit, whatever moves and
//! however it is integrated.

use rsph_core::simulation::Simulation;
use rsph_core::state::State;
use rsph_scenario::scenario::LoadedScenario;
use std::path::PathBuf;

fn simulation(name: &str, sets: &[&str]) -> Simulation {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(format!("{name}.toml"));
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    let job = LoadedScenario::from_file(&file, &sets).unwrap().lower().unwrap();
    Simulation::new(job.setup).unwrap()
}

fn bits(state: &State) -> Vec<(String, Vec<u64>)> {
    let real = |(name, values): (&str, &[f64])| (name.into(), values.iter().map(|x| x.to_bits()).collect());
    let whole = |(name, values): (&str, &[i64])| (name.into(), values.iter().map(|x| *x as u64).collect());
    state.reals().map(real).chain(state.wholes().map(whole)).collect()
}

/// Names of the arrays of two states that differ.
fn differing(a: &State, b: &State) -> Vec<String> {
    let (a, b) = (bits(a), bits(b));
    assert_eq!(a.iter().map(|x| &x.0).collect::<Vec<_>>(), b.iter().map(|x| &x.0).collect::<Vec<_>>());
    a.into_iter().zip(b).filter(|(a, b)| a.1 != b.1).map(|(a, _)| a.0).collect()
}

/// What is seen from outside.
fn seen(s: &mut Simulation) -> String {
    let snapshot = s.snapshot();
    let surface = s.surface(&snapshot);
    let sums: Vec<u64> = snapshot
        .columns()
        .flat_map(|(_, c)| c.values().to_vec())
        .chain(surface.mesh.vertices.iter().flat_map(|v| <[f64; 3]>::from(*v)))
        .chain(surface.fields.iter().flat_map(|f| f.values.clone()))
        .map(f64::to_bits)
        .collect();
    format!("{:?} {:?} {:?} {sums:?}", s.readings(), s.conservation(), s.remesh_log())
}

/// Runs to `until` with a stop after `steps` steps on the way to half of it, and again from the state at that stop.
fn continues(name: &str, sets: &[&str], steps: u64, until: f64) {
    let mut whole = simulation(name, sets);
    whole.advance_to(0.5 * until, &mut |s| s.step_count() < steps).unwrap();
    assert!(whole.step_count() == steps && whole.time() < 0.5 * until, "{} steps", whole.step_count());
    let stored = whole.state();
    let mut resumed = simulation(name, sets);
    resumed.set_state(&stored).unwrap();
    let (again, nothing) = (resumed.state(), Vec::<String>::new());
    assert_eq!(differing(&stored, &again), nothing, "{name} {sets:?}: what is taken back is given again");
    assert_eq!(seen(&mut whole), seen(&mut resumed), "{name} {sets:?}: the moment itself");
    for t in [0.5 * until, until] {
        for s in [&mut whole, &mut resumed] {
            s.advance_to(t, &mut |_| true).unwrap();
        }
        let (a, b) = (whole.state(), resumed.state());
        assert_eq!(differing(&a, &b), nothing, "{name} {sets:?} at {t}");
        assert!(seen(&mut whole) == seen(&mut resumed), "{name} {sets:?} at {t}: what is seen differs");
    }
    if sets.iter().any(|s| s.starts_with("remesh")) {
        let (count, at_stop) =
            (whole.remesh_log().unwrap().count, stored.counts::<4>("remesh/counts").unwrap());
        assert!(
            at_stop[1] >= 1 && count > at_stop[1],
            "{name} {sets:?}: {at_stop:?}, then {count} remeshings"
        );
    }
}

#[test]
fn a_solid() {
    continues("tensile_liver", &[], 33, 0.1);
    continues("tensile_liver", &["solver.formulation=paper"], 33, 0.1);
    continues("liver_load_144", &["time.dt=auto"], 37, 2e-3);
}

#[test]
fn a_remeshed_solid() {
    continues("tensile_liver", &["remesh.every=10"], 33, 0.1);
    continues("tensile_liver", &["remesh.every=auto", "load.0.traction=[0, 0, 60]"], 250, 0.6);
    continues("tensile_liver", &["remesh.every=10", "solver.formulation=paper"], 33, 0.1);
    continues(
        "liver_load_144",
        &["remesh.every=10", "time.dt=auto", "remesh.restore_level_set=true"],
        37,
        2e-3,
    );
}

#[test]
fn implicit_and_stabilised_steps() {
    let slow = "time.dt=auto";
    continues("liver_load_144", &["time.integrator=sdirk2", slow], 4, 0.4);
    continues("liver_load_144", &["time.integrator=backward-euler", "time.dt=0.01"], 7, 0.2);
    continues("liver_load_144", &["time.integrator=rkc2", "time.dt=0.001"], 7, 0.02);
    continues("liver_load_144", &["time.integrator=sdirk2", slow, "remesh.every=2"], 4, 0.4);
}

#[test]
fn large_strain() {
    let coarse = "body.spacing=0.125";
    continues("block_large_strain", &[coarse, "remesh.every=20"], 47, 2.0);
    let free = ["boundary=[]", "load=[]", "probe=[]", "initial.velocity={ rotation = { rate = [0, 0, 2] } }"];
    let mut sets = vec!["body.shape={ disc = { radius = 0.5 } }", coarse, "remesh.every=20"];
    sets.extend(free);
    continues("block_large_strain", &sets, 47, 2.0);
    let cube = "body.shape={ box = { size = [1.0, 1.0, 1.0] } }";
    continues("block_large_strain", &[cube, "body.spacing=0.25", "remesh.every=10"], 23, 1.5);
}

#[test]
fn a_body_that_moves_as_told() {
    continues("deformation_remeshed", &["body.spacing=0.05", "remesh.every=2"], 5, 0.8);
    continues("deformation_remeshed", &["body.spacing=0.05", "remesh.every=auto", "time.dt=0.005"], 30, 0.8);
}

#[test]
fn a_fluid_beside_a_solid() {
    continues("fsi_1d", &["remesh.every=auto"], 30, 0.6);
}

#[test]
fn load_steps_of_an_equilibrium() {
    let sets = ["solver.mode=static", "solver.steps=2"];
    let mut whole = simulation("liver_load", &sets);
    let watch: &mut dyn FnMut(usize, f64) -> bool = &mut |_, _| true;
    whole.solve_static(0.75, watch).unwrap();
    let mut resumed = simulation("liver_load", &sets);
    resumed.set_state(&whole.state()).unwrap();
    assert_eq!(resumed.equilibrium(), whole.equilibrium());
    for s in [&mut whole, &mut resumed] {
        s.solve_static(1.5, watch).unwrap();
    }
    assert_eq!(differing(&whole.state(), &resumed.state()), Vec::<String>::new());
}

#[test]
fn the_state_of_another_body_is_refused() {
    let state = simulation("tensile_liver", &[]).state();
    let mut other = simulation("tensile_liver", &["body.particles=216"]);
    assert!(other.set_state(&state).unwrap_err().problem.contains("another body"));
    let mut torn = State::default();
    state.reals().for_each(|(name, values)| torn.put(name, values));
    let missing = simulation("tensile_liver", &[]).set_state(&torn).unwrap_err();
    assert!(missing.problem.contains("missing"), "{missing}");
}
