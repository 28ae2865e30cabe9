//! The compressible neo-Hookean solid with Kelvin-Voigt damping, for large deformation.

use super::damping::{self, inverse_transpose};
use super::{FiniteStrain, ISOTROPIC, KelvinVoigt, Law, Material, Model};
use crate::error::InvalidInput;
use crate::tensor::Mat3;
use std::sync::Arc;

/// W(F) = mu/2 (F:F - 3) - mu ln J + lambda/2 (ln J)^2, J = det F, so that the Cauchy stress is
/// sigma = [mu (F F^T - I) + lambda ln J I]/J.
///
/// With Kelvin-Voigt damping of the rate of strain in space. For small strain it is the Kelvin-Voigt solid with the same parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    small: KelvinVoigt,
    mu: f64,
    lambda: f64,
}

pub(super) const MODEL: Model = Model {
    name: "neo-hookean",
    doc: "compressible neo-Hookean solid with Kelvin-Voigt damping, for large strain and rotation",
    parameters: &ISOTROPIC,
    build: |p| Ok(Arc::new(NeoHookean::new(p[0], p[1], p[2], p[3])?)),
};

impl NeoHookean {
    /// A material from density rho (kg/m^3), Young's modulus E (Pa) and Poisson's ratio nu at small
    /// strain, and relaxation time T (s).
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(
        density: f64,
        young_modulus: f64,
        poisson_ratio: f64,
        relaxation_time: f64,
    ) -> Result<Self, InvalidInput> {
        let small = KelvinVoigt::new(density, young_modulus, poisson_ratio, relaxation_time)?;
        let (mu, lambda) = small.lame();
        Ok(Self { small, mu, lambda })
    }
}

impl Material for NeoHookean {
    fn name(&self) -> &'static str {
        MODEL.name
    }

    fn density(&self) -> f64 {
        self.small.density()
    }

    fn relaxation_time(&self) -> f64 {
        self.small.relaxation_time()
    }

    fn law(&self) -> Law<'_> {
        Law::FiniteStrain(self)
    }
}

impl FiniteStrain for NeoHookean {
    fn energy(&self, f: &Mat3) -> f64 {
        let j = f.determinant();
        if j <= 0.0 {
            return f64::INFINITY;
        }
        let ln_j = j.ln();
        0.5 * self.mu * (f.norm_squared() - 3.0) - self.mu * ln_j + 0.5 * self.lambda * ln_j * ln_j
    }

    fn first_piola(&self, f: &Mat3) -> Mat3 {
        let (inverse_transpose, j) = inverse_transpose(f);
        (f - inverse_transpose) * self.mu + inverse_transpose * (self.lambda * j.ln())
    }

    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3 {
        let (inverse_transpose, j) = inverse_transpose(f);
        // d(F^-T) = -F^-T dF^T F^-T, d(ln J) = F^-T : dF.
        let turned = inverse_transpose * df.transpose() * inverse_transpose;
        (df + turned) * self.mu + inverse_transpose * (self.lambda * inverse_transpose.dot(df))
            - turned * (self.lambda * j.ln())
    }

    fn viscous_piola(&self, f: &Mat3, f_rate: &Mat3) -> Mat3 {
        damping::spatial(&self.small, f, f_rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid() -> NeoHookean {
        NeoHookean::new(1.0, 10.0, 0.3, 0.2).unwrap()
    }

    #[test]
    fn cauchy_stress_by_hand() {
        // Simple shear by 1 keeps the volume: sigma = mu (F F^T - I).
        let mut f = Mat3::identity();
        f[(0, 1)] = 1.0;
        let sigma = solid().first_piola(&f) * f.transpose();
        let mu = 10.0 / 2.6;
        assert!((sigma - Mat3::new(mu, mu, 0.0, mu, 0.0, 0.0, 0.0, 0.0, 0.0)).norm() < 1e-12);
        assert_eq!(solid().energy(&-Mat3::identity()), f64::INFINITY);
    }
}
