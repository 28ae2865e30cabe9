//! The whole history of the tensile test at nu = 0 against the exact series of a Kelvin-Voigt bar.

use super::Row;
use super::case::{TENSILE_LIVER, history};
use super::figure::{Curve, Figure};
use super::kelvin_voigt_bar::extension;
use std::path::Path;

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let until = if quick { 1.0 } else { 2.0 };
    let mut rows = Vec::new();
    let mut figure =
        Figure::new("Kelvin-Voigt bar (nu = 0): particles and exact series", "time", "E x extension");
    for (e, bound) in [(100.0, 0.5), (10.0, 1.0)] {
        let sets = [
            "material.poisson_ratio=0".into(),
            format!("material.young_modulus={e}"),
            "time.dt=auto".into(),
            format!("time.until={until}"),
        ];
        let run = history(TENSILE_LIVER, &sets)?;
        let exact: Vec<f64> = run.time.iter().map(|t| extension(*t, e, 0.2)).collect();
        let largest =
            run.value.iter().zip(&exact).map(|(u, exact)| (u - exact).abs() * e * 100.0).fold(0.0, f64::max);
        rows.push(Row::at_most(
            format!("series: E = {e}, largest error"),
            largest,
            bound,
            "% of the value at rest",
        ));
        let scaled = |v: &[f64]| v.iter().map(|u| u * e).collect::<Vec<f64>>();
        let particles = if e > 50.0 { Curve::solid } else { Curve::marked };
        figure.add(particles(&format!("particles, E = {e}"), &run.time, &scaled(&run.value)));
        figure.add(Curve::dotted(&format!("series, E = {e}"), &run.time, &scaled(&exact)));
    }
    figure.save(folder, "series")?;
    Ok(rows)
}
