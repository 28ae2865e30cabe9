//! Links in the documents lead somewhere: to a file of the repository, and to a heading in it.

mod tree;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use tree::root;

fn documents() -> Vec<PathBuf> {
    let markdown = |folder: PathBuf| {
        let entries = std::fs::read_dir(folder).expect("a readable folder");
        entries
            .map(|e| e.expect("a readable entry").path())
            .filter(|p| p.extension().is_some_and(|e| e == "md"))
    };
    [root(), root().join("docs"), root().join("docs/guide")].into_iter().flat_map(markdown).collect()
}

/// The name that a heading has in links.
fn anchor(heading: &str) -> String {
    let kept = heading.trim_start_matches('#').trim().to_lowercase();
    kept.chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

fn anchors(file: &Path) -> BTreeSet<String> {
    let text = std::fs::read_to_string(file).expect("a readable document");
    text.lines().filter(|l| l.starts_with('#')).map(anchor).collect()
}

/// Targets of `[text](target)`; pictures are left out.
fn links(text: &str) -> Vec<&str> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("](") {
        let picture = text[..at].rfind('[').is_some_and(|open| text[..open].ends_with('!'));
        let target = text[at + 2..].split(')').next().unwrap_or("");
        if !picture && !target.contains("://") {
            found.push(target);
        }
    }
    found
}

#[test]
fn every_link_leads_somewhere() {
    let documents = documents();
    assert!(documents.len() > 5);
    for document in &documents {
        let text = std::fs::read_to_string(document).expect("a readable document");
        for link in links(&text) {
            let (path, heading) = link.split_once('#').unwrap_or((link, ""));
            let folder = document.parent().expect("a folder");
            let target = if path.is_empty() { document.clone() } else { folder.join(path) };
            assert!(target.exists(), "{} links to {link}, which is not there", document.display());
            let known = heading.is_empty() || anchors(&target).contains(heading);
            assert!(known, "{} links to {link}: no such heading", document.display());
        }
    }
}

#[test]
fn links_and_anchors_are_understood() {
    assert_eq!(links("a [b](c.md#d), ![e](f.png), [g](https://h) and [i](j)"), ["c.md#d", "j"]);
    assert_eq!(anchor("## How far, to trust?"), "how-far-to-trust");
}
