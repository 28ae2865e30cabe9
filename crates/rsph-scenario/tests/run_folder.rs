//! The folder of a run: complete for good and bad runs, nothing from the network, errors in words.
#![allow(clippy::float_cmp, reason = "what is stored comes back bit by bit")]

mod common;

use rsph_core::setup::Units;
use rsph_core::simulation::Reading;
use rsph_scenario::output::vtkhdf::{describe, read_step};
use rsph_scenario::output::{RunInfo, RunWriters, polydata::PolyData, vtp};
use rsph_scenario::sink::Status;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Writes a made-up run of `frames` frames with a remesh after the second one.
fn run(folder: &Path, info: RunInfo, frames: u32, status: Status) {
    let mut writers = RunWriters::create(folder, info).unwrap();
    for k in 0..frames {
        let t = f64::from(k) * 0.5;
        let size = if k < 2 { 5 } else { 6 };
        writers
            .frame(
                common::snapshot(t, u64::from(k), size),
                common::surface(t, size),
                &common::conservation(t),
            )
            .unwrap();
        writers.sample(t, &common::readings(t), &common::conservation(t)).unwrap();
    }
    writers.finish(&common::outcome(status)).unwrap();
}

fn summary(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

/// The page without the plot library.
fn own_page(folder: &Path) -> String {
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    let (start, end) =
        (page.find("<script type=\"text/javascript\">").unwrap(), page.find("</script>").unwrap());
    format!("{}{}", &page[..start], &page[end..])
}

fn data(folder: &Path) -> Value {
    let page = own_page(folder);
    let (_, rest) = page.split_once("id=\"data\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn a_finished_run_leaves_every_file() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("out/made-up");
    run(&folder, common::info(), 4, Status::Finished);
    let mut names: Vec<_> =
        fs::read_dir(&folder).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(
        names,
        ["particles.vtkhdf", "probes.csv", "report.html", "scenario.toml", "summary.json", "surface.vtkhdf"]
    );
    assert_eq!(describe(&folder.join("particles.vtkhdf")).unwrap().times, [0.0, 0.5, 1.0, 1.5]);
    assert_eq!(describe(&folder.join("surface.vtkhdf")).unwrap().steps(), 4);

    let probes = fs::read_to_string(folder.join("probes.csv")).unwrap();
    let lines: Vec<_> = probes.lines().collect();
    assert_eq!(lines[0], "time,extension,tip_x,tip_y,tip_z");
    assert_eq!(lines.len(), 5);
    let row: Vec<f64> = lines[4].split(',').map(|x| x.parse().unwrap()).collect();
    assert_eq!(row[0], 1.5);
    assert_eq!(row[1], common::readings(1.5)[0].value);
}

#[test]
fn the_summary_has_the_names_that_scripts_use() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), common::info(), 3, Status::Finished);
    let s = summary(dir.path());
    for number in [
        "particles",
        "steps",
        "time",
        "wall_seconds",
        "steps_per_second",
        "rhs_evaluations",
        "particle_updates_per_second",
        "real_time_factor",
        "mass_error",
        "momentum_error",
        "dt",
        "threads",
        "spacing",
        "smoothing_length",
        "neighbours",
        "volume",
        "shape_volume",
    ] {
        assert!(s[number].is_number(), "{number}: {}", s[number]);
    }
    for part in ["kinetic", "elastic", "external_work", "dissipated"] {
        assert!(s["energy"][part].is_number(), "{part}");
    }
    assert_eq!(s["status"], "finished");
    assert_eq!(s["steps_per_second"], 150.0);
    let particles = s["particles"].as_f64().unwrap();
    assert_eq!(particles, common::snapshot(0.0, 0, 6).len() as f64, "the count after the remesh");
    assert_eq!(s["particle_updates_per_second"], particles * 1200.0 / 2.0);
    assert_eq!(s["real_time_factor"], 1.5);
    assert_eq!(s["scenario_sha256"].as_str().unwrap().len(), 64);
    assert_eq!(s["load"], serde_json::json!([0.0, 0.0, 1.0]));
    assert!(s["reaction"].is_array() && s["notes"].is_array() && s["version"].is_string());
    assert!(s["failure"].is_null());
}

