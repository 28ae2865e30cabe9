//! `rsph validate`

use crate::exit::{Code, Trouble};
use crate::output::{number, print};
use clap::Args;
use rsph_scenario::validation::{self, Row};
use std::fmt::Write;
use std::path::PathBuf;

/// Run the reproductions of the paper and the benchmarks, and compare with known values
#[derive(Debug, Args)]
#[command(after_help = "\
Prints a table: name, measured, reference, bound, pass. Exit code 1 if a bound is missed. Figures
(SVG) and their curves (CSV) go to a folder.

Examples:
  rsph validate                  all of them
  rsph validate all --quick      all of them, shortened
  rsph validate tensile --json rows.json")]
pub struct Arguments {
    /// Which checks; all of them if none is named
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Shorter and coarser versions
    #[arg(long)]
    quick: bool,
    /// Where figures and curves go
    #[arg(long, value_name = "DIR", default_value = "out/validation")]
    output: PathBuf,
    /// Write the rows to this file as JSON as well
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<Code, Trouble> {
    let all = arguments.names.iter().any(|n| n == "all");
    let names = if all { vec![] } else { arguments.names.clone() };
    if let Some(stranger) = names.iter().find(|n| !validation::names().any(|known| known == *n)) {
        let known: Vec<&str> = validation::names().collect();
        return Err(Trouble::input(
            format!("there is no validation \"{stranger}\""),
            format!("known: all {}", known.join(" ")),
        ));
    }
    if let Some(path) = &arguments.json {
        // Before hours of computing, not after.
        write_json(path, &[])?;
    }
    let mut progress = |name: &str| tracing::info!("{name}");
    let rows = validation::run(&names, arguments.quick, &arguments.output, &mut progress)
        .map_err(|e| Trouble::system(e.to_string(), "see `rsph validate --help`"))?;
    if let Some(path) = &arguments.json {
        write_json(path, &rows)?;
    }
    print(&table(&rows))?;
    tracing::info!("figures and curves in {}", arguments.output.display());
    Ok(if rows.iter().all(|r| r.pass) { Code::Good } else { Code::BoundMissed })
}

fn write_json(path: &PathBuf, rows: &[Row]) -> Result<(), Trouble> {
    serde_json::to_string_pretty(rows)
        .map_err(std::io::Error::from)
        .and_then(|text| std::fs::write(path, text))
        .map_err(|e| Trouble::input(format!("cannot write {}: {e}", path.display()), "choose another file"))
}

fn table(rows: &[Row]) -> String {
    let header = ["name", "measured", "reference", "bound", "unit", "pass"].map(String::from);
    let mut cells = vec![header];
    cells.extend(rows.iter().map(|r| {
        let reference = r.reference.map_or_else(|| "-".into(), number);
        let pass = if r.pass { "yes" } else { "NO" };
        [r.name.clone(), number(r.measured), reference, r.bound.clone(), r.unit.clone(), pass.into()]
    }));
    let width = |i: usize| cells.iter().map(|c| c[i].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..6).map(width).collect();
    let mut text = String::new();
    for row in &cells {
        let line: Vec<String> = row.iter().zip(&widths).map(|(c, w)| format!("{c:w$}")).collect();
        let _ = writeln!(text, "{}", line.join("  ").trim_end());
    }
    let missed = rows.iter().filter(|r| !r.pass).count();
    let _ = writeln!(text, "{} checks, {missed} missed", rows.len());
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up_and_misses_are_counted() {
        let row = |name: &str, pass| Row {
            name: name.into(),
            measured: 0.0097,
            reference: Some(0.0097055),
            bound: "within 2 %".into(),
            unit: "1".into(),
            pass,
        };
        let text = table(&[row("a long name", true), row("b", false)]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0].find("measured"), lines[2].find("0.0097"));
        assert!(text.contains("NO") && text.ends_with("2 checks, 1 missed\n"), "{text}");
    }
}
