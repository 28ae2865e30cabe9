//! Materials that relax by a Prony series: generalised Maxwell solids.
//!
//! Beside the spring of a law, with the stress S^e, there are Maxwell elements, each a spring of gamma_i times its stiffness in series
//! with a dashpot, that forget with the time tau_i:
//!
//! ```text
//! S(t) = S^e(t) + sum_i gamma_i int_0^t exp(-(t - s)/tau_i) dS^e/ds ds.
//! ```
//!
//! With A_i, the stress to which the dashpot of an element has let it relax,
//!
//! ```text
//! S = S^e + sum_i gamma_i (S^e - A_i),      dA_i/dt = (S^e - A_i)/tau_i.
//! ```
//!
//! S is the second Piola-Kirchhoff stress, which does not turn with the body, and sigma under a law for small strain (Simo, On a fully
//! three-dimensional finite-strain viscoelastic damage model, 1987; Holzapfel, Nonlinear Solid Mechanics, section 6.10). All of the
//! stress relaxes, so that Poisson's ratio stays.

use super::{FiniteStrain, Law, Material, Parameter, Range, Stiffness, model::Kind};
use crate::error::InvalidInput;
use crate::tensor::{Mat3, SymTensor, Vec3};
use std::sync::Arc;

/// Most terms of a series.
pub const MAX_TERMS: usize = 6;

/// The series, a parameter that materials of every model can have.
pub const PRONY: Parameter = Parameter {
    key: "prony",
    unit: "1, s",
    doc: "terms [gamma, tau] of a Prony series: stiffness over the stiffness for long times, and relaxation time",
    kind: Kind::Pairs,
};

/// One term of a Prony series: a Maxwell element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PronyTerm {
    /// gamma: its stiffness over the stiffness of the law, which is left after a long time.
    pub share: f64,
    /// tau: its relaxation time (s).
    pub time: f64,
}

impl PronyTerm {
    /// a, b and c of A(t + h) = a A(t) + b S(t) + c S(t + h), exact for a stress that goes straight from one to the other.
    pub(crate) fn exact_update(&self, h: f64) -> [f64; 3] {
        let x = h / self.time;
        // (1 - e^-x)/x, which is 1 where x is lost in rounding.
        let mean = if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 };
        let a = (-x).exp();
        [a, mean - a, 1.0 - mean]
    }
}

/// A material whose stress relaxes to the stress of its law.
#[derive(Clone, Debug)]
pub struct Relaxing {
    material: Arc<dyn Material>,
    terms: Vec<PronyTerm>,
}

impl Relaxing {
    /// The series of a material without damping, whose law is what the stress relaxes to.
    ///
    /// # Errors
    /// `material.prony` of no terms, of more than [`MAX_TERMS`], or of numbers that are not positive; `material.relaxation_time` of a
    /// material with damping.
    pub fn new(material: Arc<dyn Material>, terms: Vec<PronyTerm>) -> Result<Self, InvalidInput> {
        let problem = |value: String, problem: &str, remedy: &str| {
            Err(InvalidInput::new("material.prony", value, problem, remedy))
        };
        if terms.is_empty() || terms.len() > MAX_TERMS {
            let count = format!("{} terms", terms.len());
            return problem(count, "takes one to six terms", "for example prony = [[0.5, 1.5]]");
        }
        let positive = |x: f64| x.is_finite() && x > 0.0;
        if let Some(bad) = terms.iter().find(|term| !(positive(term.share) && positive(term.time))) {
            return problem(
                format!("[{}, {}]", bad.share, bad.time),
                "both numbers of a term must be positive: stiffness over the stiffness for long times, and time (s)",
                "for example prony = [[0.5, 1.5]]: a stress that is held falls to two thirds of it in some 1.5 s",
            );
        }
        if material.relaxation_time() > 0.0 {
            return Err(InvalidInput::new(
                "material.relaxation_time",
                material.relaxation_time(),
                "and `prony` exclude each other: each says how the material is damped",
                "set relaxation_time = 0; a short term in the series damps as well",
            ));
        }
        Ok(Self { material, terms })
    }
}

impl Material for Relaxing {
    fn name(&self) -> &'static str {
        self.material.name()
    }

    fn density(&self) -> f64 {
        self.material.density()
    }

    fn relaxation_time(&self) -> f64 {
        0.0
    }

    fn law(&self) -> Law<'_> {
        self.material.law()
    }

    fn stiffness(&self) -> Stiffness {
        self.material.stiffness()
    }

    fn young_modulus(&self) -> f64 {
        self.material.young_modulus()
    }

    fn p_wave_modulus(&self) -> f64 {
        self.material.p_wave_modulus()
    }

    fn shear_modulus(&self) -> f64 {
        self.material.shear_modulus()
    }

    fn range(&self) -> Range {
        self.material.range()
    }

    fn prony(&self) -> &[PronyTerm] {
        &self.terms
    }

    fn fibre(&self) -> Option<Vec3> {
        self.material.fibre()
    }
}

/// Second Piola-Kirchhoff stress S = F^-1 P of a law; `None` where F has no inverse.
pub(crate) fn second_piola(law: &dyn FiniteStrain, f: &Mat3) -> Option<SymTensor> {
    f.try_inverse().map(|inverse| SymTensor::symmetric_part(&(inverse * law.first_piola(f))))
}

/// Steps of Newton's method for the strain at a stress, and the change of the stretch at which it is found.
const MAX_STEPS: usize = 20;
/// See [`MAX_STEPS`].
const FOUND: f64 = 1e-9;

