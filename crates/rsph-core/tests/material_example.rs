//! The example of CONTRIBUTING.md, compiled from docs/examples as if it were a material of the core.

mod tree;

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

    mod fibre_reinforced;

    /// The line of the registry.
    pub const REGISTRY: &[Model] = &[fibre_reinforced::MODEL];
}

use tensor::SymTensor;

#[test]
fn contributing_shows_the_example_as_it_is() {
    let example = tree::read("docs/examples/fibre_reinforced.rs");
    let shown = example.split("\n#[cfg(test)]").next().unwrap_or(&example);
    assert!(tree::read("CONTRIBUTING.md").contains(shown), "CONTRIBUTING.md shows another example");
}

#[test]
fn the_registry_builds_the_example() {
    let model = material::REGISTRY[0];
    let make = |fibre_modulus: f64| {
        model.make(|key| match key {
            "density" => Some(vec![1000.0]),
            "young_modulus" => Some(vec![1e5]),
            "poisson_ratio" => Some(vec![0.3]),
            "fibre_modulus" => Some(vec![fibre_modulus]),
            "fibre" => Some(vec![0.0, 0.0, 2.0]),
            _ => None,
        })
    };
    let solid = make(5e5).unwrap();
    let plain = material::KelvinVoigt::new(1000.0, 1e5, 0.3, 0.0).unwrap();
    let (across, along) =
        (SymTensor([0.01, 0.0, 0.0, 0.0, 0.0, 0.0]), SymTensor([0.0, 0.0, 0.01, 0.0, 0.0, 0.0]));
    let by = |e: SymTensor| {
        solid.stiffness().stress(e).0[2] - material::Material::stiffness(&plain).stress(e).0[2]
    };
    assert!(by(across).abs() < 1e-9, "fibres along z do not feel a strain across");
    assert!((by(along) - 5e3).abs() < 1e-6);
    assert!(make(-1.0).is_err());
}
