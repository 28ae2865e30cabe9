//! Bad input is met at the door: exit code 2, a message with place, key, value and remedy, and
//! nothing written.

mod common;

use common::{Bench, Done, scenario, scenario_text};

/// Runs a shipped scenario after replacing `from` by `to` in its text.
fn run_edited(name: &str, from: &str, to: &str) -> (Bench, Done) {
    let text = scenario_text(name);
    assert!(text.contains(from), "{name} does not contain {from}");
    let bench = Bench::new();
    bench.write("case.toml", text.replacen(from, to, 1));
    let done = bench.rsph(&["run", "case.toml", "--output", "results"]);
    (bench, done)
}

fn refuses(name: &str, from: &str, to: &str, says: &[&str]) {
    let (bench, done) = run_edited(name, from, to);
    assert_eq!(done.code, Some(2), "{from} -> {to}: {}", done.err);
    for part in says {
        assert!(done.err.contains(part), "{from} -> {to}: no {part:?} in\n{}", done.err);
    }
    assert!(done.err.contains("help: "), "{from} -> {to}: no remedy in\n{}", done.err);
    assert!(!done.err.contains("panicked"), "{}", done.err);
    assert!(!bench.path("results").exists(), "{from} -> {to}: left a folder behind");
}

#[test]
fn unknown_keys_get_a_suggestion() {
    refuses(
        "tensile_liver",
        "young_modulus",
        "youngs_modulus",
        &[
            "case.toml:14:1",
            "material.youngs_modulus",
            "100.0",
            "unknown key",
            "did you mean `young_modulus`?",
        ],
    );
    refuses("tensile_liver", "particles", "partikles", &["`body.partikles`", "did you mean `particles`?"]);
    refuses("tensile_liver", "[solver]", "[solvr]", &["`solvr`", "did you mean `solver`?"]);
    refuses("tensile_liver", "from = 0.0", "form = 0.0", &["load[0].ramp.form", "did you mean `from`?"]);
    refuses("tensile_liver", "at = 1.0", "att = 1.0", &["load[0].region.plane.att", "did you mean `at`?"]);
    refuses("tensile_liver", "size =", "sizes =", &["body.shape.box.sizes", "did you mean `size`?"]);
}

#[test]
fn unknown_names_list_the_known() {
    refuses(
        "tensile_liver",
        "\"kelvin-voigt\"",
        "\"kelvin-voight\"",
        &["material.model", "kelvin-voight", "did you mean \"kelvin-voigt\"?"],
    );
    refuses("tensile_liver", "\"traction\"", "\"tractoin\"", &["load[0].kind", "did you mean \"traction\"?"]);
    refuses("tensile_liver", "\"rk4\"", "\"rk5\"", &["time.integrator", "\"rk4\""]);
    refuses("tensile_liver", "\"below\"", "\"under\"", &["boundary[0].region.plane.side", "\"above\""]);
    refuses(
        "tensile_liver",
        "\"displacement.z\"",
        "\"displacment.z\"",
        &["probe[0].quantity", "did you mean \"displacement.z\"?"],
    );
    refuses("tensile_liver", "\"displacement.z\"", "\"displacement.w\"", &["has the components x, y, z"]);
    refuses("tensile_liver", "{ box =", "{ boxx =", &["body.shape", "did you mean \"box\"?"]);
    refuses("liver_load", "\"liver\"", "\"livr\"", &["body.shape.organ", "\"liver\""]);
    refuses("tensile_liver", "[\"x\", \"y\", \"z\"]", "[\"x\", \"t\"]", &["boundary[0].fix", "\"t\""]);
}

