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
fn a_piece_that_nothing_joins_is_left_out_and_told_of() {
    for mode in ["static", "dynamic"] {
        let done = run(0.0, "-0.5", "below", mode);
        assert_eq!(done.code, Some(0), "{mode}: {}", done.err);
        assert!(done.err.contains("50.0 % of the body's volume is left out"), "{mode}: {}", done.err);
    }
}

#[test]
fn a_body_whose_clamp_is_on_the_piece_left_out_is_refused() {
    for mode in ["static", "dynamic"] {
        let done = run(0.0, "0.35", "above", mode);
        assert_eq!(done.code, Some(2), "{mode}: {}", done.err);
        assert!(
            done.err.contains("`boundary[0].region`") && done.err.contains("no particle"),
            "{}",
            done.err
        );
    }
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
