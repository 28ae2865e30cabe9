//! The source tree as text, for the tests that compare it with the documents.
#![allow(dead_code)]

use std::fs;
use std::path::{Path, PathBuf};

/// A source file.
pub struct SourceFile {
    /// Path relative to the crate's `src`, with forward slashes: `dynamics/solid.rs`.
    pub path: String,
    /// Its text.
    pub text: String,
}

/// The folder of this crate.
pub fn crate_folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The root of the repository.
pub fn root() -> PathBuf {
    crate_folder().join("../..")
}

/// The text of a file of the repository.
pub fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// All Rust files below `folder`, by path.
pub fn sources(folder: &Path) -> Vec<SourceFile> {
    let mut files = Vec::new();
    collect(folder, folder, &mut files);
    files.sort_by(|a, b| a.path.cmp(&b.path));
    files
}

fn collect(folder: &Path, below: &Path, files: &mut Vec<SourceFile>) {
    for entry in fs::read_dir(folder).expect("a readable folder").map(|e| e.expect("a readable entry")) {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, below, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let relative = path.strip_prefix(below).expect("below the folder");
            let parts: Vec<_> = relative.iter().map(|p| p.to_string_lossy()).collect();
            files.push(SourceFile {
                path: parts.join("/"),
                text: fs::read_to_string(&path).expect("a readable file"),
            });
        }
    }
}

impl SourceFile {
    /// The code without comments and without the unit tests at its end.
    pub fn code(&self) -> String {
        let end = self.text.find("#[cfg(test)]\nmod ").unwrap_or(self.text.len());
        let lines = self.text[..end].lines();
        lines.map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
    }

    /// The whole text on one line, without comment markers: what a sentence says across line breaks.
    pub fn prose(&self) -> String {
        let strip = |l: &str| {
            let l = l.trim();
            let l = l.strip_prefix("//").map_or(l, |l| l.trim_start_matches(['/', '!']));
            l.trim().to_owned()
        };
        self.text.lines().map(strip).collect::<Vec<_>>().join(" ")
    }

    /// Path of the module in the crate: `["dynamics", "elastic"]`; empty for the crate's root.
    pub fn module(&self) -> Vec<String> {
        let mut module: Vec<String> =
            self.path.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
        if module.last().is_some_and(|m| m == "mod" || m == "lib") {
            module.pop();
        }
        module
    }
}

/// The texts between backticks.
pub fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}
