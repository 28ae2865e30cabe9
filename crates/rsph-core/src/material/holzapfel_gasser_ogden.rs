//! Two families of dispersed fibres in a neo-Hookean ground: arteries, capsules, muscle.

use super::isochoric::{Invariants, Isochoric};
use super::{Damped, Formula, Model, Parameter, TISSUE, tissue};
use crate::error::InvalidInput;
use crate::tensor::lanes::{Real, Tensor};
use crate::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// W = mu/2 (I1 - 3) + K/2 (ln J)^2 + sum_a k1/(2 k2) (exp(k2 <E_a>^2) - 1), E_a = kappa (I1 - 3) + (1 - 3 kappa)(I4_a - 1).
///
/// I4_a = J^-2/3 |F a|^2 is the square of the stretch along the fibres a without its change of volume; <E> is E where fibres are
/// stretched, and 0 else. kappa is 0 for fibres that are aligned and 1/3 where they have no direction.
/// (T. C. Gasser, R. W. Ogden and G. A. Holzapfel, J. R. Soc. Interface 3, 15, 2006.)
#[derive(Clone, Debug, PartialEq)]
pub struct FibreEnergy {
    ground: Isochoric<Ground>,
    k1: f64,
    k2: f64,
    dispersion: f64,
    /// Direction of the first family.
    direction: Vec3,
    /// Directions of the families, a (x) a.
    fibres: [Mat3; 2],
}

/// Rounding of E in the undeformed body, where fibres count as stretched, so that time steps, which go by the stiffness there, count
/// the fibres.
const ROUNDING: f64 = 1e-12;

/// The neo-Hookean ground: w = mu/2 (I1 - 3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    mu: f64,
}

impl Invariants for Ground {
    fn energy(&self, i1: f64, _: f64) -> f64 {
        0.5 * self.mu * (i1 - 3.0)
    }

    #[inline(always)]
    fn slopes<T: Real>(&self, i1: T, _: T) -> [T; 2] {
        [i1 * 0.0 + 0.5 * self.mu, i1 * 0.0]
    }

    #[inline(always)]
    fn curvature<T: Real>(&self, i1: T) -> T {
        i1 * 0.0
    }
}

/// The solid of Holzapfel, Gasser and Ogden with Kelvin-Voigt damping of its ground.
pub type HolzapfelGasserOgden = Damped<FibreEnergy>;

pub(super) const MODEL: Model = Model {
    name: "holzapfel-gasser-ogden",
    doc: "neo-Hookean solid with two families of dispersed fibres: vessel walls, capsules, muscle",
    parameters: &[
        TISSUE[0],
        Parameter::new("shear_modulus", "Pa", "shear modulus mu of the ground"),
        Parameter::new("k1", "Pa", "k1, the stiffness of the fibres"),
        Parameter::new("k2", "1", "k2, how fast the fibres stiffen"),
        Parameter::new("dispersion", "1", "kappa, the dispersion of the fibres: 0 aligned, 1/3 isotropic")
            .or(0.0),
        Parameter::new("fibre", "1", "direction of the fibres in the undeformed body").vector(),
        Parameter::new("second_fibre", "1", "direction of the second family; as the first if it is left out")
            .vector()
            .optional(),
        TISSUE[1],
        TISSUE[2],
        TISSUE[3],
    ],
    build: |v| {
        let mu = v.number("shear_modulus");
        let small = tissue(v, ("material.shear_modulus", mu))?;
        let (k1, k2, dispersion) = (v.number("k1"), v.number("k2"), v.number("dispersion"));
        for (key, x) in [("material.k1", k1), ("material.k2", k2)] {
            if !(x.is_finite() && x >= 0.0) {
                return Err(InvalidInput::new(
                    key,
                    x,
                    "must be zero or positive",
                    "k1 = 0 is the ground alone",
                ));
            }
        }
        if !(0.0..=1.0 / 3.0).contains(&dispersion) {
            return Err(InvalidInput::new(
                "material.dispersion",
                dispersion,
                "must lie between 0 (aligned) and 1/3 (isotropic)",
                "arteries: about 0.2",
            ));
        }
        let first = direction("material.fibre", v.list("fibre"))?;
        let second = v.list("second_fibre");
        let second = if second.is_empty() { first } else { direction("material.second_fibre", second)? };
        let ground = Isochoric { invariants: Ground { mu }, bulk_modulus: small.bulk_modulus() };
        let fibres = [first, second].map(|a| a * a.transpose());
        let law = FibreEnergy { ground, k1, k2, dispersion, direction: first, fibres };
        Ok(Arc::new(HolzapfelGasserOgden { name: MODEL.name, small, law }))
    },
};

