//! The corpus of the fuzzing, seeds and what was found, through the readers: each input comes to its end, soon. See
//! `fuzz/run`.

#[path = "../../../fuzz/src/targets.rs"]
mod targets;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// Longest time for one input.
const SOON: Duration = Duration::from_secs(5);

#[test]
fn every_input_of_the_corpus_comes_to_its_end() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    for (name, target) in targets::TARGETS {
        let mut count = 0;
        for entry in fs::read_dir(corpus.join(name)).expect("a folder for each target") {
            let path = entry.unwrap().path();
            let bytes = fs::read(&path).unwrap();
            let start = Instant::now();
            target(&bytes);
            assert!(start.elapsed() < SOON, "{} took {:?}", path.display(), start.elapsed());
            count += 1;
        }
        assert!(count > 0, "the target {name} has no corpus");
    }
}

#[test]
fn every_folder_of_the_corpus_has_a_target() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    for entry in fs::read_dir(corpus).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(targets::TARGETS.iter().any(|(known, _)| *known == name), "no target {name}");
    }
}
