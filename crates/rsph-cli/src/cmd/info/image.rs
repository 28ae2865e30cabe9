//! Images: segmentations and maps of values.

use crate::exit::Trouble;
use crate::output::number;
use rsph_scenario::label_map::survey;
use std::fmt::Write;
use std::path::Path;

/// Most labels that are listed.
const MAX_LABELS: usize = 40;

pub fn describe(path: &Path) -> Result<String, Trouble> {
    let found =
        survey(path).map_err(|e| Trouble::input(format!("{}: {}", e.path.display(), e.problem), e.remedy))?;
    let grid = &found.grid;
    let ([nx, ny, nz], millimetres) = (grid.size, 1e3 * grid.metres);
    let [dx, dy, dz] = grid.edges().map(|edge| edge * millimetres);
    let mut text = String::new();
    let _ = writeln!(
        text,
        "image: {nx} x {ny} x {nz} voxels of {} x {} x {} mm",
        number(dx),
        number(dy),
        number(dz)
    );
    let [x, y, z] = [0, 1, 2].map(|i| number(grid.placement.origin[i] * millimetres));
    let _ = writeln!(text, "orientation: {}, the first voxel at ({x}, {y}, {z}) mm", grid.orientation());
    if found.without > 0 {
        let _ = writeln!(text, "without a value: {} voxels, which count as outside", found.without);
    }
    let Some(labels) = &found.labels else {
        let [low, high] = found.range.map(number);
        let _ = writeln!(text, "values: {low} to {high}, no labels");
        return Ok(text);
    };
    let millilitres = dx * dy * dz * 1e-3;
    let mut listed = 0;
    for (label, count) in labels.iter().filter(|(label, _)| **label != 0) {
        listed += 1;
        if listed <= MAX_LABELS {
            let _ =
                writeln!(text, "label {label}: {count} voxels, {} ml", number(*count as f64 * millilitres));
        }
    }
    if listed > MAX_LABELS {
        let _ = writeln!(text, "  and {} more labels", listed - MAX_LABELS);
    }
    if listed == 0 {
        let _ = writeln!(text, "labels: none, every voxel is 0");
    }
    Ok(text)
}
