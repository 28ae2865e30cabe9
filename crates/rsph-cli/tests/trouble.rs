//! Runs that the system or the user ends early, and what `--resume` makes of them.
#![cfg(unix)]

mod common;

use common::{Bench, Done, scenario};
use rsph_scenario::output::vtkhdf::describe;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const UNTIL: &str = "time.until=0.6";

/// The arguments of a run of the tensile test into `folder`.
fn arguments<'a>(file: &'a str, folder: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut all =
        vec!["run", file, "--quiet", "--output", folder, "--set", UNTIL, "--set", "output.every=0.002"];
    all.extend(more);
    all
}

fn tensile(bench: &Bench, folder: &str, more: &[&str]) -> Done {
    bench.rsph(&arguments(scenario("tensile_liver").to_str().unwrap(), folder, more))
}

fn start(bench: &Bench, folder: &str) -> Child {
    let file = scenario("tensile_liver");
    let mut command = bench.command(&arguments(file.to_str().unwrap(), folder, &[]));
    let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let begun = Instant::now();
    while !bench.path(folder).join("checkpoint.h5").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

fn send(signal: &str, child: &Child) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

fn probes(bench: &Bench, folder: &str) -> Vec<u8> {
    std::fs::read(bench.path(folder).join("probes.csv")).unwrap()
}

fn frames(folder: &Path) -> [usize; 2] {
    ["particles.vtkhdf", "surface.vtkhdf"].map(|file| describe(&folder.join(file)).unwrap().steps())
}

fn status(folder: &Path) -> String {
    let text = std::fs::read_to_string(folder.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    summary["status"].as_str().unwrap().to_owned()
}

#[test]
fn a_signal_stores_a_checkpoint_and_resuming_ends_as_without_it() {
    let bench = Bench::in_memory();
    assert_eq!(tensile(&bench, "whole", &[]).code, Some(0));
    for (signal, name, code) in [("-TERM", "terminated", 143), ("-INT", "interrupted", 130)] {
        let mut child = start(&bench, name);
        std::thread::sleep(Duration::from_millis(30));
        send(signal, &child);
        assert_eq!(child.wait().unwrap().code(), Some(code), "{signal}");
        let folder = bench.path(name);
        assert_eq!(status(&folder), "interrupted");
        let stopped = frames(&folder);
        assert_eq!(stopped[0], stopped[1]);
        let resumed = tensile(&bench, name, &["--resume"]);
        assert_eq!(resumed.code, Some(0), "{}", resumed.err);
        assert_eq!(status(&folder), "finished");
        assert!(probes(&bench, name) == probes(&bench, "whole"), "{signal}");
        assert_eq!(frames(&folder), [301, 301]);
    }
    // Once more: there is nothing left to do, and nothing changes.
    assert_eq!(tensile(&bench, "interrupted", &["--resume"]).code, Some(0));
    assert!(probes(&bench, "interrupted") == probes(&bench, "whole"));
    assert_eq!(frames(&bench.path("interrupted")), [301, 301]);
}

#[test]
fn what_can_not_be_resumed_is_refused() {
    let bench = Bench::in_memory();
    let none = tensile(&bench, "none", &["--resume"]);
    assert_eq!(none.code, Some(2));
    assert!(none.err.contains("nothing to resume") && !bench.path("none").exists(), "{}", none.err);

    assert_eq!(tensile(&bench, "r", &[]).code, Some(0));
    let before = probes(&bench, "r");
    let sets = ["--resume", "--set", "load.0.traction=[0, 0, 2]", "--set", "solver.hourglass=0.2"];
    let other = tensile(&bench, "r", &sets);
    assert_eq!(other.code, Some(2));
    assert!(other.err.contains("another scenario"), "{}", other.err);
    assert!(
        other.err.contains("`load[0].traction`") && other.err.contains("`solver.hourglass`"),
        "{}",
        other.err
    );
    assert!(!other.err.contains("time.until"), "{}", other.err);
    // The scenario in the folder is that of the checkpoint.
    let stored = bench.rsph(&["run", "r/scenario.toml", "--resume", "--output", "r"]);
    assert_eq!(stored.code, Some(0), "{}", stored.err);
    assert!(stored.err.contains("goes on from its checkpoint at t = 0.6"), "{}", stored.err);
    // How often it is stored says nothing about the results.
    let rarely = ["--resume", "--set", "output.checkpoint={ frames = 7 }"];
    assert_eq!(tensile(&bench, "r", &rarely).code, Some(0));
    assert!(probes(&bench, "r") == before);
    // Both are asked for at once.
    assert_eq!(tensile(&bench, "r", &["--resume", "--force"]).code, Some(2));

    let checkpoint = bench.path("r/checkpoint.h5");
    std::fs::write(&checkpoint, "no HDF5").unwrap();
    let damaged = tensile(&bench, "r", &["--resume"]);
    assert_eq!(damaged.code, Some(2));
    assert!(damaged.err.contains("not a readable checkpoint"), "{}", damaged.err);
    assert!(probes(&bench, "r") == before);
}

#[test]
fn two_runs_do_not_share_a_folder() {
    let bench = Bench::in_memory();
    let mut first = start(&bench, "r");
    for how in ["--force", "--resume"] {
        let second = tensile(&bench, "r", &[how]);
        assert_eq!(second.code, Some(2), "{how}: {}", second.err);
        assert!(second.err.contains("another run writes to"), "{how}: {}", second.err);
    }
    // A run that is killed holds nothing.
    first.kill().unwrap();
    first.wait().unwrap();
    assert_eq!(tensile(&bench, "r", &["--resume"]).code, Some(0));
}

/// Files of a run that may not be larger than that many blocks of 512 bytes, as on a disk that is full.
fn cramped(bench: &Bench, folder: &str, blocks: usize) -> Done {
    let file = scenario("tensile_liver");
    let program = env!("CARGO_BIN_EXE_rsph");
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -f {blocks}; exec \"$0\" \"$@\""), program]);
    command.args(arguments(file.to_str().unwrap(), folder, &[])).current_dir(bench.path(""));
    command.output().unwrap().into()
}

