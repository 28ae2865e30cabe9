//! A sphere under two smeared loads at its poles, against the exact series.
//!
//! With Legendre polynomials P_n(cos theta) the displacement of a sphere of radius 1 under axisymmetric tractions is
//!
//! ```text
//! u_r     = sum (a_n n r^(n-1) + b_n (n + alpha_n) r^(n+1)) P_n
//! u_theta = sum (a_n r^(n-1) + b_n r^(n+1)) dP_n/dtheta
//! alpha_n = -2 (n lambda + (3 n + 1) mu) / ((n + 3) lambda + (n + 5) mu)
//! ```
//!
//! (A. I. Lurie, Theory of Elasticity, 2005, chapter 5: solid harmonics); a_n and b_n follow from the tractions on r = 1.

use super::beyond;
use super::case::{Case, YOUNG, hold, read};
use super::meshes::{ball, shape_of, turned};
use crate::Row;
use rsph_core::setup::{Fix, LoadKind, PatchCentre};
use rsph_core::tensor::Vec3;
use std::f64::consts::FRAC_PI_2;

/// Radius of the smeared load over that of the sphere.
const RADIUS: f64 = 0.45;
/// Terms of the series.
const TERMS: usize = 60;
/// Intervals of its integrals from pole to equator.
const INTERVALS: u32 = 4000;

/// Coefficients of P_n of the displacement and the normal strain on the surface, both along its normal, for E = 1, and the
/// compliance of one half.
struct Series {
    moved: [f64; TERMS + 1],
    strain: [f64; TERMS + 1],
    compliance: f64,
}

/// P_n and dP_n/dtheta at an angle from the pole, n up to [`TERMS`].
fn legendre(angle: f64) -> ([f64; TERMS + 1], [f64; TERMS + 1]) {
    let (c, s) = (angle.cos(), angle.sin());
    let (mut p, mut slope) = ([1.0; TERMS + 1], [0.0; TERMS + 1]);
    (p[1], slope[1]) = (c, -s);
    for n in 2..=TERMS {
        let k = n as f64;
        p[n] = ((2.0 * k - 1.0) * c * p[n - 1] - (k - 1.0) * p[n - 2]) / k;
        // P_n' = P_(n-2)' + (2 n - 1) P_(n-1)
        slope[n] = slope[n - 2] - (2.0 * k - 1.0) * s * p[n - 1];
    }
    (p, slope)
}

/// The traction exp(-d^2 / r^2) towards the equatorial plane, normal and along the meridian.
fn traction(angle: f64) -> (f64, f64) {
    let pressure = (-2.0 * (1.0 - angle.cos()) / (RADIUS * RADIUS)).exp();
    (-pressure * angle.cos(), pressure * angle.sin())
}

impl Series {
    fn new(nu: f64) -> Self {
        let (lambda, mu) = (nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), 0.5 / (1.0 + nu));
        // Only even terms: both halves are loaded alike. Simpson's rule over one half.
        let step = FRAC_PI_2 / f64::from(INTERVALS);
        let weight = |k: u32| match k {
            0 | INTERVALS => step / 3.0,
            k if k % 2 == 1 => 4.0 * step / 3.0,
            _ => 2.0 * step / 3.0,
        };
        let (mut normal, mut along) = ([0.0; TERMS + 1], [0.0; TERMS + 1]);
        for k in 0..=INTERVALS {
            let angle = step * f64::from(k);
            let (p, slope) = legendre(angle);
            let (t_normal, t_along) = traction(angle);
            for n in (0..=TERMS).step_by(2) {
                let share = weight(k) * angle.sin() * (2 * n + 1) as f64;
                normal[n] += share * t_normal * p[n];
                if n > 0 {
                    along[n] += share * t_along * slope[n] / (n * (n + 1)) as f64;
                }
            }
        }
        let mut found = Self { moved: [0.0; TERMS + 1], strain: [0.0; TERMS + 1], compliance: 0.0 };
        let mut tangential = [0.0; TERMS + 1];
        let uniform = normal[0] / (3.0 * lambda + 2.0 * mu);
        (found.moved[0], found.strain[0]) = (uniform, uniform);
        for n in (2..=TERMS).step_by(2) {
            let k = n as f64;
            let alpha = -2.0 * (k * lambda + (3.0 * k + 1.0) * mu) / ((k + 3.0) * lambda + (k + 5.0) * mu);
            // sigma_rr and sigma_rtheta of a_n = 1 and of b_n = 1.
            let rr = [
                2.0 * mu * k * (k - 1.0),
                lambda * (2.0 * k + alpha * (k + 3.0)) + 2.0 * mu * (k + alpha) * (k + 1.0),
            ];
            let rt = [2.0 * mu * (k - 1.0), mu * (2.0 * k + alpha)];
            let determinant = rr[0] * rt[1] - rr[1] * rt[0];
            let a = (normal[n] * rt[1] - along[n] * rr[1]) / determinant;
            let b = (along[n] * rr[0] - normal[n] * rt[0]) / determinant;
            found.moved[n] = a * k + b * (k + alpha);
            found.strain[n] = a * k * (k - 1.0) + b * (k + 1.0) * (k + alpha);
            tangential[n] = a + b;
        }
        for k in 0..=INTERVALS {
            let angle = step * f64::from(k);
            let (p, slope) = legendre(angle);
            let (t_normal, t_along) = traction(angle);
            let sum = |c: &[f64], f: &[f64]| c.iter().zip(f).map(|(c, f)| c * f).sum::<f64>();
            let work = t_normal * sum(&found.moved, &p) + t_along * sum(&tangential, &slope);
            found.compliance += weight(k) * std::f64::consts::TAU * angle.sin() * work;
        }
        found
    }
}

