//! Ogden's solid, in principal stretches.

use super::{Damped, Hyperelastic, Model, Parameter, TISSUE, tissue};
use crate::error::InvalidInput;
use crate::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// W = sum_i 2 mu_i / a_i^2 (l1^a_i + l2^a_i + l3^a_i - 3) + K/2 (ln J)^2, l the principal stretches without their change of volume.
///
/// The shear modulus at small strain is the sum of the mu_i; FEBio's c_i are 2 mu_i.
/// (R. W. Ogden, Proc. R. Soc. A 326, 565, 1972.)
#[derive(Clone, Debug, PartialEq)]
pub struct OgdenEnergy {
    /// mu_i and a_i.
    terms: Vec<[f64; 2]>,
    /// K.
    bulk_modulus: f64,
}

/// Ogden's solid with Kelvin-Voigt damping.
pub type Ogden = Damped<OgdenEnergy>;

pub(super) const MODEL: Model = Model {
    name: "ogden",
    doc: "Ogden's solid of one to six terms in the principal stretches: brain, fat, liver",
    parameters: &[
        TISSUE[0],
        Parameter::new("moduli", "Pa", "mu_i of each term; their sum is the shear modulus at small strain")
            .list(),
        Parameter::new("exponents", "1", "exponent a_i of each term").list(),
        TISSUE[1],
        TISSUE[2],
        TISSUE[3],
    ],
    build: |v| {
        let (moduli, exponents) = (v.list("moduli"), v.list("exponents"));
        if moduli.len() != exponents.len() {
            return Err(InvalidInput::new(
                "material.exponents",
                format!("{} numbers", exponents.len()),
                format!("every term has a modulus and an exponent, and there are {} moduli", moduli.len()),
                "for example moduli = [500.0], exponents = [8.0]",
            ));
        }
        if let Some(a) = exponents.iter().find(|a| !(a.is_finite() && **a != 0.0)) {
            return Err(InvalidInput::new(
                "material.exponents",
                a,
                "must be numbers other than 0",
                "2 is the neo-Hookean solid",
            ));
        }
        let terms = moduli.iter().zip(exponents).map(|(m, a)| [*m, *a]).collect();
        let small = tissue(v, ("material.moduli", moduli.iter().sum()))?;
        let law = OgdenEnergy { terms, bulk_modulus: small.bulk_modulus() };
        Ok(Arc::new(Ogden { name: MODEL.name, small, law }))
    },
};

/// Axes of V = sqrt(F F^T) and the logarithms of its stretches, less a third of ln J, and ln J.
struct Stretches {
    axes: Mat3,
    logarithms: Vec3,
    ln_j: f64,
}

impl Stretches {
    fn new(f: &Mat3) -> Self {
        let eigen = (f * f.transpose()).symmetric_eigen();
        let ln_j = f.determinant().ln();
        let logarithms = eigen.eigenvalues.map(|square| 0.5 * square.max(f64::MIN_POSITIVE).ln());
        let mean = logarithms.sum() / 3.0;
        Self { axes: eigen.eigenvectors, logarithms: logarithms.add_scalar(-mean), ln_j }
    }
}

impl OgdenEnergy {
    /// Principal Kirchhoff stresses.
    fn principal(&self, s: &Stretches) -> Vec3 {
        let mut stress = Vec3::repeat(self.bulk_modulus * s.ln_j);
        for [mu, a] in &self.terms {
            let powers = s.logarithms.map(|l| (a * l).exp());
            stress += (powers - Vec3::repeat(powers.sum() / 3.0)) * (2.0 * mu / a);
        }
        stress
    }

    /// Their derivatives with the logarithms of the stretches.
    fn principal_slopes(&self, s: &Stretches) -> Mat3 {
        let mut slopes = Mat3::repeat(self.bulk_modulus);
        for [mu, a] in &self.terms {
            let powers = s.logarithms.map(|l| (a * l).exp());
            let mean = powers.sum() / 3.0;
            for i in 0..3 {
                for j in 0..3 {
                    let own = if i == j { powers[i] } else { 0.0 };
                    slopes[(i, j)] += 2.0 * mu * (own - (powers[i] + powers[j]) / 3.0 + mean / 3.0);
                }
            }
        }
        slopes
    }

    /// (t_i - t_j) / (l_i^2 - l_j^2) times l_j^2, t the principal Kirchhoff stresses; also where the stretches l are equal.
    fn ratio(&self, s: &Stretches, i: usize, j: usize) -> f64 {
        let apart = s.logarithms[i] - s.logarithms[j];
        let term = |[mu, a]: &[f64; 2]| {
            let growth =
                if apart.abs() < 1e-12 { 0.5 * a } else { (a * apart).exp_m1() / (2.0 * apart).exp_m1() };
            2.0 * mu / a * (a * s.logarithms[j]).exp() * growth
        };
        self.terms.iter().map(term).sum()
    }
}

impl Hyperelastic for OgdenEnergy {
    fn energy(&self, f: &Mat3) -> f64 {
        if f.determinant().is_nan() || f.determinant() <= 0.0 {
            return f64::INFINITY;
        }
        let s = Stretches::new(f);
        let term = |[mu, a]: &[f64; 2]| {
            2.0 * mu / (a * a) * s.logarithms.iter().map(|l| (a * l).exp_m1()).sum::<f64>()
        };
        self.terms.iter().map(term).sum::<f64>() + 0.5 * self.bulk_modulus * s.ln_j * s.ln_j
    }

    fn first_piola(&self, f: &Mat3) -> Mat3 {
        let s = Stretches::new(f);
        let kirchhoff = s.axes * Mat3::from_diagonal(&self.principal(&s)) * s.axes.transpose();
        f.try_inverse().map_or_else(Mat3::zeros, |inverse| kirchhoff * inverse.transpose())
    }

    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3 {
        let Some(inverse) = f.try_inverse() else { return Mat3::zeros() };
        let s = Stretches::new(f);
        let (stress, slopes) = (self.principal(&s), self.principal_slopes(&s));
        // In the axes of V: dF F^-1, by which B = F F^T changes by l B + B l^T.
        let l = s.axes.transpose() * df * inverse * s.axes;
        let mut change = Mat3::from_diagonal(&(slopes * l.diagonal()));
        for i in 0..3 {
            for j in (0..3).filter(|&j| j != i) {
                // t_ij = ratio (l_ij + l_ji l_i^2 / l_j^2).
                let squares = (2.0 * (s.logarithms[i] - s.logarithms[j])).exp();
                change[(i, j)] = self.ratio(&s, i, j) * (l[(i, j)] + squares * l[(j, i)]);
            }
        }
        // P = t F^-T.
        let change = change - Mat3::from_diagonal(&stress) * l.transpose();
        s.axes * change * s.axes.transpose() * inverse.transpose()
    }
}
