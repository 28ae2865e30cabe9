//! Bodies that hang by little or by nothing: told of, whichever way they are solved.

mod common;

use common::{Bench, Done};
use std::fmt::Write;

/// A closed surface of boxes with these (lower, upper) corners, as OBJ; pieces that overlap are one body.
fn boxes(corners: &[([f64; 3], [f64; 3])]) -> String {
    let mut text = String::new();
    for (k, (low, high)) in corners.iter().enumerate() {
        for v in 0..8 {
            let at = |i: usize| if v >> i & 1 == 1 { high[i] } else { low[i] };
            writeln!(text, "v {} {} {}", at(0), at(1), at(2)).unwrap();
        }
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        for q in quads {
            let [a, b, c, d] = q.map(|v| 8 * k + v + 1);
            writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
        }
    }
    text
}

/// Two blocks, 0.2 apart, joined by a square neck of that width if it is not zero; the lower one is larger.
fn dumbbell(neck: f64) -> String {
    let half = 0.5 * neck;
    let mut parts = vec![([-0.4, -0.4, -0.6], [0.4, 0.4, -0.1]), ([-0.4, -0.4, 0.1], [0.4, 0.4, 0.5])];
    if neck > 0.0 {
        parts.push(([-half, -half, -0.2], [half, half, 0.2]));
    }
    boxes(&parts)
}

const SCENARIO: &str = r#"
title = "Two blocks"
units = "normalised"
[body]
shape = { mesh = { path = "body.obj" } }
spacing = 0.1
[material]
model = "kelvin-voigt"
density = 1.0
young_modulus = 100.0
poisson_ratio = 0.3
relaxation_time = 0.2
[[boundary]]
kind = "clamp"
region = { plane = { axis = "z", at = AT, side = "SIDE" } }
[[load]]
kind = "body_force"
region = "all"
acceleration = [0.1, 0.0, -0.3]
[time]
integrator = "sdirk2"
dt = 0.1
until = 0.2
[output]
every = 0.1
"#;

/// Runs the dumbbell held beyond a plane, to rest or in time.
fn run(neck: f64, at: &str, side: &str, mode: &str) -> Done {
    let bench = Bench::new();
    bench.write("body.obj", dumbbell(neck));
    bench.write("case.toml", SCENARIO.replace("AT", at).replace("SIDE", side));
    bench.rsph(&["run", "case.toml", "--set", &format!("solver.mode={mode}")])
}

#[test]
fn a_block_on_a_thin_neck_comes_to_rest_or_is_told_of() {
    for mode in ["static", "dynamic"] {
        for neck in [0.3, 0.14, 0.06] {
            let done = run(neck, "-0.5", "below", mode);
            match done.code {
                Some(0) => {}
                Some(3) => {
                    let told = ["too thin", "thin piece", "held by nothing", "not held enough"];
                    assert!(told.iter().any(|t| done.err.contains(t)), "{mode}, {neck}: {}", done.err);
                    assert!(neck < 0.2, "{mode}, {neck}: {}", done.err);
                }
                code => panic!("{mode}, {neck}: {code:?} {}", done.err),
            }
        }
    }
}

#[test]
fn a_piece_that_nothing_holds_is_left_out_at_rest_and_moves_in_time() {
    // What the clamp leaves of the two blocks, in layers of 64 particles.
    for (at, side, held, unheld) in [("-0.5", "below", 256, 256), ("0.4", "above", 192, 320)] {
        let done = run(0.0, at, side, "static");
        assert_eq!(done.code, Some(0), "{}", done.err);
        let share = 100.0 * f64::from(unheld) / f64::from(held + unheld);
        let told =
            format!("{share:.2} % of the body's volume is left out, the piece of {unheld} particles around");
        assert!(done.err.contains(&told) && done.err.contains("nothing holds it"), "{}", done.err);
        assert!(done.err.contains(&format!("{held} particles, spacing")), "{}", done.err);
        let done = run(0.0, at, side, "dynamic");
        assert_eq!(done.code, Some(0), "{}", done.err);
        assert!(
            !done.err.contains("left out") && done.err.contains("512 particles, spacing"),
            "{}",
            done.err
        );
    }
}

