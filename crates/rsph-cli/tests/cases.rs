//! Inputs that once failed, beside the repository in `shared/cases`: each with the right value. Absent there, they are not run.

mod common;

use common::Bench;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of a case.
fn case(name: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/cases").join(name);
    let there = folder.is_dir();
    if !there {
        println!("{} is not there: not run", folder.display());
    }
    there.then_some(folder)
}

/// A bench with the files of a case.
fn bench_of(name: &str) -> Option<Bench> {
    let (folder, bench) = (case(name)?, Bench::new());
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), bench.path(entry.file_name().to_str().unwrap())).unwrap();
    }
    Some(bench)
}

/// A number after `key` in what a program says.
fn number_after(text: &str, key: &str) -> f64 {
    let (_, rest) = text.split_once(key).unwrap_or_else(|| panic!("no {key:?} in {text}"));
    rest.split_whitespace().next().unwrap().trim_end_matches(',').parse().unwrap()
}

/// A number of the summary of a run.
fn summary(bench: &Bench, folder: &str) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(bench.path(folder).join("summary.json")).unwrap()).unwrap()
}

#[test]
fn meshes_have_their_volume() {
    for (name, file, volume) in [
        ("conformal-parts", "cubes2.obj", 2e-6),
        ("obj-latin1", "L_latin1.obj", 1.2e-5),
        ("obj-latin1", "L_trailing.obj", 1.2e-5),
        ("obj-latin1", "L_cont.obj", 1.2e-5),
        ("stl-solid-header-with-tail", "L_solid_header_tail.stl", 1.2e-5),
        ("stl-solid-header-with-tail", "L_solid_header_tail2.stl", 1.2e-5),
        ("stl-solid-header-with-tail", "L_bom.stl", 1.2e-5),
    ] {
        let Some(bench) = bench_of(name) else { continue };
        let sampled = bench.rsph(&["sample", file, "--particles", "200"]);
        assert_eq!(sampled.code, Some(0), "{file}: {}", sampled.err);
        let found = number_after(&sampled.out, "of the mesh's ");
        assert!((found / volume - 1.0).abs() < 1e-6, "{file}: {found}");
    }
}

#[test]
fn extents_have_the_digits_that_tell_units() {
    let Some(bench) = bench_of("info-digits") else { return };
    let info = bench.rsph(&["info", "L_far.stl"]);
    for line in ["x: 100 to 100.04,", "y: 200 to 200.03,", "z: -50 to -49.98,", "unit: metres"] {
        assert!(info.out.contains(line), "no {line} in {}", info.out);
    }
}

/// A label map at rest under nothing but its hold.
fn segmented(file: &str) -> String {
    format!(
        "body = {{ labelmap = \"{file}\", particles = 500 }}\nsolver = {{ mode = \"static\" }}\n\
         material = {{ model = \"kelvin-voigt\", density = 1000.0, young_modulus = 1e4, poisson_ratio = 0.3, \
         relaxation_time = 0.1 }}\n[[boundary]]\nkind = \"clamp\"\n\
         region = {{ plane = {{ axis = \"z\", at = -1.0, side = \"below\" }} }}\n"
    )
}

#[test]
fn images_are_read_as_other_programs_read_them() {
    if let Some(bench) = bench_of("gz-zero-padding") {
        let info = bench.rsph(&["info", "n_gz_trailzeros.nii.gz"]);
        assert!(info.code == Some(0) && info.out.contains("label 1: 3628 voxels, 10.88 ml"), "{}", info.out);
    }
    if let Some(bench) = bench_of("negative-pixdim") {
        let info = |file| bench.rsph(&["info", file]).out;
        assert_eq!(info("n_negpix_q.nii"), info("n_positive.nii"));
    }
    if let Some(bench) = bench_of("one-voxel-wall") {
        bench.write("wall.toml", segmented("n_wall1.nii.gz"));
        let run = bench.rsph(&["run", "wall.toml"]);
        assert!(run.code == Some(2) && run.err.contains("too thin for its voxels"), "{}", run.err);
    }
}

#[test]
fn runs_do_what_they_should() {
    if let Some(bench) = bench_of("two-organs-one-label") {
        assert_eq!(bench.rsph(&["run", "two.toml", "--output", "o"]).code, Some(0));
        let load = summary(&bench, "o")["load"].as_array().unwrap()[2].as_f64().unwrap();
        // 7.8 cm2 of voxels; their rounded surface has less.
        assert!((-0.0078..-0.0072).contains(&load), "{load}");
    }
    if let Some(bench) = bench_of("resume-longer") {
        assert_eq!(bench.rsph(&["run", "dyn.toml", "--output", "o"]).code, Some(0));
        let longer = bench.rsph(&["run", "dyn.toml", "--output", "o", "--resume", "--set", "time.until=0.4"]);
        assert_eq!(longer.code, Some(0), "{}", longer.err);
        assert_eq!(summary(&bench, "o")["time"], 0.4);
    }
    if let Some(bench) = bench_of("small-strain-law-beyond-its-range") {
        assert_eq!(bench.rsph(&["run", "stretch.toml", "--output", "o"]).code, Some(0));
        let notes = summary(&bench, "o")["notes"].to_string();
        assert!(notes.contains("neo-hookean"), "{notes}");
    }
    if let Some(bench) = bench_of("static-neo-hookean") {
        let run = bench.rsph(&["run", "nh.toml", "--output", "o"]);
        assert_eq!(run.code, Some(0), "{}", run.err);
    }
    if let Some(bench) = bench_of("reaction-per-boundary") {
        let text = fs::read_to_string(bench.path("pull.toml")).unwrap();
        let named = ["foot", "grip"].into_iter().fold(text, |text, name| {
            text.replacen("[[boundary]]\n", &format!("[[BOUNDARY]]\nname = \"{name}\"\n"), 1)
        });
        bench.write("pull.toml", named.replace("BOUNDARY", "boundary"));
        assert_eq!(bench.rsph(&["run", "pull.toml", "--output", "o"]).code, Some(0));
        let readings = &summary(&bench, "o")["readings"];
        for (name, force) in [("foot_force_z", -1.0), ("grip_force_z", 1.0)] {
            let found = readings[name].as_f64().unwrap_or_else(|| panic!("{readings}"));
            assert!((found - force).abs() < 1e-3, "{name}: {found}");
        }
    }
}

#[test]
fn compliance_hardly_depends_on_the_spacing() {
    let Some(bench) = bench_of("locking-organ") else { return };
    let compliance = |particles: usize| {
        let set = format!("body.particles={particles}");
        let run = bench.rsph(&["run", "liver.toml", "--output", "o", "--force", "--set", &set]);
        assert_eq!(run.code, Some(0), "{}", run.err);
        summary(&bench, "o")["equilibrium"]["compliance"].as_f64().unwrap()
    };
    let found = [1000, 5000, 20_000].map(compliance);
    assert!(found.iter().all(|c| (c / found[2] - 1.0).abs() < 0.05), "{found:?}");
}

#[test]
fn a_light_beam_swings_to_twice_its_rest() {
    let Some(bench) = bench_of("neo-hookean-bending") else { return };
    assert_eq!(bench.rsph(&["run", "beam.toml", "--output", "o"]).code, Some(0));
    let text = fs::read_to_string(bench.path("o/probes.csv")).unwrap();
    let largest = text
        .lines()
        .filter_map(|line| line.split(',').nth(1)?.parse::<f64>().ok())
        .fold(0.0, |most: f64, value| most.max(value.abs()));
    assert!((largest / 8.061e-4 - 1.0).abs() < 0.1, "{largest}");
}
