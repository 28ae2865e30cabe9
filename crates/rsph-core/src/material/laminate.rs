//! Two materials in one cell, with a plane between them: a laminate.
//!
//! With the volume fractions s and 1 - s and the unit normal N of the plane, the deformation gradients of the layers are
//!
//! ```text
//! F_1 = F + (1 - s) a (x) N,      F_2 = F - s a (x) N,
//! ```
//!
//! so that their mean is F and the displacement is continuous. The jump a makes the energy s W_1(F_1) + (1 - s) W_2(F_2) least, so
//! that the tractions P_1 N = P_2 N are equal (Milton, The Theory of Composites, chapter 9). The mean stress s P_1 + (1 - s) P_2 is the
//! derivative of that energy. Springs in series and springs in parallel are both exact, which a mean of the moduli is not.

use super::scaled::Scaled;
use super::{FiniteStrain, Stiffness};
use crate::tensor::{Mat3, SymTensor, Vec3};

/// Steps of Newton's method for the jump.
const MAX_STEPS: usize = 25;
/// Halvings of such a step.
const MAX_HALVINGS: i32 = 20;
/// Difference of the tractions at which the jump is good enough, in units of the smaller shear modulus.
const TOLERANCE: f64 = 1e-11;

/// How two materials share a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Volume fraction of the first material, between 0 and 1.
    pub share: f64,
    /// Unit normal of the plane between them, in the undeformed body.
    pub normal: Vec3,
}

impl Interface {
    /// The deformation gradients of the layers.
    fn gradients(&self, f: &Mat3, jump: &Vec3) -> [Mat3; 2] {
        let step = jump * self.normal.transpose();
        [f + step * (1.0 - self.share), f - step * self.share]
    }

    /// The mean of two tensors in the layers.
    fn mean(&self, of: [Mat3; 2]) -> Mat3 {
        of[0] * self.share + of[1] * (1.0 - self.share)
    }

    /// The jump of two linear materials at a strain of the cell, -(N . C' . N)^-1 (C_1 - C_2) : e N with C' = (1 - s) C_1 + s C_2.
    fn linear_jump(&self, of: [&Stiffness; 2]) -> impl Fn(SymTensor) -> Vec3 {
        let (s, n) = (self.share, self.normal);
        let [first, second] = of.map(|stiffness| *stiffness);
        let acoustic = Mat3::from_columns(&std::array::from_fn::<_, 3, _>(|k| {
            let strain = SymTensor::symmetric_part(&(Vec3::ith(k, 1.0) * n.transpose()));
            first.stress(strain).dot(&n) * (1.0 - s) + second.stress(strain).dot(&n) * s
        }));
        let inverse = acoustic.try_inverse().unwrap_or_else(Mat3::zeros);
        move |strain| -(inverse * (first.stress(strain).dot(&n) - second.stress(strain).dot(&n)))
    }

    /// The stiffness of two linear materials.
    pub(crate) fn stiffness(&self, of: [&Stiffness; 2]) -> Stiffness {
        let jump = self.linear_jump(of);
        Stiffness::of(|strain| {
            let layers =
                self.gradients(&strain.to_matrix(), &jump(strain)).map(|g| SymTensor::symmetric_part(&g));
            of[0].stress(layers[0]) * self.share + of[1].stress(layers[1]) * (1.0 - self.share)
        })
    }

    /// The displacement gradient of the first layer of two linear materials.
    pub(crate) fn first_linear_layer(&self, of: [&Stiffness; 2], gradient: &Mat3) -> Mat3 {
        let jump = self.linear_jump(of)(SymTensor::symmetric_part(gradient));
        self.gradients(gradient, &jump)[0]
    }
}

/// A laminate of two laws.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Laminate<'a> {
    pub(crate) interface: Interface,
    pub(crate) layers: [Scaled<'a>; 2],
    /// The smaller of the shear moduli (Pa).
    pub(crate) shear_modulus: f64,
}

impl Laminate<'_> {
    fn layer_energy(&self, of: &[Mat3; 2]) -> f64 {
        let s = self.interface.share;
        s * self.layers[0].energy(&of[0]) + (1.0 - s) * self.layers[1].energy(&of[1])
    }

    /// The difference of the tractions.
    fn mismatch(&self, of: &[Mat3; 2]) -> Vec3 {
        (self.layers[0].first_piola(&of[0]) - self.layers[1].first_piola(&of[1])) * self.interface.normal
    }

    /// How the difference of the tractions answers to the jump.
    fn acoustic(&self, of: &[Mat3; 2]) -> Mat3 {
        let (s, n) = (self.interface.share, &self.interface.normal);
        Mat3::from_columns(&std::array::from_fn::<_, 3, _>(|k| {
            let step = Vec3::ith(k, 1.0) * n.transpose();
            self.layers[0].tangent(&of[0], &step) * n * (1.0 - s)
                + self.layers[1].tangent(&of[1], &step) * n * s
        }))
    }

    /// The deformation gradients of the layers; that of the cell in both where it is turned inside out.
    pub(crate) fn gradients(&self, f: &Mat3) -> [Mat3; 2] {
        let mut jump = Vec3::zeros();
        let mut of = self.interface.gradients(f, &jump);
        let mut energy = self.layer_energy(&of);
        if !energy.is_finite() {
            return of;
        }
        for _ in 0..MAX_STEPS {
            let mismatch = self.mismatch(&of);
            if mismatch.norm() <= TOLERANCE * self.shear_modulus {
                break;
            }
            let acoustic = self.acoustic(&of);
            let step = match acoustic.cholesky() {
                Some(factors) => -factors.solve(&mismatch),
                None => mismatch * (-1.0 / acoustic.norm().max(f64::MIN_POSITIVE)),
            };
            // As long as it lowers the energy, but for rounding.
            let slack = 1e-13 * (energy.abs() + acoustic.norm());
            let mut shorter = (0..MAX_HALVINGS).map(|k| jump + step * 0.5_f64.powi(k)).map(|jump| {
                let layers = self.interface.gradients(f, &jump);
                (jump, layers, self.layer_energy(&layers))
            });
            let Some(lower) = shorter.find(|(.., found)| *found <= energy + slack) else { break };
            (jump, of, energy) = lower;
        }
        of
    }

    /// The tangent at F as a function of dF.
    pub(crate) fn tangent_at(&self, f: &Mat3) -> impl Fn(&Mat3) -> Mat3 {
        let of = self.gradients(f);
        let inverse = self.acoustic(&of).try_inverse().unwrap_or_else(Mat3::zeros);
        move |df| {
            let alone = [0, 1].map(|k| self.layers[k].tangent(&of[k], df));
            let jump = -(inverse * ((alone[0] - alone[1]) * self.interface.normal));
            let changes = self.interface.gradients(df, &jump);
            self.interface.mean([0, 1].map(|k| self.layers[k].tangent(&of[k], &changes[k])))
        }
    }
}

