//! Several materials in one body, through scenario files: by region, shape, label of a label map, and maps of moduli.

use rsph_core::particles::Field;
use rsph_core::simulation::Simulation;
use rsph_scenario::scenario::LoadedScenario;
use std::path::Path;

/// A NIfTI-1 image of bytes with voxels of 100 mm, the first around the origin.
fn image(size: [i16; 3], voxel: impl Fn(usize, usize, usize) -> u8) -> Vec<u8> {
    let mut raw = vec![0; 352];
    let mut put = |at: usize, bytes: &[u8]| raw[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    for (i, n) in [3, size[0], size[1], size[2], 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * i, &n.to_le_bytes());
    }
    put(70, &2_i16.to_le_bytes());
    put(108, &352.0_f32.to_le_bytes());
    put(123, &[2]);
    put(254, &1_i16.to_le_bytes());
    for i in 0..3 {
        put(280 + 20 * i, &100.0_f32.to_le_bytes());
    }
    put(344, b"n+1\0");
    let [nx, ny, nz] = size.map(|n| n as usize);
    raw.extend((0..nx * ny * nz).map(|n| voxel(n % nx, n / nx % ny, n / nx / ny)));
    raw
}

const MATERIAL: &str = "model = \"kelvin-voigt\"\ndensity = 1000.0\nyoung_modulus = 100.0\npoisson_ratio = 0.0\nrelaxation_time = 0.0\n";

/// A bar along x of unit length that is pulled by 1 Pa, with those tables for its body and materials.
fn stretch(body: &str, materials: &str, from: f64, folder: &Path) -> (f64, Vec<f64>) {
    let face =
        |at: f64, side: &str| format!("{{ plane = {{ axis = \"x\", at = {at}, side = \"{side}\" }} }}");
    let (foot, end) = (face(from, "below"), face(from + 1.0, "above"));
    let text = format!(
        "{body}\nsolver = {{ mode = \"static\" }}\ntime = {{ until = 1.0 }}\n{materials}
        [[boundary]]\nkind = \"clamp\"\nregion = {foot}
        [[load]]\nkind = \"traction\"\nregion = {end}\ntraction = [1.0, 0.0, 0.0]
        [[probe]]\nname = \"end\"\nquantity = \"displacement.x\"\nregion = {end}\n"
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
        let (found, material) = stretch(body, &materials, 0.0, folder.path());
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
    // The first voxel of the body begins at .05; its surface is rounded at the edges of the voxels.
    let (found, material) = stretch(body, &materials, 0.05, folder.path());
    assert!((found / 0.0055 - 1.0).abs() < 0.03, "{found}");
    let stiff = material.iter().filter(|m| **m > 0.5).count();
    assert_eq!(2 * stiff, material.len());

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
    let (found, _) = stretch(body, &materials, 0.0, folder.path());
    let exact = 0.4 / 100.0 + 0.1 * 2.0_f64.ln() / 100.0 + 0.5 / 200.0;
    assert!((found / exact - 1.0).abs() < 0.01, "{found} {exact}");
}
