//! docs/equations.md against the source: every equation of the paper has its section, and code and
//! ledger name each other.

mod tree;

use std::collections::{BTreeMap, BTreeSet};
use tree::{crate_folder, quoted, read, sources};

/// The last numbered equation of the paper.
const LAST: u32 = 21;

/// Equation numbers that a text names: `Eq. (5)`, `Eq. 5`, `Eqs. (1), (11)`, `Eqs. (10) to (14)`.
fn tags(text: &str) -> BTreeSet<u32> {
    let mut found = BTreeSet::new();
    for (at, _) in text.match_indices("Eq") {
        if text[..at].chars().next_back().is_some_and(char::is_alphanumeric) {
            continue;
        }
        let rest = text[at + 2..].trim_start_matches('s');
        let Some(mut rest) = rest.strip_prefix('.').map(str::trim_start) else { continue };
        let mut first = None;
        while let Some((number, after)) = number(rest) {
            match first.take() {
                Some(from) => found.extend(from..=number),
                None => _ = found.insert(number),
            }
            let next = [", and (", ", (", " and (", " to ("].iter().find(|s| after.starts_with(**s));
            let Some(separator) = next else { break };
            if *separator == " to (" {
                first = Some(number);
            }
            rest = &after[separator.len() - 1..];
        }
    }
    found
}

/// A number, in parentheses or not, at the start of `text`, and what follows.
fn number(text: &str) -> Option<(u32, &str)> {
    let inner = text.strip_prefix('(').unwrap_or(text);
    let end = inner.find(|c: char| !c.is_ascii_digit()).unwrap_or(inner.len());
    let number = inner[..end].parse().ok()?;
    let after = &inner[end..];
    if text.starts_with('(') { Some((number, after.strip_prefix(')')?)) } else { Some((number, after)) }
}

/// One section of the ledger.
#[derive(Debug, Default)]
struct Entry {
    /// (path below the crate's folder, symbol in it or nothing).
    code: Vec<(String, String)>,
    tests: Vec<(String, String)>,
    text: String,
}

fn ledger() -> BTreeMap<u32, Entry> {
    let text = read("docs/equations.md");
    let mut entries = BTreeMap::new();
    let mut current: Option<u32> = None;
    let mut item = "";
    for line in text.lines() {
        // An indented line continues the item above it.
        if !line.starts_with("  ") {
            item = line;
        }
        if line.starts_with('#') {
            current = line.strip_prefix("### ").and_then(number).map(|(n, _)| n);
            if let Some(n) = current {
                assert!(entries.insert(n, Entry::default()).is_none(), "two sections for ({n})");
            }
            continue;
        }
        let Some(entry) = current.and_then(|n| entries.get_mut(&n)) else { continue };
        entry.text.push_str(line);
        entry.text.push('\n');
        let places = || {
            quoted(line).map(|q| {
                let (path, symbol) = q.split_once("::").unwrap_or((q, ""));
                (path.to_owned(), symbol.to_owned())
            })
        };
        if item.starts_with("- Code:") {
            entry.code.extend(places());
        } else if item.starts_with("- Tests:") {
            entry.tests.extend(places());
        }
    }
    entries
}

#[test]
fn tags_are_understood() {
    let text = "Eq. (5), Eqs. (1), (11) and Eqs. (13) to (15), with 3 (Eq. 9). Eq. (2) 1 (4) Equal 7";
    assert_eq!(tags(text).into_iter().collect::<Vec<_>>(), [1, 2, 5, 9, 11, 13, 14, 15]);
}

#[test]
fn every_equation_has_a_section_that_is_complete_or_says_not_yet() {
    let ledger = ledger();
    let numbers: Vec<u32> = ledger.keys().copied().collect();
    assert_eq!(numbers, (1..=LAST).collect::<Vec<_>>());
    for (n, entry) in &ledger {
        assert!(entry.text.contains("$$"), "({n}) has no formula");
        assert!(entry.text.contains("- Deviation:"), "({n}) does not say how it deviates from the paper");
        if !entry.text.contains("Not yet") {
            assert!(!entry.code.is_empty(), "({n}) names no code");
            assert!(!entry.tests.is_empty(), "({n}) names no test");
        }
    }
}

#[test]
fn every_tag_in_the_source_is_in_the_ledger() {
    let ledger = ledger();
    for file in sources(&crate_folder().join("src")) {
        let path = format!("src/{}", file.path);
        for n in tags(&file.prose()) {
            let entry = ledger.get(&n).unwrap_or_else(|| panic!("{path} names ({n}), which is no equation"));
            assert!(entry.code.iter().any(|(p, _)| *p == path), "({n}) of the ledger does not name {path}");
        }
    }
}

#[test]
fn every_place_in_the_ledger_exists_and_carries_its_tag() {
    let files: BTreeMap<String, _> =
        sources(&crate_folder()).into_iter().map(|f| (f.path.clone(), f)).collect();
    let defines = |text: &str, symbol: &str| {
        ["fn", "struct", "enum", "trait", "const"].iter().any(|keyword| {
            text.match_indices(&format!("{keyword} {symbol}")).any(|(at, found)| {
                !text[at + found.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_')
            })
        })
    };
    for (n, entry) in ledger() {
        for (path, symbol) in entry.code.iter().chain(&entry.tests) {
            let file = files.get(path).unwrap_or_else(|| panic!("({n}) names {path}, which is not there"));
            let name = symbol.rsplit("::").next().unwrap_or("");
            assert!(name.is_empty() || defines(&file.text, name), "({n}): {path} has no {name}");
        }
        for (path, _) in &entry.code {
            assert!(tags(&files[path].prose()).contains(&n), "({n}): {path} does not name it");
        }
        for (path, symbol) in &entry.tests {
            assert!(!symbol.is_empty(), "({n}): {path}: which test?");
        }
    }
}
