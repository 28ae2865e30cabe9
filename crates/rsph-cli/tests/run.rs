//! Whole runs of shortened scenarios.

mod common;

use common::{Bench, Done, scenario};
use rsph_core::shape::Placement;
use rsph_core::tensor::{Mat3, Vec3};
use rsph_scenario::label_map::ImageGrid;
use rsph_scenario::output::nifti::{self, Meaning, VoxelField};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// A tensile test of 20 steps.
fn short(bench: &Bench, more: &[&str]) -> Done {
    let file = scenario("tensile_liver");
    let mut arguments = vec!["run", file.to_str().unwrap(), "--set", "time.until=0.02"];
    arguments.extend(["--set", "output.every=0.005", "--output", "results"]);
    arguments.extend(more);
    bench.rsph(&arguments)
}

fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().skip(1).map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect()
}

/// A bar pulled to rest.
const PULLED: &str = r#"
body = { shape = { box = { size = [1.0, 1.0, 1.0] } }, spacing = 0.125 }
material = { model = "kelvin-voigt", density = 1.0, young_modulus = 100.0, poisson_ratio = 0.0, relaxation_time = 0.1 }
solver = { mode = "static" }
[[boundary]]
kind = "clamp"
region = { plane = { axis = "z", at = 0.0, side = "below" } }
[[load]]
kind = "traction"
traction = [0.0, 0.0, 1.0]
region = { plane = { axis = "z", at = 1.0, side = "above" } }
"#;

#[test]
fn a_static_run_asks_for_no_time_and_says_what_came_out() {
    let bench = Bench::new();
    bench.write("pulled.toml", PULLED);
    for (more, unit) in
        [(&[][..], true), (&["--set", "time.dt=100.0"], true), (&["--set", "units=normalised"], false)]
    {
        let done = bench.rsph(&[&["run", "pulled.toml", "--force"], more].concat());
        assert_eq!(done.code, Some(0), "{}", done.err);
        // The uppermost particles are at z = 0.9375.
        let words = if unit {
            ["displacement 0.009375 m, strain 0.01000, von Mises stress 1.000 Pa", "load (0, 0, 1.000) N"]
        } else {
            ["displacement 0.009375, strain 0.01000, von Mises stress 1.000\n", "load (0, 0, 1.000), carried"]
        };
        assert!(words.iter().all(|words| done.out.contains(words)), "{}", done.out);
    }
    bench.write("moving.toml", PULLED.replace("mode = \"static\"", "smoothing = 0.8"));
    let refused = bench.rsph(&["run", "moving.toml"]);
    assert!(refused.code == Some(2) && refused.err.contains("when the motion ends"), "{}", refused.err);
}