#[test]
fn the_hash_is_that_of_the_scenario_file() {
    let dir = tempfile::tempdir().unwrap();
    let info = RunInfo { scenario: "abc".into(), ..common::info() };
    run(dir.path(), info, 1, Status::Finished);
    assert_eq!(fs::read_to_string(dir.path().join("scenario.toml")).unwrap(), "abc");
    let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    assert_eq!(summary(dir.path())["scenario_sha256"], known);
}

#[test]
fn failed_and_interrupted_runs_say_so() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), common::info(), 2, Status::Failed(common::failure()));
    let s = summary(dir.path());
    assert_eq!(s["status"], "failed");
    assert_eq!(s["failure"]["kind"], "unstable");
    let page = own_page(dir.path());
    for words in [
        "class=\"banner\"><strong>The simulation failed",
        "strain 12.5",
        "choose time.dt",
        "(step 301)",
        "0.1, 0.2, 0.9",
    ] {
        assert!(page.contains(words), "{words}");
    }
    run(dir.path(), common::info(), 2, Status::Interrupted);
    assert_eq!(summary(dir.path())["status"], "interrupted");
    assert!(own_page(dir.path()).contains("<strong>The run was interrupted"));
    run(dir.path(), common::info(), 2, Status::Finished);
    assert!(!own_page(dir.path()).contains("<strong>The "));
}

#[test]
fn a_run_that_ends_before_its_first_frame_has_a_report() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), common::info(), 0, Status::Failed(common::failure()));
    assert!(own_page(dir.path()).contains("The run has no surface."));
    assert!(read_step(&dir.path().join("particles.vtkhdf"), None).unwrap_err().problem.contains("no step"));
}

#[test]
fn the_report_fetches_nothing_and_escapes_what_it_shows() {
    let dir = tempfile::tempdir().unwrap();
    let mut info = common::info();
    info.probes[0].name = "</script><script>alert(1)</script>".into();
    let mut writers = RunWriters::create(dir.path(), info).unwrap();
    writers.finish(&common::outcome(Status::Finished)).unwrap();
    let page = own_page(dir.path());
    for fetching in ["http:", "https:", "src=", "href=", "url(", "@import", "<link", "<iframe", "fetch("] {
        assert!(!page.contains(fetching), "{fetching}");
    }
    assert!(!page.contains("<script>alert"));
    assert!(page.contains("Made-up ball &lt;sheared &amp; stretched&gt;"));
    assert!(page.contains("<figcaption>load 1: pressure &lt;2 kPa&gt;</figcaption>"));
    // The factor 1 at half of the time, a quarter at the end.
    assert!(page.contains("<polyline points=\"0.0,86.0 160.0,4.0 320.0,65.5\"/>"));
    assert!(page.contains("factor from 0 to 1; time [s] from 0 to 1"));
    assert!(page.contains("# &lt;/script&gt; {{data}}"), "the scenario is shown as it is");
    let whole = fs::read_to_string(dir.path().join("report.html")).unwrap();
    assert!(!whole.contains("<script src"));
    assert!(whole.contains("plotly.js v"));
}

#[test]
fn the_report_carries_frames_curves_and_units() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), common::info(), 4, Status::Finished);
    let d = data(dir.path());
    let frames = d["view"]["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 4);
    assert_eq!(d["view"]["meshes"].as_array().unwrap().len(), 2, "one mesh before and one after the remesh");
    assert_eq!(frames.iter().map(|f| f["mesh"].as_u64().unwrap()).collect::<Vec<_>>(), [0, 0, 1, 1]);
    for scalar in ["normal_strain", "shear_strain", "von_mises"] {
        assert!(frames[3]["scalars"][scalar].is_object(), "{scalar}");
    }
    assert_eq!(d["curves"]["time"].as_array().unwrap().len(), 4);
    assert_eq!(d["curves"]["probes"].as_array().unwrap().len(), 4);
    assert_eq!(d["length_unit"], " [m]");
    assert!(own_page(dir.path()).contains("kg/m³"));

    let info = RunInfo { units: Units::Normalised, ..common::info() };
    run(dir.path(), info, 2, Status::Finished);
    assert_eq!(data(dir.path())["length_unit"], "");
    assert!(!own_page(dir.path()).contains("kg/m³"));
}

