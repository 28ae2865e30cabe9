//! Materials. One model a file, plus one line in [`REGISTRY`].

mod composition;
mod corotated;
mod damped;
mod damping;
mod finite_strain;
mod fung;
mod holzapfel_gasser_ogden;
mod hyperelastic;
mod isochoric;
mod kelvin_voigt;
mod laminate;
mod model;
mod mooney_rivlin;
mod neo_hookean;
mod ogden;
mod prony;
mod saint_venant_kirchhoff;
mod scaled;
mod veronda_westmann;
mod yeoh;

pub use composition::Composition;
pub(crate) use composition::MaterialSet;
pub use corotated::Corotated;
pub(crate) use corotated::rotation_of;
pub use damped::Damped;
pub use finite_strain::FiniteStrain;
pub use fung::Fung;
pub use holzapfel_gasser_ogden::HolzapfelGasserOgden;
pub use hyperelastic::{Formula, Hyperelastic};
pub use isochoric::{Invariants, Isochoric};
pub use kelvin_voigt::KelvinVoigt;
pub use laminate::Interface;
pub use model::{Kind, Model, Parameter, Values, model, models, register};
pub use mooney_rivlin::MooneyRivlin;
pub use neo_hookean::NeoHookean;
pub use ogden::Ogden;
pub use prony::{MAX_TERMS, PRONY, PronyTerm, Relaxing};
pub(crate) use prony::{energy_beyond, second_piola};
pub use saint_venant_kirchhoff::SaintVenantKirchhoff;
pub(crate) use scaled::Scaled;
pub use veronda_westmann::VerondaWestmann;
pub use yeoh::Yeoh;

use crate::tensor::{Mat3, SymTensor, Vec3};
use model::{ISOTROPIC, TISSUE, tissue};
use std::fmt::Debug;

/// A constitutive law with its density and damping.
pub trait Material: Debug + Send + Sync {
    /// Name in scenario files.
    fn name(&self) -> &'static str;
    /// Density rho in the undeformed state (kg/m^3).
    fn density(&self) -> f64;
    /// Relaxation time T (s): viscosity over stiffness in the undeformed state.
    fn relaxation_time(&self) -> f64;
    /// Stress as a function of the deformation.
    fn law(&self) -> Law<'_>;
    /// Stiffness in the undeformed state.
    fn stiffness(&self) -> Stiffness {
        self.law().stiffness()
    }
    /// Young's modulus (Pa) in the undeformed state, by the mean over all directions where they differ: the scale of
    /// the hourglass term and of penalties.
    fn young_modulus(&self) -> f64 {
        self.stiffness().young_modulus()
    }
    /// P-wave modulus lambda + 2 mu (Pa) in the undeformed state: the scale of waves and of volume changes.
    fn p_wave_modulus(&self) -> f64 {
        self.stiffness().p_wave_modulus()
    }
    /// Shear modulus mu (Pa) in the undeformed state.
    fn shear_modulus(&self) -> f64 {
        self.stiffness().shear_modulus()
    }
    /// Terms of the Prony series by which the stress relaxes to S^e of the law; none if it does not.
    fn prony(&self) -> &[PronyTerm] {
        &[]
    }
    /// Direction of its fibres, a unit vector; `None` if it has none.
    fn fibre(&self) -> Option<Vec3> {
        None
    }
    /// What deformation it is for.
    fn range(&self) -> Range {
        match self.law() {
            Law::Linear(_) => Range { strain: SMALL_STRAIN, turn: SMALL_TURN },
            Law::FiniteStrain(_) => Range { strain: f64::INFINITY, turn: f64::INFINITY },
        }
    }
}

/// What deformation a law is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Largest change of a length over the length.
    pub strain: f64,
    /// Largest angle of a rotation (rad).
    pub turn: f64,
}

impl Range {
    /// Whether there is a deformation that it is not for.
    pub fn is_limited(&self) -> bool {
        self.strain.is_finite() || self.turn.is_finite()
    }
}

/// Strain and turn (rad) up to which a linear law is right to a few per cent: 5 % and 5 degrees.
const SMALL_STRAIN: f64 = 0.05;
const SMALL_TURN: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Stress as a function of the deformation gradient F = dx/dX = 1 + grad u and its rate.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "one at a time, on the stack of a sweep")]
pub enum Law<'a> {
    /// sigma = C : (e + T de/dt), e = sym grad u, Eq. (5).
    Linear(Stiffness),
    /// Any law P(F, dF/dt).
    FiniteStrain(&'a dyn FiniteStrain),
}