#[test]
fn missing_keys_come_with_an_example() {
    refuses("tensile_liver", "until = 3.0", "", &["`time.until`", "missing in `time`", "`until = 3.0`"]);
    refuses(
        "tensile_liver",
        "young_modulus = 100.0",
        "",
        &["`material.young_modulus`", "missing in [material]"],
    );
    refuses("tensile_liver", "kind = \"clamp\"", "", &["`boundary[0].kind`", "`kind = \"clamp\"`"]);
    refuses(
        "tensile_liver",
        "traction = [0.0, 0.0, 1.0]",
        "",
        &["`load[0].traction`", "kind \"traction\" needs it"],
    );
    refuses("tensile_liver", "model = \"kelvin-voigt\"", "", &["`material.model`", "kelvin-voigt"]);
    refuses("tensile_liver", "particles = 343", "", &["body", "`particles = 1000`"]);
    refuses("tensile_liver", "kind = \"clamp\"", "kind = \"prescribed\"", &["`boundary[0].motion`", "ramp"]);
    let bench = Bench::new();
    bench.write("empty.toml", "");
    let done = bench.rsph(&["run", "empty.toml"]);
    assert_eq!(done.code, Some(2));
    assert!(done.err.contains("`body`") && done.err.contains("shape = "), "{}", done.err);
}

#[test]
fn wrong_types_say_what_is_allowed() {
    refuses(
        "tensile_liver",
        "until = 3.0",
        "until = \"long\"",
        &["time.until", "\"long\"", "a number is allowed"],
    );
    refuses(
        "tensile_liver",
        "dt = \"auto\"",
        "dt = \"fast\"",
        &["time.dt", "\"fast\"", "a number (s) or \"auto\""],
    );
    refuses(
        "tensile_liver",
        "particles = 343",
        "particles = -3",
        &["body.particles", "-3", "a whole number"],
    );
    refuses(
        "tensile_liver",
        "density = 1.0",
        "density = [1.0]",
        &["material.density", "a number is allowed"],
    );
    refuses("tensile_liver", "traction = [0.0, 0.0, 1.0]", "traction = [0.0, 1.0]", &["load[0].traction"]);
    refuses("tensile_liver", "[body]", "body = 3\n[bodi]", &["body"]);
    refuses("tensile_liver", "until = 3.0", "until = ", &["case.toml:36", "no valid TOML"]);
    refuses("tensile_liver", "until = 3.0", "until = 3.0\nuntil = 4.0", &["case.toml:37", "duplicate key"]);
}

#[test]
fn numbers_out_of_range_are_named() {
    refuses(
        "tensile_liver",
        "poisson_ratio = 0.3",
        "poisson_ratio = 0.5",
        &["case.toml:15:17", "0.5", "less than 0.5"],
    );
    refuses("tensile_liver", "density = 1.0", "density = nan", &["material.density", "nan", "finite"]);
    refuses("tensile_liver", "at = 0.0", "at = inf", &["boundary[0].region.plane.at", "finite"]);
    refuses(
        "hanging_column",
        "spacing = 0.0625",
        "spacing = -0.1",
        &["body.spacing", "-0.1", "greater than 0"],
    );
    refuses("tensile_liver", "particles = 343", "particles = 343\nspacing = 0.1", &["exclude each other"]);
    refuses("tensile_liver", "dt = \"auto\"", "dt = 0", &["time.dt", "must be positive"]);
    refuses("tensile_liver", "until = 3.0", "until = 0.0", &["time.until", "greater than 0"]);
    refuses("tensile_liver", "every = 0.05", "every = -1", &["output.every", "greater than 0"]);
    refuses("tensile_liver", "every = 0.05", "every = 1e-9", &["output.every", "frames"]);
    refuses("tensile_liver", "every = 0 ", "every = -10", &["remesh.every"]);
    refuses(
        "tensile_liver",
        "from = 0.0, to = 0.0",
        "from = 1.0, to = 0.5",
        &["load[0].ramp.to", "0.5", "earlier"],
    );
    refuses("tensile_liver", "smoothing = 1.25", "smoothing = 0", &["solver.smoothing", "greater than 0"]);
    refuses(
        "tensile_liver",
        "smoothing = 1.25",
        "smoothing = 1.25\nhourglass = -0.1",
        &["solver.hourglass", "0 or greater"],
    );
    refuses("tensile_liver", "[\"x\", \"y\", \"z\"]", "[]", &["boundary[0].fix", "at least one"]);
    refuses("tensile_liver", "\"extension\"", "\"a,b\"", &["probe[0].name", "commas"]);
    refuses("tensile_liver", "\"extension\"", "\"time\"", &["probe[0].name", "two columns"]);
    refuses("tensile_liver", "size = [1.0, 1.0", "size = [1.0, -1.0", &["body.shape.box.size[1]", "-1.0"]);
    refuses("liver_load", "[0.0, -1.0, 0.0]", "[0, 0, 0]", &["load[0].direction", "zero vector"]);
}

