//! Scenario files, whole ones and damaged ones.

#![allow(clippy::float_cmp)] // values are handed on, not computed

use proptest::prelude::*;
use rsph_core::region::Region;
use rsph_core::sample::Resolution;
use rsph_core::setup::{Fix, LoadKind, Motion, TimeStep};
use rsph_scenario::Job;
use rsph_scenario::scenario::{LoadedScenario, ScenarioError, schema};
use std::path::PathBuf;

const TENSILE: &str = include_str!("../../../scenarios/tensile_liver.toml");

fn lower(text: &str, sets: &[&str]) -> Result<Job, ScenarioError> {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    LoadedScenario::from_text("f.toml", text.into(), PathBuf::new(), &sets)?.lower()
}

#[test]
fn the_tensile_test_is_lowered_word_by_word() {
    let job = lower(TENSILE, &[]).unwrap();
    assert_eq!((job.until, job.frame_interval), (3.0, 0.05));
    let setup = job.setup;
    let solid = setup.solid().unwrap();
    assert_eq!(setup.resolution, Resolution::Particles(343));
    assert_eq!(setup.time_step, TimeStep::Auto);
    assert_eq!(solid.boundaries[0].fix, Fix::ALL);
    let LoadKind::Traction { traction, .. } = &solid.loads[0].kind else { panic!("{:?}", solid.loads) };
    assert_eq!(traction.z, 1.0);
    assert_eq!(setup.probes[0].quantity.component, Some(2));
    assert_eq!(solid.material.density(), 1.0);
}

#[test]
fn every_kind_of_part_is_understood() {
    let job = lower(TENSILE, &[
        "body.shape={ cylinder = { radius = 0.5, height = 2.0, axis = \"y\" } }",
        "initial.velocity={ rotation = { rate = [0, 0, 1] } }",
        "initial.displacement={ affine = { gradient = [[0, 1, 0], [0, 0, 0], [0, 0, 0]] } }",
        "boundary.0.kind=prescribed",
        "boundary.0.fix=[\"z\"]",
        "boundary.0.motion={ oscillation = { amplitude = [0, 0, 0.1], frequency = 2 } }",
        "load.0={ kind = \"patch\", pressure = 2, centre = [0, 0, 1], radius = 0.1, direction = [0, 0, -2] }",
        "time.dt=auto",
        "probe.0.region={ and = [\"all\", { not = { box = { min = [0, 0, 0], max = [1, 1, 0.5] } } }] }",
    ])
    .unwrap();
    let setup = job.setup;
    let solid = setup.solid().unwrap();
    assert_eq!(solid.boundaries[0].fix, Fix::Components([false, false, true]));
    assert!(
        matches!(solid.boundaries[0].motion, Some(Motion::Oscillation { frequency, .. }) if frequency == 2.0)
    );
    let LoadKind::Patch { direction, radius, .. } = &solid.loads[0].kind else { panic!("{:?}", solid.loads) };
    assert_eq!((direction.z, *radius), (-1.0, Some(0.1)));
    assert_eq!(setup.initial.displacement.at(&[0.0, 2.0, 0.0].into()).x, 2.0);
    assert_eq!(setup.initial.velocity.at(&[1.0, 0.0, 0.0].into()).y, 1.0);
    assert!(matches!(&setup.probes[0].region, Region::And(parts) if parts.len() == 2));
}

#[test]
fn loads_and_motions_follow_curves() {
    let load = "load.0={ kind = \"follower_pressure\", region = \"all\", pressure = 2, curve = { time = [0, 0.5, 2], \
                value = [0, 1, 0], kind = \"smooth\", periodic = true } }";
    let job = lower(TENSILE, &[load, "boundary.0.kind=prescribed", motion_text()]).unwrap();
    let solid = job.setup.solid().unwrap();
    assert!(matches!(solid.loads[0].kind, LoadKind::FollowerPressure { pressure, .. } if pressure == 2.0));
    let curve = &solid.loads[0].curve;
    assert_eq!([0.5, 1.25, 2.0, 4.5].map(|t| curve.at(t)), [1.0, 0.5, 0.0, 1.0]);
    let motion = solid.boundaries[0].motion.as_ref().unwrap();
    assert_eq!((motion.displacement(1.0).z, motion.velocity(1.0).z), (0.05, 0.05));
    // A jump has no velocity, and none is needed at rest.
    let step = "boundary.0.motion.curve.kind=step";
    let error = lower(TENSILE, &["boundary.0.kind=prescribed", motion_text(), step]).unwrap_err();
    assert!(error.to_string().contains("boundary[0].motion.curve.kind"), "{error}");
    lower(TENSILE, &["boundary.0.kind=prescribed", motion_text(), step, "solver.mode=static"]).unwrap();
}

