//! A measured quantity beside what it should be.

use serde::Serialize;

/// One measured quantity beside what it should be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the check.
    pub name: String,
    /// What was measured.
    pub measured: f64,
    /// What the literature or a finer method says; `None`: nothing to compare with.
    pub reference: Option<f64>,
    /// The bound that decides, in words: "within 2 %", ">= 1.5".
    pub bound: String,
    /// Unit of the measured value.
    pub unit: String,
    /// Whether the bound is kept.
    pub pass: bool,
    /// What the paper says about it, if it does.
    pub paper: Option<String>,
}

impl Row {
    /// A value that must agree with `reference` to `percent`.
    pub(super) fn within(
        name: impl Into<String>,
        measured: f64,
        reference: f64,
        percent: f64,
        unit: &str,
    ) -> Self {
        let pass = (measured / reference - 1.0).abs() <= percent / 100.0;
        Self {
            reference: Some(reference),
            ..Self::new(name, measured, format!("within {percent} %"), unit, pass)
        }
    }

    /// A value that must agree with `reference` to `distance`.
    pub(super) fn near(
        name: impl Into<String>,
        measured: f64,
        reference: f64,
        distance: f64,
        unit: &str,
    ) -> Self {
        let pass = (measured - reference).abs() <= distance;
        Self {
            reference: Some(reference),
            ..Self::new(name, measured, format!("within {distance}"), unit, pass)
        }
    }

    /// A value that must not exceed `limit`.
    pub(super) fn at_most(name: impl Into<String>, measured: f64, limit: f64, unit: &str) -> Self {
        Self::new(name, measured, format!("<= {}", plain(limit)), unit, measured <= limit)
    }

    /// A value that must reach `limit`.
    pub(super) fn at_least(name: impl Into<String>, measured: f64, limit: f64, unit: &str) -> Self {
        Self::new(name, measured, format!(">= {limit}"), unit, measured >= limit)
    }

    /// Adds what the paper says.
    #[must_use]
    pub(super) fn paper(self, says: &str) -> Self {
        Self { paper: Some(says.into()), ..self }
    }

    fn new(name: impl Into<String>, measured: f64, bound: String, unit: &str, pass: bool) -> Self {
        Self { name: name.into(), measured, reference: None, bound, unit: unit.into(), pass, paper: None }
    }
}

/// A bound as one writes it: small ones as powers of ten.
fn plain(limit: f64) -> String {
    if limit != 0.0 && limit.abs() < 1e-3 { format!("{limit:e}") } else { format!("{limit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_decide() {
        assert!(Row::within("a", 1.019, 1.0, 2.0, "1").pass && !Row::within("a", 0.979, 1.0, 2.0, "1").pass);
        assert!(Row::near("a", -1.1, -1.0, 0.2, "1").pass && !Row::near("a", -1.3, -1.0, 0.2, "1").pass);
        assert!(Row::at_most("a", 1e-5, 1e-5, "1").pass && !Row::at_least("a", 0.9, 1.0, "1").pass);
        // What could not be measured is missed.
        for row in [
            Row::within("a", f64::NAN, 1.0, 2.0, "1"),
            Row::near("a", f64::NAN, 1.0, 2.0, "1"),
            Row::at_most("a", f64::NAN, 1.0, "1"),
            Row::at_least("a", f64::NAN, 1.0, "1"),
        ] {
            assert!(!row.pass, "{row:?}");
        }
        assert_eq!(Row::at_most("a", 0.0, 1e-12, "1").bound, "<= 1e-12");
    }
}
