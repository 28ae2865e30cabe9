//! A Kelvin-Voigt solid with one family of fibres, such as muscle: stiffer along one direction.

use super::{KelvinVoigt, Law, Material, Model, Parameter, Stiffness};
use crate::error::InvalidInput;
use crate::tensor::{SymTensor, Vec3};
use std::sync::Arc;

/// Adds k (a.e.a) a (x) a to the stress of a Kelvin-Voigt solid; a is the direction of the fibres.
#[derive(Clone, Copy, Debug)]
pub struct FibreReinforced {
    matrix: KelvinVoigt,
    fibre_modulus: f64,
    /// a (x) a
    fibre: SymTensor,
}

pub const MODEL: Model = Model {
    name: "fibre-reinforced",
    doc: "Kelvin-Voigt solid with one family of fibres, for small strain",
    parameters: &[
        Parameter::new("density", "kg/m^3", "density rho"),
        Parameter::new("young_modulus", "Pa", "Young's modulus E without fibres"),
        Parameter::new("poisson_ratio", "1", "Poisson's ratio nu without fibres"),
        Parameter::new("relaxation_time", "s", "relaxation time T of the damping").or(0.0),
        Parameter::new("fibre_modulus", "Pa", "stiffness k that the fibres add along themselves"),
        Parameter::new("fibre", "1", "direction of the fibres").vector(),
    ],
    build: |v| {
        let [density, e, nu, t] =
            ["density", "young_modulus", "poisson_ratio", "relaxation_time"].map(|key| v.number(key));
        let matrix = KelvinVoigt::new(density, e, nu, t)?;
        let fibre = Vec3::from_column_slice(v.list("fibre"));
        Ok(Arc::new(FibreReinforced::new(matrix, v.number("fibre_modulus"), fibre)?))
    },
};

impl FibreReinforced {
    /// A solid from its matrix, the stiffness of the fibres k (Pa) and their direction (any length).
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(matrix: KelvinVoigt, fibre_modulus: f64, direction: Vec3) -> Result<Self, InvalidInput> {
        if !(fibre_modulus.is_finite() && fibre_modulus >= 0.0) {
            return Err(InvalidInput::new(
                "material.fibre_modulus",
                fibre_modulus,
                "must be zero or positive (Pa)",
                "0 gives the isotropic solid",
            ));
        }
        let Some(a) = direction.try_normalize(0.0).filter(|a| a.iter().all(|c| c.is_finite())) else {
            return Err(InvalidInput::new(
                "material.fibre",
                format!("{:?}", direction.as_slice()),
                "must be finite and not the zero vector",
                "for example [0.0, 0.0, 1.0] for fibres along z",
            ));
        };
        Ok(Self { matrix, fibre_modulus, fibre: SymTensor::symmetric_part(&(a * a.transpose())) })
    }
}

impl Material for FibreReinforced {
    fn name(&self) -> &'static str {
        MODEL.name
    }

    fn density(&self) -> f64 {
        self.matrix.density()
    }

    fn relaxation_time(&self) -> f64 {
        self.matrix.relaxation_time()
    }

    fn law(&self) -> Law<'_> {
        let matrix = self.matrix.stiffness();
        Law::Linear(Stiffness::of(|e| {
            matrix.stress(e) + self.fibre * (self.fibre_modulus * self.fibre.double_dot(e))
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn stress_is_the_derivative_of_the_energy() {
        let matrix = KelvinVoigt::new(1.0, 10.0, 0.3, 0.2).unwrap();
        let m = FibreReinforced::new(matrix, 30.0, Vec3::new(1.0, 2.0, -1.0)).unwrap();
        let e = SymTensor([0.3, -0.1, 0.2, 0.05, 0.4, -0.2]);
        let d = SymTensor([-0.2, 0.5, 0.1, 0.3, -0.1, 0.25]);
        // The energy is quadratic: the central difference is exact.
        let c = m.stiffness();
        let slope = c.energy_density(e + d * 0.5) - c.energy_density(e + d * -0.5);
        assert_relative_eq!(slope, c.stress(e).double_dot(d), max_relative = 1e-12);
    }

    #[test]
    fn fibres_without_direction_are_refused() {
        let matrix = KelvinVoigt::new(1.0, 10.0, 0.3, 0.2).unwrap();
        assert!(FibreReinforced::new(matrix, 30.0, Vec3::zeros()).is_err());
        assert!(FibreReinforced::new(matrix, f64::NAN, Vec3::x()).is_err());
    }
}