#[test]
fn crumbs_are_left_out_with_a_note() {
    let bench = Bench::new();
    let crumb = ([0.6, -0.1, -0.5], [0.8, 0.1, -0.3]);
    bench.write("body.obj", boxes(&[([-0.4, -0.4, -0.6], [0.4, 0.4, -0.1]), crumb]));
    bench.write("case.toml", SCENARIO.replace("AT", "-0.5").replace("SIDE", "below"));
    let done = bench.rsph(&["run", "case.toml"]);
    assert_eq!(done.code, Some(0), "{}", done.err);
    let told = "a piece too small for particles to deform (the largest has 8 and lies around";
    assert!(done.err.contains(told) && done.err.contains("256 particles, spacing"), "{}", done.err);
}

#[test]
fn a_load_on_two_bodies_of_one_file_is_that_of_both() {
    let half = |held: &str| {
        SCENARIO
            .replace("AT", "-0.5")
            .replace("SIDE", "below")
            .replace(r#"region = { plane = { axis = "z", at = -0.5, side = "below" } }"#, held)
            .replace(
                "kind = \"body_force\"\nregion = \"all\"\nacceleration = [0.1, 0.0, -0.3]",
                "kind = \"pressure\"\npressure = 0.5\nregion = { plane = { axis = \"z\", at = 0.4, side = \"above\" } }",
            )
    };
    let bench = Bench::new();
    bench.write(
        "body.obj",
        boxes(&[([-0.9, -0.4, 0.0], [-0.1, 0.4, 0.4]), ([0.05, -0.4, 0.0], [0.75, 0.4, 0.4])]),
    );
    let both = r#"region = { plane = { axis = "z", at = 0.0, side = "below" } }"#;
    let one = r#"region = { and = [ { plane = { axis = "z", at = 0.001, side = "below" } }, { plane = { axis = "x", at = 0.0, side = "below" } } ] }"#;
    for (held, area) in [(both, 0.64 + 0.56), (one, 0.64)] {
        bench.write("case.toml", half(held));
        let done =
            bench.rsph(&["run", "case.toml", "--force", "--output", "o", "--set", "solver.mode=static"]);
        assert_eq!(done.code, Some(0), "{}", done.err);
        let text = std::fs::read_to_string(bench.path("o/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        let load = summary["load"][2].as_f64().unwrap();
        assert!((load + 0.5 * area).abs() < 1e-6 * area, "{load} {}", done.err);
    }
    // Loads and probes on nothing but what is left out.
    let other = r#"region = { plane = { axis = "x", at = 0.75, side = "above" } }"#;
    let text = half(one).replace(r#"region = { plane = { axis = "z", at = 0.4, side = "above" } }"#, other);
    bench.write("case.toml", text);
    let done = bench.rsph(&["run", "case.toml", "--force", "--output", "o", "--set", "solver.mode=static"]);
    assert_eq!(done.code, Some(2), "{}", done.err);
    assert!(done.err.contains("load[0]") && done.err.contains("acts on no"), "{}", done.err);
    let probe = "[[probe]]\nname = \"p\"\nquantity = \"displacement.z\"\nregion = { point = [0.3, 0.0, 0.2] }\n[time]";
    bench.write("case.toml", half(one).replace("[time]", probe));
    let done = bench.rsph(&["run", "case.toml", "--force", "--output", "o", "--set", "solver.mode=static"]);
    assert_eq!(done.code, Some(2), "{}", done.err);
    assert!(done.err.contains("probe[0].region") && done.err.contains("left out"), "{}", done.err);
}

#[test]
fn a_body_that_nothing_holds_has_no_equilibrium_but_moves() {
    let bench = Bench::new();
    bench.write("body.obj", dumbbell(0.3));
    let held = SCENARIO.find("[[boundary]]").unwrap()..SCENARIO.find("[[load]]").unwrap();
    let mut free = SCENARIO.to_owned();
    free.replace_range(held, "");
    bench.write("case.toml", free);
    let done = bench.rsph(&["run", "case.toml", "--set", "solver.mode=static"]);
    assert_eq!(done.code, Some(3), "{}", done.err);
    assert!(done.err.contains("held by nothing"), "{}", done.err);
    let done = bench.rsph(&["run", "case.toml", "--force"]);
    assert_eq!(done.code, Some(0), "{}", done.err);
}
