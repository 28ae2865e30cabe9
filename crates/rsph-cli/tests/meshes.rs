//! Verbs on meshes and results: sample, info, surface.

mod common;

use common::{Bench, scenario};

/// A tetrahedron with its corner at the origin and unit edges, volume 1/6.
const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

#[test]
fn sample_counts_particles_and_compares_volumes() {
    let bench = Bench::new();
    bench.write("organ.obj", TETRAHEDRON);
    let done = bench.rsph(&["sample", "organ.obj", "--particles", "500", "--output", "p.csv"]);
    assert_eq!(done.code, Some(0), "{}", done.err);
    assert!(
        done.out.contains("4 triangles, closed") && done.out.contains("of the mesh's 0.1667"),
        "{}",
        done.out
    );
    let csv = std::fs::read_to_string(bench.path("p.csv")).unwrap();
    let volumes: Vec<f64> =
        csv.lines().skip(1).map(|l| l.split(',').nth(3).unwrap().parse().unwrap()).collect();
    assert!(done.out.contains(&format!("particles: {}", volumes.len())));
    let volume: f64 = volumes.iter().sum();
    assert!((volume * 6.0 - 1.0).abs() < 0.03, "{volume}");
    assert!((400..600).contains(&volumes.len()), "{}", volumes.len());
}

#[test]
fn sample_refuses_bad_meshes_and_numbers() {
    let bench = Bench::new();
    bench.write("organ.obj", TETRAHEDRON);
    bench.write("open.obj", TETRAHEDRON.replace("f 2 3 4\n", ""));
    bench.write("organ.xyz", TETRAHEDRON);
    let neither = bench.rsph(&["sample", "organ.obj"]);
    assert_eq!(neither.code, Some(2));
    assert!(neither.err.contains("--spacing <S>|--particles <N>"), "{}", neither.err);
    for (arguments, says) in [
        (["organ.obj", "--spacing", "0"], "--spacing"),
        (["organ.obj", "--spacing", "-1"], "--spacing"),
        (["organ.obj", "--spacing", "nan"], "--spacing"),
        (["organ.obj", "--spacing", "1e-9"], "--spacing"),
        (["organ.obj", "--particles", "0"], "--particles"),
        (["open.obj", "--particles", "100"], "3 open edges"),
        (["missing.stl", "--particles", "100"], "missing.stl"),
        (["organ.xyz", "--particles", "100"], "xyz"),
    ] {
        let done = bench.rsph(&[&["sample"], &arguments[..]].concat());
        assert_eq!(done.code, Some(2), "{arguments:?}: {}", done.err);
        assert!(done.err.contains(says), "{arguments:?}: no {says:?} in {}", done.err);
    }
}

#[test]
fn info_of_a_mesh_says_whether_it_is_closed() {
    let bench = Bench::new();
    bench.write("organ.obj", TETRAHEDRON);
    bench.write("open.obj", TETRAHEDRON.replace("f 2 3 4\n", ""));
    let closed = bench.rsph(&["info", "organ.obj"]);
    assert!(closed.out.contains("closed: yes") && closed.out.contains("volume: 0.1667"), "{}", closed.out);
    let open = bench.rsph(&["info", "open.obj"]);
    assert!(open.out.contains("closed: no, 3 open edges") && open.out.contains("body: none"), "{}", open.out);
    assert!(!closed.out.contains("part"), "{}", closed.out);
    bench.write("parts.obj", TETRAHEDRON.replace("f 2 3 4\n", "g slanted face\nf 2 3 4\n"));
    let parts = bench.rsph(&["info", "parts.obj"]);
    assert!(parts.out.contains("part \"slanted\": area 0.866"), "{}", parts.out);
    bench.write("broken.vtkhdf", "this is no HDF5 file");
    for file in ["broken.vtkhdf", "missing.vtkhdf", "missing.stl", "."] {
        let done = bench.rsph(&["info", file]);
        assert_eq!(done.code, Some(2), "{file}: {}", done.err);
        assert!(done.err.contains(file), "{file}: {}", done.err);
    }
}

