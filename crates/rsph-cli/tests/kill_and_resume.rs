//! A run that is killed at random moments, and resumed each time, ends as one that never was: bit by bit, no frame
//! lost or doubled. The results can be read after every kill.
//!
//! Short by default. The full form, from the root of the repository:
//!
//! ```text
//! RSPH_KILLS=100 RSPH_UNTIL=15 cargo test --release -p rsph-cli --test kill_and_resume -- --nocapture
//! ```

mod common;

use common::{Bench, scenario};
use rsph_scenario::output::vtkhdf::{describe, read_step};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// A number from the environment.
fn number(name: &str, default: f64) -> f64 {
    std::env::var(name).map_or(default, |text| text.parse().expect(name))
}

/// Numbers between 0 and 1, other ones in every test run: any moment must do.
struct Random(u64);

impl Random {
    fn new() -> Self {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
        println!("seed {}", now.as_nanos() as u64);
        Self(now.as_nanos() as u64 | 1)
    }

    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Frames of a results file, bit by bit; `None` if there is no file yet.
fn frames(path: &Path) -> Option<Vec<String>> {
    if !path.exists() {
        return None;
    }
    let info = describe(path).unwrap();
    let frame = |k: usize| {
        let f = read_step(path, Some(k)).unwrap();
        let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        let fields: Vec<_> = f.fields.iter().map(|f| (&f.name, bits(&f.values))).collect();
        format!("{:?} {:?} {:?} {fields:?}", f.time, bits(f.points.as_flattened()), f.cells)
    };
    Some((0..info.steps()).map(frame).collect())
}

/// The numbers of a summary that have nothing to do with the wall clock.
fn physics(folder: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join("summary.json")).unwrap();
    let mut summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    for clock in ["wall_seconds", "steps_per_second", "particle_updates_per_second", "real_time_factor"] {
        assert!(summary.as_object_mut().unwrap().remove(clock).is_some(), "{clock}");
    }
    summary
}

/// What the page draws.
fn drawn(folder: &Path) -> String {
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    let (_, rest) = page.split_once("id=\"data\">").unwrap();
    rest.split_once("</script>").unwrap().0.to_owned()
}

fn assert_same(a: &Path, b: &Path) {
    for file in ["particles.vtkhdf", "surface.vtkhdf"] {
        let (a, b) = (frames(&a.join(file)).unwrap(), frames(&b.join(file)).unwrap());
        assert_eq!(a.len(), b.len(), "frames of {file}");
        for (k, (a, b)) in a.iter().zip(&b).enumerate() {
            assert!(a == b, "frame {k} of {file} differs");
        }
    }
    let probes = |folder: &Path| std::fs::read(folder.join("probes.csv")).unwrap();
    assert!(probes(a) == probes(b), "probes.csv differs");
    assert_eq!(physics(a), physics(b));
    assert!(drawn(a) == drawn(b), "report.html differs");
}

