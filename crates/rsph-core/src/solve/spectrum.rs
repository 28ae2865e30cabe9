//! The largest eigenvalue of D^-1 A, by the Lanczos process that hides in conjugate gradients.

use super::sums::{Sums, combine, noise};
use nalgebra::DMatrix;

/// Largest eigenvalue of D^-1 A from `steps` applications of A, from below: `apply(x, y)` gives y = A x,
/// `divide(r, z)` gives z = D^-1 r, both symmetric and not negative, for fields of `len` values. Zero if
/// A D^-1 is.
pub fn largest_eigenvalue(
    len: usize,
    steps: usize,
    apply: &mut dyn FnMut(&[f64], &mut [f64]),
    divide: &mut dyn FnMut(&[f64], &mut [f64]),
) -> f64 {
    let mut r = vec![0.0; len];
    noise(&mut r);
    let (mut z, mut p, mut q) = (vec![0.0; len], vec![0.0; len], vec![0.0; len]);
    let mut sums = Sums::new(len);
    let (mut diagonal, mut off) = (Vec::new(), Vec::new());
    let (mut rz, mut beta, mut before) = (0.0, 0.0, 1.0);
    for step in 0..steps {
        divide(&r, &mut z);
        let next = sums.dot(&r, &z);
        if step > 0 {
            beta = next / rz;
            off.push(beta.max(0.0).sqrt() / before);
        }
        rz = next;
        combine(1.0, &z, beta, &mut p);
        apply(&p, &mut q);
        let pq = sums.dot(&p, &q);
        if !(pq > 0.0 && rz > 0.0) {
            off.pop();
            break;
        }
        let alpha = rz / pq;
        diagonal.push(1.0 / alpha + beta / before);
        before = alpha;
        combine(-alpha, &q, 1.0, &mut r);
    }
    let k = diagonal.len();
    if k == 0 {
        return 0.0;
    }
    let tridiagonal = DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => off[i.min(j)],
        _ => 0.0,
    });
    tridiagonal.symmetric_eigenvalues().max()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_end_of_a_known_spectrum() {
        // Second differences on a line over a diagonal of 2: eigenvalues 1 - cos(k pi / (n + 1)).
        let n = 60;
        let mut apply = |x: &[f64], y: &mut [f64]| {
            for i in 0..n {
                let left = if i > 0 { x[i - 1] } else { 0.0 };
                let right = if i + 1 < n { x[i + 1] } else { 0.0 };
                y[i] = 2.0 * x[i] - left - right;
            }
        };
        let mut divide = |r: &[f64], z: &mut [f64]| z.iter_mut().zip(r).for_each(|(z, r)| *z = 0.5 * r);
        let exact = 1.0 + (std::f64::consts::PI / (n + 1) as f64).cos();
        let found = largest_eigenvalue(n, 40, &mut apply, &mut divide);
        assert!((found / exact - 1.0).abs() < 1e-3, "{found} {exact}");
        let nothing = largest_eigenvalue(n, 5, &mut |_, y| y.fill(0.0), &mut divide);
        assert!(nothing.abs() < f64::MIN_POSITIVE);
    }
}
