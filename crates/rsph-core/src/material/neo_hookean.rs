//! The compressible neo-Hookean solid with Kelvin-Voigt damping, for large deformation.

use super::{FiniteStrain, KelvinVoigt, Material, Model, Parameter};
use crate::error::InvalidInput;
use crate::tensor::{Mat3, SymTensor};
use std::sync::Arc;

/// W(F) = mu/2 (F:F - 3) - mu ln J + lambda/2 (ln J)^2, J = det F, so that the Cauchy stress is
/// sigma = [mu (F F^T - I) + lambda ln J I]/J.
///
/// The damping acts on the rate of strain in space, d = sym(grad v): its Kirchhoff stress is
/// J sigma_v = T (2 mu d + lambda tr d I), the viscous part of Eq. (5) per undeformed volume. It does not
/// feel rotations, and its power T (2 mu d:d + lambda (tr d)^2) is never negative for nu >= 0.
///
/// For small strain it is the Kelvin-Voigt solid of Eq. (5) with the same parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    small: KelvinVoigt,
    mu: f64,
    lambda: f64,
}

pub(super) const MODEL: Model = Model {
    name: "neo-hookean",
    doc: "compressible neo-Hookean solid with Kelvin-Voigt damping, for large strain and rotation",
    parameters: &[
        Parameter { key: "density", unit: "kg/m^3", doc: "undeformed density rho", default: None },
        Parameter {
            key: "young_modulus",
            unit: "Pa",
            doc: "Young's modulus E at small strain",
            default: None,
        },
        Parameter {
            key: "poisson_ratio",
            unit: "1",
            doc: "Poisson's ratio nu at small strain",
            default: None,
        },
        Parameter {
            key: "relaxation_time",
            unit: "s",
            doc: "relaxation time T of the damping",
            default: None,
        },
    ],
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

    /// The limit of small strain, Eq. (5).
    fn stress(&self, effective_strain: SymTensor) -> SymTensor {
        self.small.stress(effective_strain)
    }

    /// The limit of small strain.
    fn energy_density(&self, strain: SymTensor) -> f64 {
        self.small.energy_density(strain)
    }

    fn p_wave_modulus(&self) -> f64 {
        self.small.p_wave_modulus()
    }

    fn finite_strain(&self) -> Option<&dyn FiniteStrain> {
        Some(self)
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
        let (inverse_transpose, _) = inverse_transpose(f);
        // grad v = (dF/dt) F^-1; P = J sigma_v F^-T.
        let d = SymTensor::symmetric_part(&(f_rate * inverse_transpose.transpose()));
        self.small.stress(d * self.small.relaxation_time()).to_matrix() * inverse_transpose
    }
}

/// F^-T by cofactors, and det F.
fn inverse_transpose(f: &Mat3) -> (Mat3, f64) {
    let (a, b, c) = (f.column(0), f.column(1), f.column(2));
    let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
    let j = a.dot(&bc);
    (Mat3::from_columns(&[bc, ca, ab]) / j, j)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tensor::Vec3;
    use nalgebra::Rotation3;
    use proptest::prelude::*;

    fn solid() -> NeoHookean {
        NeoHookean::new(1.0, 10.0, 0.3, 0.2).unwrap()
    }

    fn matrix(size: f64) -> impl Strategy<Value = Mat3> {
        prop::array::uniform9(-size..size).prop_map(|m| Mat3::from_row_slice(&m))
    }

    proptest! {
        #[test]
        fn stress_is_the_derivative_of_the_energy(g in matrix(0.3), d in matrix(1.0)) {
            let (f, e) = (Mat3::identity() + g, 1e-5);
            prop_assume!(f.determinant() > 0.1);
            let slope = (solid().energy(&(f + d * e)) - solid().energy(&(f - d * e))) / (2.0 * e);
            let p = solid().first_piola(&f);
            prop_assert!((slope - p.dot(&d)).abs() < 1e-6 * (1.0 + p.norm()));
            let dp = (solid().first_piola(&(f + d * e)) - solid().first_piola(&(f - d * e))) / (2.0 * e);
            let tangent = solid().tangent(&f, &d);
            prop_assert!((dp - tangent).norm() < 1e-6 * (1.0 + tangent.norm()));
        }

        #[test]
        fn a_rotation_turns_the_stress_and_costs_nothing(
            g in matrix(0.3), rate in matrix(1.0), turn in prop::array::uniform3(-3.0..3.0_f64)
        ) {
            let (f, q) = (Mat3::identity() + g, *Rotation3::new(Vec3::from(turn)).matrix());
            prop_assume!(f.determinant() > 0.1);
            let s = solid();
            prop_assert!((s.energy(&(q * f)) - s.energy(&f)).abs() < 1e-10);
            prop_assert!((s.first_piola(&(q * f)) - q * s.first_piola(&f)).norm() < 1e-9);
            // d(QF)/dt = Q (dF/dt + W F) with any spin W: the damping sees dF/dt only.
            let spin = 0.5 * (rate - rate.transpose());
            let turned = s.viscous_piola(&(q * f), &(q * (rate + spin * f)));
            prop_assert!((turned - q * s.viscous_piola(&f, &rate)).norm() < 1e-9 * (1.0 + turned.norm()));
        }

        #[test]
        fn damping_takes_energy(g in matrix(0.4), rate in matrix(2.0)) {
            let f = Mat3::identity() + g;
            prop_assume!(f.determinant() > 0.05);
            prop_assert!(solid().viscous_piola(&f, &rate).dot(&rate) >= 0.0);
        }

        #[test]
        fn small_strain_is_kelvin_voigt(g in matrix(1e-6), rate in matrix(1e-6)) {
            let s = solid();
            let f = Mat3::identity() + g;
            let p = s.first_piola(&f) + s.viscous_piola(&f, &rate);
            let e = SymTensor::symmetric_part(&(g + rate * s.relaxation_time()));
            let linear = s.stress(e).to_matrix();
            prop_assert!((p - linear).norm() < 1e-9, "{}", (p - linear).norm());
        }
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