#[test]
fn a_long_run_keeps_its_page_small() {
    let dir = tempfile::tempdir().unwrap();
    let mut writers = RunWriters::create(dir.path(), common::info()).unwrap();
    for k in 0..100_u32 {
        let t = f64::from(k) * 0.1;
        let rings = 30 + k as usize % 2; // every frame is a new mesh
        writers
            .frame(common::snapshot(t, 0, 3), common::surface(t, rings), &common::conservation(t))
            .unwrap();
    }
    for k in 0..10_000_u32 {
        let t = f64::from(k) * 0.001;
        writers.sample(t, &common::readings(t), &common::conservation(t)).unwrap();
    }
    writers.finish(&common::outcome(Status::Finished)).unwrap();
    assert!(fs::metadata(dir.path().join("report.html")).unwrap().len() < 15_000_000);
    let d = data(dir.path());
    let frames = d["view"]["frames"].as_array().unwrap();
    assert!((20..=41).contains(&frames.len()), "{}", frames.len());
    assert_eq!(frames[0]["time"], 0.0);
    assert_eq!(frames.last().unwrap()["time"], 99.0 * 0.1);
    assert!(d["curves"]["time"].as_array().unwrap().len() <= 2001);
    assert_eq!(describe(&dir.path().join("surface.vtkhdf")).unwrap().steps(), 100);
}

#[test]
fn results_that_are_no_numbers_are_stored_as_such() {
    let dir = tempfile::tempdir().unwrap();
    let mut writers = RunWriters::create(dir.path(), common::info()).unwrap();
    let mut surface = common::surface(0.0, 4);
    surface.fields[3].values[0] = f64::NAN;
    let mut sums = common::conservation(0.0);
    sums.momentum_error = f64::NAN;
    writers.frame(common::snapshot(0.0, 0, 4), surface, &sums).unwrap();
    let readings: Vec<_> =
        common::readings(0.0).into_iter().map(|r| Reading { value: f64::INFINITY, ..r }).collect();
    writers.sample(0.0, &readings, &sums).unwrap();
    writers.finish(&common::outcome(Status::Finished)).unwrap();
    assert!(summary(dir.path())["momentum_error"].is_null());
    assert!(data(dir.path())["curves"]["probes"][0][0].is_null());
}

#[test]
fn folders_that_can_not_be_written_are_errors_with_their_path() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("file");
    fs::write(&file, "").unwrap();
    let error = RunWriters::create(&file.join("below"), common::info()).unwrap_err();
    assert!(error.to_string().contains("below"), "{error}");

    let mut writers = RunWriters::create(&dir.path().join("run"), common::info()).unwrap();
    let error = writers.sample(0.0, &common::readings(0.0)[..2], &common::conservation(0.0)).unwrap_err();
    assert!(error.to_string().contains("probes.csv"), "{error}");
    fs::create_dir(dir.path().join("run/summary.json")).unwrap();
    let error = writers.finish(&common::outcome(Status::Finished)).unwrap_err();
    assert!(error.to_string().contains("summary.json"), "{error}");
    assert!(!dir.path().join("run/summary.json.part").exists());
}

#[test]
fn a_new_run_removes_the_old_report() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), common::info(), 2, Status::Finished);
    let _writers = RunWriters::create(dir.path(), common::info()).unwrap();
    assert!(!dir.path().join("summary.json").exists());
    assert!(!dir.path().join("report.html").exists());
}

#[test]
fn vtp_says_what_it_holds() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("surface.vtp");
    let mut frame = PolyData::from_surface(0.5, common::surface(0.5, 4));
    frame.fields[0].name = "a<b".into();
    vtp::write(&path, &frame).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(&format!("NumberOfPoints=\"{}\"", frame.points.len())));
    assert!(text.contains("Name=\"a&lt;b\" NumberOfComponents=\"3\""));
    assert!(text.ends_with("</VTKFile>\n"));
    frame.fields[0].values.pop();
    assert!(vtp::write(&path, &frame).unwrap_err().to_string().contains("surface.vtp"));
}
