//! Trilinear hexahedra: the stiffness of a full cubic block of the body's material.

use crate::material::Stiffness;
use crate::tensor::{Mat3, SymTensor, Vec3};

/// Corner `k` of a unit cube, x fastest.
pub fn corner(k: usize) -> [usize; 3] {
    [k & 1, k >> 1 & 1, k >> 2]
}

/// Stiffness between the corners of a cube with edge 1; that of a cube with edge H is H times this.
/// Block (m, n) is the force on corner m against a displacement of corner n. Of the pressure, -tr(sigma)/3,
/// the share `pressure` counts, 0 to 1.
pub fn stiffness(material: &Stiffness, pressure: f64) -> [[Mat3; 8]; 8] {
    // Two Gauss points along each axis are exact for trilinear functions.
    let gauss = |k: usize| if k == 0 { 0.5 - 0.75_f64.sqrt() / 3.0 } else { 0.5 + 0.75_f64.sqrt() / 3.0 };
    let mut blocks = [[Mat3::zeros(); 8]; 8];
    for q in 0..8 {
        let x = corner(q).map(gauss);
        let strain = |n: usize, j: usize| {
            let mut direction = Vec3::zeros();
            direction[j] = 1.0;
            SymTensor::symmetric_part(&(direction * gradient(n, x).transpose()))
        };
        for n in 0..8 {
            for j in 0..3 {
                let sigma = material.stress(strain(n, j));
                let less = (pressure - 1.0) / 3.0 * (sigma.0[0] + sigma.0[1] + sigma.0[2]);
                let sigma = sigma + SymTensor([less, less, less, 0.0, 0.0, 0.0]);
                for (m, block) in blocks.iter_mut().enumerate() {
                    for i in 0..3 {
                        block[n][(i, j)] += strain(m, i).double_dot(sigma) / 8.0;
                    }
                }
            }
        }
    }
    blocks
}

/// Gradient of the shape function of corner `n` at a point of the unit cube.
fn gradient(n: usize, x: [f64; 3]) -> Vec3 {
    let c = corner(n);
    let value = |i: usize| if c[i] == 1 { x[i] } else { 1.0 - x[i] };
    let slope = |i: usize| if c[i] == 1 { 1.0 } else { -1.0 };
    Vec3::from_fn(|i, _| (0..3).map(|j| if i == j { slope(j) } else { value(j) }).product())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{KelvinVoigt, Material};

    #[test]
    fn a_uniform_strain_meets_its_energy_and_a_rotation_no_force() {
        let material = KelvinVoigt::new(1.0, 10.0, 0.3, 0.0).unwrap();
        let k = stiffness(&material.stiffness(), 1.0);
        let position = |n: usize| Vec3::from_fn(|i, _| corner(n)[i] as f64);
        let force = |g: &Mat3, m: usize| (0..8).map(|n| k[m][n] * (g * position(n))).sum::<Vec3>();
        let g = Mat3::new(0.1, -0.3, 0.2, 0.05, 0.2, -0.1, 0.4, 0.15, -0.25);
        let energy: f64 = (0..8).map(|m| 0.5 * force(&g, m).dot(&(g * position(m)))).sum();
        let exact = material.stiffness().energy_density(SymTensor::symmetric_part(&g));
        assert!((energy / exact - 1.0).abs() < 1e-12);
        let spin = g - g.transpose();
        assert!((0..8).all(|m| force(&spin, m).norm() < 1e-12));
    }

    #[test]
    fn a_share_of_the_pressure_takes_from_dilation_and_not_from_shear() {
        let material = KelvinVoigt::new(1.0, 10.0, 0.49, 0.0).unwrap();
        let position = |n: usize| Vec3::from_fn(|i, _| corner(n)[i] as f64);
        let energy = |pressure: f64, g: &Mat3| -> f64 {
            let k = stiffness(&material.stiffness(), pressure);
            let force = |m: usize| (0..8).map(|n| k[m][n] * (g * position(n))).sum::<Vec3>();
            (0..8).map(|m| force(m).dot(&(g * position(m)))).sum()
        };
        let (dilation, shear) = (Mat3::identity(), Mat3::new(0.2, 0.3, 0.0, 0.0, -0.2, 0.1, 0.0, 0.0, 0.0));
        assert!((energy(0.3, &dilation) / energy(1.0, &dilation) - 0.3).abs() < 1e-12);
        assert!((energy(0.3, &shear) / energy(1.0, &shear) - 1.0).abs() < 1e-12);
    }
}
