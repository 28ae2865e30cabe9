//! A column that hangs under its own weight: u(L) = rho g L^2 / (2 E) at nu = 0.

use super::Row;
use super::case::{HANGING_COLUMN, history};
use std::path::Path;

pub(super) fn run(quick: bool, _folder: &Path) -> Result<Vec<Row>, String> {
    let until = if quick { "time.until=2" } else { "time.until=3" };
    let run = history(HANGING_COLUMN, &[until.into()])?;
    Ok(vec![Row::within("column: sag of the lower end", run.last(), -0.005, 0.5, "length")])
}
