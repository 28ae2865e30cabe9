//! The level set that particles carry: surface normals, Eq. (15).

use crate::kernel::QuarticSpline;
use crate::neighbors::Pairs;
use crate::tensor::Vec3;
use rayon::prelude::*;

/// Unit normals n = grad phi / |grad phi| of every particle, Eq. (15), with the gradient by Eq. (10);
/// zero where the gradient vanishes.
pub fn normals(
    positions: &[Vec3],
    volume: &[f64],
    level_set: &[f64],
    pairs: &Pairs,
    kernel: &QuarticSpline<3>,
) -> Vec<Vec3> {
    (0..positions.len())
        .into_par_iter()
        .map(|a| {
            let mut gradient = Vec3::zeros();
            for &b in pairs.of(a) {
                let b = b as usize;
                let x = positions[b] - positions[a];
                let r = x.norm();
                if r > 0.0 {
                    let w = kernel.gradient_weight(r);
                    gradient += volume[b] * (level_set[b] - level_set[a]) * w * x; // Eq. (10)
                }
            }
            gradient.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vec3::zeros)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_a_plane_and_a_sphere() {
        let dx = 0.1;
        let n = 9;
        let positions: Vec<Vec3> = (0..n * n * n)
            .map(|k| Vec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64) * dx)
            .collect();
        let volume = vec![dx * dx * dx; positions.len()];
        let kernel = QuarticSpline::<3>::new(1.25 * dx);
        let pairs = Pairs::new(&positions, kernel.support());
        let direction = Vec3::new(1.0, -2.0, 0.5).normalize();
        let centre = Vec3::repeat(-1.0);
        let plane: Vec<f64> = positions.iter().map(|x| x.dot(&direction)).collect();
        let sphere: Vec<f64> = positions.iter().map(|x| (x - centre).norm() - 1.0).collect();
        let middle = (n * n * n) / 2;
        let from_plane = normals(&positions, &volume, &plane, &pairs, &kernel);
        assert!((from_plane[middle] - direction).norm() < 1e-12);
        let from_sphere = normals(&positions, &volume, &sphere, &pairs, &kernel);
        assert!((from_sphere[middle] - (positions[middle] - centre).normalize()).norm() < 1e-2);
    }
}
