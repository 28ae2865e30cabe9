//! Measures of deformation and stress: fields that results have only where they are asked for.

use crate::material::logarithmic_strain;
use crate::particles::Field;
use crate::tensor::{Mat3, SymTensor, Vec3};

/// Fields that can be asked for beside those of every frame.
pub const MEASURES: &[Field] = &[
    Field::DeformationGradient,
    Field::VolumeRatio,
    Field::GreenLagrangeStrain,
    Field::HenckyStrain,
    Field::PrincipalStretch,
    Field::PrincipalStrain,
    Field::PrincipalDirection1,
    Field::PrincipalDirection2,
    Field::PrincipalDirection3,
    Field::MaxShearStrain,
    Field::PrincipalStress,
    Field::MaxShearStress,
    Field::Pressure,
    Field::FirstPiolaStress,
    Field::SecondPiolaStress,
];

/// Whether that is one of [`MEASURES`].
pub fn is_measure(field: Field) -> bool {
    MEASURES.contains(&field)
}

/// Whether a measure follows from the stress.
pub fn rests_on_stress(field: Field) -> bool {
    matches!(
        field,
        Field::PrincipalStress
            | Field::MaxShearStress
            | Field::Pressure
            | Field::FirstPiolaStress
            | Field::SecondPiolaStress
    )
}

/// Deformation and stress at one place of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalState {
    /// F = dx/dX = 1 + grad u, whatever the law.
    pub deformation: Mat3,
    /// Strain as results show it: e = sym grad u of a law for small strain, ln V of any other.
    pub strain: SymTensor,
    /// Cauchy's stress (Pa); sigma of a law for small strain.
    pub stress: SymTensor,
    /// Whether the law is for small strain and knows one stress only.
    pub is_small_strain: bool,
}

impl LocalState {
    /// The components of one of [`MEASURES`] behind what is in `out`; nothing for any other field.
    pub fn put(&self, field: Field, out: &mut Vec<f64>) {
        let f = &self.deformation;
        match field {
            Field::DeformationGradient => put_rows(f, out),
            Field::VolumeRatio => out.push(f.determinant()),
            Field::GreenLagrangeStrain => {
                out.extend(SymTensor::symmetric_part(&(0.5 * (f.transpose() * f - Mat3::identity()))).0);
            }
            Field::HenckyStrain => out.extend(logarithmic_strain(f).0),
            Field::PrincipalStretch => out.extend(principal_stretches(f)),
            Field::PrincipalStrain => out.extend(Principal::of(self.strain).values),
            Field::PrincipalDirection1 => out.extend(Principal::of(self.strain).direction(0).iter()),
            Field::PrincipalDirection2 => out.extend(Principal::of(self.strain).direction(1).iter()),
            Field::PrincipalDirection3 => out.extend(Principal::of(self.strain).direction(2).iter()),
            Field::MaxShearStrain => out.push(Principal::of(self.strain).largest_shear()),
            Field::PrincipalStress => out.extend(Principal::of(self.stress).values),
            Field::MaxShearStress => out.push(Principal::of(self.stress).largest_shear()),
            Field::Pressure => out.push(-self.stress.trace() / 3.0),
            Field::FirstPiolaStress => put_rows(&self.first_piola(), out),
            Field::SecondPiolaStress => out.extend(self.second_piola().0),
            _ => {}
        }
    }

    /// P = J sigma F^-T (Pa): force per undeformed area.
    fn first_piola(&self) -> Mat3 {
        let sigma = self.stress.to_matrix();
        if self.is_small_strain {
            return sigma;
        }
        let f = &self.deformation;
        let inverse = f.try_inverse().unwrap_or_else(|| Mat3::repeat(f64::NAN));
        f.determinant() * sigma * inverse.transpose()
    }

    /// S = F^-1 P (Pa).
    fn second_piola(&self) -> SymTensor {
        if self.is_small_strain {
            return self.stress;
        }
        let inverse = self.deformation.try_inverse().unwrap_or_else(|| Mat3::repeat(f64::NAN));
        SymTensor::symmetric_part(&(inverse * self.first_piola()))
    }
}

/// Principal values of a symmetric tensor, the largest first, and its principal directions.
struct Principal {
    values: [f64; 3],
    directions: Mat3,
    order: [usize; 3],
}

impl Principal {
    fn of(tensor: SymTensor) -> Self {
        let matrix = tensor.to_matrix();
        if !matrix.iter().all(|x| x.is_finite()) {
            return Self { values: [f64::NAN; 3], directions: Mat3::repeat(f64::NAN), order: [0, 1, 2] };
        }
        let eigen = matrix.symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|i, j| eigen.eigenvalues[*j].total_cmp(&eigen.eigenvalues[*i]));
        Self { values: order.map(|i| eigen.eigenvalues[i]), directions: eigen.eigenvectors, order }
    }

    /// Unit vector of principal value `k`; of its two signs the one whose largest component is positive.
    fn direction(&self, k: usize) -> Vec3 {
        let direction: Vec3 = self.directions.column(self.order[k]).into_owned();
        let sign = if direction[direction.iamax()] < 0.0 { -1.0 } else { 1.0 };
        direction * sign
    }

    /// Half of the difference between the largest and the smallest: the largest shear in any plane.
    fn largest_shear(&self) -> f64 {
        0.5 * (self.values[0] - self.values[2])
    }
}