#[test]
fn keys_of_another_kind_are_refused() {
    refuses(
        "tensile_liver",
        "traction = [",
        "pressure = 3.0\ntraction = [",
        &["load[0].pressure", "does not belong", "`region`, `traction`"],
    );
    let motion = "motion = { oscillation = { amplitude = [1.0, 0.0, 0.0], frequency = 1.0 } }";
    refuses(
        "tensile_liver",
        "kind = \"clamp\"",
        &format!("kind = \"clamp\"\n{motion}"),
        &["boundary[0].motion", "does not move"],
    );
}

#[test]
fn a_missing_mesh_is_named_with_its_path() {
    refuses(
        "liver_visible_human",
        "../../shared/data/meshes/visible_human_liver_female.stl",
        "no/such.stl",
        &["body.shape.mesh", "no/such.stl"],
    );
}

#[test]
fn label_maps_that_show_no_body_are_named() {
    let shape = "shape = { organ = \"liver\" }";
    let missing = "labelmap = { path = \"no/such.nii.gz\", label = 2 }";
    refuses("liver_load", shape, missing, &["body.labelmap.path", "no/such.nii.gz"]);
    refuses("liver_load", shape, "labelmap = 3", &["body.labelmap", "the path of an image"]);
    refuses("liver_load", shape, "labelmap = { label = 3 }", &["body.labelmap", "path"]);
    let axes = "labelmap = { path = \"a.nii\", axes = \"patient\" }";
    refuses("liver_load", shape, axes, &["body.labelmap.axes", "image", "organ"]);
    let scale = "labelmap = { path = \"a.nii\", scale = -1.0 }";
    refuses("liver_load", shape, scale, &["body.labelmap.scale", "greater than 0"]);
    refuses(
        "liver_load",
        shape,
        "labelmap = { path = \"case.toml\" }",
        &["case.toml", "no NIfTI or NRRD file"],
    );
    let both = format!("{shape}\nlabelmap = \"a.nii\"");
    refuses("liver_load", shape, &both, &["body.labelmap", "exclude each other"]);
    refuses("liver_load", shape, "", &["body", "shape"]);
}

#[test]
fn a_missing_scenario_is_named() {
    let done = Bench::new().rsph(&["run", "nowhere.toml"]);
    assert_eq!(done.code, Some(2));
    assert!(done.err.contains("nowhere.toml") && done.err.contains("rsph new"), "{}", done.err);
}

#[test]
fn bad_edits_name_the_set() {
    let bench = Bench::new();
    let file = scenario("tensile_liver");
    for (set, says) in [
        ("time.untill=1", "did you mean `until`?"),
        ("load.5.ramp.to=1", "no entry 5"),
        ("time.until", "key.path=value"),
        ("material.poisson_ratio=0.6", "less than 0.5"),
        ("time.until=-1", "greater than 0"),
    ] {
        let done = bench.rsph(&["run", file.to_str().unwrap(), "--set", set]);
        assert_eq!(done.code, Some(2), "{set}: {}", done.err);
        assert!(done.err.contains(&format!("--set {set}")) && done.err.contains(says), "{set}: {}", done.err);
    }
    assert!(!bench.path("out").exists());
}

