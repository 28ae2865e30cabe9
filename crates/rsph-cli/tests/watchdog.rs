//! Settings that can not go well: each is caught, and the message names the cause.

mod common;

use common::{Bench, Done, scenario};
use rsph_scenario::output::vtkhdf::{describe, read_step};

fn run(bench: &Bench, name: &str, sets: &[&str]) -> Done {
    let file = scenario(name);
    let mut arguments = vec!["run", file.to_str().unwrap(), "--quiet", "--output", "r"];
    arguments.extend(sets.iter().flat_map(|s| ["--set", s]));
    bench.rsph(&arguments)
}

fn summary(bench: &Bench) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(bench.path("r/summary.json")).unwrap()).unwrap()
}

/// A run that fails with that kind of failure, at most `steps` steps after its last good state, says all of `says`,
/// and leaves its last good state and the one after it.
fn fails(name: &str, sets: &[&str], kind: &str, steps: u64, says: &[&str]) {
    let bench = Bench::new();
    let done = run(&bench, name, sets);
    assert_eq!(done.code, Some(3), "{sets:?}: {}", done.err);
    let told = done.err.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
    for word in says {
        assert!(told.contains(word), "{sets:?}: `{word}` is not in {told}");
    }
    assert!(told.contains("at X = (") && told.contains("help: "), "{told}");
    let summary = summary(&bench);
    assert_eq!(summary["failure"]["kind"], kind, "{summary}");
    let (good, noticed) = (summary["steps"].as_u64().unwrap(), summary["failure"]["step"].as_u64().unwrap());
    assert!(noticed > good && noticed - good <= steps, "{sets:?}: good at {good}, noticed at {noticed}");
    // The last frame is good, and the post-mortem one comes after it.
    let last = read_step(&bench.path("r/particles.vtkhdf"), None).unwrap();
    assert!(last.fields.iter().all(|f| f.values.iter().all(|x| x.is_finite())));
    let post_mortem = bench.path("r/post_mortem.vtkhdf");
    assert_eq!(describe(&post_mortem).unwrap().steps(), 1);
    assert!(read_step(&post_mortem, None).unwrap().time > last.time);
}

#[test]
fn a_time_step_three_times_the_limit() {
    // The limit is 8.40e-4.
    let sets = ["time.dt=0.00252", "time.allow_unstable=true"];
    let says = ["3.0 times the stability limit", "set by viscosity", "`time.dt = \"auto\"`"];
    fails("tensile_liver", &sets, "unstable", 8, &says);
    let sets = ["material.relaxation_time=1e-4", "time.dt=0.05", "time.allow_unstable=true"];
    fails("tensile_liver", &sets, "unstable", 8, &["times the stability limit", "set by wave speed"]);
}

#[test]
fn a_nearly_incompressible_body() {
    let nearly = "material.poisson_ratio=0.4999";
    // At the door.
    let bench = Bench::new();
    let done = run(&bench, "tensile_liver", &[nearly, "time.dt=0.001"]);
    assert_eq!(done.code, Some(2), "{}", done.err);
    assert!(
        done.err.contains("`time.dt`") && done.err.contains("Poisson's ratio so near 0.5"),
        "{}",
        done.err
    );
    assert!(!bench.path("r").exists());
    // For those who insist.
    let says =
        ["times the stability limit", "Poisson's ratio so near 0.5 makes the material 5001 times stiffer"];
    fails("tensile_liver", &[nearly, "time.dt=0.001", "time.allow_unstable=true"], "unstable", 8, &says);
    // With steps that are short enough it goes well.
    let bench = Bench::new();
    let done = run(&bench, "tensile_liver", &[nearly, "time.dt=auto", "time.until=1e-4"]);
    assert_eq!(done.code, Some(0), "{}", done.err);
}

#[test]
fn too_few_neighbours() {
    let bench = Bench::new();
    let done = run(&bench, "tensile_liver", &["solver.smoothing=0.7"]);
    assert_eq!(done.code, Some(2), "{}", done.err);
    assert!(
        done.err.contains("`solver.smoothing`") && done.err.contains("too few neighbours"),
        "{}",
        done.err
    );
    assert!(!bench.path("r").exists());
}

#[test]
fn a_load_that_turns_particles_inside_out() {
    let says = ["turned inside out (det F = ", "loads or moved parts are too much for this stiffness"];
    fails("tensile_liver", &["load.0.traction=[0, 0, -500]"], "inverted", 20, &says);
    // Between two looks a remesh fails, or leaves a lattice on which no step is short enough.
    let bench = Bench::new();
    let done = run(&bench, "tensile_liver", &["load.0.traction=[0, 0, -500]", "remesh.every=7"]);
    assert_eq!(done.code, Some(3), "{}", done.err);
    let found = |what: &str, remedy: &str| done.err.contains(what) && done.err.contains(remedy);
    assert!(
        found("remeshing failed", "check the loads against the stiffness")
            || found("squeezed to nothing", "lower the loads"),
        "{}",
        done.err
    );
    let says = ["turned inside out (det F <= 0)", "load or move the body more slowly"];
    let sets = ["load.0.traction=[0, -500, 0]", "load.0.ramp={ from = 0.0, to = 3.0 }", "remesh.every=0"];
    fails("block_large_strain", &sets, "inverted", 20, &says);
}

#[test]
fn an_equilibrium_that_is_inside_out() {
    let bench = Bench::new();
    let done = run(&bench, "tensile_liver", &["load.0.traction=[0, 0, -500]", "solver.mode=static"]);
    assert_eq!(done.code, Some(3), "{}", done.err);
    assert!(done.err.contains("turned inside out"), "{}", done.err);
}

#[test]
fn a_summary_says_what_made_it() {
    let bench = Bench::new();
    assert_eq!(run(&bench, "tensile_liver", &["time.until=0.01"]).code, Some(0));
    let summary = summary(&bench);
    for key in ["version", "simd", "processor", "scenario_sha256"] {
        assert!(summary[key].as_str().is_some_and(|text| !text.is_empty()), "{key}: {summary}");
    }
}
