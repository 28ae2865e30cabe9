//! Materials. One model a file, plus one line in [`REGISTRY`].

mod finite_strain;
mod kelvin_voigt;
mod neo_hookean;
mod passive;

pub use finite_strain::FiniteStrain;
pub use kelvin_voigt::KelvinVoigt;
pub use neo_hookean::NeoHookean;
pub use passive::Passive;

use crate::error::InvalidInput;
use crate::tensor::SymTensor;
use std::fmt::Debug;
use std::sync::Arc;

/// A linear map from strain to stress, both with their six components in VTK order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent(pub [[f64; 6]; 6]);

/// A viscoelastic solid of Kelvin-Voigt form: its stress is a function of the *effective strain*
/// e + T de/dt, Eq. (5).
pub trait Material: Debug + Send + Sync {
    /// Name in scenario files.
    fn name(&self) -> &'static str;
    /// Density rho in the undeformed state (kg/m^3).
    fn density(&self) -> f64;
    /// Relaxation time T (s).
    fn relaxation_time(&self) -> f64;
    /// Stress (Pa) at the effective strain e + T de/dt.
    fn stress(&self, effective_strain: SymTensor) -> SymTensor;
    /// The law as a matrix, of a material whose stress is a linear function of the strain; `None` for any
    /// other.
    fn linear(&self) -> Option<Tangent> {
        let mut unit = [0.0; 6];
        let columns: [SymTensor; 6] = std::array::from_fn(|j| {
            unit.fill(0.0);
            unit[j] = 1.0;
            self.stress(SymTensor(unit))
        });
        Some(Tangent(std::array::from_fn(|i| columns.map(|c| c.0[i]))))
    }
    /// Elastic energy density (J/m^3) at strain e.
    fn energy_density(&self, strain: SymTensor) -> f64;
    /// P-wave modulus lambda + 2 mu (Pa): the scale of waves and of volume changes.
    fn p_wave_modulus(&self) -> f64;
    /// Young's modulus (Pa) for small strain, the mean of those along the axes where they differ: the scale of the
    /// hourglass term and of penalties.
    fn young_modulus(&self) -> f64 {
        let strain = |j: usize| SymTensor(std::array::from_fn(|k| if k == j { SMALL } else { 0.0 }));
        let columns: [SymTensor; 3] = std::array::from_fn(|j| self.stress(strain(j)));
        let stiffness = nalgebra::Matrix3::from_fn(|i, j| columns[j].0[i] / SMALL);
        let compliance = stiffness.try_inverse().map_or(f64::INFINITY, |c| c.trace() / 3.0);
        1.0 / compliance
    }
    /// The law for large deformation, if it has one; the functions of strain above are then its limit for
    /// small strain.
    fn finite_strain(&self) -> Option<&dyn FiniteStrain> {
        None
    }
}

/// A strain at which every law is linear.
const SMALL: f64 = 1e-6;

/// One parameter of a material model.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Key in scenario files.
    pub key: &'static str,
    /// Unit in SI.
    pub unit: &'static str,
    /// What it is.
    pub doc: &'static str,
    /// Value if the key is absent; `None`: required.
    pub default: Option<f64>,
}

/// Builds a material from the values of its parameters.
pub type Build = fn(&[f64]) -> Result<Arc<dyn Material>, InvalidInput>;

/// One row of the registry: what a scenario, the schema and Python need to know of a model.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// Name in scenario files.
    pub name: &'static str,
    /// One line for `--help`, schema and docs.
    pub doc: &'static str,
    /// Parameters, in order.
    pub parameters: &'static [Parameter],
    /// Builds the material from its parameters in that order.
    pub build: Build,
}

/// All material models.
pub const REGISTRY: &[Model] = &[kelvin_voigt::MODEL, neo_hookean::MODEL];

/// The model of that name.
pub fn model(name: &str) -> Option<&'static Model> {
    REGISTRY.iter().find(|m| m.name == name)
}
