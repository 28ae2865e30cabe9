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
