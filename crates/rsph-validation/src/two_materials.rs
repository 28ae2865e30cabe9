//! A stiff tumour in an organ from a segmentation of two labels, against finite elements (`validation/two_materials/reference.py`).

use crate::Row;
use rsph_core::particles::Field;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use rsph_scenario::scenario::LoadedScenario;
use std::path::Path;

/// The segmentation.
const LABELS: &[u8] = include_bytes!("../../../validation/two_materials/tumour.nii.gz");
/// The figures of the finite elements.
const REFERENCE: &str = include_str!("../../../validation/two_materials/reference.json");
/// Loads: name, acceleration (m/s^2), the axis along which it moves the body.
const LOADS: [(&str, &str, usize); 2] = [("pulled", "[1.0, 0.0, 0.0]", 0), ("bent", "[0.0, 0.0, -0.2]", 2)];

/// The organ under its weight along x and against z.
pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    std::fs::create_dir_all(folder).map_err(|e| e.to_string())?;
    std::fs::write(folder.join("tumour.nii.gz"), LABELS).map_err(|e| e.to_string())?;
    let reference: serde_json::Value = serde_json::from_str(REFERENCE).map_err(|e| e.to_string())?;
    let particles = if quick { 5000 } else { 20_000 };
    let mut rows = Vec::new();
    for nu in [0.3, 0.45] {
        for (load, acceleration, axis) in LOADS {
            // The finest mesh is the last.
            let case = format!("kelvin-voigt, nu {nu}, {load}");
            let meshes = reference["cases"][&case].as_array().ok_or("the reference lacks a case")?;
            let exact = meshes.last().ok_or("the reference lacks a mesh")?;
            let numbers = |key: &str| -> Vec<f64> {
                exact[key]
                    .as_array()
                    .map_or(Vec::new(), |v| v.iter().filter_map(serde_json::Value::as_f64).collect())
            };
            let found = at_rest(particles, nu, acceleration, folder)?;
            let name = |of: &str| format!("tumour, nu = {nu}, {load}: {of}");
            let mean = numbers("mean_displacement")[axis];
            rows.push(Row::within(name("mean displacement"), found.mean[axis], mean, 3.0, "m"));
            let mean = numbers("tumour_mean_displacement")[axis];
            rows.push(Row::within(name("displacement of the tumour"), found.of_tumour[axis], mean, 3.0, "m"));
            let strain = numbers("tumour_mean_strain");
            let largest = (0..6).fold(0, |k, c| if strain[c].abs() > strain[k].abs() { c } else { k });
            let what = ["xx", "yy", "zz", "xy", "yz", "xz"][largest];
            rows.push(Row::within(
                name(&format!("mean strain {what} in the tumour")),
                found.strain[largest],
                strain[largest],
                10.0,
                "1",
            ));
        }
    }
    Ok(rows)
}

/// Means over the body and over the particles in the tumour.
struct Found {
    mean: Vec3,
    of_tumour: Vec3,
    strain: [f64; 6],
}

fn at_rest(particles: usize, nu: f64, acceleration: &str, folder: &Path) -> Result<Found, String> {
    let material = |name: &str, modulus: f64| {
        format!(
            "[[material]]\nname = \"{name}\"\nmodel = \"kelvin-voigt\"\ndensity = 1000.0\nyoung_modulus = {modulus:?}
            poisson_ratio = {nu}\nrelaxation_time = 0.0\n"
        )
    };
    let text = format!(
        "body = {{ labelmap = {{ path = \"tumour.nii.gz\", labels = {{ 1 = \"parenchyma\", 2 = \"tumour\" }} }}, particles = {particles} }}
        solver = {{ mode = \"static\" }}\ntime = {{ until = 1.0 }}
        {}{}
        [[boundary]]\nkind = \"clamp\"\nregion = {{ plane = {{ axis = \"x\", at = -0.056, side = \"below\" }} }}
        [[load]]\nkind = \"body_force\"\nregion = \"all\"\nacceleration = {acceleration}\n",
        material("parenchyma", 5e3),
        material("tumour", 5e4),
    );
    let loaded = LoadedScenario::from_text("tumour.toml", text, folder.to_path_buf(), &[]);
    let job = loaded.and_then(|scenario| scenario.lower()).map_err(|e| e.to_string())?;
    let mut body = Simulation::new(job.setup).map_err(|e| e.to_string())?;
    body.solve_static(1.0, &mut |_, _| true).map_err(|e| e.to_string())?;
    let snapshot = body.snapshot();
    let column = |field| snapshot.column(field);
    let (u, e) = (column(Field::Displacement), column(Field::Strain));
    let material = column(Field::Material).values();
    let volume = column(Field::Volume).values();
    let mut found = Found { mean: Vec3::zeros(), of_tumour: Vec3::zeros(), strain: [0.0; 6] };
    let (mut all, mut inside) = (0.0, 0.0);
    for (a, v) in volume.iter().enumerate() {
        (all, found.mean) = (all + v, found.mean + u.vector(a) * *v);
        if material[a] > 0.5 {
            (inside, found.of_tumour) = (inside + v, found.of_tumour + u.vector(a) * *v);
            found.strain.iter_mut().zip(e.tensor(a).0).for_each(|(sum, e)| *sum += e * v);
        }
    }
    (found.mean, found.of_tumour) = (found.mean / all, found.of_tumour / inside);
    found.strain = found.strain.map(|e| e / inside);
    Ok(found)
}
