//! Code that the compiler can not check stands in the files named here, and nowhere else. That each block says why
//! it is sound is for clippy (`undocumented_unsafe_blocks`).

mod tree;

use tree::{root, sources};

/// Files with such code, and what it is for.
const NAMED: &[(&str, &str)] = &[
    ("crates/rsph-py/src/arrays.rs", "NumPy arrays that look at the core's columns"),
    ("crates/rsph-core/tests/allocations.rs", "an allocator that counts"),
    ("benches/wasm/src/lib.rs", "names of functions that JavaScript calls"),
];

/// Crates that can not have any.
const WITHOUT: &[&str] = &[
    "crates/rsph-core/src/lib.rs",
    "crates/rsph-scenario/src/lib.rs",
    "crates/rsph-validation/src/lib.rs",
    "crates/rsph-cli/src/main.rs",
];

fn has_unsafe(code: &str) -> bool {
    code.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|word| word == concat!("un", "safe"))
}

#[test]
fn unsafe_code_stands_in_named_files_only() {
    let mut found = Vec::new();
    for folder in ["crates", "fuzz/src", "docs/examples", "benches"] {
        for file in sources(&root().join(folder)) {
            let path = format!("{folder}/{}", file.path);
            let code: Vec<&str> = file.text.lines().map(|l| l.split("//").next().unwrap_or("")).collect();
            if has_unsafe(&code.join("\n")) {
                found.push(path);
            }
        }
    }
    found.sort();
    let mut named: Vec<String> = NAMED.iter().map(|(path, _)| (*path).to_owned()).collect();
    named.sort();
    assert_eq!(found, named, "files with code that the compiler can not check");
}

#[test]
fn crates_that_need_none_forbid_it() {
    for path in WITHOUT {
        assert!(tree::read(path).contains("#![forbid(unsafe_code)]"), "{path}");
    }
}
