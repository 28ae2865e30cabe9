//! Meshes that are no closed surfaces, from file to report.

mod common;

use common::Bench;
use std::fmt::Write as _;
use std::path::Path;

/// A unit box of 10 cells along each edge as an OBJ, without the triangles that `drop` names.
fn open_box(drop: impl Fn([f64; 3]) -> bool) -> String {
    let mut text = String::new();
    let mut vertices = 0;
    for axis in 0..3 {
        for (end, turned) in [(0.0, true), (1.0, false)] {
            for (i, j) in (0..100).map(|n| (f64::from(n % 10), f64::from(n / 10))) {
                let point = |a: f64, b: f64| {
                    let mut x = [0.0; 3];
                    (x[axis], x[(axis + 1) % 3], x[(axis + 2) % 3]) = (end, (i + a) / 10.0, (j + b) / 10.0);
                    x
                };
                if drop(point(0.5, 0.5)) {
                    continue;
                }
                for [x, y, z] in [point(0.0, 0.0), point(1.0, 0.0), point(1.0, 1.0), point(0.0, 1.0)] {
                    let _ = writeln!(text, "v {x} {y} {z}");
                }
                let [a, b, c, d] = [1, 2, 3, 4].map(|k| vertices + k);
                let [b, d] = if turned { [d, b] } else { [b, d] };
                let _ = writeln!(text, "f {a} {b} {c} {d}");
                vertices += 4;
            }
        }
    }
    text
}

/// A hole of 4 x 5 cells in the top.
fn in_the_lid(x: [f64; 3]) -> bool {
    x[2] > 0.99 && x[0] > 0.3 && x[0] < 0.7 && x[1] < 0.5
}

const SCENARIO: &str = r#"
units = "SI"
body = { shape = { mesh = { path = "open.obj" } }, spacing = 0.1 }
material = { model = "kelvin-voigt", density = 1000.0, young_modulus = 1e5, poisson_ratio = 0.3, relaxation_time = 0.1 }
solver = { mode = "static" }
time = { until = 1.0 }
[[boundary]]
kind = "clamp"
region = { plane = { axis = "z", at = 0.15, side = "below" } }
[[load]]
kind = "body_force"
acceleration = [0.0, 0.0, -9.81]
"#;

#[test]
fn an_open_mesh_runs_to_the_end_and_says_how_sure_its_inside_is() {
    let bench = Bench::new();
    bench.write("open.obj", open_box(in_the_lid));
    bench.write("case.toml", SCENARIO);
    let done = bench.rsph(&["run", "case.toml", "--output", "o"]);
    assert_eq!(done.code, Some(0), "{}", done.err);
    assert!(done.err.contains("open edges") && done.err.contains("made up"), "{}", done.err);
    let summary: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(bench.path("o/summary.json")).unwrap()).unwrap();
    let notes: Vec<&str> = summary["notes"].as_array().unwrap().iter().filter_map(|n| n.as_str()).collect();
    assert!(notes.iter().any(|n| n.contains("of the body are uncertain")), "{notes:?}");
    let repair = &summary["repair"];
    // Edges of the 4 x 5 cells that are missing; the outermost ones are shared with a face of the box.
    assert_eq!(repair["open_edges"], 18);
    let number = |key: &str| repair[key].as_f64().unwrap();
    // What lies beyond the clamp is cut off.
    assert!(
        (number("volume") - 1.0).abs() < 5e-3 && (summary["volume"].as_f64().unwrap() - 0.85).abs() < 0.01
    );
    assert!(
        (number("made_up") - 0.2 / 6.0).abs() < 0.01 && (0.005..0.1).contains(&number("uncertain")),
        "{repair}"
    );
    let gap = repair["gap_at"].as_array().unwrap();
    assert!((gap[2].as_f64().unwrap() - 1.0).abs() < 0.1, "{repair}");
    let report = std::fs::read_to_string(bench.path("o/report.html")).unwrap();
    assert!(report.contains("is not closed (18 open edges") && report.contains("made up"));
}

#[test]
fn a_mesh_is_not_repaired_against_the_users_will_nor_beyond_reason() {
    let bench = Bench::new();
    bench.write("open.obj", open_box(in_the_lid));
    bench.write("case.toml", SCENARIO);
    let done = bench.rsph(&["run", "case.toml", "--set", "body.shape.mesh.repair=false"]);
    assert_eq!(done.code, Some(2), "{}", done.err);
    assert!(done.err.contains("18 open edges") && done.err.contains("repair = true"), "{}", done.err);
    // Only the bottom, and a tray with low walls.
    for (height, says) in [(0.01, "its size is"), (0.3, "too wide")] {
        bench.write("open.obj", open_box(|x| x[2] > height));
        let done = bench.rsph(&["run", "case.toml"]);
        assert_eq!(done.code, Some(2), "{}", done.err);
        assert!(done.err.contains(says) && done.err.contains("case.toml:3:"), "{says}: {}", done.err);
        assert!(!bench.path("out").exists());
    }
}

#[test]
fn info_and_sample_tell_what_was_repaired() {
    let bench = Bench::new();
    bench.write("open.obj", open_box(in_the_lid));
    let info = bench.rsph(&["info", "open.obj"]);
    assert!(
        info.out.contains("closed: no, 18 open edges") && info.out.contains("body: volume"),
        "{}",
        info.out
    );
    assert!(
        info.out.contains("of the body are uncertain") && info.out.contains("widest gap"),
        "{}",
        info.out
    );
    let sample = bench.rsph(&["sample", "open.obj", "--particles", "1000"]);
    assert_eq!(sample.code, Some(0), "{}", sample.err);
    assert!(
        sample.out.contains("particles: 1000") && sample.err.contains("uncertain"),
        "{}{}",
        sample.out,
        sample.err
    );
}

#[test]
fn a_published_liver_of_open_parts_is_one_body() {
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/meshes/VH_F_Liver.glb");
    if !mesh.exists() {
        eprintln!("skipped: there is no {}", mesh.display());
        return;
    }
    let bench = Bench::new();
    let done = bench.rsph(&["sample", mesh.to_str().unwrap(), "--particles", "5000", "--output", "p.csv"]);
    assert_eq!(done.code, Some(0), "{}", done.err);
    let csv = std::fs::read_to_string(bench.path("p.csv")).unwrap();
    let volumes: Vec<f64> =
        csv.lines().skip(1).map(|l| l.split(',').nth(3).unwrap().parse().unwrap()).collect();
    let volume: f64 = volumes.iter().sum();
    println!("{} particles, volume {volume:.6e}\n{}{}", volumes.len(), done.out, done.err);
    assert!((volume / 2.245e-3 - 1.0).abs() < 0.05, "{volume}");
    assert!(done.out.contains("closed, 1 piece,"), "{}", done.out);
}