/// The unit vector along three numbers.
fn direction(key: &str, numbers: &[f64]) -> Result<Vec3, InvalidInput> {
    let vector = (numbers.len() == 3).then(|| Vec3::from_column_slice(numbers));
    let unit = vector.and_then(|v| v.try_normalize(0.0)).filter(|a| a.iter().all(|x| x.is_finite()));
    unit.ok_or_else(|| {
        InvalidInput::new(
            key,
            format!("{numbers:?}"),
            "must be a direction: three numbers, not all zero",
            "for example [1.0, 0.0, 0.0]",
        )
    })
}

/// What a family of fibres adds.
struct Family<T> {
    /// <E>.
    stretch: T,
    /// 1 where E >= 0, 0 elsewhere.
    on: T,
    /// dW/dE.
    slope: T,
    /// dE/dF.
    gradient: Tensor<T>,
}

impl FibreEnergy {
    /// J^-2/3 and F^-T.
    #[inline(always)]
    fn scale<T: Real>(f: &Tensor<T>) -> (T, Tensor<T>) {
        let (inverse_transpose, j) = f.inverse_transpose();
        ((j.ln() * (-2.0 / 3.0)).exp(), inverse_transpose)
    }

    /// kappa 1 + (1 - 3 kappa) a (x) a: E = J^-2/3 h : C - 1.
    #[inline(always)]
    fn structure(&self, family: usize) -> Mat3 {
        Mat3::identity() * self.dispersion + self.fibres[family] * (1.0 - 3.0 * self.dispersion)
    }

    #[inline(always)]
    fn family<T: Real>(
        &self,
        f: &Tensor<T>,
        (scale, inverse_transpose): (T, &Tensor<T>),
        family: usize,
    ) -> Family<T> {
        let fh = f.times_matrix(&self.structure(family));
        let raw = fh.dot(f);
        let raw_stretch = scale * raw + -1.0;
        let (stretch, on) = (raw_stretch.positive_part(), (raw_stretch + ROUNDING).is_positive());
        let slope = (stretch * stretch * self.k2).exp() * stretch * self.k1;
        let gradient = (fh * 2.0).plus(raw * (-2.0 / 3.0), inverse_transpose).scaled(scale);
        Family { stretch, on, slope, gradient }
    }
}

impl Formula for FibreEnergy {
    fn fibre(&self) -> Option<Vec3> {
        Some(self.direction)
    }

    fn energy(&self, f: &Mat3) -> f64 {
        let ground = self.ground.energy(f);
        if !ground.is_finite() {
            return ground;
        }
        let f = Tensor::from(f);
        let (scale, inverse_transpose) = Self::scale(&f);
        let of_family = |a| {
            let square = self.family(&f, (scale, &inverse_transpose), a).stretch.powi(2);
            if self.k2 > 0.0 {
                0.5 * self.k1 / self.k2 * (self.k2 * square).exp_m1()
            } else {
                0.5 * self.k1 * square
            }
        };
        ground + of_family(0) + of_family(1)
    }

    #[inline(always)]
    fn first_piola<T: Real>(&self, f: &Tensor<T>) -> Tensor<T> {
        let mut piola = self.ground.first_piola(f);
        let (scale, inverse_transpose) = Self::scale(f);
        for a in 0..2 {
            let family = self.family(f, (scale, &inverse_transpose), a);
            piola = piola.plus(family.slope, &family.gradient);
        }
        piola
    }

    #[inline(always)]
    fn tangent<T: Real>(&self, f: &Tensor<T>, df: &Tensor<T>) -> Tensor<T> {
        let mut change = self.ground.tangent(f, df);
        let (scale, g) = Self::scale(f);
        let (t, s) = (g.times(&df.transpose()).times(&g), g.dot(df));
        for a in 0..2 {
            let family = self.family(f, (scale, &g), a);
            let h = self.structure(a);
            let fh = f.times_matrix(&h);
            let square = family.stretch * family.stretch;
            let curvature = (square * self.k2).exp() * (square * (2.0 * self.k2) + 1.0) * family.on * self.k1;
            let change_of_gradient = (df.times_matrix(&h) * 2.0)
                .plus(fh.dot(df) * (-4.0 / 3.0), &g)
                .plus(fh.dot(f) * (2.0 / 3.0), &t)
                .scaled(scale)
                .plus(s * (-2.0 / 3.0), &family.gradient);
            change = change
                .plus(curvature * family.gradient.dot(df), &family.gradient)
                .plus(family.slope, &change_of_gradient);
        }
        change
    }
}
