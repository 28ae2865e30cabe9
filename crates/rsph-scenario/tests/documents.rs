//! The documents about scenario files against the format itself.

use rsph_scenario::scenario::{LoadedScenario, schema};
use std::collections::BTreeSet;
use std::path::PathBuf;

fn read(path: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The text of the code blocks in that language.
fn blocks(text: &str, language: &str) -> Vec<String> {
    let opening = format!("```{language}\n");
    text.split(opening.as_str())
        .skip(1)
        .filter_map(|rest| rest.split("```").next())
        .map(String::from)
        .collect()
}

/// Names of all keys that a schema knows, at any depth.
fn keys(schema: &serde_json::Value, found: &mut BTreeSet<String>) {
    match schema {
        serde_json::Value::Object(entries) => {
            if let Some(properties) = entries.get("properties").and_then(|p| p.as_object()) {
                found.extend(properties.keys().cloned());
            }
            entries.values().for_each(|v| keys(v, found));
        }
        serde_json::Value::Array(items) => items.iter().for_each(|v| keys(v, found)),
        _ => {}
    }
}

#[test]
fn the_scenario_of_the_readme_can_be_simulated() {
    let blocks = blocks(&read("README.md"), "toml");
    assert_eq!(blocks.len(), 1);
    let scenario = LoadedScenario::from_text("README.md", blocks[0].clone(), PathBuf::new(), &[]);
    let job = scenario.and_then(|s| s.lower()).expect("a scenario");
    rsph_core::simulation::Simulation::new(job.setup).expect("a simulation");
}

#[test]
fn the_guide_names_every_key() {
    let guide = read("docs/guide/scenario.md");
    let mut names = BTreeSet::new();
    keys(&schema(), &mut names);
    assert!(names.len() > 40, "{names:?}");
    for name in names {
        let named = [format!("`{name}`"), format!("{name} = "), format!("[[{name}]]"), format!("[{name}]")];
        assert!(named.iter().any(|n| guide.contains(n)), "docs/guide/scenario.md does not name {name}");
    }
}

#[test]
fn the_examples_of_the_guide_are_understood() {
    // Each line of the guide's blocks replaces a key of a scenario that is otherwise good.
    let guide = read("docs/guide/scenario.md");
    let base = "time = { until = 1.0 }\n[material]\nmodel = \"kelvin-voigt\"\ndensity = 1.0\n\
                young_modulus = 1.0\npoisson_ratio = 0.3\nrelaxation_time = 0.2\n";
    let mut lines = 0;
    for line in blocks(&guide, "toml").iter().flat_map(|b| b.lines()).filter(|l| !l.trim().is_empty()) {
        lines += 1;
        let body = "[body]\nspacing = 0.1\n";
        let box_shape = "shape = { box = { size = [1.0, 1.0, 1.0] } }\n";
        let text = match line.split(' ').next() {
            Some("shape" | "labelmap") => format!("{base}{body}{line}\n"),
            Some("velocity") => format!("{base}{body}{box_shape}[initial]\n{line}\n"),
            Some("motion") => {
                format!(
                    "{base}{body}{box_shape}[[boundary]]\nkind = \"prescribed\"\nregion = \"all\"\n{line}\n"
                )
            }
            Some("curve") => {
                let load = "[[load]]\nkind = \"pressure\"\nregion = \"all\"\npressure = 1.0\n";
                format!("{base}{body}{box_shape}{load}{line}\n")
            }
            other => panic!("an example of {other:?}"),
        };
        let understood = LoadedScenario::from_text("scenario.md", text, PathBuf::new(), &[]);
        assert!(understood.is_ok(), "{line}: {}", understood.unwrap_err());
    }
    assert!(lines >= 9);
}