#[test]
fn a_full_disk_ends_a_run_with_4_and_resuming_goes_on() {
    let bench = Bench::in_memory();
    assert_eq!(tensile(&bench, "whole", &[]).code, Some(0));
    let mut most = 0;
    for blocks in [300, 2000, 9000, 24_000] {
        let folder = format!("r{blocks}");
        let full = cramped(&bench, &folder, blocks);
        assert_eq!(full.code, Some(4), "{blocks}: {}", full.err);
        assert!(full.err.contains("cannot write") && full.err.contains("too large"), "{}", full.err);
        let path = bench.path(&folder);
        let stored = frames(&path);
        assert!(stored[0].abs_diff(stored[1]) < 301, "{stored:?}");
        most = most.max(stored[0]);
        if path.join("checkpoint.h5").exists() {
            let resumed = tensile(&bench, &folder, &["--resume"]);
            assert_eq!(resumed.code, Some(0), "{blocks}: {}", resumed.err);
            assert!(probes(&bench, &folder) == probes(&bench, "whole"), "{blocks}");
            assert_eq!(frames(&path), [301, 301]);
        }
    }
    assert!(most > 20, "{most}");
}

#[test]
fn a_folder_that_can_not_be_written_is_the_fault_of_the_system() {
    // Nobody can make a folder there, not even the one who may do anything.
    let bench = Bench::in_memory();
    let done = tensile(&bench, "/proc/rsph", &[]);
    if Path::new("/proc").exists() {
        assert_eq!(done.code, Some(4), "{}", done.err);
        assert!(done.err.contains("cannot write to the output folder"), "{}", done.err);
    }
}
