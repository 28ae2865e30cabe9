//! Real organs, where their meshes are at hand: sampled volume, and a surface in one closed piece.

use rsph_core::sample::{Resolution, sample};
use rsph_core::shape::{MeshShape, Shape, organ};
use rsph_core::tensor::Vec3;
use rsph_scenario::mesh_io::read_mesh;
use std::path::PathBuf;

/// Volume inside of the capsule and the bare area of `VH_F_Liver.glb`, in metres (validation/imperfect/README.md).
const CAPSULE: f64 = 2.1382e-3;

/// The path of a mesh beside the repository; `None`, with a message, if it is absent.
fn mesh_path(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/meshes").join(name);
    if !path.is_file() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

fn real_organ(name: &str) -> Option<MeshShape> {
    let mesh = read_mesh(&mesh_path(name)?, 1.0).unwrap();
    let (shape, notes) = MeshShape::new(&mesh, name).unwrap();
    assert!(notes.is_empty());
    Some(shape)
}

/// Samples at the counts of the paper and above, prints what comes out, and checks it.
fn check(shape: &dyn Shape) {
    for count in [144, 1_000, 5_000, 20_000] {
        let start = std::time::Instant::now();
        let body = sample(shape, Resolution::Particles(count), &[]).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        let found = body.cells.len();
        let volume = body.volume() / shape.volume() - 1.0;
        let surface = body.surface.volume() / shape.volume() - 1.0;
        println!(
            "{} {count}: {found} particles, dx {:.5}, volume {:+.2} %, surface {:+.2} %, {} triangles, dropped \
             {:.1e}, {seconds:.2} s",
            shape.name(),
            body.grid.spacing,
            100.0 * volume,
            100.0 * surface,
            body.surface.triangles.len(),
            body.dropped_volume
        );
        // Some counts do not occur: a nearly symmetric body gains particles in pairs of pairs.
        assert!(found.abs_diff(count) <= (count / 500).max(6), "{found}");
        assert!(volume.abs() < if count < 1_000 { 0.06 } else { 0.03 }, "{volume}");
        assert!(body.surface.is_closed());
        assert_eq!((body.surface.components(), body.surface.genus()), (1, Some(0)));
        assert!(body.surface.volume() > 0.0);
        assert_eq!(body.level_set.len(), found);
    }
}

#[test]
fn real_liver() {
    if let Some(liver) = real_organ("visible_human_liver_female.stl") {
        assert!((liver.volume() / 2.245e-3 - 1.0).abs() < 0.01);
        assert_eq!(sample(&liver, Resolution::Particles(144), &[]).unwrap().cells.len(), 144);
        check(&liver);
    }
}

#[test]
fn real_kidney() {
    if let Some(kidney) = real_organ("visible_human_kidney_left_male.stl") {
        check(&kidney);
    }
}

#[test]
fn analytic_organs() {
    check(&organ("liver").unwrap());
    check(&organ("kidney").unwrap());
}

#[test]
fn the_sign_of_the_distance_agrees_with_the_fractions() {
    let Some(liver) = real_organ("visible_human_liver_female.stl") else { return };
    let body = sample(&liver, Resolution::Particles(5_000), &[]).unwrap();
    for (fraction, phi) in body.fraction.iter().zip(&body.level_set) {
        let reach = 0.87 * body.grid.spacing;
        assert!(*phi < reach);
        if *phi < -reach {
            assert!(*fraction > 0.999, "{fraction} at {phi}");
        }
    }
    assert!(liver.signed_distance(&Vec3::new(0.0, 1.0, 0.0)) > 0.9);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let liver = organ("liver").unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| sample(&liver, Resolution::Particles(3_000), &[]).unwrap())
    };
    let (one, two) = (on(1), on(2));
    assert_eq!((one.grid, one.cells, one.fraction), (two.grid, two.cells, two.fraction));
    assert_eq!((one.level_set, one.surface), (two.level_set, two.surface));
}

#[test]
fn a_liver_of_open_overlapping_parts_becomes_one() {
    let Some(path) = mesh_path("VH_F_Liver.glb") else { return };
    let mesh = read_mesh(&path, 1.0).unwrap();
    let closed_only = MeshShape::new_closed(&mesh, "mesh VH_F_Liver.glb").unwrap_err();
    assert!(closed_only.problem.contains("open edges"), "{closed_only}");
    let begun = std::time::Instant::now();
    let (shape, notes) = MeshShape::new(&mesh, "mesh VH_F_Liver.glb").unwrap();
    let repaired = begun.elapsed().as_secs_f64();
    let body = sample(&shape, Resolution::Particles(5_000), &[]).unwrap();
    println!(
        "{} triangles; repaired in {repaired:.2} s; shape {:.6e}, {} particles {:.6e}\n{}",
        mesh.triangles.len(),
        shape.volume(),
        body.cells.len(),
        body.volume(),
        notes.join("\n")
    );
    // Issue 8; the reference is a wrap that lies a millimetre outside.
    assert!((body.volume() / 2.245e-3 - 1.0).abs() < 0.05);
    // Capsule and bare area, two of the parts, share their rims and enclose this by the divergence theorem.
    assert!((shape.volume() / CAPSULE - 1.0).abs() < 5e-3);
    assert_eq!((body.surface.components(), shape.surface().components()), (1, 1));
    assert!(body.dropped_volume == 0.0);
    let repair = shape.repair().unwrap();
    assert!(repair.uncertain < 0.01 && repair.made_up < 0.01, "{repair:?}");
}
