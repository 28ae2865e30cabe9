//! Unit labels of a report. The numerics do not know units; the scenario names its system.

use rsph_core::setup::Units;

/// The system's name in scenario files.
pub fn name(units: Units) -> &'static str {
    match units {
        Units::Si => "SI",
        Units::Normalised => "normalised",
    }
}

/// The label of an SI unit in the scenario's system: `m^3` becomes `m³`, and everything `1` in the
/// normalised system.
pub fn label(units: Units, si: &str) -> String {
    match units {
        Units::Si => si.replace("^2", "²").replace("^3", "³"),
        Units::Normalised => "1".to_owned(),
    }
}

/// ` [m]`, ready to follow the name of a quantity; nothing for pure numbers and normalised values.
pub fn bracket(units: Units, si: &str) -> String {
    match label(units, si).as_str() {
        "1" | "" => String::new(),
        unit => format!(" [{unit}]"),
    }
}

/// A number for people: five significant digits, a power of ten only where it shortens.
pub fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || (1e-3..1e6).contains(&size) {
        let rounded: f64 = format!("{x:.4e}").parse().unwrap_or(x);
        return format!("{rounded}");
    }
    if !x.is_finite() {
        return x.to_string();
    }
    let text = format!("{x:.3e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
    format!("{mantissa}·10^{exponent}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        let cases = [
            (0.0, "0"),
            (1000.0, "1000"),
            (0.142857142, "0.14286"),
            (3e-15, "3·10^-15"),
            (-2.5e7, "-2.5·10^7"),
        ];
        for (x, text) in cases {
            assert_eq!(number(x), text);
        }
        assert_eq!(number(f64::NAN), "NaN");
    }

    #[test]
    fn units_follow_the_system() {
        assert_eq!(label(Units::Si, "kg/m^3"), "kg/m³");
        assert_eq!(label(Units::Normalised, "kg/m^3"), "1");
        assert_eq!(bracket(Units::Si, "Pa"), " [Pa]");
        assert_eq!(bracket(Units::Si, "1"), "");
        assert_eq!(bracket(Units::Normalised, "Pa"), "");
    }
}
