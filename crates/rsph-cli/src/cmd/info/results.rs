//! Files of results.

use crate::exit::Trouble;
use crate::output::number;
use rsph_scenario::output::vtkhdf;
use std::fmt::Write;
use std::path::Path;

pub fn describe(path: &Path) -> Result<String, Trouble> {
    let info = vtkhdf::describe(path).map_err(|e| Trouble::results(&e))?;
    let mut text = String::new();
    let _ = writeln!(text, "results: VTKHDF PolyData, {:.1} kB", info.bytes as f64 / 1e3);
    let _ = writeln!(text, "frames: {}", info.steps());
    if let (Some(first), Some(last)) = (info.times.first(), info.times.last()) {
        let _ = writeln!(text, "time: {} to {}", number(*first), number(*last));
    }
    for (name, counts) in [("points", &info.points), ("triangles", &info.polygons)] {
        let (least, most) = (counts.iter().min().unwrap_or(&0), counts.iter().max().unwrap_or(&0));
        let _ = if least == most {
            writeln!(text, "{name}: {most}")
        } else {
            writeln!(text, "{name}: {least} to {most}")
        };
    }
    for field in &info.fields {
        let kind = match field.components {
            1 => "scalar",
            3 => "vector",
            6 => "symmetric tensor, XX YY ZZ XY YZ XZ",
            _ => "other",
        };
        let _ = writeln!(text, "field: {} ({kind})", field.name);
    }
    Ok(text)
}
