//! The paper to the letter: that and when Eqs. (10) to (14) without correction blow up.

use super::Row;
use super::case::{TENSILE_LIVER, history};
use super::figure::{Curve, Figure};
use std::path::Path;

pub(super) fn run(_quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let until = || "time.until=1".to_string();
    let literal =
        history(TENSILE_LIVER, &["solver.formulation=paper".into(), "time.dt=0.001".into(), until()])?;
    let adjoint = history(TENSILE_LIVER, &[until()])?;
    let mut figure =
        Figure::new("The paper to the letter is unstable: liver under tension", "time", "extension");
    figure.limit(-0.005, 0.02);
    figure.add(Curve::solid("adjoint formulation", &adjoint.time, &adjoint.value));
    figure.add(Curve::dashed("Eqs. (10) to (14) to the letter", &literal.time, &literal.value));
    figure.save(folder, "literal")?;
    let stopped = literal.failure.as_ref().map_or(f64::INFINITY, |f| f.time);
    Ok(vec![Row::at_most("literal: the paper's scheme stops at", stopped, 1.0, "time")])
}
