//! The codemap of ARCHITECTURE.md against the tree: every file named is there, every file of the core
//! is named.

mod tree;

use std::collections::BTreeSet;
use tree::{quoted, read, root, sources};

/// Crates whose every file must be named.
const COMPLETE: &[&str] = &["rsph-core"];

/// The section of ARCHITECTURE.md about a crate.
fn section(text: &str, name: &str) -> String {
    let heading = format!("### `crates/{name}`");
    let lines = text.lines().skip_while(|l| !l.starts_with(&heading)).skip(1);
    lines.take_while(|l| !l.starts_with('#')).collect::<Vec<_>>().join("\n")
}

#[test]
fn files_and_codemap_agree() {
    let text = read("ARCHITECTURE.md");
    for name in COMPLETE {
        let section = section(&text, name);
        let named: BTreeSet<&str> = quoted(&section).filter(|q| q.rsplit('.').next() == Some("rs")).collect();
        let files = sources(&root().join("crates").join(name).join("src"));
        let there: BTreeSet<&str> = files.iter().map(|f| f.path.as_str()).collect();
        let vanished: Vec<_> = named.difference(&there).collect();
        let missing: Vec<_> = there.difference(&named).collect();
        assert!(vanished.is_empty(), "ARCHITECTURE.md names files that {name} does not have: {vanished:?}");
        assert!(missing.is_empty(), "ARCHITECTURE.md does not name these files of {name}: {missing:?}");
    }
}