/// Ratios of lengths after and before, lambda_1 >= lambda_2 >= lambda_3.
fn principal_stretches(f: &Mat3) -> [f64; 3] {
    let squares = SymTensor::symmetric_part(&(f * f.transpose()));
    Principal::of(squares).values.map(|square| square.max(0.0).sqrt())
}

/// The nine components, row by row.
fn put_rows(matrix: &Mat3, out: &mut Vec<f64>) {
    out.extend(matrix.transpose().iter());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(state: &LocalState, field: Field) -> Vec<f64> {
        let mut out = Vec::new();
        state.put(field, &mut out);
        assert_eq!(out.len(), field.spec().components, "{field:?}");
        out
    }

    fn close(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        let far = |(a, b): (&f64, &f64)| (a - b).abs() > 1e-12;
        assert!(!found.iter().zip(expected).any(far), "{found:?} {expected:?}");
    }

    fn deformed(deformation: Mat3) -> LocalState {
        let strain = logarithmic_strain(&deformation);
        LocalState { deformation, strain, stress: SymTensor::ZERO, is_small_strain: false }
    }

    #[test]
    fn simple_shear_has_its_closed_form() {
        let shear: f64 = 1.3;
        let mut f = Mat3::identity();
        f[(0, 1)] = shear;
        let state = deformed(f);
        let stretch = shear / 2.0 + (1.0 + shear * shear / 4.0).sqrt();
        close(&value(&state, Field::PrincipalStretch), &[stretch, 1.0, 1.0 / stretch]);
        let ln = stretch.ln();
        close(&value(&state, Field::PrincipalStrain), &[ln, 0.0, -ln]);
        close(&value(&state, Field::MaxShearStrain), &[ln]);
        close(&value(&state, Field::VolumeRatio), &[1.0]);
        let green = [0.0, shear * shear / 2.0, 0.0, shear / 2.0, 0.0, 0.0];
        close(&value(&state, Field::GreenLagrangeStrain), &green);
        // The axes of V: tan(2 angle) = 2 / shear.
        let angle = 0.5 * (2.0 / shear).atan();
        let (sin, cos) = angle.sin_cos();
        close(&value(&state, Field::PrincipalDirection1), &[cos, sin, 0.0]);
        close(&value(&state, Field::PrincipalDirection2), &[0.0, 0.0, 1.0]);
        close(&value(&state, Field::PrincipalDirection3), &[-sin, cos, 0.0]);
        let (double_sin, double_cos) = (2.0 * angle).sin_cos();
        let hencky = [ln * double_cos, -ln * double_cos, 0.0, ln * double_sin, 0.0, 0.0];
        close(&value(&state, Field::HenckyStrain), &hencky);
        close(&value(&state, Field::DeformationGradient), &[1.0, shear, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn a_rotation_strains_nothing_and_turns_stress() {
        let turn = *nalgebra::Rotation3::new(Vec3::new(0.4, -1.1, 0.7)).matrix();
        let axial = Vec3::new(1.2, 0.9, 0.95);
        let stretch = Mat3::from_diagonal(&axial);
        let rigid = deformed(turn);
        close(&value(&rigid, Field::GreenLagrangeStrain), &[0.0; 6]);
        close(&value(&rigid, Field::HenckyStrain), &[0.0; 6]);
        close(&value(&rigid, Field::PrincipalStretch), &[1.0; 3]);
        // Uniaxial stress along x, stretched and then turned: S does not know of the turn.
        let sigma = Mat3::from_diagonal(&Vec3::new(5.0, 0.0, 0.0));
        let turned = turn * sigma * turn.transpose();
        let state = LocalState { stress: SymTensor::symmetric_part(&turned), ..deformed(turn * stretch) };
        let nominal = 5.0 * axial.y * axial.z;
        close(&value(&state, Field::SecondPiolaStress), &[nominal / axial.x, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let piola = turn * Mat3::from_diagonal(&Vec3::new(nominal, 0.0, 0.0));
        close(&value(&state, Field::FirstPiolaStress), piola.transpose().as_slice());
        close(&value(&state, Field::PrincipalStress), &[5.0, 0.0, 0.0]);
        close(&value(&state, Field::MaxShearStress), &[2.5]);
        close(&value(&state, Field::Pressure), &[-5.0 / 3.0]);
        close(&value(&state, Field::VolumeRatio), &[1.2 * 0.9 * 0.95]);
        let strain: Vec<f64> = [1.2_f64, 0.95, 0.9].iter().map(|x| x.ln()).collect();
        close(&value(&state, Field::PrincipalStrain), &strain);
    }

    #[test]
    fn small_strain_has_one_stress_and_the_strain_of_engineers() {
        let gradient = Mat3::new(0.01, 0.004, 0.0, 0.002, -0.003, 0.0, 0.0, 0.0, -0.003);
        let strain = SymTensor::symmetric_part(&gradient);
        let stress = SymTensor([3.0, 1.0, 1.0, 0.5, 0.0, 0.0]);
        let deformation = Mat3::identity() + gradient;
        let state = LocalState { deformation, strain, stress, is_small_strain: true };
        close(&value(&state, Field::SecondPiolaStress), &stress.0);
        close(&value(&state, Field::FirstPiolaStress), &[3.0, 0.5, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 1.0]);
        // Mohr's circle.
        let (centre, radius) = (0.0035, (0.0065_f64.powi(2) + 0.003_f64.powi(2)).sqrt());
        let found = value(&state, Field::PrincipalStrain);
        close(&[found[0]], &[centre + radius]);
        close(&value(&state, Field::MaxShearStrain), &[0.5 * (found[0] - found[2])]);
    }
}