#[test]
fn a_run_fills_its_folder_and_says_where() {
    let bench = Bench::new();
    let done = short(&bench, &[]);
    assert_eq!(done.code, Some(0), "{}", done.err);
    assert!(
        done.out.contains("results/report.html") && done.out.contains("particles.vtkhdf"),
        "{}",
        done.out
    );
    for file in ["particles.vtkhdf", "surface.vtkhdf", "probes.csv", "summary.json", "report.html"] {
        assert!(bench.path("results").join(file).exists(), "{file}");
    }
    let as_run = std::fs::read_to_string(bench.path("results/scenario.toml")).unwrap();
    let table: toml::Table = as_run.parse().unwrap();
    assert_eq!(table["time"]["until"].as_float(), Some(0.02));
    assert!(as_run.contains("# the top is pulled upwards"));

    let probes = rows(&bench.path("results/probes.csv"));
    assert_eq!((probes.len(), probes[0][0]), (29, 0.0));
    let last = probes.last().unwrap();
    assert!((last[0] - 0.02).abs() < 1e-12 && last[1] > 0.0, "{last:?}");

    let summary = std::fs::read_to_string(bench.path("results/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!((summary["particles"].as_u64(), summary["steps"].as_u64()), (Some(343), Some(28)));
}

#[test]
fn results_are_overwritten_only_by_force() {
    let bench = Bench::new();
    assert_eq!(short(&bench, &["--quiet"]).code, Some(0));
    let refused = short(&bench, &[]);
    assert_eq!(refused.code, Some(2));
    assert!(refused.err.contains("--force"), "{}", refused.err);
    assert_eq!(short(&bench, &["--force"]).code, Some(0));
}

#[test]
fn quiet_is_silent() {
    let done = short(&Bench::new(), &["--quiet"]);
    assert_eq!((done.code, done.out.as_str(), done.err.as_str()), (Some(0), "", ""));
}

/// The law of the paper, pulled to 1.78 of its length, and a body of 100 m.
const BEYOND: &str = r#"
    units = "SI"
    solver = { mode = "static" }
    time = { until = 1.0 }
    material = { model = "kelvin-voigt", density = 1000.0, young_modulus = 1e4, poisson_ratio = 0.3, relaxation_time = 0.2 }
    body = { shape = { box = { size = [0.1, 0.1, 0.1] } }, spacing = 0.0125 }
    [[boundary]]
    kind = "clamp"
    region = { plane = { axis = "z", at = 0.0, side = "below" } }
    [[load]]
    kind = "traction"
    traction = [0.0, 0.0, 8e3]
    region = { plane = { axis = "z", at = 0.1, side = "above" } }
"#;

#[test]
fn a_law_beyond_its_range_is_named_wherever_results_are_read() {
    let bench = Bench::new();
    std::fs::write(bench.path("beyond.toml"), BEYOND).unwrap();
    let run = |more: &[&str]| {
        let done = bench.rsph(&[&["run", "beyond.toml", "--output", "results", "--force"], more].concat());
        assert_eq!(done.code, Some(0), "{}", done.err);
        let read = |file: &str| std::fs::read_to_string(bench.path("results").join(file)).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).unwrap();
        (done.err, summary["notes"].as_array().unwrap().clone(), read("report.html"))
    };
    let (log, notes, report) = run(&[]);
    let note = notes[0].as_str().unwrap();
    assert!(
        note.contains("strained by 1.0") && note.contains("neo-hookean") && notes.len() == 1,
        "{notes:?}"
    );
    assert!(log.contains(note) && report.contains("Do not trust this far"), "{log}");
    let law = "material.model=neo-hookean";
    let (_, notes, report) = run(&["--set", law]);
    assert!(notes.is_empty() && !report.contains("Do not trust this far"), "{notes:?}");
    let size = "body={ shape = { box = { size = [100, 100, 100] } }, spacing = 20.0 }";
    let (_, notes, _) = run(&["--set", law, "--set", size, "--set", "load=[]"]);
    assert!(notes[0].as_str().unwrap().contains("`scale = 0.001`"), "{notes:?}");
}

#[test]
fn threads_do_not_change_the_result() {
    let read = |threads: &str| {
        let bench = Bench::new();
        assert_eq!(short(&bench, &["--threads", threads]).code, Some(0));
        std::fs::read(bench.path("results/probes.csv")).unwrap()
    };
    assert_eq!(read("1"), read("2"));
}

#[test]
fn a_time_step_above_the_limit_is_refused_or_blows_up_with_3() {
    let bench = Bench::new();
    let refused = short(&bench, &["--set", "time.dt=0.01"]);
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    assert!(
        refused.err.contains("stability limit") && refused.err.contains("allow_unstable"),
        "{}",
        refused.err
    );
    assert!(!bench.path("results").exists());

    let allowed = ["--set", "time.dt=0.01", "--set", "time.allow_unstable=true", "--set", "time.until=1.0"];
    let failed = short(&bench, &allowed);
    assert_eq!(failed.code, Some(3), "{}", failed.err);
    assert!(failed.err.contains("failed at t ="), "{}", failed.err);
    assert!(bench.path("results/summary.json").exists());
}

#[test]
fn a_region_without_particles_points_at_its_line() {
    let bench = Bench::new();
    let done = short(&bench, &["--set", "boundary.0.region={ ball = { centre = [9, 9, 9], radius = 0.1 } }"]);
    assert_eq!(done.code, Some(2), "{}", done.err);
    assert!(done.err.contains("`boundary[0].region`") && done.err.contains("no particle"), "{}", done.err);
    assert!(!bench.path("results").exists());
}

#[test]
fn bad_meshes_are_refused_before_anything_is_written() {
    let triangle = |a: &str, b: &str, c: &str| {
        format!("facet normal 0 0 1\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n")
    };
    let open = triangle("0 0 0", "1 0 0", "0 1 0") + &triangle("0 0 0", "1 0 0", "0 0 1");
    for (facets, says) in [
        (open, "open edges"),
        (triangle("0 0 nan", "1 0 0", "0 1 0"), "a vertex is three numbers"),
        (String::new(), "triangle"),
    ] {
        let bench = Bench::new();
        bench.write("organ.stl", format!("solid organ\n{facets}endsolid organ\n"));
        let text = common::scenario_text("liver_visible_human")
            .replace("../../shared/data/meshes/visible_human_liver_female.stl", "organ.stl");
        bench.write("organ.toml", text);
        let done = bench.rsph(&["run", "organ.toml"]);
        assert_eq!(done.code, Some(2), "{says}: {}", done.err);
        assert!(done.err.contains(says) && done.err.contains("organ.stl"), "{says}: {}", done.err);
        assert!(done.err.contains("organ.toml:9:"), "{says}: {}", done.err);
        assert!(!bench.path("out").exists());
    }
}

#[test]
fn the_real_liver_runs() {
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/meshes/visible_human_liver_female.stl");
    if !mesh.exists() {
        eprintln!("skipped: there is no {}", mesh.display());
        return;
    }
    let bench = Bench::new();
    let file = scenario("liver_visible_human");
    let set = format!("body.shape.mesh.path={}", mesh.display());
    let arguments =
        ["run", file.to_str().unwrap(), "--set", &set, "--set", "time.until=1e-4", "--output", "o"];
    let done = bench.rsph(&arguments);
    assert_eq!(done.code, Some(0), "{}", done.err);
}

#[test]
fn the_stored_scenario_of_a_mesh_runs_from_its_folder() {
    let bench = Bench::new();
    bench.write("organ.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    let text = std::fs::read_to_string(scenario("liver_visible_human")).unwrap();
    let mesh = "../../shared/data/meshes/visible_human_liver_female.stl";
    bench.write("case.toml", text.replace(mesh, "organ.obj"));
    let common = ["--set", "time.until=1e-5", "--set", "body.particles=100", "--output"];
    let first = bench.rsph(&[&["run", "case.toml"], &common[..], &["first"]].concat());
    assert_eq!(first.code, Some(0), "{}", first.err);
    let again = bench.rsph(&[&["run", "first/scenario.toml"], &common[..], &["second"]].concat());
    assert_eq!(again.code, Some(0), "{}", again.err);
}

#[test]
fn every_shipped_scenario_starts() {
    for name in [
        "tensile_liver",
        "tensile_kidney",
        "hanging_column",
        "liver_load",
        "liver_load_144",
        "deformation",
        "deformation_remeshed",
        "tensile_liver_remeshed",
    ] {
        let bench = Bench::new();
        let file = scenario(name);
        let arguments = ["run", file.to_str().unwrap(), "--set", "time.until=1e-5", "--quiet"];
        let done = bench.rsph(&arguments);
        assert_eq!(done.code, Some(0), "{name}: {}", done.err);
        assert!(bench.path("out").join(name).join("summary.json").exists(), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_closes_the_last_frame_and_exits_with_130() {
    let bench = Bench::new();
    let file = scenario("tensile_kidney");
    let mut child = bench
        .command(&["run", file.to_str().unwrap(), "--output", "results"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !bench.path("results/probes.csv").exists() && begun.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(50));
    }
    std::thread::sleep(Duration::from_millis(200));
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let summary = std::fs::read_to_string(bench.path("results/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["status"], "interrupted");
    let time = summary["time"].as_f64().unwrap();
    let probes = rows(&bench.path("results/probes.csv"));
    assert!((probes.last().unwrap()[0] - time).abs() < 1e-9, "{time}");
}

#[test]
fn the_scheme_of_the_paper_fails_and_says_when() {
    let bench = Bench::new();
    let file = scenario("tensile_liver");
    let done = bench.rsph(&[
        "run",
        file.to_str().unwrap(),
        "--set",
        "solver.formulation=paper",
        "--output",
        "results",
    ]);
    assert_eq!(done.code, Some(3), "{}", done.err);
    assert!(done.err.contains("failed at t = 0.3") && done.err.contains("adjoint"), "{}", done.err);
    // Results up to there, in the order of time.
    let times: Vec<f64> = rows(&bench.path("results/probes.csv")).iter().map(|r| r[0]).collect();
    assert!(times.len() > 100 && times.is_sorted(), "{times:?}");
    let summary = std::fs::read_to_string(bench.path("results/summary.json")).unwrap();
    assert!(summary.contains("\"failed\""), "{summary}");
}

/// A coarse deformation test of four steps.
fn deformation(bench: &Bench, name: &str, more: &[&str]) -> Done {
    let file = scenario(name);
    let mut arguments = vec!["run", file.to_str().unwrap(), "--set", "body.spacing=0.05"];
    arguments.extend(["--set", "time.until=0.08", "--set", "output.every=0.04", "--output", "results"]);
    arguments.extend(more);
    bench.rsph(&arguments)
}

#[test]
fn a_remeshed_deformation_reports_what_remeshing_did() {
    let bench = Bench::new();
    let done = deformation(&bench, "deformation_remeshed", &[]);
    assert_eq!(done.code, Some(0), "{}", done.err);
    let summary = std::fs::read_to_string(bench.path("results/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let remesh = &summary["remesh"];
    assert_eq!(remesh["count"].as_u64(), Some(2));
    assert!(remesh["particles_after"].as_u64() > remesh["particles_before"].as_u64(), "{remesh}");
    assert!(summary["mass_error"].as_f64().unwrap() < 1e-13, "{summary}");
    let probes = std::fs::read_to_string(bench.path("results/probes.csv")).unwrap();
    assert!(probes.starts_with("time,volume_inside\n"), "{probes}");
    let rows = rows(&bench.path("results/probes.csv"));
    assert_eq!(rows.len(), 5);
    assert!(rows.iter().all(|r| (r[1] / rows[0][1] - 1.0).abs() < 0.1), "{rows:?}");
    for file in ["particles.vtkhdf", "surface.vtkhdf"] {
        let info = bench.rsph(&["info", bench.path("results").join(file).to_str().unwrap()]);
        assert!(info.out.contains("frames: 3"), "{file}: {}", info.out);
    }

    let without = Bench::new();
    assert_eq!(deformation(&without, "deformation", &[]).code, Some(0));
    let summary = std::fs::read_to_string(without.path("results/summary.json")).unwrap();
    assert!(summary.contains("\"remesh\": null"), "{summary}");
}

#[test]
fn a_remeshed_solid_reports_what_remeshing_did() {
    let bench = Bench::new();
    let file = scenario("tensile_liver_remeshed");
    let sets = ["--set", "time.until=0.1", "--set", "output.every=0.05", "--output", "results"];
    let done = bench.rsph(&[&["run", file.to_str().unwrap()], &sets[..]].concat());
    assert_eq!(done.code, Some(0), "{}", done.err);
    let summary = std::fs::read_to_string(bench.path("results/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let remesh = &summary["remesh"];
    assert!(remesh["count"].as_u64() >= Some(9), "{remesh}");
    assert!(remesh["energy_after"].as_f64() > Some(0.0), "{remesh}");
    assert!(remesh["largest_mass_jump"].as_f64() < Some(1e-13), "{remesh}");
    assert!(remesh["largest_momentum_jump"].as_f64() < Some(1e-5), "{remesh}");
    // The exact history of the bar without lateral contraction is 3.6e-3 at this time.
    let extension = rows(&bench.path("results/probes.csv")).last().unwrap()[1];
    assert!((3.0e-3..4.0e-3).contains(&extension), "{extension}");
}

#[test]
fn remeshing_does_not_depend_on_threads() {
    let read = |threads: &str| {
        let bench = Bench::new();
        let done = deformation(&bench, "deformation_remeshed", &["--threads", threads, "--quiet"]);
        assert_eq!(done.code, Some(0), "{}", done.err);
        std::fs::read(bench.path("results/probes.csv")).unwrap()
    };
    assert_eq!(read("1"), read("2"));
}

#[test]
fn particles_that_leave_are_followed_until_no_lattice_holds_them() {
    let bench = Bench::new();
    let away = ["--set", "dynamics.velocity={constant=[50, 0, 0]}", "--set", "remesh.every=1"];
    let done = deformation(&bench, "deformation_remeshed", &away);
    assert_eq!(done.code, Some(0), "{}", done.err);
    let bench = Bench::new();
    let fast = ["--set", "dynamics.velocity={constant=[1e12, 0, 0]}", "--set", "remesh.every=1"];
    let done = deformation(&bench, "deformation_remeshed", &fast);
    assert_eq!(done.code, Some(3), "{}", done.err);
    assert!(done.err.contains("no lattice reaches"), "{}", done.err);
}

/// A bar of 0.1 m with nu = 0 whose top moves by 1 mm: E A d / L = 1 N on each grip.
const GRIPS: &str = r#"
    units = "SI"
    solver = { mode = "static", steps = 2 }
    time = { until = 0.5 }
    material = { model = "kelvin-voigt", density = 1000.0, young_modulus = 1e4, poisson_ratio = 0.0, relaxation_time = 0.2 }
    body = { shape = { box = { size = [0.1, 0.1, 0.1] } }, spacing = 0.0125 }
    [[boundary]]
    name = "lower"
    kind = "clamp"
    region = { plane = { axis = "z", at = 0.0, side = "below" } }
    [[boundary]]
    name = "upper"
    kind = "prescribed"
    region = { plane = { axis = "z", at = 0.1, side = "above" } }
    motion = { ramp = { displacement = [0.0, 0.0, 0.001], from = 0.0, to = 0.5 } }
"#;

#[test]
fn the_force_of_each_grip_is_read_in_time() {
    let bench = Bench::new();
    std::fs::write(bench.path("grips.toml"), GRIPS).unwrap();
    let done = bench.rsph(&["run", "grips.toml", "--output", "results"]);
    assert_eq!(done.code, Some(0), "{}", done.err);
    let csv = bench.path("results/probes.csv");
    let header = std::fs::read_to_string(&csv).unwrap();
    let header = header.lines().next().unwrap();
    assert!(header.contains("lower_moment_z,upper_force_x") && header.ends_with("upper_displacement_z"));
    for (row, force) in rows(&csv).iter().zip([0.0, 0.5, 1.0]) {
        assert!((row[3] + force).abs() < 1e-8 && (row[9] - force).abs() < 1e-8, "{row:?}");
        assert!(row[4..=6].iter().chain(&row[10..=12]).all(|moment| moment.abs() < 1e-9), "{row:?}");
        assert!((row[15] - 0.001 * force).abs() < 1e-15, "{row:?}");
    }
    let summary = std::fs::read_to_string(bench.path("results/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert!((summary["readings"]["upper_force_z"].as_f64().unwrap() - 1.0).abs() < 1e-8, "{summary}");
    let report = std::fs::read_to_string(bench.path("results/report.html")).unwrap();
    assert!(report.contains(r#"{"name":"upper.z","force":8,"displacement":14}"#));
    let twice = bench.rsph(&["run", "grips.toml", "--set", "boundary.1.name=lower", "--output", "no"]);
    assert!(twice.code == Some(2) && twice.err.contains("lower_force_x"), "{}", twice.err);
}

#[test]
fn a_field_of_a_run_is_written_on_the_voxels_of_an_image() {
    let bench = Bench::new();
    std::fs::write(bench.path("grips.toml"), GRIPS).unwrap();
    let fields = "output.fields=[\"principal_strain\"]";
    let done = bench.rsph(&["run", "grips.toml", "--set", fields, "--output", "results"]);
    assert_eq!(done.code, Some(0), "{}", done.err);
    // Voxels of 10 mm around the bar of 0.1 m.
    let placement = Placement { axes: Mat3::identity() * 10.0, origin: Vec3::repeat(-5.0) };
    let grid = ImageGrid { size: [12, 12, 12], placement, metres: 1e-3 };
    let (name, meaning) = ("ct".to_owned(), Meaning::Scalar);
    let empty = VoxelField { name, meaning, voxels: Vec::new(), values: Vec::new() };
    nifti::write(&bench.path("ct.nii.gz"), &grid, &empty, 0.0).unwrap();
    let image = |more: &[&str]| {
        let all = [&["image", "results", "--like", "ct.nii.gz", "--output", "field.nii"], more].concat();
        bench.rsph(&all)
    };
    let done = image(&["--field", "principal_strain.1", "--outside", "nan"]);
    assert_eq!(done.code, Some(0), "{}", done.err);
    assert!(done.out.contains("1000 voxels of the body at t = 0.5"), "{}", done.out);
    let raw = std::fs::read(bench.path("field.nii")).unwrap();
    let values: Vec<f32> = raw[352..].as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    assert_eq!(values.iter().filter(|x| x.is_nan()).count(), 12 * 12 * 12 - 1000);
    assert!(values.iter().filter(|x| !x.is_nan()).all(|e| (e - 0.01).abs() < 1e-6));
    let refused = image(&["--field", "temperature"]);
    assert!(refused.code == Some(2) && refused.err.contains("principal_strain"), "{}", refused.err);
    let elsewhere = image(&["--scale", "1"]);
    assert!(elsewhere.code == Some(2) && elsewhere.err.contains("ct.nii.gz"), "{}", elsewhere.err);
}