impl<'a> Law<'a> {
    /// The law for any deformation; `None` for a linear one.
    pub fn finite_strain(self) -> Option<&'a dyn FiniteStrain> {
        match self {
            Self::Linear(_) => None,
            Self::FiniteStrain(law) => Some(law),
        }
    }

    /// Stiffness at F = 1.
    pub fn stiffness(&self) -> Stiffness {
        match self {
            Self::Linear(stiffness) => *stiffness,
            Self::FiniteStrain(law) => Stiffness::of(|strain| {
                SymTensor::symmetric_part(&law.tangent(&Mat3::identity(), &strain.to_matrix()))
            }),
        }
    }

    /// Energy per undeformed volume (J/m^3) at this displacement gradient; infinite where the body is turned inside out.
    #[inline]
    pub fn energy_density(&self, gradient: &Mat3) -> f64 {
        match self {
            Self::Linear(stiffness) => stiffness.energy_density(SymTensor::symmetric_part(gradient)),
            Self::FiniteStrain(law) => law.energy(&(Mat3::identity() + gradient)),
        }
    }

    /// Strain and Cauchy stress as results show them, of the displacement gradient grad u and its rate: e and sigma of a linear
    /// law, else Hencky's strain ln V and P F^T / det F, viscosity included.
    pub fn measures(&self, relaxation_time: f64, gradient: &Mat3, rate: &Mat3) -> (SymTensor, SymTensor) {
        match self {
            Self::Linear(stiffness) => {
                let effective = SymTensor::symmetric_part(&(gradient + rate * relaxation_time));
                (SymTensor::symmetric_part(gradient), stiffness.stress(effective))
            }
            Self::FiniteStrain(law) => {
                let f = Mat3::identity() + gradient;
                let piola = law.first_piola(&f) + law.viscous_piola(&f, rate);
                let cauchy = SymTensor::symmetric_part(&(piola * f.transpose() / f.determinant()));
                (logarithmic_strain(&f), cauchy)
            }
        }
    }
}

/// Hencky's strain ln V = 1/2 ln(F F^T).
pub(crate) fn logarithmic_strain(f: &Mat3) -> SymTensor {
    let eigen = (f * f.transpose()).symmetric_eigen();
    let logarithms = eigen.eigenvalues.map(|s| 0.5 * s.max(f64::MIN_POSITIVE).ln());
    let strain = eigen.eigenvectors * Mat3::from_diagonal(&logarithms) * eigen.eigenvectors.transpose();
    SymTensor::symmetric_part(&strain)
}

/// A linear map from strain to stress, both with their six components in VTK order (Pa).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness(pub [[f64; 6]; 6]);

impl Stiffness {
    /// The matrix of a linear function from strain to stress.
    pub fn of(stress: impl Fn(SymTensor) -> SymTensor) -> Self {
        let unit = |j: usize| SymTensor(std::array::from_fn(|k| f64::from(u8::from(k == j))));
        let columns: [SymTensor; 6] = std::array::from_fn(|j| stress(unit(j)));
        Self(std::array::from_fn(|i| columns.map(|c| c.0[i])))
    }

    /// lambda 1 (x) 1 + 2 mu I.
    pub fn isotropic(mu: f64, lambda: f64) -> Self {
        Self(std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let shear = if i == j { 2.0 * mu } else { 0.0 };
                shear + if i < 3 && j < 3 { lambda } else { 0.0 }
            })
        }))
    }

    /// C : e.
    #[inline(always)]
    pub fn stress(&self, strain: SymTensor) -> SymTensor {
        SymTensor(self.0.map(|row| row.iter().zip(strain.0).map(|(c, e)| c * e).sum()))
    }

    /// Energy density 1/2 e : C : e (J/m^3).
    pub fn energy_density(&self, strain: SymTensor) -> f64 {
        0.5 * self.stress(strain).double_dot(strain)
    }

    /// The stiffness of the material turned by the rotation R: R (C : (R^T e R)) R^T.
    #[must_use]
    pub fn turned(&self, turn: &Mat3) -> Self {
        Self::of(|strain| {
            let strain = SymTensor::symmetric_part(&(turn.transpose() * strain.to_matrix() * turn));
            SymTensor::symmetric_part(&(turn * self.stress(strain).to_matrix() * turn.transpose()))
        })
    }

    /// Strain at a stress, C^-1 : sigma; zero where C has no inverse.
    pub fn strain(&self, stress: SymTensor) -> SymTensor {
        let matrix = nalgebra::Matrix6::from_fn(|i, j| self.0[i][j]);
        let inverse = matrix.try_inverse().unwrap_or_else(nalgebra::Matrix6::zeros);
        SymTensor((inverse * nalgebra::Vector6::from(stress.0)).into())
    }

    /// Young's modulus (Pa) of the isotropic material that is as stiff in the mean over all directions (Voigt): it does not change where
    /// the material is turned.
    pub fn young_modulus(&self) -> f64 {
        let c = &self.0;
        let of_volume: f64 = c[..3].iter().flat_map(|row| &row[..3]).sum();
        let along = c[0][0] + c[1][1] + c[2][2] + c[3][3] + c[4][4] + c[5][5];
        let (bulk, shear) = (of_volume / 9.0, (along - of_volume / 3.0) / 10.0);
        9.0 * bulk * shear / (3.0 * bulk + shear)
    }

    /// P-wave modulus (Pa), the largest of those along the axes.
    pub fn p_wave_modulus(&self) -> f64 {
        (0..3).map(|i| self.0[i][i]).fold(0.0, f64::max)
    }

    /// Shear modulus (Pa), the mean of those in the planes of the axes.
    pub fn shear_modulus(&self) -> f64 {
        (3..6).map(|i| self.0[i][i]).sum::<f64>() / 6.0
    }
}

impl std::ops::Mul<f64> for Stiffness {
    type Output = Self;

    fn mul(self, k: f64) -> Self {
        Self(self.0.map(|row| row.map(|c| c * k)))
    }
}

/// All material models of this crate; [`models`] has those that were added to them as well.
pub const REGISTRY: &[Model] = &[
    kelvin_voigt::MODEL,
    corotated::MODEL,
    neo_hookean::MODEL,
    saint_venant_kirchhoff::MODEL,
    mooney_rivlin::MODEL,
    yeoh::MODEL,
    ogden::MODEL,
    veronda_westmann::MODEL,
    fung::MODEL,
    holzapfel_gasser_ogden::MODEL,
];