/// A box of these edges as OBJ.
fn box_of([x, y, z]: [f64; 3]) -> String {
    let corner = |k: usize| [k % 2, k / 2 % 2, k / 4].map(|i| i as f64);
    let vertices: Vec<String> =
        (0..8).map(corner).map(|[i, j, k]| format!("v {} {} {}\n", i * x, j * y, k * z)).collect();
    vertices.concat() + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
}

#[test]
fn an_organ_of_your_own_runs_at_once() {
    let bench = Bench::new();
    bench.write("mm.obj", box_of([100.0, 80.0, 60.0]));
    bench.write("m.obj", box_of([0.1, 0.08, 0.06]));
    bench.write("cm.obj", box_of([3.0, 2.0, 2.0]));
    let weight = 1060.0 * 9.81 * 0.1 * 0.08 * 0.048;
    for (file, scale) in [("mm.obj", "scale = 0.001"), ("m.obj", "scale = 1")] {
        let new = bench.rsph(&["new", "--mesh", file]);
        assert!(
            new.out.contains("100.0 x 80.00 x 60.00 mm, 480.0 ml") && new.out.contains(scale),
            "{}",
            new.out
        );
        bench.write("mine.toml", new.out);
        let run =
            bench.rsph(&["run", "mine.toml", "--output", "o", "--force", "--set", "body.particles=500"]);
        assert_eq!(run.code, Some(0), "{}", run.err);
        let text = std::fs::read_to_string(bench.path("o/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        let load = summary["load"][2].as_f64().unwrap();
        assert!((load / -weight - 1.0).abs() < 1e-3, "{load} {weight}");
        assert!(summary["readings"]["tip"].as_f64().unwrap() < 0.0);
    }
    let unclear = bench.rsph(&["new", "--mesh", "cm.obj"]);
    assert!(unclear.code == Some(2) && unclear.err.contains("--scale"), "{}", unclear.err);
    let told = bench.rsph(&["new", "--mesh", "cm.obj", "--scale", "0.01"]);
    assert!(told.out.contains("30.00 x 20.00 x 20.00 mm"), "{}{}", told.out, told.err);
    assert_eq!(bench.rsph(&["new", "--mesh", "none.stl"]).code, Some(2));
}

#[test]
fn the_surface_of_a_run_comes_out_closed() {
    let bench = Bench::new();
    let file = scenario("tensile_liver");
    let set = ["--set", "time.until=0.02", "--set", "output.every=0.01", "--quiet", "--output", "o"];
    let run = bench.rsph(&[&["run", file.to_str().unwrap()], &set[..]].concat());
    assert_eq!(run.code, Some(0), "{}", run.err);

    let info = bench.rsph(&["info", "o/particles.vtkhdf"]);
    assert!(info.out.contains("frames: 3") && info.out.contains("points: 343"), "{}", info.out);
    assert!(info.out.contains("field: strain (symmetric tensor"), "{}", info.out);

    for output in ["s.stl", "s.ply", "s.obj", "s.vtp"] {
        let done = bench.rsph(&["surface", "o", "--step", "1", "--output", output]);
        assert_eq!(done.code, Some(0), "{output}: {}", done.err);
        assert!(done.out.contains("t = 0.01"), "{}", done.out);
    }
    let mesh = bench.rsph(&["info", "s.stl"]);
    assert!(mesh.out.contains("closed: yes") && mesh.out.contains("genus: 0"), "{}", mesh.out);

    for arguments in [["o", "--step", "9"], ["o", "--output", "s.xyz"], ["nowhere", "--step", "0"]] {
        let done = bench.rsph(&[&["surface"], &arguments[..]].concat());
        assert_eq!(done.code, Some(2), "{arguments:?}: {}", done.err);
    }
}