/// A quarter of one half of the sphere, between three planes of symmetry that are turned against the lattice, and where its
/// pole is.
fn loaded(per_radius: f64, nu: f64) -> Result<(Case, Vec3), String> {
    let spacing = 1.0 / per_radius;
    let (mesh, [x, y, z]) = turned(&ball(1.0, 5), Some([1.0, 2.0, 0.5]));
    let shape = shape_of(&mesh).map_err(|e| e.to_string())?;
    let boundaries = [x, y, z].map(|a| hold(beyond(Vec3::zeros(), -a), Fix::Normal)).to_vec();
    let (centre, radius) = (PatchCentre::At(z), Some(RADIUS));
    let loads = vec![LoadKind::Patch { pressure: 1.0, centre, radius, direction: -z }];
    Ok((Case { shape, spacing, nu, boundaries, loads }, z))
}

/// The sphere with its compliance for E = 1.
pub fn with_compliance(per_radius: f64, nu: f64) -> Result<(Case, f64), String> {
    let (case, _) = loaded(per_radius, nu)?;
    Ok((case, 0.25 * Series::new(nu).compliance))
}

/// Displacement, strain and stress of the sphere's surface.
pub fn sphere(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let nu = 0.3;
    let exact = Series::new(nu);
    let sizes: &[(f64, f64, f64)] =
        if quick { &[(6.0, 5.0, 15.0)] } else { &[(6.0, 5.0, 15.0), (10.0, 2.0, 6.0), (20.0, 0.6, 3.0)] };
    for (per_radius, of_displacement, of_strain) in sizes {
        let spacing = 1.0 / per_radius;
        let (case, z) = loaded(*per_radius, nu)?;
        let (mut body, found) = case.solve()?;
        let (mut moved, mut strained, mut stress) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for v in read(&mut body, YOUNG) {
            if v.x.norm() < 1.0 - 0.1 * spacing {
                continue;
            }
            let n = v.x.normalize();
            let angle = n.dot(&z).clamp(0.0, 1.0).acos();
            let (p, _) = legendre(angle);
            let sum = |c: &[f64]| c.iter().zip(&p).map(|(c, p)| c * p).sum::<f64>();
            let (u, e) = (sum(&exact.moved), sum(&exact.strain));
            moved[0] += v.area * (v.u.dot(&n) - u).powi(2);
            moved[1] += v.area * u * u;
            strained[0] += v.area * (n.dot(&v.strain.dot(&n)) - e).powi(2);
            strained[1] += v.area * e * e;
            let (t_normal, t_along) = traction(angle);
            let meridian = (n * angle.cos() - z).try_normalize(1e-9).unwrap_or_else(Vec3::zeros);
            let t = t_normal * n + t_along * meridian;
            stress[0] += v.area * t.dot(&v.stress.dot(&n));
            stress[1] += v.area * t.dot(&t);
        }
        let name =
            |of: &str| format!("surfaces: sphere under a local load, nu = {nu}, dx = R/{per_radius}, {of}");
        let off = |sums: [f64; 2]| 100.0 * (sums[0] / sums[1]).sqrt();
        rows.push(Row::within(
            name("compliance"),
            found.compliance,
            0.25 * exact.compliance,
            *of_displacement,
            "1/E",
        ));
        rows.push(Row::at_most(
            name("displacement of the surface off by"),
            off(moved),
            *of_displacement,
            "%",
        ));
        rows.push(Row::at_most(name("normal strain on the surface off by"), off(strained), *of_strain, "%"));
        rows.push(Row::within(name("stress over the load"), stress[0] / stress[1], 1.0, 3.0, "1"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Betti's theorem with the dilation u = r: 3 K times the change of volume is int t.x dS.
    #[test]
    fn the_volume_changes_as_the_load_says() {
        for nu in [0.0, 0.3, 0.45] {
            let series = Series::new(nu);
            assert!(series.compliance > 0.0);
            let change = 4.0 * std::f64::consts::PI * series.moved[0];
            let step = FRAC_PI_2 / 20_000.0;
            let work: f64 = (0..20_000)
                .map(|k| step * (f64::from(k) + 0.5))
                .map(|angle| step * 2.0 * std::f64::consts::TAU * angle.sin() * traction(angle).0)
                .sum();
            let found = change / (1.0 - 2.0 * nu);
            assert!((found / work - 1.0).abs() < 1e-6, "{found} {work}");
        }
    }
}
