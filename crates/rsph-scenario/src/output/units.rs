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
