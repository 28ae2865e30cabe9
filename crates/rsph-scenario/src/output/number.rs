//! Numbers for people.

/// A number with four significant digits.
pub fn number(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) {
        let digits = if x == 0.0 { 0 } else { (3 - x.abs().log10().floor() as i32).clamp(0, 6) };
        format!("{x:.*}", digits as usize)
    } else {
        format!("{x:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_keep_their_size() {
        assert_eq!(number(0.0), "0");
        assert_eq!(number(0.012345), "0.01235");
        assert_eq!(number(1000.0), "1000");
        assert_eq!(number(2.2451e-6), "2.245e-6");
    }
}