#[test]
fn foundations_are_springs_of_the_surface() {
    let bed =
        r#"foundation=[{ region = { plane = { axis = "z", at = 0.0, side = "below" } }, normal = 1e5 }]"#;
    let job = lower(TENSILE, &[bed]).unwrap();
    let foundations = &job.setup.solid().unwrap().foundations;
    assert_eq!(foundations.len(), 1);
    assert_eq!((foundations[0].normal, foundations[0].tangential), (1e5, 0.0));
    let error = lower(TENSILE, &[r#"foundation=[{ region = "all", stiffness = 1e5 }]"#]).unwrap_err();
    assert!(error.to_string().contains("foundation[0].stiffness"), "{error}");
}

/// A motion along a curve.
fn motion_text() -> &'static str {
    "boundary.0.motion={ curve = { displacement = [0, 0, 0.1], time = [0, 2], value = [0, 1] } }"
}

#[test]
fn a_beam_starts_in_its_mode_or_is_refused_at_the_key() {
    let beam = include_str!("../../../scenarios/oscillating_beam.toml");
    let velocity = lower(beam, &[]).unwrap().setup.initial.velocity;
    let at = |x: f64, y: f64| velocity.at(&[x, y, 0.05].into());
    assert!((at(0.0, 0.05).y - 0.01).abs() < 1e-12 && (at(1.0, 0.05).y - 0.01).abs() < 1e-10);
    assert!(at(0.5, 0.05).y < -0.005, "the middle goes the other way");
    assert!(at(0.0, 0.1).x > 0.0 && at(0.0, 0.0).x < 0.0, "sections turn with the axis");
    for (set, key) in [
        ("initial.velocity.free_beam.amplitude=[0.01, 0.0, 0.0]", "initial.velocity.free_beam.amplitude"),
        ("initial.velocity.free_beam.end=[0.0, 0.05, 0.05]", "initial.velocity.free_beam.end"),
        ("initial.velocity.free_beam.number=0", "initial.velocity.free_beam.number"),
    ] {
        let error = lower(beam, &[set]).unwrap_err().to_string();
        assert!(error.contains(key), "{error}");
    }
}

#[test]
fn the_scenario_as_run_is_read_back_the_same() {
    let sets =
        ["time.until=0.5".to_owned(), "solver.smoothing=1.5".to_owned(), "body.spacing=0.2".to_owned()];
    let first = LoadedScenario::from_text("f.toml", TENSILE.into(), PathBuf::new(), &sets).unwrap();
    let again = LoadedScenario::from_text("f.toml", first.as_run().into(), PathBuf::new(), &[]).unwrap();
    assert_eq!(format!("{:?}", first.tables()), format!("{:?}", again.tables()));
    assert_eq!((again.tables().until(), again.tables().body.particles), (0.5, None));
}

#[test]
fn schema_names_every_load_and_region() {
    let text = schema().to_string();
    for word in [
        "traction",
        "body_force",
        "patch",
        "half_space",
        "surface_patch",
        "part",
        "upper-right",
        "liver",
        "rk4",
    ] {
        assert!(text.contains(&format!("\"{word}\"")), "{word}");
    }
}

proptest! {
    /// Whatever is cut out of a scenario or put into it: it is understood, or an error says where.
    #[test]
    fn damaged_scenarios_never_panic(
        start in 0..TENSILE.len(),
        length in 0..30usize,
        insert in prop_oneof![Just(String::new()), "\\PC{0,6}", "[\\[\\]{}=\",.0-9a-z\\n ]{0,8}"],
    ) {
        let end = (start + length).min(TENSILE.len());
        let text = format!("{}{insert}{}", &TENSILE[..start], &TENSILE[end..]);
        if let Err(error) = lower(&text, &[]) {
            prop_assert!(!error.problem.is_empty() && !error.remedy.is_empty(), "{}", error);
            prop_assert!(error.place().is_some(), "{}", error);
        }
    }
}
