//! The exact answer for a bar of Kelvin-Voigt material (one dimension, nu = 0) that is clamped at one
//! end and pulled at the other by a traction that is there from t = 0 on.

use std::f64::consts::PI;

/// Modes summed one by one; the rest are so strongly damped that they relax together as exp(-t/T).
const MODES: u32 = 400;

/// u(L, t) / L for Young's modulus E, density rho, length L, relaxation time T and traction p: the
/// static p / E less one damped oscillation for each mode of the clamped-free bar,
///
/// u/L = p/E [1 - sum_n 8/((2n-1) pi)^2 g_n(t)], g'' + T w^2 g' + w^2 g = 0, g(0) = 1, g'(0) = 0,
/// w = (2n-1) pi/2 sqrt(E/rho) / L.
pub(super) fn extension(t: f64, young_modulus: f64, relaxation_time: f64) -> f64 {
    let (density, length, traction) = (1.0, 1.0, 1.0);
    let (mut sum, mut rest) = (0.0, 1.0);
    for n in 1..=MODES {
        let k = f64::from(2 * n - 1);
        let omega = 0.5 * PI * k * (young_modulus / density).sqrt() / length;
        let weight = 8.0 / (k * PI).powi(2);
        sum += weight * decay(t, omega, relaxation_time);
        rest -= weight;
    }
    sum += rest * (-t / relaxation_time).exp();
    traction / young_modulus * (1.0 - sum)
}

/// g(t) of one mode.
pub(super) fn decay(t: f64, omega: f64, relaxation_time: f64) -> f64 {
    let half = 0.5 * relaxation_time * omega * omega;
    let discriminant = half * half - omega * omega;
    if discriminant > 0.0 {
        let root = discriminant.sqrt();
        // The slow root without cancellation: slow * fast = omega^2.
        let fast = half + root;
        let slow = omega * omega / fast;
        (fast * (-slow * t).exp() - slow * (-fast * t).exp()) / (fast - slow)
    } else {
        let root = (-discriminant).sqrt();
        let sinc = if root * t < 1e-8 { t } else { (root * t).sin() / root };
        (-half * t).exp() * ((root * t).cos() + half * sinc)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_tabulated_values() {
        // Another implementation of the series, which takes the modes beyond the 400th as settled:
        // their weights sum to 5e-4.
        let table = [
            (100.0, 0.1, 0.003573),
            (100.0, 0.2, 0.006296),
            (100.0, 0.3, 0.007869),
            (100.0, 0.5, 0.009293),
            (100.0, 1.0, 0.009955),
            (10.0, 0.1, 0.01533),
            (10.0, 0.3, 0.06405),
            (10.0, 1.0, 0.10621),
        ];
        for (e, t, expected) in table {
            let value = extension(t, e, 0.2);
            let settled = 5.1e-4 * (-t / 0.2_f64).exp() / e;
            assert!((value + settled - expected).abs() < 1.5e-5 / e.sqrt(), "E = {e}, t = {t}: {value}");
        }
    }

    #[test]
    fn starts_at_rest_and_ends_static() {
        assert!(extension(0.0, 100.0, 0.2).abs() < 1e-15);
        assert!((extension(20.0, 100.0, 0.2) - 0.01).abs() < 1e-9);
    }
}
