//! Dependencies against `deny.toml`, without a network: licences of what is compiled here, sources of everything.
//! `cargo deny check` does the same for all platforms, and looks for advisories.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Packages that come with the text of their licence instead of its name.
const IN_PER_FILE: &[(&str, &str)] = &[("hdf5-metno-src", "HDF5")];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn table(path: &str) -> toml::Table {
    let text = std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
    text.parse().unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn texts(list: &toml::Value) -> Vec<&str> {
    list.as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect()
}

/// What cargo says about the packages that are compiled on this platform.
fn packages() -> Vec<Value> {
    let output = |program: &str, words: &[&str]| {
        let done = Command::new(program).args(words).current_dir(root()).output().unwrap();
        assert!(done.status.success(), "{program}: {}", String::from_utf8_lossy(&done.stderr));
        String::from_utf8(done.stdout).unwrap()
    };
    let version = output("rustc", &["-vV"]);
    let host = version.lines().find_map(|l| l.strip_prefix("host: ")).unwrap();
    let cargo = option_env!("CARGO").unwrap_or("cargo");
    let words = ["metadata", "--format-version=1", "--locked", "--offline", "--filter-platform", host];
    let metadata: Value = serde_json::from_str(&output(cargo, &words)).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

/// Whether an expression such as `(MIT OR Zlib) AND ISC` is met by licences of the list.
fn is_met(expression: &str, allowed: &[&str]) -> bool {
    // As packages write it, and as cargo-deny understands it.
    let spaced =
        expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ").replace(" or ", " OR ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut at = 0;
    let met = any_of(&words, &mut at, allowed);
    met && at == words.len()
}

fn any_of(words: &[&str], at: &mut usize, allowed: &[&str]) -> bool {
    let mut met = all_of(words, at, allowed);
    while words.get(*at) == Some(&"OR") {
        *at += 1;
        met |= all_of(words, at, allowed);
    }
    met
}

fn all_of(words: &[&str], at: &mut usize, allowed: &[&str]) -> bool {
    let mut met = one(words, at, allowed);
    while words.get(*at) == Some(&"AND") {
        *at += 1;
        met &= one(words, at, allowed);
    }
    met
}

fn one(words: &[&str], at: &mut usize, allowed: &[&str]) -> bool {
    let Some(word) = words.get(*at) else { return false };
    *at += 1;
    if *word == "(" {
        let met = any_of(words, at, allowed);
        let closes = words.get(*at) == Some(&")");
        *at += 1;
        return met && closes;
    }
    if words.get(*at) == Some(&"WITH") {
        let exception = words.get(*at + 1).copied().unwrap_or_default();
        *at += 2;
        return allowed.contains(&format!("{word} WITH {exception}").as_str());
    }
    allowed.contains(word)
}

#[test]
fn expressions_are_understood() {
    let allowed = ["MIT", "ISC", "Apache-2.0 WITH LLVM-exception"];
    for good in ["MIT", "GPL-3.0 OR MIT", "GPL-3.0/MIT", "GPL-3.0 or MIT", "(MIT OR Zlib) AND ISC"] {
        assert!(is_met(good, &allowed), "{good}");
    }
    for bad in
        ["", "Apache-2.0", "MIT AND GPL-3.0", "(MIT OR ISC) AND Zlib", "MIT )", "Apache-2.0 WITH Classpath"]
    {
        assert!(!is_met(bad, &allowed), "{bad}");
    }
    assert!(is_met("Apache-2.0 WITH LLVM-exception OR GPL-2.0", &allowed));
}

#[test]
fn licences_are_those_that_are_allowed() {
    let deny = table("deny.toml");
    let allowed = texts(&deny["licenses"]["allow"]);
    let refused: Vec<String> = packages()
        .iter()
        .filter_map(|package| {
            let name = package["name"].as_str().unwrap();
            let in_a_file = IN_PER_FILE.iter().find(|(known, _)| *known == name).map(|(_, licence)| *licence);
            let expression = package["license"].as_str().or(in_a_file).unwrap_or("none");
            (!is_met(expression, &allowed)).then(|| format!("{name}: {expression}"))
        })
        .collect();
    assert!(refused.is_empty(), "licences that deny.toml does not allow: {refused:?}");
}

#[test]
fn everything_comes_from_the_registry() {
    let deny = table("deny.toml");
    let registries = texts(&deny["sources"]["allow-registry"]);
    for lock in ["Cargo.lock", "fuzz/Cargo.lock"] {
        let packages = table(lock);
        for package in packages["package"].as_array().unwrap() {
            let Some(source) = package.get("source").and_then(toml::Value::as_str) else {
                let name = package["name"].as_str().unwrap();
                assert!(name.starts_with("rsph"), "{lock}: {name} has no source and is not ours");
                continue;
            };
            let registry = source.strip_prefix("registry+").unwrap_or(source);
            assert!(registries.contains(&registry), "{lock}: {} from {source}", package["name"]);
            assert!(package.get("checksum").is_some(), "{lock}: {} without checksum", package["name"]);
        }
    }
}