impl FiniteStrain for Laminate<'_> {
    fn energy(&self, f: &Mat3) -> f64 {
        self.layer_energy(&self.gradients(f))
    }

    fn first_piola(&self, f: &Mat3) -> Mat3 {
        let of = self.gradients(f);
        self.interface.mean([0, 1].map(|k| self.layers[k].first_piola(&of[k])))
    }

    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3 {
        self.tangent_at(f)(df)
    }

    /// Both layers at the rate of the cell.
    fn viscous_piola(&self, f: &Mat3, f_rate: &Mat3) -> Mat3 {
        self.interface.mean([0, 1].map(|k| self.layers[k].viscous_piola(f, f_rate)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{KelvinVoigt, Law, Material, NeoHookean};

    const NORMAL: [f64; 3] = [1.0, -2.0, 0.5];

    fn interface() -> Interface {
        Interface { share: 0.3, normal: Vec3::from(NORMAL).normalize() }
    }

    fn laminate(of: [&dyn FiniteStrain; 2]) -> Laminate<'_> {
        let layers = of.map(|law| Scaled { law, factor: 1.0, turn: None });
        Laminate { interface: interface(), layers, shear_modulus: 1.0 }
    }

    #[test]
    fn layers_in_series_add_their_compliances_and_in_parallel_their_stiffnesses() {
        let of = [10.0, 1.0].map(|e| KelvinVoigt::new(1.0, e, 0.0, 0.0).unwrap().stiffness());
        let c = Interface { share: 0.3, normal: Vec3::x() }.stiffness([&of[0], &of[1]]);
        assert!((c.0[0][0] - 1.0 / (0.3 / 10.0 + 0.7)).abs() < 1e-12);
        assert!((c.0[1][1] - (3.0 + 0.7)).abs() < 1e-12);
        // Shear across the plane is in series, shear in it in parallel.
        assert!((c.0[3][3] - 1.0 / (0.3 / 10.0 + 0.7)).abs() < 1e-12);
        assert!((c.0[4][4] - (3.0 + 0.7)).abs() < 1e-12);
    }

    #[test]
    fn at_small_strain_it_is_the_laminate_of_the_stiffnesses() {
        let of = [(10.0, 0.45), (1.0, 0.3)].map(|(e, nu)| NeoHookean::new(1.0, e, nu, 0.0).unwrap());
        let laws = [&of[0], &of[1]].map(|m| m.law().finite_strain().unwrap());
        let exact = interface().stiffness([&of[0].stiffness(), &of[1].stiffness()]);
        let found = Law::FiniteStrain(&laminate(laws)).stiffness();
        for i in 0..6 {
            for j in 0..6 {
                assert!((found.0[i][j] - exact.0[i][j]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn stress_and_tangent_are_derivatives_and_tractions_agree_at_large_strain() {
        let of = [(10.0, 0.49), (1.0, 0.3)].map(|(e, nu)| NeoHookean::new(1.0, e, nu, 0.0).unwrap());
        let laminate = laminate([&of[0], &of[1]].map(|m| m.law().finite_strain().unwrap()));
        let f = Mat3::new(1.3, -0.3, 0.2, 0.05, 0.9, -0.1, 0.4, 0.15, 1.1);
        let layers = laminate.gradients(&f);
        assert!(laminate.mismatch(&layers).norm() < 1e-10);
        assert!((interface().mean(layers) - f).amax() < 1e-14);
        let (piola, h) = (laminate.first_piola(&f), 1e-5);
        for c in 0..9 {
            let mut df = Mat3::zeros();
            df[(c / 3, c % 3)] = h;
            let slope = (laminate.energy(&(f + df)) - laminate.energy(&(f - df))) / (2.0 * h);
            assert!((slope - piola[(c / 3, c % 3)]).abs() < 1e-6, "{slope} {}", piola[(c / 3, c % 3)]);
            let change = (laminate.first_piola(&(f + df)) - laminate.first_piola(&(f - df))) / 2.0;
            assert!((change - laminate.tangent(&f, &df)).amax() < 1e-6 * h.sqrt());
        }
        let turn = *nalgebra::Rotation3::from_scaled_axis(Vec3::new(0.4, 1.0, -0.7)).matrix();
        assert!((laminate.first_piola(&(turn * f)) - turn * piola).amax() < 1e-9);
    }
}
