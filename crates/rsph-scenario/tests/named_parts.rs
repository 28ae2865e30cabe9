//! Boundaries, loads and probes on named and painted parts of mesh files.

#![allow(clippy::format_push_string, clippy::format_collect)]

use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use rsph_scenario::mesh_io::read_mesh_with_parts;
use rsph_scenario::scenario::LoadedScenario;
use std::fs;
use std::path::Path;

const CORNERS: [[u8; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
/// The faces of a unit cube as squares, from below to above.
const FACES: [(&str, [usize; 4]); 6] = [
    ("lower", [0, 3, 2, 1]),
    ("front", [0, 1, 5, 4]),
    ("right", [1, 2, 6, 5]),
    ("back", [2, 3, 7, 6]),
    ("left", [3, 0, 4, 7]),
    ("upper", [4, 5, 6, 7]),
];

/// The cube as OBJ, in millimetres: a group a face, all sides one object, the upper face of another material.
fn obj() -> String {
    let mut text = "mtllib none.mtl\n".to_owned();
    for [x, y, z] in CORNERS {
        text += &format!("v {x}e3 {y}e3 {z}e3\n");
    }
    for (name, corners) in FACES {
        let object = if ["lower", "upper"].contains(&name) { "ends" } else { "sides of it" };
        let material = if name == "upper" { "red" } else { "grey" };
        let numbers = corners.map(|v| format!(" {}", v + 1)).concat();
        text += &format!("o {object}\ng {name}\nusemtl {material}\nf{numbers}\n");
    }
    text
}

/// The same as PLY in metres, with coloured faces and a whole number a face.
fn painted_faces() -> String {
    let mut text = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
                    element face 6\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\n\
                    property uchar blue\nproperty int label\nend_header\n"
        .to_owned();
    text += &CORNERS.map(|[x, y, z]| format!("{x} {y} {z}\n")).concat();
    for (number, (name, corners)) in FACES.iter().enumerate() {
        let colour = if *name == "upper" { "255 0 0" } else { "200 200 200" };
        let numbers = corners.map(|v| format!(" {v}")).concat();
        text += &format!("4{numbers} {colour} {number}\n");
    }
    text
}

/// The same with coloured vertices: red on the upper face.
fn painted_vertices() -> String {
    let mut text =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
                    property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
                    element face 6\nproperty list uchar int vertex_indices\nend_header\n"
            .to_owned();
    for [x, y, z] in CORNERS {
        text += &format!("{x} {y} {z} {} 255\n", if z == 1 { "255 0 0" } else { "0 128 255" });
    }
    text + &FACES.map(|(_, corners)| format!("4{}\n", corners.map(|v| format!(" {v}")).concat())).concat()
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in
        [("cube.obj", obj()), ("faces.ply", painted_faces()), ("vertices.ply", painted_vertices())]
    {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

#[test]
fn parts_are_named_by_groups_objects_materials_colours_and_numbers() {
    let folder = folder();
    let read = |name: &str| read_mesh_with_parts(&folder.path().join(name), 1.0).unwrap();
    let obj = read("cube.obj");
    let names: Vec<&str> = obj.parts.keys().map(String::as_str).collect();
    let wanted = ["back", "ends", "front", "grey", "left", "lower", "red", "right", "sides of it", "upper"];
    assert_eq!(names, wanted);
    assert_eq!(obj.parts["red"], obj.parts["upper"]);
    assert_eq!((obj.parts["grey"].len(), obj.parts["sides of it"].len()), (10, 8));
    assert_eq!(obj.area_and_centre("upper"), (1e6, Vec3::new(500.0, 500.0, 1000.0)));

    let faces = read("faces.ply");
    assert_eq!(faces.area_and_centre("#ff0000"), (1.0, Vec3::new(0.5, 0.5, 1.0)));
    assert_eq!(faces.parts["label=5"], faces.parts["#ff0000"]);
    assert_eq!((faces.parts.len(), faces.parts["#c8c8c8"].len()), (8, 10));

    // A triangle has the colour of two or more of its corners.
    let vertices = read("vertices.ply");
    let (area, _) = vertices.area_and_centre("#ff0000");
    assert_eq!((vertices.parts.len(), area), (2, 3.0));
}

const SCENARIO: &str = r#"
    body = { shape = { mesh = { path = "cube.obj", scale = 0.001 } }, spacing = 0.2 }
    solver = { mode = "static" }
    time = { until = 1.0 }
    [material]
    model = "kelvin-voigt"
    density = 1.0
    young_modulus = 100.0
    poisson_ratio = 0.3
    relaxation_time = 0.0
    [[boundary]]
    kind = "clamp"
    region = LOWER
    [[load]]
    kind = "traction"
    traction = [1, 0, 1]
    region = UPPER
    [[probe]]
    name = "extension"
    quantity = "displacement.z"
    region = UPPER
"#;

fn scenario(lower: &str, upper: &str, sets: &[&str], folder: &Path) -> LoadedScenario {
    let text = SCENARIO.replace("LOWER", lower).replace("UPPER", upper);
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    LoadedScenario::from_text("parts.toml", text, folder.into(), &sets).unwrap()
}

fn extension_and_load(lower: &str, upper: &str, sets: &[&str], folder: &Path) -> (f64, Vec3) {
    let job = scenario(lower, upper, sets, folder).lower().unwrap();
    let mut body = Simulation::new(job.setup).unwrap();
    let found = body.solve_static(1.0, &mut |_, _| true).unwrap();
    (body.readings()[0].value, found.load)
}

#[test]
fn parts_hold_and_load_what_geometry_does() {
    let folder = folder();
    let run = |lower: &str, upper: &str, sets: &[&str]| extension_and_load(lower, upper, sets, folder.path());
    let patch = |z: f64, facing: f64| {
        format!(
            "{{ surface_patch = {{ centre = [0.5, 0.5, {z}], radius = 2.0, facing = [0, 0, {facing}] }} }}"
        )
    };
    let (expected, load) = run(&patch(0.0, -1.0), &patch(1.0, 1.0), &[]);
    assert!((load - Vec3::new(1.0, 0.0, 1.0)).norm() < 1e-9 && expected > 0.005, "{expected} {load}");
    for upper in [
        "{ part = \"upper\" }",
        "{ part = { name = \"#ff0000\", path = \"faces.ply\", scale = 1.0 } }",
        "{ part = { name = [\"label=5\"], path = \"faces.ply\", scale = 1.0 } }",
        "{ and = [{ part = \"ends\" }, { not = { part = \"lower\" } }] }",
        "{ and = [{ part = [\"upper\", \"left\"] }, { part = \"red\" }] }",
    ] {
        let found = run("{ part = \"lower\" }", upper, &[]);
        assert!(
            (found.0 / expected - 1.0).abs() < 1e-9 && (found.1 - load).norm() < 1e-9,
            "{upper}: {found:?}"
        );
    }
    // A body that is no mesh, on the parts of one.
    let of_file = "{ part = { name = \"upper\", path = \"cube.obj\", scale = 0.001 } }";
    let lower = "{ part = { name = \"lower\", path = \"cube.obj\", scale = 0.001 } }";
    let (found, load) = run(lower, of_file, &["body.shape={ box = { size = [1.0, 1.0, 1.0] } }"]);
    assert!((found / expected - 1.0).abs() < 0.01 && (load.z - 1.0).abs() < 1e-9, "{found} {load}");
}

#[test]
fn what_a_clamp_cuts_off_is_not_loaded() {
    let folder = folder();
    let cut = "{ plane = { axis = \"z\", at = 0.3, side = \"below\" } }";
    let (_, load) = extension_and_load(cut, "{ part = \"right\" }", &[], folder.path());
    assert!((load.x - 0.7).abs() < 1e-3 && (load.z - 0.7).abs() < 1e-3, "{load}");
}

#[test]
fn parts_of_a_mesh_that_had_to_be_closed() {
    let folder = folder();
    // A triangle of the front is missing.
    let open = obj().replace("g front\nusemtl grey\nf 1 2 6 5\n", "g front\nusemtl grey\nf 1 2 6\n");
    assert_ne!(open, obj());
    fs::write(folder.path().join("open.obj"), open).unwrap();
    let sets = ["body.shape.mesh.path=\"open.obj\""];
    let (_, load) = extension_and_load("{ part = \"lower\" }", "{ part = \"upper\" }", &sets, folder.path());
    assert!((load.z - 1.0).abs() < 0.03, "{load}");
}

#[test]
fn parts_that_are_not_there_are_refused_with_those_that_are() {
    let folder = folder();
    let refused = |upper: &str, sets: &[&str]| {
        let error = scenario("{ part = \"lower\" }", upper, sets, folder.path()).lower().unwrap_err();
        format!("{error}; {}", error.remedy)
    };
    let unknown = refused("{ part = \"top\" }", &[]);
    assert!(
        unknown.contains("load[0].region.part") && unknown.contains("cube.obj has no part \"top\""),
        "{unknown}"
    );
    assert!(unknown.contains("\"upper\"") && unknown.contains("\"sides of it\""), "{unknown}");
    let near = refused("{ part = [\"uper\"] }", &[]);
    assert!(near.contains("did you mean \"upper\"?"), "{near}");
    let none = refused("{ part = [] }", &[]);
    assert!(none.contains("at least one name"), "{none}");
    let no_mesh = refused("{ part = \"upper\" }", &["body.shape={ organ = \"liver\" }"]);
    assert!(no_mesh.contains("the body is none") && no_mesh.contains("path = "), "{no_mesh}");
    let no_file = refused("{ part = { name = \"upper\", path = \"no.obj\" } }", &[]);
    assert!(no_file.contains("load[0].region.part.path") && no_file.contains("no.obj"), "{no_file}");
    let no_scale = refused("{ part = { name = \"upper\", path = \"cube.obj\", scale = -1.0 } }", &[]);
    assert!(no_scale.contains("load[0].region.part.scale"), "{no_scale}");
    let misspelt = LoadedScenario::from_text(
        "parts.toml",
        SCENARIO.replace("LOWER", "{ part = { nam = \"upper\" } }").replace("UPPER", "\"all\""),
        folder.path().into(),
        &[],
    );
    assert!(misspelt.unwrap_err().to_string().contains("nam"));
}

#[test]
fn a_stored_scenario_finds_its_parts_from_anywhere() {
    let folder = folder();
    let upper = "{ not = { or = [{ part = { name = \"#ff0000\", path = \"faces.ply\", scale = 1.0 } }] } }";
    let first = scenario("{ part = \"lower\" }", upper, &[], folder.path());
    let text = first.as_run_anywhere();
    LoadedScenario::from_text("again.toml", text, "elsewhere".into(), &[]).unwrap().lower().unwrap();
}
