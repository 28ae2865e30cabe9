//! Verbs that only speak: help, schema, new, validate.

mod common;

use common::{Bench, scenario};
use std::io::Read;
use std::process::Stdio;

const VERBS: &[&str] = &["run", "validate", "sample", "surface", "image", "info", "schema", "new"];

#[test]
fn help_of_every_verb_teaches_with_examples() {
    let bench = Bench::new();
    let help = bench.rsph(&["--help"]);
    assert_eq!(help.code, Some(0));
    for verb in VERBS {
        assert!(help.out.contains(&format!("\n  {verb} ")), "{verb} in {}", help.out);
        let done = bench.rsph(&[verb, "--help"]);
        assert_eq!(done.code, Some(0), "{verb}");
        assert!(done.out.contains("Examples:\n  rsph "), "{verb}: {}", done.out);
    }
}

#[test]
fn unknown_verb_and_option_exit_with_2() {
    let bench = Bench::new();
    assert_eq!(bench.rsph(&["rum"]).code, Some(2));
    assert_eq!(bench.rsph(&["run", "x.toml", "--colour"]).code, Some(2));
    assert_eq!(bench.rsph(&["run", "x.toml", "--threads", "0"]).code, Some(2));
    assert_eq!(bench.rsph(&["sample", "x.stl"]).code, Some(2));
}

#[test]
fn schema_knows_keys_units_and_materials() {
    let done = Bench::new().rsph(&["schema"]);
    assert_eq!(done.code, Some(0));
    let schema: serde_json::Value = serde_json::from_str(&done.out).unwrap();
    assert_eq!(schema["additionalProperties"], false);
    for key in ["body", "material", "boundary", "load", "solver", "time", "remesh", "output", "probe"] {
        assert!(schema["properties"][key].is_object(), "{key}");
    }
    assert!(done.out.contains("poisson_ratio") && done.out.contains("kelvin-voigt"));
    assert!(done.out.contains("Distance dx between particles (m)"));
}

#[test]
fn every_template_is_the_shipped_scenario() {
    let bench = Bench::new();
    assert_eq!(bench.rsph(&["new"]).out, std::fs::read_to_string(scenario("liver_load")).unwrap());
    for entry in scenario("x").parent().unwrap().read_dir().unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        let (done, text) = (bench.rsph(&["new", name]), std::fs::read_to_string(&path).unwrap());
        // No template names a file that the user lacks.
        let wanted = if text.contains("/shared/") { (Some(2), String::new()) } else { (Some(0), text) };
        assert_eq!((done.code, done.out), wanted, "{name}");
    }
    let unknown = bench.rsph(&["new", "spleen"]);
    assert_eq!(unknown.code, Some(2));
    assert!(unknown.err.contains("spleen") && unknown.err.contains("tensile_liver"), "{}", unknown.err);
}

#[test]
fn unknown_validation_is_refused() {
    let done = Bench::new().rsph(&["validate", "nonsense"]);
    assert_eq!(done.code, Some(2));
    assert!(done.err.contains("nonsense"), "{}", done.err);
}

#[test]
fn validations_are_listed_and_reported_on_a_page() {
    let bench = Bench::new();
    let list = bench.rsph(&["validate", "--list"]);
    assert_eq!(list.code, Some(0));
    for name in ["deformation", "figure_6", "figure_7", "oscillation", "patch"] {
        assert!(list.out.lines().any(|l| l.starts_with(name) && l.len() > 30), "{name} in {}", list.out);
    }
    let done = bench.rsph(&["validate", "patch", "--quick", "--report", "page.html", "--json", "rows.json"]);
    assert_eq!(done.code, Some(0), "{}", done.err);
    let page = std::fs::read_to_string(bench.path("page.html")).unwrap();
    let rows: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(bench.path("rows.json")).unwrap()).unwrap();
    let rows = rows.as_array().unwrap();
    assert!(rows.len() >= 7, "{rows:?}");
    for row in rows {
        let name = row["name"].as_str().unwrap();
        assert!(page.contains(name) && done.out.contains(name), "{name}");
    }
    assert!(page.contains("<svg") && page.contains("bounds are kept"), "the figure of today is in it");
    assert_eq!(bench.rsph(&["validate", "patch", "--report", "nowhere/page.html"]).code, Some(2));
}

#[test]
fn a_reader_that_leaves_early_is_no_panic() {
    let bench = Bench::new();
    let mut child = bench.command(&["schema"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert_eq!((child.wait().unwrap().code(), err.as_str()), (Some(0), ""));
}
