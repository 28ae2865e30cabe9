//! Bending modes of a slender beam with free ends.

use crate::error::InvalidInput;
use crate::tensor::Vec3;
use std::f64::consts::PI;

/// The shape of a bending mode of a free Euler-Bernoulli beam:
/// `amplitude f(s) - e (amplitude . r) f'(s) / length`, with e along the beam, s from 0 to 1 on it and r the way
/// from its axis: sections move across the beam and turn with it. f is 1 at s = 0, its largest value.
///
/// f = [cosh(b s) + cos(b s) - q (sinh(b s) + sin(b s))] / 2 with cosh b cos b = 1 and
/// q = (cosh b - cos b)/(sinh b - sin b) solves f'''' = b^4 f with f'' = f''' = 0 at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeBeamMode {
    start: Vec3,
    along: Vec3,
    length: f64,
    amplitude: Vec3,
    root: f64,
}

/// Modes of higher number are waves shorter than any beam is thick.
const HIGHEST: usize = 20;

impl FreeBeamMode {
    /// The mode of that number (1 is the slowest, with two nodes) of a beam whose axis goes from `start` to `end`;
    /// the ends move by `amplitude` across the axis.
    ///
    /// # Errors
    /// Names what makes no beam: ends that are one point, an amplitude along the beam, a number that is not 1 to 20.
    pub fn new(start: Vec3, end: Vec3, amplitude: Vec3, number: usize) -> Result<Self, InvalidInput> {
        let length = (end - start).norm();
        if !(length > 0.0 && length.is_finite()) {
            return Err(InvalidInput::new(
                "free_beam.end",
                format!("[{}, {}, {}]", end.x, end.y, end.z),
                "the axis of the beam needs two different ends",
                "write the centres of its two end faces as `start` and `end`",
            ));
        }
        let along = (end - start) / length;
        if amplitude.dot(&along).abs() > 1e-9 * amplitude.norm() {
            return Err(InvalidInput::new(
                "free_beam.amplitude",
                format!("[{}, {}, {}]", amplitude.x, amplitude.y, amplitude.z),
                "a beam bends across its axis: the amplitude must be perpendicular to `end` - `start`",
                "use the field \"wave\" for motion along a bar",
            ));
        }
        if !(1..=HIGHEST).contains(&number) {
            return Err(InvalidInput::new(
                "free_beam.number",
                number,
                format!("the number of the mode must be 1 to {HIGHEST}"),
                "1 is the slowest bending mode",
            ));
        }
        Ok(Self { start, along, length, amplitude, root: root(number) })
    }

    /// The vector at `x`.
    pub fn at(&self, x: &Vec3) -> Vec3 {
        let way = x - self.start;
        let s = way.dot(&self.along) / self.length;
        let off_axis = way - self.along * (s * self.length);
        let (f, slope) = self.shape(s);
        self.amplitude * f - self.along * (self.amplitude.dot(&off_axis) * slope / self.length)
    }

    /// f and f' at s. The growing part of cosh - q sinh is (1 - q) exp(b s) / 2, whose factor is
    /// written so that nothing cancels.
    fn shape(&self, s: f64) -> (f64, f64) {
        let b = self.root;
        let below = b.sinh() - b.sin();
        let one_minus_q = (b.cos() - b.sin() - (-b).exp()) / below;
        let q = 1.0 - one_minus_q;
        let growing = 0.5 * one_minus_q * (b * s).exp();
        let fading = 0.5 * (1.0 + q) * (-b * s).exp();
        let (sin, cos) = (b * s).sin_cos();
        (0.5 * (growing + fading + cos - q * sin), 0.5 * b * (growing - fading - sin - q * cos))
    }
}

/// The n-th positive root of cosh b cos b = 1, by Newton's method on cos b = 1 / cosh b.
fn root(number: usize) -> f64 {
    let mut b = (number as f64 + 0.5) * PI;
    for _ in 0..8 {
        let inverse = 1.0 / b.cosh();
        b -= (b.cos() - inverse) / (b.tanh() * inverse - b.sin());
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn beam(number: usize) -> FreeBeamMode {
        FreeBeamMode::new(Vec3::new(1.0, 2.0, 3.0), Vec3::new(3.0, 2.0, 3.0), Vec3::y(), number).unwrap()
    }

    #[test]
    fn roots_are_those_of_the_tables() {
        // Blevins, Formulas for Natural Frequency and Mode Shape.
        for (n, tabled) in [(1, 4.73004074), (2, 7.85320462), (3, 10.9956078), (4, 14.1371655)] {
            assert_relative_eq!(root(n), tabled, max_relative = 1e-8);
        }
    }

    #[test]
    fn ends_are_free_and_the_mode_moves_no_mass() {
        for number in [1, 2, 5, 20] {
            let mode = beam(number);
            let (at_start, at_end) = (mode.shape(0.0).0, mode.shape(1.0).0);
            assert_relative_eq!(at_start, 1.0, max_relative = 1e-12);
            assert_relative_eq!(at_end.abs(), 1.0, max_relative = 1e-9);
            // No bending moment at the ends, by differences of the slope.
            let h = 1e-5 / mode.root;
            for s in [0.0, 1.0] {
                let curvature = (mode.shape(s + h).1 - mode.shape(s - h).1) / (2.0 * h);
                assert!(curvature.abs() < 1e-4 * mode.root.powi(2), "{number} {s} {curvature}");
            }
            // Orthogonal to translation and rotation, by the midpoint rule.
            let n = 20_000;
            let sums = (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n)).fold([0.0; 2], |[a, b], s| {
                let f = mode.shape(s).0 / f64::from(n);
                [a + f, b + f * s]
            });
            assert!(sums.iter().all(|m| m.abs() < 1e-5), "{number} {sums:?}");
        }
    }

    #[test]
    fn sections_stay_perpendicular_to_the_axis() {
        // Shear d_x u_y + d_y u_x vanishes everywhere.
        let mode = beam(1);
        let h = 1e-6;
        for x in [Vec3::new(1.3, 2.1, 3.0), Vec3::new(2.6, 1.9, 3.05)] {
            let slope = |d: Vec3, c: usize| (mode.at(&(x + d * h))[c] - mode.at(&(x - d * h))[c]) / (2.0 * h);
            assert!((slope(Vec3::x(), 1) + slope(Vec3::y(), 0)).abs() < 1e-8);
            assert!(slope(Vec3::x(), 1).abs() > 0.1);
        }
    }

    #[test]
    fn what_is_no_beam_is_refused() {
        let refused = |end: Vec3, amplitude: Vec3, number: usize| {
            FreeBeamMode::new(Vec3::zeros(), end, amplitude, number).unwrap_err().key
        };
        assert_eq!(refused(Vec3::zeros(), Vec3::y(), 1), "free_beam.end");
        assert_eq!(refused(Vec3::x(), Vec3::new(0.1, 1.0, 0.0), 1), "free_beam.amplitude");
        assert_eq!(refused(Vec3::x(), Vec3::y(), 0), "free_beam.number");
        assert_eq!(refused(Vec3::x(), Vec3::y(), 21), "free_beam.number");
    }
}
