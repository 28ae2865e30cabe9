//! Every reader with bytes from anywhere. A target must come back: with a result or with an error, soon, and
//! without much memory. `crates/rsph-scenario/tests/fuzz_corpus.rs` runs them on the corpus.

use miette::{GraphicalReportHandler, GraphicalTheme};
use rsph_core::sample::Resolution;
use rsph_core::setup::Setup;
use rsph_core::shape::{MeshShape, voxel_shape};
use rsph_core::simulation::Simulation;
use rsph_scenario::label_map::{Axes, read_label};
use rsph_scenario::mesh_io::read_mesh;
use rsph_scenario::output::checkpoint::Checkpoint;
use rsph_scenario::output::{self, vtkhdf};
use rsph_scenario::scenario::{LoadedScenario, ScenarioError};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Reads bytes.
pub type Target = fn(&[u8]);

/// The targets by name; the corpus has a folder for each.
pub const TARGETS: &[(&str, Target)] = &[
    ("scenario", scenario),
    ("simulation", simulation),
    ("set", set),
    ("stl", |bytes| mesh(bytes, "stl")),
    ("obj", |bytes| mesh(bytes, "obj")),
    ("ply", |bytes| mesh(bytes, "ply")),
    ("gltf", |bytes| mesh(bytes, "gltf")),
    ("nifti", nifti),
    ("vtkhdf", results),
    ("checkpoint", checkpoint),
];

/// A scenario up to what the core would simulate; messages are rendered as for a user.
fn scenario(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match LoadedScenario::from_text("f.toml", text.into(), PathBuf::new(), &[]) {
        Err(error) => told(&error),
        Ok(loaded) => {
            if let Err(error) = loaded.check() {
                told(&error);
            }
            let again = LoadedScenario::from_text("g.toml", loaded.as_run_anywhere(), PathBuf::new(), &[]);
            assert!(again.is_ok(), "a scenario that was understood is not when stored");
        }
    }
}

/// The first steps of a scenario, with few particles.
fn simulation(bytes: &[u8]) {
    const PARTICLES: usize = 60;
    const STEPS: usize = 3;
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(loaded) = LoadedScenario::from_text("f.toml", text.into(), PathBuf::new(), &[]) else { return };
    let mut job = match loaded.lower() {
        Ok(job) => job,
        Err(error) => return told(&error),
    };
    if let Resolution::Particles(n) = job.setup.resolution {
        job.setup.resolution = Resolution::Particles(n.min(PARTICLES));
    } else {
        job.setup.resolution = Resolution::Particles(PARTICLES);
    }
    match Simulation::new(job.setup) {
        Err(error) => told(&loaded.document().invalid_input(&error)),
        Ok(mut simulation) => {
            for _ in 0..STEPS {
                if simulation.step().is_err() {
                    break;
                }
            }
            let _ = (simulation.snapshot(), simulation.readings());
        }
    }
}

/// An edit of a scenario.
fn set(bytes: &[u8]) {
    const TEXT: &str = include_str!("../../scenarios/tensile_liver.toml");
    let Ok(edits) = std::str::from_utf8(bytes) else { return };
    let edits: Vec<String> = edits.lines().map(String::from).collect();
    match LoadedScenario::from_text("f.toml", TEXT.into(), PathBuf::new(), &edits) {
        Ok(loaded) => drop(loaded.check().map_err(|error| told(&error))),
        Err(error) => told(&error),
    }
}

/// A mesh, and the body that it bounds.
fn mesh(bytes: &[u8], extension: &str) {
    with_file(bytes, extension, |path| match read_mesh(path, 1.0) {
        Ok(mesh) => drop(MeshShape::new(&mesh, "mesh")),
        Err(error) => assert!(!error.to_string().is_empty()),
    });
}

/// A segmentation, and the body of a label in it.
fn nifti(bytes: &[u8]) {
    with_file(bytes, "nii", |path| match read_label(path, 1) {
        Ok(found) => drop(voxel_shape(&found.runs, found.size, &found.placement(None, Axes::Organ), "image")),
        Err(error) => assert!(!error.to_string().is_empty()),
    });
}

/// The results of a run: what there is, and its last frame.
fn results(bytes: &[u8]) {
    with_file(bytes, "vtkhdf", |path| {
        if let Ok(info) = vtkhdf::describe(path) {
            for field in &info.fields {
                let _ = vtkhdf::read_field(path, 0, &field.name);
            }
        }
        let _ = vtkhdf::read_step(path, None);
    });
}

/// A checkpoint, and a simulation that goes on from it.
fn checkpoint(bytes: &[u8]) {
    const TEXT: &str = include_str!("../checkpoint.toml");
    static SETUP: LazyLock<Option<Setup>> = LazyLock::new(|| {
        let loaded = LoadedScenario::from_text("f.toml", TEXT.into(), PathBuf::new(), &[]);
        Some(loaded.and_then(|s| s.lower()).ok()?.setup)
    });
    let Ok(folder) = tempfile::tempdir() else { return };
    if std::fs::write(folder.path().join(output::checkpoint::FILE), bytes).is_err() {
        return;
    }
    let Ok(stored) = Checkpoint::read(folder.path()) else { return };
    let setup = SETUP.clone().expect("a scenario");
    let mut simulation = Simulation::new(setup).expect("a simulation");
    if simulation.set_state(&stored.state).is_ok() {
        let _ = simulation.step().and_then(|()| simulation.step());
        let _ = (simulation.snapshot(), simulation.readings());
    }
}

/// Hands over a file with these bytes, in a folder of its own.
fn with_file(bytes: &[u8], extension: &str, read: impl FnOnce(&Path)) {
    let Ok(folder) = tempfile::tempdir() else { return };
    let path = folder.path().join("file").with_extension(extension);
    if std::fs::write(&path, bytes).is_ok() {
        read(&path);
    }
}

/// Makes the message that a user would see.
fn told(error: &ScenarioError) {
    let mut text = error.to_string();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor());
    assert!(handler.render_report(&mut text, error).is_ok(), "no message about {error}");
}