/// W(F) - W_A - A : (E - E_A) per undeformed volume (J/m^3), with W_A and E_A where the law has the stress A: what a spring holds whose
/// dashpot has taken it from 0 to E_A. `None` where no such strain is found.
pub(crate) fn energy_beyond(law: &dyn FiniteStrain, f: &Mat3, relaxed: &Mat3) -> Option<f64> {
    let green = |f: &Mat3| 0.5 * (f.transpose() * f - Mat3::identity());
    let (strain, stress) = (green(f), second_piola(law, f)?.to_matrix());
    // On the way to F in the proportion of the stresses.
    let way = relaxed.dot(&stress) / stress.norm_squared();
    let squared = Mat3::identity() + 2.0 * strain * if way.is_finite() { way.clamp(-1.0, 1.5) } else { 0.0 };
    let eigen = squared.symmetric_eigen();
    let roots = eigen.eigenvalues.map(|l| l.max(0.04).sqrt());
    let mut stretch = eigen.eigenvectors * Mat3::from_diagonal(&roots) * eigen.eigenvectors.transpose();
    for _ in 0..MAX_STEPS {
        let inverse = stretch.try_inverse()?;
        let now = inverse * law.first_piola(&stretch);
        // dS = U^-1 (dP - dU S) for changes dU of U by the six components.
        let slope = Stiffness::of(|change| {
            let du = change.to_matrix();
            SymTensor::symmetric_part(&(inverse * (law.tangent(&stretch, &du) - du * now)))
        });
        let step = slope.strain(SymTensor::symmetric_part(&(relaxed - now))).to_matrix();
        let mut length = 1.0;
        while !law.energy(&(stretch + length * step)).is_finite() {
            length *= 0.5;
            if length < 1e-3 {
                return None;
            }
        }
        stretch += length * step;
        if step.amax() < FOUND {
            let beyond = law.energy(f) - law.energy(&stretch) - relaxed.dot(&(strain - green(&stretch)));
            return beyond.is_finite().then_some(beyond);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{KelvinVoigt, NeoHookean};

    #[test]
    fn a_spring_holds_all_that_its_dashpot_did_not_take() {
        let material = NeoHookean::new(1.0, 10.0, 0.45, 0.0).unwrap();
        let law = material.law().finite_strain().unwrap();
        let turn = *nalgebra::Rotation3::from_scaled_axis(Vec3::new(0.4, 1.0, -0.7)).matrix();
        let f = turn * Mat3::new(1.3, -0.3, 0.2, 0.05, 0.9, -0.1, 0.4, 0.15, 0.8);
        assert!((energy_beyond(law, &f, &Mat3::zeros()).unwrap() - law.energy(&f)).abs() < 1e-12);
        let of_f = second_piola(law, &f).unwrap().to_matrix();
        assert!(energy_beyond(law, &f, &of_f).unwrap().abs() < 1e-12);
        // The change with F at constant A is S - A.
        let g = Mat3::new(0.8, 0.1, 0.0, 0.1, 1.2, -0.2, 0.0, -0.2, 1.1);
        let relaxed = second_piola(law, &g).unwrap().to_matrix();
        let df = Mat3::new(0.2, -0.1, 0.4, 0.3, 0.1, -0.5, 0.0, 0.2, -0.3) * 1e-5;
        let [after, before] = [f + df, f - df].map(|f| energy_beyond(law, &f, &relaxed).unwrap());
        let power = (law.first_piola(&f) - f * relaxed).dot(&df);
        assert!(((after - before) / (2.0 * power) - 1.0).abs() < 1e-7);
        // Squeezed at once and let go slowly.
        let squeezed = Mat3::from_diagonal(&Vec3::new(1.2, 1.2, 0.5));
        let relaxed = second_piola(law, &squeezed).unwrap().to_matrix();
        assert!(energy_beyond(law, &Mat3::identity(), &relaxed).unwrap() > 0.0);
    }

    #[test]
    fn the_update_is_exact_for_a_stress_that_grows_evenly_in_steps_of_any_length() {
        let term = PronyTerm { share: 1.0, time: 0.7 };
        // dA/dt = (t - A)/tau from A(0) = 0.
        let exact = |t: f64| t - 0.7 * (1.0 - (-t / 0.7).exp());
        for h in [1e-9, 1e-3, 0.3, 50.0] {
            let (t, [a, b, c]) = (1.3, term.exact_update(h));
            let found = a * exact(t) + b * t + c * (t + h);
            assert!((found - exact(t + h)).abs() < 1e-12 * (t + h), "{h}: {found}");
        }
    }

    #[test]
    fn what_is_no_series_is_refused() {
        let of = |t: f64, terms: &[(f64, f64)]| {
            let terms = terms.iter().map(|(share, time)| PronyTerm { share: *share, time: *time }).collect();
            Relaxing::new(Arc::new(KelvinVoigt::new(1.0, 1.0, 0.3, t).unwrap()), terms).map_err(|e| e.key)
        };
        assert!(of(0.0, &[(0.5, 1.0); 6]).is_ok());
        assert_eq!(of(0.1, &[(0.5, 1.0)]).unwrap_err(), "material.relaxation_time");
        for terms in [&[][..], &[(0.5, 1.0); 7], &[(0.0, 1.0)], &[(0.5, -1.0)], &[(f64::NAN, 1.0)]] {
            assert_eq!(of(0.0, terms).unwrap_err(), "material.prony");
        }
    }
}
