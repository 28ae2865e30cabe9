//! Every file in `tests/bad_inputs` through the program: what is wrong is met at the door, soon, with a message
//! that says what and what to do, and nothing is left behind. Beside NAME stands NAME.expected: each of its lines
//! must stand in the message. A first line `exit 0` says that NAME only looks wrong, and must run.
#![cfg(unix)]

mod common;

use common::{Bench, Done};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// Longest time until a refusal, and most memory, in kB of addresses.
const SOON: Duration = Duration::from_secs(5);
const MEMORY: &str = "4000000";

/// What no message for a user holds.
const INSIDES: &[&str] = &["panicked", "Some(", "Ok(", "Err(", "Error {", "Os {", "got [", "\\u{", "unwrap"];

/// A scenario whose body is in a file.
const AROUND: &str = "particles = 100\n\n[material]\nmodel = \"kelvin-voigt\"\ndensity = 1000.0\n\
    young_modulus = 1e4\npoisson_ratio = 0.3\nrelaxation_time = 0.01\n\n[time]\nuntil = 0.001\n";

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/bad_inputs")
}

/// The names of all inputs.
fn inputs() -> Vec<String> {
    let names = fs::read_dir(folder()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    let is_input = |name: &String| !name.ends_with(".expected") && name != "README.md";
    let mut names: Vec<String> = names.filter(is_input).collect();
    names.sort();
    names
}

/// The arguments of the program that reads the file `name`, which lies in the bench.
fn arguments(bench: &Bench, name: &str) -> Vec<String> {
    let body = match name.rsplit('.').next() {
        Some("toml") => return ["run", name, "--output", "results"].map(String::from).to_vec(),
        Some("vtkhdf") => return ["info", name].map(String::from).to_vec(),
        Some("h5") => {
            // The scenario that it belongs to, and results that nobody comes to read: the checkpoint is first.
            let scenario = include_str!("../../../fuzz/checkpoint.toml");
            bench.write("around.toml", scenario);
            bench.write("results/checkpoint.h5", fs::read(folder().join(name)).unwrap());
            let results = ["particles.vtkhdf", "surface.vtkhdf", "probes.csv"];
            for result in results.into_iter().filter(|_| name != "results_not_there.h5") {
                bench.write(&format!("results/{result}"), "");
            }
            let words = ["run", "around.toml", "--output", "results", "--resume"];
            return words.map(String::from).to_vec();
        }
        Some("nii" | "gz" | "nrrd") => format!("labelmap = {{ path = \"{name}\", label = 2 }}"),
        _ => format!("shape = {{ mesh = {{ path = \"{name}\" }} }}"),
    };
    bench.write("around.toml", format!("[body]\n{body}\n{AROUND}"));
    arguments(bench, "around.toml")
}

/// What scenarios here name as mesh or image: a folder, a file without end, a link to itself.
fn surroundings(bench: &Bench) {
    for name in ["folder.stl", "folder.nii"] {
        fs::create_dir(bench.path(name)).unwrap();
    }
    for name in ["endless.stl", "endless.bin"] {
        symlink("/dev/zero", bench.path(name)).unwrap();
    }
    symlink(bench.path("circle.stl"), bench.path("circle.stl")).unwrap();
}

/// Runs the program with little memory.
fn run(bench: &Bench, name: &str) -> Done {
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -v $0; exec \"$@\"", MEMORY, env!("CARGO_BIN_EXE_rsph")]);
    command.args(arguments(bench, name)).current_dir(bench.path("")).env("RAYON_NUM_THREADS", "2");
    command.output().unwrap().into()
}

/// A message without the piece of the file that it shows, on one line each for problem and remedy.
fn message(text: &str) -> String {
    let (problem, rest) = text.split_once("help: ").unwrap_or((text, ""));
    // The box around the piece of the file begins with a corner.
    let problem = problem.split('\u{256d}').next().unwrap_or(problem);
    let line = |s: &str| s.split_whitespace().collect::<Vec<_>>().join(" ");
    format!("{}\nhelp: {}", line(problem), line(rest))
}

fn listing(bench: &Bench) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(bench.path(""))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// What is wrong about how the program met the input.
fn trouble(name: &str) -> Option<String> {
    let bench = Bench::new();
    surroundings(&bench);
    fs::copy(folder().join(name), bench.path(name)).unwrap();
    let expected = fs::read_to_string(folder().join(format!("{name}.expected"))).unwrap_or_default();
    let runs = expected.starts_with("exit 0\n");
    arguments(&bench, name);
    let before = listing(&bench);
    let start = Instant::now();
    let done = run(&bench, name);
    let took = start.elapsed();
    let said = message(&done.err);
    if let Some(update) = std::env::var_os("RSPH_WRITE_EXPECTED") {
        let _ = fs::write(Path::new(&update).join(format!("{name}.expected")), format!("{said}\n"));
    }
    let mut troubles = Vec::new();
    if took > SOON && !runs {
        troubles.push(format!("took {:.1} s", took.as_secs_f64()));
    }
    if done.code != Some(if runs { 0 } else { 2 }) {
        troubles.push(format!("exit code {:?}", done.code));
    }
    if expected.trim().is_empty() {
        troubles.push(format!("no {name}.expected"));
    }
    let lines = expected.lines().skip(usize::from(runs));
    troubles.extend(lines.filter(|l| !said.contains(l)).map(|l| format!("does not say: {l}")));
    troubles.extend(INSIDES.iter().filter(|w| said.contains(**w)).map(|w| format!("shows insides: {w}")));
    if !runs && listing(&bench) != before {
        troubles.push(format!("left behind: {:?}", listing(&bench)));
    }
    (!troubles.is_empty()).then(|| format!("{name}: {}\n{said}\n", troubles.join("; ")))
}

#[test]
fn every_input_is_met_at_the_door() {
    let inputs = inputs();
    assert!(inputs.len() >= 60, "{} inputs", inputs.len());
    let troubles: Vec<String> = inputs.iter().filter_map(|name| trouble(name)).collect();
    assert!(troubles.is_empty(), "{} of {}:\n{}", troubles.len(), inputs.len(), troubles.join("\n"));
}

#[test]
fn every_expectation_belongs_to_an_input() {
    let inputs = inputs();
    for entry in fs::read_dir(folder()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if let Some(input) = name.strip_suffix(".expected") {
            assert!(inputs.iter().any(|i| i == input), "{name} without {input}");
        }
    }
}

/// Results go into the folder that is named, or nowhere.
#[test]
fn places_that_can_not_hold_results_are_refused() {
    let bench = Bench::new();
    surroundings(&bench);
    bench.write("around.toml", include_str!("../../../fuzz/checkpoint.toml"));
    // A file in the way is the user's mistake (2), what the system says no to is not (4). The last is a folder of
    // the system in which nobody can make one.
    let places = [
        ("around.toml", 2),
        ("around.toml/deeper", 2),
        ("circle.stl", 4),
        ("circle.stl/deeper", 4),
        ("/proc/rsph-results", 4),
    ];
    let before = listing(&bench);
    for (place, code) in
        places.into_iter().filter(|(p, _)| cfg!(target_os = "linux") || !p.starts_with("/proc"))
    {
        let done = bench.rsph(&["run", "around.toml", "--output", place]);
        assert_eq!(done.code, Some(code), "{place}: {}", done.err);
        for part in
            ["cannot write to the output folder", place, "help: choose another folder with `--output`"]
        {
            assert!(done.err.contains(part), "{place}: no {part:?} in\n{}", done.err);
        }
        assert_eq!(listing(&bench), before, "{place}");
    }
}
