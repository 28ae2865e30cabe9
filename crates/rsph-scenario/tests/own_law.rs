//! A law of one's own from a scenario: the example of CONTRIBUTING.md, added from outside of the core.

use rsph_core::setup::RemeshTrigger;
use rsph_core::simulation::Simulation;
use rsph_scenario::scenario::LoadedScenario;
use std::path::PathBuf;

// What the example expects around itself.
mod error {
    pub use rsph_core::error::InvalidInput;
}
mod tensor {
    pub use rsph_core::tensor::{SymTensor, Vec3};
}
#[path = "../../../docs/examples"]
mod material {
    pub use rsph_core::material::{KelvinVoigt, Law, Material, Model, Parameter, Stiffness};

    pub mod fibre_reinforced;
}

const SCENARIO: &str = r#"
    body = { shape = { box = { size = [1, 1, 1] } }, particles = 216 }
    time = { until = 1.0 }
    [material]
    model = "fibre-reinforced"
    density = 1.0
    young_modulus = 100.0
    poisson_ratio = 0.0
    fibre_modulus = 300.0
    fibre = [0, 0, 2]
    [[boundary]]
    kind = "clamp"
    region = { plane = { axis = "z", at = 0.0, side = "below" } }
    [[load]]
    kind = "traction"
    traction = [0, 0, 1]
    region = { plane = { axis = "z", at = 1.0, side = "above" } }
    [[probe]]
    name = "extension"
    quantity = "displacement.z"
    region = { plane = { axis = "z", at = 1.0, side = "above" } }
"#;

fn scenario(sets: &[&str]) -> LoadedScenario {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    LoadedScenario::from_text("own_law.toml", SCENARIO.into(), PathBuf::new(), &sets).unwrap()
}

#[test]
fn a_law_of_ones_own_runs_from_a_scenario() {
    let unknown = scenario(&[]).lower().unwrap_err().to_string();
    assert!(unknown.contains("known models: \"kelvin-voigt\""), "{unknown}");

    rsph_core::material::register(&material::fibre_reinforced::MODEL);
    let job = scenario(&["solver.mode=static"]).lower().unwrap();
    let mut body = Simulation::new(job.setup).unwrap();
    body.solve_static(1.0, &mut |_, _| true).unwrap();
    // A bar: 1 / (E + k).
    assert!((body.readings()[0].value - 1.0 / 400.0).abs() < 1e-7, "{:?}", body.readings());

    let mut setup = scenario(&[]).lower().unwrap().setup;
    setup.remesh.trigger = RemeshTrigger::Steps(20);
    let mut body = Simulation::new(setup).unwrap();
    for _ in 0..50 {
        body.step().unwrap();
    }
    assert_eq!(body.remesh_log().unwrap().count, 2);

    let wrong = scenario(&["material.fibre=[1, 0]"]).lower().unwrap_err().to_string();
    assert!(wrong.contains("material.fibre") && wrong.contains("[<x>, <y>, <z>]"), "{wrong}");
}
