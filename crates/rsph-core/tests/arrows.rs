//! The arrows of ARCHITECTURE.md: which module may use which, and what must be absent.

mod tree;

use std::collections::BTreeSet;
use tree::{SourceFile, crate_folder, read, root, sources};

/// The modules of the core in layers, lowest first. A module uses modules of lower layers only, not
/// those beside it. A new module finds its place here and in ARCHITECTURE.md.
const LAYERS: &[&[&str]] = &[
    &["tensor", "kernel", "tiles", "pool"],
    &["error", "grid", "particles", "region", "neighbors"],
    &["mesh", "material", "snapshot", "level_set", "vector_field", "fluid", "state"],
    &["marching_cubes", "remesh", "reconstruct", "flow", "winding", "measures"],
    &["shape"],
    &["sample"],
    &["setup", "lattice"],
    &["ops", "mls"],
    &["boundary", "surface"],
    &["moments"],
    &["dynamics"],
    &["solve"],
    &["integrate", "stability", "observe", "watchdog"],
    &["simulation"],
];

/// Modules that need even less than their layer allows: a material knows only tensors, and the sums
/// know no physics.
const STRICTER: &[(&str, &[&str])] =
    &[("material", &["error", "tensor"]), ("ops", &["lattice", "tensor", "tiles"])];

/// Imports against the arrows that are there for now, as (file, item).
const EXCEPTIONS: &[(&str, &str)] = &[];

/// What the core has no business with: files, clocks, the terminal, the environment.
const ABSENT: &[&str] = &[
    "std::fs",
    "std::io",
    "std::net",
    "std::env",
    "std::process",
    "Instant",
    "SystemTime",
    "println!",
    "print!",
    "dbg!",
];

/// Full paths of everything that `file` names by `crate::` or `super::`.
fn imports(file: &SourceFile) -> BTreeSet<String> {
    let code = file.code();
    let mut found = BTreeSet::new();
    for (marker, climbs) in [("crate::", false), ("super::", true)] {
        for (at, _) in code.match_indices(marker) {
            let before = code[..at].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == '$' || (climbs && c == ':')) {
                continue;
            }
            let mut rest = &code[at + marker.len()..];
            let mut prefix = if climbs { parent(&file.module()) } else { Vec::new() };
            while let Some(further) = rest.strip_prefix("super::") {
                prefix = parent(&prefix);
                rest = further;
            }
            use_tree(rest, &prefix, &mut found);
        }
    }
    found
}

fn parent(module: &[String]) -> Vec<String> {
    module[..module.len().saturating_sub(1)].to_vec()
}

/// Adds the paths of a use tree, `a::b` or `a::{b, c::d}`, at the start of `text`; returns the rest.
fn use_tree<'a>(text: &'a str, prefix: &[String], found: &mut BTreeSet<String>) -> &'a str {
    let text = text.trim_start();
    if let Some(mut rest) = text.strip_prefix('{') {
        loop {
            rest = use_tree(rest, prefix, found).trim_start();
            match rest.strip_prefix(',') {
                Some(after) if !after.trim_start().starts_with('}') => rest = after,
                Some(after) => return after.trim_start().trim_start_matches('}'),
                None => return rest.strip_prefix('}').unwrap_or(rest),
            }
        }
    }
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    let (name, rest) = text.split_at(end);
    let mut path = prefix.to_vec();
    if name != "self" && !name.is_empty() {
        path.push(name.to_owned());
    }
    if let Some(rest) = rest.strip_prefix("::") {
        return use_tree(rest, &path, found);
    }
    found.insert(path.join("::"));
    rest
}

fn top(path: &str) -> &str {
    path.split("::").next().unwrap_or(path)
}

fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|l| l.contains(&module))
}

fn core() -> Vec<SourceFile> {
    sources(&crate_folder().join("src"))
}

#[test]
fn use_trees_are_understood() {
    let file = SourceFile {
        path: "a/b.rs".into(),
        text: "use crate::{c::{D, e::F}, g};\nuse super::h::I;\nfn x(y: crate::j::K) { super::super::l() }\n\
               // crate::comment\n#[cfg(test)]\nmod tests { use crate::test; }"
            .into(),
    };
    let expected = ["a::h::I", "c::D", "c::e::F", "g", "j::K", "l"];
    assert_eq!(imports(&file).into_iter().collect::<Vec<_>>(), expected);
}

