//! Arrays as they travel in a page: 16 bits a number over the array's own range, in base64. That
//! is finer than any screen and a fifth of the size of decimal numbers.

use base64::prelude::{BASE64_STANDARD, Engine};
use serde::Serialize;

/// An array of numbers: `low + (high - low) code / 65534`; the code 65535 is "no number".
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Packed {
    low: f64,
    high: f64,
    codes: String,
}

const LEVELS: f64 = 65534.0;
const MISSING: u16 = 65535;

impl Packed {
    /// Packs `values`.
    pub fn new(values: impl Iterator<Item = f64> + Clone) -> Self {
        let finite = values.clone().filter(|v| v.is_finite());
        let (low, high) = finite.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
        let scale = if high > low { LEVELS / (high - low) } else { 0.0 };
        let code = |v: f64| if v.is_finite() { ((v - low) * scale).round() as u16 } else { MISSING };
        let bytes: Vec<u8> = values.flat_map(|v| code(v).to_le_bytes()).collect();
        Self { low, high, codes: BASE64_STANDARD.encode(bytes) }
    }

    /// Size in a page (bytes).
    pub fn size(&self) -> usize {
        self.codes.len() + 64
    }
}

/// Indices in base64, four bytes each.
pub fn indices(values: impl Iterator<Item = u32>) -> String {
    BASE64_STANDARD.encode(values.flat_map(u32::to_le_bytes).collect::<Vec<u8>>())
}

/// `x` to six significant digits, which is all that a plot shows.
pub fn six_digits(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "rounded numbers are exact")]
mod tests {
    use super::*;

    fn unpack(p: &Packed) -> Vec<f64> {
        let bytes = BASE64_STANDARD.decode(&p.codes).unwrap();
        let code = |b: &[u8; 2]| u16::from_le_bytes(*b);
        bytes
            .as_chunks::<2>()
            .0
            .iter()
            .map(|b| match code(b) {
                MISSING => f64::NAN,
                c => p.low + (p.high - p.low) * f64::from(c) / LEVELS,
            })
            .collect()
    }

    #[test]
    fn values_survive_within_a_level() {
        let values: Vec<f64> = (0..100).map(|i| f64::from(i).sin() * 1e-7).collect();
        let packed = Packed::new(values.iter().copied());
        for (a, b) in values.iter().zip(unpack(&packed)) {
            assert!((a - b).abs() < 2e-7 / LEVELS, "{a} {b}");
        }
    }

    #[test]
    fn constants_and_numbers_that_are_none_survive() {
        let packed = Packed::new([3.0, f64::NAN, 3.0, f64::INFINITY].into_iter());
        let values = unpack(&packed);
        assert_eq!((values[0], values[2]), (3.0, 3.0));
        assert!(values[1].is_nan() && values[3].is_nan());
        assert_eq!(unpack(&Packed::new(std::iter::empty())), Vec::<f64>::new());
    }

    #[test]
    fn six_digits_are_kept() {
        assert_eq!(six_digits(1.0 / 3.0), 0.333333);
        assert_eq!(six_digits(-123456789.0), -123457000.0);
        assert!(six_digits(f64::NAN).is_nan());
    }
}