#[test]
fn the_output_folder_is_checked_before_computing() {
    let bench = Bench::new();
    let file = scenario("tensile_liver");
    bench.write("a_file", "");
    let done = bench.rsph(&["run", file.to_str().unwrap(), "--output", "a_file/deeper"]);
    assert_eq!(done.code, Some(2), "{}", done.err);
    assert!(done.err.contains("a_file") && done.err.contains("--output"), "{}", done.err);

    std::fs::create_dir(bench.path("old")).unwrap();
    bench.write("old/summary.json", "{}");
    let done = bench.rsph(&["run", file.to_str().unwrap(), "--output", "old"]);
    assert_eq!(done.code, Some(2), "{}", done.err);
    assert!(done.err.contains("summary.json") && done.err.contains("--force"), "{}", done.err);
}

#[test]
fn a_run_without_end_is_refused() {
    refuses("tensile_liver", "dt = \"auto\"", "dt = 1e-300", &["`time.until`", "steps; 1e12 are allowed"]);
    refuses("tensile_liver", "until = 3.0", "until = 1e300", &["`output.every`", "2.000e301 frames"]);
}

#[test]
fn a_scenario_in_its_own_output_folder_is_not_overwritten() {
    let bench = Bench::new();
    bench.write("results/scenario.toml", scenario_text("tensile_liver"));
    let done = bench.rsph(&["run", "results/scenario.toml", "--output", "results", "--force"]);
    assert_eq!(done.code, Some(2), "{}", done.err);
    assert!(done.err.contains("lies in its own output folder"), "{}", done.err);
    let kept = std::fs::read_to_string(bench.path("results/scenario.toml")).unwrap();
    assert_eq!(kept, scenario_text("tensile_liver"));
}

#[test]
fn what_has_no_place_in_a_prescribed_motion_is_refused() {
    let name = "deformation";
    refuses(name, "velocity = \"leveque\"", "", &["`dynamics.velocity`", "needs it"]);
    refuses(name, "\"leveque\"", "\"levek\"", &["dynamics.velocity", "leveque"]);
    refuses(name, "iso = 0.25", "iso = 1.5", &["`dynamics.iso`", "between 0 and 1"]);
    refuses(name, "iso = 0.25", "iso = 0.25\nband = -1", &["`dynamics.band`", "between 0"]);
    refuses(name, "iso = 0.25", "iso = 0.25\nreversal = 0", &["`dynamics.reversal`", "positive"]);
    refuses(name, "dt = 0.02", "dt = 0.5", &["`time.dt`", "at most"]);
    refuses(
        name,
        "[time]",
        "[[load]]\nkind = \"body_force\"\nacceleration = [0, 0, 1]\n[time]",
        &["`load`", "prescribed"],
    );
    refuses(
        name,
        "[time]",
        "[[probe]]\nname = \"s\"\nquantity = \"stress.xx\"\nregion = \"all\"\n[time]",
        &["`probe[0].quantity`", "colour"],
    );
    refuses(
        name,
        "[time]",
        "[[probe]]\nname = \"volume_inside\"\nquantity = \"colour\"\nregion = \"all\"\n[time]",
        &["`probe[0].name`", "two columns"],
    );
    refuses(name, "[time]", "[remesh]\nkernel = \"m4\"\n[time]", &["remesh.kernel", "m4-prime"]);
    let restored = "[remesh]\nrestore_level_set = true\n[time]";
    refuses(name, "[time]", restored, &["`remesh.restore_level_set`", "belongs to a solid"]);
}

#[test]
fn what_has_no_place_in_a_solid_is_refused() {
    let name = "tensile_liver";
    refuses(name, "[time]", "[dynamics]\niso = 0.5\n[time]", &["`dynamics.iso`", "prescribed"]);
    refuses(name, "\"displacement.z\"", "\"colour\"", &["`probe[0].quantity`", "no colour"]);
    let table = "[material]\nmodel = \"kelvin-voigt\"\ndensity = 1.0\nyoung_modulus = 100.0       # 0.1 MPa\n\
                 poisson_ratio = 0.3\nrelaxation_time = 0.2\n";
    refuses(name, table, "", &["`material`", "missing", "model = \"kelvin-voigt\""]);
}