#[test]
fn imports_follow_the_arrows() {
    let mut used = BTreeSet::new();
    let mut wrong = Vec::new();
    for file in core().iter().filter(|f| f.path != "lib.rs") {
        let module = file.module()[0].clone();
        let Some(own) = layer(&module) else {
            wrong.push(format!("{}: module {module} has no layer", file.path));
            continue;
        };
        for item in imports(file) {
            let target = top(&item);
            if target == module {
                continue;
            }
            if let Some(exception) = EXCEPTIONS.iter().find(|(f, i)| *f == file.path && *i == item) {
                used.insert(*exception);
                continue;
            }
            let allowed = STRICTER.iter().find(|(m, _)| *m == module).map(|(_, allowed)| *allowed);
            if layer(target).is_none_or(|l| l >= own) || allowed.is_some_and(|a| !a.contains(&target)) {
                wrong.push(format!("{}: {module} must not use {item}", file.path));
            }
        }
    }
    assert!(wrong.is_empty(), "imports against the arrows:\n{}", wrong.join("\n"));
    let stale: Vec<_> = EXCEPTIONS.iter().filter(|e| !used.contains(*e)).collect();
    assert!(stale.is_empty(), "exceptions that are no longer needed: {stale:?}");
}

#[test]
fn every_layer_names_modules_that_exist() {
    let modules: BTreeSet<String> = core().iter().filter_map(|f| f.module().into_iter().next()).collect();
    for module in LAYERS.iter().copied().flatten() {
        assert!(modules.contains(*module), "there is no module {module}");
    }
}

#[test]
fn architecture_shows_the_same_layers() {
    let text = read("ARCHITECTURE.md");
    let lines: Vec<Vec<&str>> = text.lines().map(|l| l.split_whitespace().collect()).collect();
    for (i, modules) in LAYERS.iter().enumerate() {
        let number = (i + 1).to_string();
        let expected: Vec<&str> = std::iter::once(number.as_str()).chain(modules.iter().copied()).collect();
        assert!(lines.contains(&expected), "ARCHITECTURE.md lacks the line {expected:?}");
    }
}

#[test]
fn core_has_no_files_clock_or_printing() {
    for file in core() {
        let code = file.code();
        for word in ABSENT {
            assert!(!code.contains(word), "{} uses {word}", file.path);
        }
    }
}

/// Names of the dependencies of a crate, those for tests left out.
fn dependencies(name: &str) -> BTreeSet<String> {
    let manifest = read(&format!("crates/{name}/Cargo.toml"));
    let mut inside = false;
    let mut names = BTreeSet::new();
    for line in manifest.lines() {
        if line.starts_with('[') {
            inside = line.contains("dependencies") && !line.contains("dev-dependencies");
        } else if inside && line.contains('=') {
            names.insert(line.split(['.', '=', ' ']).next().unwrap_or("").to_owned());
        }
    }
    names
}

#[test]
fn crates_depend_in_one_direction() {
    let own = |name: &str| -> Vec<String> {
        dependencies(name).into_iter().filter(|d| d.starts_with("rsph")).collect()
    };
    assert_eq!(own("rsph-core"), [""; 0]);
    assert_eq!(own("rsph-scenario"), ["rsph-core"]);
    assert_eq!(own("rsph-validation"), ["rsph-core", "rsph-scenario"]);
    assert_eq!(own("rsph-cli"), ["rsph-core", "rsph-scenario", "rsph-validation"]);
    assert_eq!(own("rsph-py"), ["rsph-core", "rsph-scenario"]);
}

#[test]
fn only_scenario_knows_hdf5_and_files_formats() {
    let formats = ["csv", "gltf", "hdf5", "ply-rs-bw", "schemars", "stl_io", "toml"];
    for name in ["rsph-core", "rsph-validation", "rsph-cli", "rsph-py"] {
        let dependencies = dependencies(name);
        // Validations read reference curves and write their own.
        for format in formats.iter().filter(|f| name != "rsph-validation" || **f != "csv") {
            assert!(!dependencies.contains(*format), "{name} depends on {format}");
        }
        for file in sources(&root().join("crates").join(name).join("src")) {
            assert!(!file.code().contains("hdf5::"), "{name}/{} uses hdf5", file.path);
        }
    }
    assert!(dependencies("rsph-scenario").contains("hdf5"));
}
