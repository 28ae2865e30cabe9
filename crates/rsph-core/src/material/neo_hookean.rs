//! The compressible neo-Hookean solid with Kelvin-Voigt damping, for large deformation.

use super::{Damped, Formula, ISOTROPIC, KelvinVoigt, Model};
use crate::error::InvalidInput;
use crate::tensor::Mat3;
use crate::tensor::lanes::{Real, Tensor};
use std::sync::Arc;

/// W(F) = mu/2 (F:F - 3) - mu ln J + lambda/2 (ln J)^2, J = det F, so that the Cauchy stress is
/// sigma = [mu (F F^T - I) + lambda ln J I]/J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookeanEnergy {
    mu: f64,
    lambda: f64,
}

/// The neo-Hookean solid with Kelvin-Voigt damping of the rate of strain in space. For small strain it is the Kelvin-Voigt solid
/// with the same parameters.
pub type NeoHookean = Damped<NeoHookeanEnergy>;

pub(super) const MODEL: Model = Model {
    name: "neo-hookean",
    doc: "compressible neo-Hookean solid with Kelvin-Voigt damping, for large strain and rotation",
    parameters: &ISOTROPIC,
    build: |v| {
        let [density, young_modulus, poisson_ratio, relaxation_time] = v.isotropic();
        Ok(Arc::new(NeoHookean::new(density, young_modulus, poisson_ratio, relaxation_time)?))
    },
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
        Ok(Self { name: MODEL.name, small, law: NeoHookeanEnergy { mu, lambda } })
    }
}

impl Formula for NeoHookeanEnergy {
    fn energy(&self, f: &Mat3) -> f64 {
        let j = f.determinant();
        if j <= 0.0 {
            return f64::INFINITY;
        }
        let ln_j = j.ln();
        0.5 * self.mu * (f.norm_squared() - 3.0) - self.mu * ln_j + 0.5 * self.lambda * ln_j * ln_j
    }

    #[inline(always)]
    fn first_piola<T: Real>(&self, f: &Tensor<T>) -> Tensor<T> {
        let (inverse_transpose, j) = f.inverse_transpose();
        (*f * self.mu).plus(j.ln() * self.lambda + -self.mu, &inverse_transpose)
    }

    #[inline(always)]
    fn tangent<T: Real>(&self, f: &Tensor<T>, df: &Tensor<T>) -> Tensor<T> {
        let (inverse_transpose, j) = f.inverse_transpose();
        // d(F^-T) = -F^-T dF^T F^-T, d(ln J) = F^-T : dF.
        let turned = inverse_transpose.times(&df.transpose()).times(&inverse_transpose);
        (*df * self.mu)
            .plus(j.ln() * -self.lambda + self.mu, &turned)
            .plus(inverse_transpose.dot(df) * self.lambda, &inverse_transpose)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::FiniteStrain;

    fn solid() -> NeoHookean {
        NeoHookean::new(1.0, 10.0, 0.3, 0.2).unwrap()
    }

    #[test]
    fn cauchy_stress_by_hand() {
        // Simple shear by 1 keeps the volume: sigma = mu (F F^T - I).
        let mut f = Mat3::identity();
        f[(0, 1)] = 1.0;
        let sigma = FiniteStrain::first_piola(&solid(), &f) * f.transpose();
        let mu = 10.0 / 2.6;
        assert!((sigma - Mat3::new(mu, mu, 0.0, mu, 0.0, 0.0, 0.0, 0.0, 0.0)).norm() < 1e-12);
        assert_eq!(FiniteStrain::energy(&solid(), &-Mat3::identity()), f64::INFINITY);
    }
}