#[test]
fn a_run_that_has_ended_goes_on_to_a_later_end() {
    let bench = Bench::in_memory();
    let file = scenario("tensile_liver");
    let run = |folder: &str, until: &str, every: &str, more: &[&str]| {
        let (until, every) = (format!("time.until={until}"), format!("output.every={every}"));
        let sets = ["--set", &until, "--set", &every, "--quiet", "--output", folder];
        bench.rsph(&[&["run", file.to_str().unwrap()], &sets[..], more].concat())
    };
    assert_eq!(run("whole", "0.5", "0.125", &[]).code, Some(0));
    assert_eq!(run("part", "0.25", "0.125", &[]).code, Some(0));
    let longer = run("part", "0.5", "0.125", &["--resume", "--set", "title=\"longer\""]);
    assert_eq!(longer.code, Some(0), "{}", longer.err);
    for file in ["particles.vtkhdf", "surface.vtkhdf"] {
        let [whole, part] = ["whole", "part"].map(|f| frames(&bench.path(f).join(file)).unwrap());
        assert!(whole == part && whole.len() == 5, "{} frames of {file}", part.len());
    }
    let probes = |folder: &str| std::fs::read(bench.path(folder).join("probes.csv")).unwrap();
    assert!(probes("whole") == probes("part"));
    // With other frames from here on: at .55 and .6.
    assert_eq!(run("part", "0.6", "0.05", &["--resume"]).code, Some(0));
    let info = describe(&bench.path("part/particles.vtkhdf")).unwrap();
    let times: Vec<f64> = info.times.iter().map(|t| (1e6 * t).round() / 1e6).collect();
    assert_eq!(times, [0.0, 0.125, 0.25, 0.375, 0.5, 0.55, 0.6]);
    let earlier = run("part", "0.3", "0.05", &["--resume"]);
    assert!(earlier.code == Some(2) && earlier.err.contains("later than the end"), "{}", earlier.err);
    let other = run("part", "0.7", "0.05", &["--resume", "--set", "material.poisson_ratio=0.31"]);
    assert!(other.code == Some(2) && other.err.contains("material.poisson_ratio"), "{}", other.err);
}

#[test]
fn a_run_that_is_killed_and_resumed_ends_as_one_that_never_was() {
    let (kills, until) = (number("RSPH_KILLS", 6.0) as usize, number("RSPH_UNTIL", 1.0));
    let bench = Bench::in_memory();
    let file = scenario("tensile_liver_remeshed");
    let sets = [
        format!("time.until={until}"),
        format!("output.every={}", until / 200.0),
        "output.checkpoint={ minutes = 0.005, frames = 20 }".into(),
    ];
    let command = |folder: &str, more: &[&str]| {
        let mut command = bench.command(&["run", file.to_str().unwrap(), "--quiet", "--output", folder]);
        command.args(sets.iter().flat_map(|s| ["--set", s])).args(more).stdout(Stdio::null());
        command
    };
    let begun = Instant::now();
    assert!(command("whole", &[]).status().unwrap().success());
    let duration = begun.elapsed();
    println!("uninterrupted: {duration:.2?}");
    let whole = frames(&bench.path("whole/particles.vtkhdf")).unwrap();

    let mut random = Random::new();
    let (mut killed, mut runs, mut most) = (0, 0, 0);
    while killed < kills {
        let folder = format!("run{runs}");
        let path = bench.path(&folder);
        // A third of the run between kills, on average, so that every run sees several.
        loop {
            let resumable = path.join("checkpoint.h5").exists();
            let mut child =
                command(&folder, &[if resumable { "--resume" } else { "--force" }]).spawn().unwrap();
            let patience = Duration::from_secs_f64(if killed < kills { random.next() * 0.6 } else { 100.0 })
                .mul_f64(duration.as_secs_f64());
            let begun = Instant::now();
            let status = loop {
                if let Some(status) = child.try_wait().unwrap() {
                    break Some(status);
                }
                if begun.elapsed() >= patience {
                    child.kill().unwrap(); // SIGKILL
                    child.wait().unwrap();
                    break None;
                }
                std::thread::sleep(Duration::from_micros(200));
            };
            if let Some(status) = status {
                assert!(status.success(), "run {runs} after {killed} kills: {status}");
                break;
            }
            killed += 1;
            for name in ["particles.vtkhdf", "surface.vtkhdf"] {
                // Whatever moment it was, the file is whole: the frames of the uninterrupted run up to there.
                let there = frames(&path.join(name));
                if let (Some(there), "particles.vtkhdf") = (there, name) {
                    assert!(whole.starts_with(&there), "run {runs}, kill {killed}: {} frames", there.len());
                    most = most.max(there.len());
                }
            }
        }
        assert_same(&bench.path("whole"), &path);
        std::fs::remove_dir_all(&path).unwrap();
        runs += 1;
    }
    println!(
        "{killed} kills in {runs} runs of {} frames, all equal; up to {most} frames at a kill",
        whole.len()
    );
}
