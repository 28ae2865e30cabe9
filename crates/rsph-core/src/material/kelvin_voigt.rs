//! The linear viscoelastic solid of Hooke and Kelvin-Voigt, Eqs. (5) and (6).

use super::{ISOTROPIC, Law, Material, Model, Stiffness};
use crate::error::InvalidInput;
use std::sync::Arc;

/// Refuses a parameter that is not positive.
pub(super) fn positive(key: &str, x: f64, hint: &str) -> Result<(), InvalidInput> {
    if x.is_finite() && x > 0.0 {
        Ok(())
    } else {
        Err(InvalidInput::new(key, x, "must be a positive number", hint))
    }
}

/// Eq. (5): sigma = 2 mu (e + T de/dt) + lambda tr(e + T de/dt) I.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KelvinVoigt {
    density: f64,
    relaxation_time: f64,
    mu: f64,
    lambda: f64,
}

pub(super) const MODEL: Model = Model {
    name: "kelvin-voigt",
    doc: "linear elastic solid with Kelvin-Voigt damping (Eq. 5), for small strain",
    parameters: &ISOTROPIC,
    build: |v| {
        let [density, young_modulus, poisson_ratio, relaxation_time] = v.isotropic();
        Ok(Arc::new(KelvinVoigt::new(density, young_modulus, poisson_ratio, relaxation_time)?))
    },
};

impl KelvinVoigt {
    /// A material from density rho (kg/m^3), Young's modulus E (Pa), Poisson's ratio nu and
    /// relaxation time T (s).
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(
        density: f64,
        young_modulus: f64,
        poisson_ratio: f64,
        relaxation_time: f64,
    ) -> Result<Self, InvalidInput> {
        positive("material.density", density, "soft tissue: about 1000 kg/m^3")?;
        positive("material.young_modulus", young_modulus, "liver: about 1e5 Pa, kidney: about 1e4 Pa")?;
        if !(poisson_ratio > -1.0 && poisson_ratio < 0.5) {
            return Err(InvalidInput::new(
                "material.poisson_ratio",
                poisson_ratio,
                "must be greater than -1 and less than 0.5, where the solid becomes incompressible",
                "the paper uses 0.3; for nearly incompressible tissue take 0.45 to 0.49",
            ));
        }
        if !(relaxation_time.is_finite() && relaxation_time >= 0.0) {
            return Err(InvalidInput::new(
                "material.relaxation_time",
                relaxation_time,
                "must be zero or positive (s)",
                "the paper uses 0.2 s; 0 switches the damping off",
            ));
        }
        // Eq. (6): the Lame constants.
        let mu = young_modulus / (2.0 * (1.0 + poisson_ratio));
        let lambda = poisson_ratio * young_modulus / ((1.0 - 2.0 * poisson_ratio) * (1.0 + poisson_ratio));
        Ok(Self { density, relaxation_time, mu, lambda })
    }

    /// A material from its shear modulus mu and bulk modulus K (Pa) instead.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub(super) fn of_moduli(
        density: f64,
        shear_modulus: f64,
        bulk_modulus: f64,
        relaxation_time: f64,
    ) -> Result<Self, InvalidInput> {
        positive("material.bulk_modulus", bulk_modulus, "a thousand shear moduli is nearly incompressible")?;
        let poisson_ratio =
            (3.0 * bulk_modulus - 2.0 * shear_modulus) / (6.0 * bulk_modulus + 2.0 * shear_modulus);
        let young_modulus = 2.0 * shear_modulus * (1.0 + poisson_ratio);
        Self::new(density, young_modulus, poisson_ratio, relaxation_time)
    }

    /// Bulk modulus K = lambda + 2/3 mu (Pa).
    pub(super) fn bulk_modulus(&self) -> f64 {
        self.lambda + 2.0 / 3.0 * self.mu
    }

    /// Lame constants (mu, lambda) in Pa, Eq. (6).
    pub fn lame(&self) -> (f64, f64) {
        (self.mu, self.lambda)
    }
}

impl Material for KelvinVoigt {
    fn name(&self) -> &'static str {
        MODEL.name
    }

    fn density(&self) -> f64 {
        self.density
    }

    fn relaxation_time(&self) -> f64 {
        self.relaxation_time
    }

    fn law(&self) -> Law<'_> {
        Law::Linear(Stiffness::isotropic(self.mu, self.lambda)) // Eq. (5)
    }
}
