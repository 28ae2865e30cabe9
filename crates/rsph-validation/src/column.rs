//! A column that hangs under its own weight: u(L) = rho g L^2 / (2 E) at nu = 0.

use super::Row;
use super::case::{HANGING_COLUMN, history};
use super::figure::{Curve, Figure};
use std::path::Path;

/// rho g L^2 / (2 E)
const SAG: f64 = 0.005;

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let until = if quick { "time.until=2" } else { "time.until=3" };
    let run = history(HANGING_COLUMN, &[until.into()])?;
    let mut figure = Figure::new("A hanging column", "time", "sag of the lower end");
    let sag: Vec<f64> = run.value.iter().map(|u| -u).collect();
    figure.add(Curve::solid("particles", &run.time, &sag));
    let end = run.time.last().copied().unwrap_or(0.0);
    figure.add(Curve::dotted("exact, at rest", &[0.0, end], &[SAG; 2]));
    figure.save(folder, "column")?;
    Ok(vec![Row::within("column: sag of the lower end", run.last(), -SAG, 0.5, "length")])
}
