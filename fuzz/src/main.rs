//! libFuzzer around one of the targets, which the variable `RSPH_FUZZ_TARGET` names; `./run` sets it.
#![no_main]

mod targets;

use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

static TARGET: LazyLock<targets::Target> = LazyLock::new(|| {
    let name = std::env::var("RSPH_FUZZ_TARGET").unwrap_or_default();
    targets::TARGETS.iter().find(|(known, _)| *known == name).map_or_else(
        || {
            let known: Vec<_> = targets::TARGETS.iter().map(|(known, _)| *known).collect();
            eprintln!("RSPH_FUZZ_TARGET = {name}: no target; there are {}", known.join(", "));
            std::process::exit(2)
        },
        |(_, target)| *target,
    )
});

fuzz_target!(|bytes: &[u8]| TARGET(bytes));
