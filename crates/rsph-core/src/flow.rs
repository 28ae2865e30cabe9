//! Velocity fields that are given, not computed: what a prescribed motion follows.

use crate::tensor::{Mat3, Vec3};
use crate::vector_field::VectorField;
use std::f64::consts::PI;

/// Distance over which velocity gradients are measured, in units of the domain.
const STEP: f64 = 1e-5;

/// A steady velocity field.
#[derive(Clone, Debug)]
pub enum VelocityField {
    /// The deformation of LeVeque and Enright in the unit cube, Eq. (18): free of divergence, zero on
    /// the faces of the cube.
    Leveque,
    /// Any other.
    Steady(VectorField),
}

impl VelocityField {
    /// The velocity at `x`.
    pub fn at(&self, x: &Vec3) -> Vec3 {
        match self {
            Self::Leveque => {
                let (sin, double) = (x.map(|c| (PI * c).sin().powi(2)), x.map(|c| (2.0 * PI * c).sin()));
                Vec3::new(
                    2.0 * sin.x * double.y * double.z,
                    -double.x * sin.y * double.z,
                    -double.x * double.y * sin.z,
                ) // Eq. (18)
            }
            Self::Steady(field) => field.at(x),
        }
    }
}

/// A velocity field with its course in time: what moves the particles of a prescribed motion.
#[derive(Clone, Debug)]
pub struct Flow {
    /// The field.
    pub velocity: VelocityField,
    /// P: the field is multiplied by cos(pi t / P), so that everything is back in its place at t = P;
    /// `None`: it is steady.
    pub reversal: Option<f64>,
}

impl Flow {
    /// Velocity at position `x` and time `t`.
    pub fn at(&self, x: &Vec3, t: f64) -> Vec3 {
        self.velocity.at(x) * self.amplitude(t)
    }

    /// The largest rate of strain or rotation |dv_i/dx_j| at `x` (1/s).
    pub fn rate_at(&self, x: &Vec3, t: f64) -> f64 {
        let step = STEP * x.amax().max(1.0);
        let gradient = Mat3::from_columns(&[0, 1, 2].map(|i| {
            let mut e = Vec3::zeros();
            e[i] = step;
            (self.velocity.at(&(x + e)) - self.velocity.at(&(x - e))) / (2.0 * step)
        }));
        gradient.amax() * self.amplitude(t).abs()
    }

    /// The largest rate of strain or rotation anywhere and at any time, if it is known (1/s).
    pub fn largest_rate(&self) -> Option<f64> {
        match &self.velocity {
            VelocityField::Leveque => Some(2.0 * PI),
            VelocityField::Steady(_) => None,
        }
    }

    fn amplitude(&self, t: f64) -> f64 {
        self.reversal.map_or(1.0, |p| (PI * t / p).cos())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_deformation_is_free_of_divergence(x in prop::array::uniform3(0.0..1.0_f64)) {
            let (x, e) = (Vec3::from(x), 1e-5);
            let divergence: f64 = (0..3)
                .map(|i| {
                    let mut d = Vec3::zeros();
                    d[i] = e;
                    (VelocityField::Leveque.at(&(x + d))[i] - VelocityField::Leveque.at(&(x - d))[i]) / (2.0 * e)
                })
                .sum();
            prop_assert!(divergence.abs() < 1e-8, "{divergence}");
        }
    }

    #[test]
    fn nothing_leaves_the_cube_and_time_turns_back() {
        let flow = Flow { velocity: VelocityField::Leveque, reversal: Some(2.0) };
        assert!(flow.at(&Vec3::new(1.0, 0.3, 0.6), 0.0).x.abs() < 1e-15);
        let x = Vec3::new(0.2, 0.3, 0.6);
        assert!((flow.at(&x, 0.25) + flow.at(&x, 1.75)).norm() < 1e-15);
        assert!(flow.at(&x, 0.0).norm() > 0.1);
        // The largest gradient of the field is 2 pi.
        let x = Vec3::new(0.25, 0.25, 0.25);
        assert!((flow.rate_at(&x, 0.0) - 2.0 * PI).abs() < 1e-6);
    }
}
