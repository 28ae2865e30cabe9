//! Numbers for people.

/// A number with four significant digits.
pub fn number(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) {
        // Rounding may add a digit before the point.
        let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
        let digits = if x == 0.0 { 0 } else { (3 - rounded.abs().log10().floor() as i32).clamp(0, 6) };
        format!("{x:.*}", digits as usize)
    } else {
        format!("{x:.3e}")
    }
}

/// The ends of an interval, with four significant digits of its length.
pub fn interval(low: f64, high: f64) -> [String; 2] {
    let length = high - low;
    let is_plain = |x: f64| x == 0.0 || (1e-4..1e7).contains(&x.abs());
    if !(length > 0.0 && is_plain(low) && is_plain(high)) {
        return [number(low), number(high)];
    }
    let digits = (3 - length.log10().floor() as i32).clamp(0, 9) as usize;
    [low, high].map(|x| {
        let text = format!("{x:.digits$}");
        let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        if short == "-0" { "0".into() } else { short.to_owned() }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_an_interval_differ_by_its_length() {
        assert_eq!(interval(100.0, 100.04), ["100", "100.04"]);
        assert_eq!(interval(-50.0, -49.98), ["-50", "-49.98"]);
        assert_eq!(interval(-0.1317, 0.0), ["-0.1317", "0"]);
        assert_eq!(interval(-1234.5678, 98765.4321), ["-1235", "98765"]);
        assert_eq!(interval(0.0, 3.2e-7), ["0", "3.200e-7"]);
    }

    #[test]
    fn numbers_are_short_and_keep_their_size() {
        assert_eq!(number(0.0), "0");
        assert_eq!(number(0.012345), "0.01235");
        assert_eq!(number(1000.0), "1000");
        assert_eq!(number(0.999_999_94), "1.000");
        assert_eq!(number(2.2451e-6), "2.245e-6");
    }
}
