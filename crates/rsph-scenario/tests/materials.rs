//! Several materials in one body, through scenario files: by region, shape, label of a label map, and maps of moduli.

mod common;

use rsph_core::particles::Field;
use rsph_core::simulation::Simulation;
use rsph_scenario::scenario::LoadedScenario;
use std::path::Path;

/// Voxels of 100 mm, the first around the origin.
fn image(size: [i16; 3], voxel: impl Fn(usize, usize, usize) -> u8) -> Vec<u8> {
    let [nx, ny, nz] = size.map(|n| n as usize);
    let voxels: Vec<u8> = (0..nx * ny * nz).map(|n| voxel(n % nx, n / nx % ny, n / nx / ny)).collect();
    common::nifti(size, 100.0, [0.0; 3], &voxels)
}

const MATERIAL: &str = "model = \"kelvin-voigt\"\ndensity = 1000.0\nyoung_modulus = 100.0\npoisson_ratio = 0.0\nrelaxation_time = 0.0\n";

/// What pulls a bar along x of unit length by 1 Pa.
const TRACTION: &str = "kind = \"traction\"\nregion = { plane = { axis = \"x\", at = 1.0, side = \"above\" } }\n\
                        traction = [1.0, 0.0, 0.0]";

/// The displacement of the point (x, y, y) at the end of a bar that is held at its `foot`, and the numbers of the materials, with those
/// tables for its body, its materials and what pulls it.
fn stretch(
    body: &str,
    materials: &str,
    load: &str,
    [foot, x, y]: [f64; 3],
    folder: &Path,
) -> (f64, Vec<f64>) {
    let text = format!(
        "{body}\nsolver = {{ mode = \"static\" }}\ntime = {{ until = 1.0 }}\n{materials}
        [[boundary]]\nkind = \"clamp\"\nregion = {{ plane = {{ axis = \"x\", at = {foot}, side = \"below\" }} }}
        [[load]]\n{load}
        [[probe]]\nname = \"end\"\nquantity = \"displacement.x\"\nregion = {{ point = [{x}, {y}, {y}] }}\n",
    );
    let loaded = LoadedScenario::from_text("bar.toml", text, folder.to_path_buf(), &[]).unwrap();
    let anywhere = loaded.as_run_anywhere();
    let loaded = LoadedScenario::from_text("bar.toml", anywhere, "/".into(), &[]).unwrap();
    let mut simulation = Simulation::new(loaded.lower().unwrap().setup).unwrap();
    simulation.solve_static(1.0, &mut |_, _| true).unwrap();
    let snapshot = simulation.snapshot();
    let material = if snapshot.particles.has(Field::Material) {
        snapshot.column(Field::Material).values().to_vec()
    } else {
        Vec::new()
    };
    (simulation.readings()[0].value, material)
}

#[test]
fn a_region_and_a_shape_say_where_a_material_is() {
    let folder = tempfile::tempdir().unwrap();
    let body = "body = { shape = { box = { size = [1.0, 0.25, 0.25] } }, spacing = 0.05 }";
    for place in [
        "region = { plane = { axis = \"x\", at = 0.5, side = \"above\" } }",
        "shape = { box = { size = [1.0, 1.0, 1.0], corner = [0.5, -0.3, -0.3] } }",
    ] {
        let stiff = MATERIAL.replace("100.0\np", "1000.0\np");
        let materials = format!("[[material]]\n{MATERIAL}\n[[material]]\nname = \"stiff\"\n{place}\n{stiff}");
        let (found, material) = stretch(body, &materials, TRACTION, [0.0, 1.0, 0.125], folder.path());
        assert!((found / 0.0055 - 1.0).abs() < 0.01, "{place}: {found}");
        let stiff = material.iter().filter(|m| **m > 0.5).count();
        assert_eq!((material.len(), stiff), (500, 250));
    }
}

#[test]
fn labels_with_names_are_one_body_of_several_materials() {
    let folder = tempfile::tempdir().unwrap();
    // Voxels 0 to 9 along x are two materials, with nothing beside them.
    let label = |i: usize, j: usize, k: usize| match i {
        _ if !(1..5).contains(&j) || !(1..5).contains(&k) || !(1..11).contains(&i) => 0,
        1..=5 => 6,
        _ => 7,
    };
    std::fs::write(folder.path().join("labels.nii"), image([12, 6, 6], label)).unwrap();
    let body = "body = { labelmap = { path = \"labels.nii\", labels = { 6 = \"soft\", 7 = \"stiff\" } }, spacing = 0.05 }";
    let stiff = MATERIAL.replace("100.0\np", "1000.0\np");
    let materials =
        format!("[[material]]\nname = \"soft\"\n{MATERIAL}\n[[material]]\nname = \"stiff\"\n{stiff}");
    // The body reaches from .05 to 1.05, with rounded ends, and is held and cut at .15. Its own weight, of 1 Pa a metre, pulls it.
    let weight = "kind = \"body_force\"\nregion = \"all\"\nacceleration = [0.001, 0.0, 0.0]";
    let end = [0.15, 1.05, 0.25];
    let (found, material) = stretch(body, &materials, weight, end, folder.path());
    // Against the same body of one material: what the rounded end lacks counts for both.
    let one = stretch(body, &materials.replace("1000.0\np", "100.0\np"), weight, end, folder.path()).0;
    let exact = (0.5 * (0.9_f64.powi(2) - 0.5_f64.powi(2)) / 100.0 + 0.125 / 1000.0) / (0.405 / 100.0);
    assert!((found / one / exact - 1.0).abs() < 0.02, "{found} {one} {exact}");
    let stiff = material.iter().filter(|m| **m > 0.5).count();
    // Five of nine, less the rounded end.
    let share = stiff as f64 / material.len() as f64;
    assert!((0.5..0.57).contains(&share), "{share}");

    let text = "body = { labelmap = { path = \"labels.nii\", labels = { 6 = \"soft\", 7 = \"stiff\" } }, spacing = 0.05 }
        time = { until = 1.0 }\n[[material]]\nname = \"soft\"\nregion = \"all\"\n"
        .to_owned()
        + MATERIAL;
    let loaded = LoadedScenario::from_text("bar.toml", text, folder.path().to_path_buf(), &[]).unwrap();
    let error = loaded.lower().unwrap_err().to_string();
    assert!(error.contains("label 7 is \"stiff\", and there is no material of that name"), "{error}");
}

#[test]
fn a_map_of_moduli_scales_the_law() {
    let folder = tempfile::tempdir().unwrap();
    // 100 Pa up to x = .45 and 200 Pa from .55 on, linear between the centres of the voxels there.
    std::fs::write(folder.path().join("moduli.nii"), image([12, 4, 4], |i, _, _| if i < 5 { 1 } else { 2 }))
        .unwrap();
    let body = "body = { shape = { box = { size = [1.0, 0.25, 0.25] } }, spacing = 0.05 }";
    let materials = format!("[material]\nmodulus = {{ path = \"moduli.nii\", factor = 100.0 }}\n{MATERIAL}");
    let (found, _) = stretch(body, &materials, TRACTION, [0.0, 1.0, 0.125], folder.path());
    let exact = 0.4 / 100.0 + 0.1 * 2.0_f64.ln() / 100.0 + 0.5 / 200.0;
    assert!((found / exact - 1.0).abs() < 0.01, "{found} {exact}");
}
