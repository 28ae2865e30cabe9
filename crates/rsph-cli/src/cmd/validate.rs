//! `rsph validate`

use crate::exit::{Code, Trouble};
use crate::output::{number, print};
use clap::Args;
use rsph_validation::report::{self, Conditions};
use rsph_validation::{CASES, Outcome, Row};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Where a checkout has the READMEs and figures of the cases, and gets the report.
const DOCUMENTS: &str = "validation";

/// Run the reproductions of the paper and the benchmarks, and compare with known values
#[derive(Debug, Args)]
#[command(after_help = "\
Prints a table: name, measured, reference, bound, pass. Exit code 1 if a bound is missed. Figures
(SVG) and their curves (CSV) go to a folder, everything on one page to a report.

Examples:
  rsph validate                  all of them
  rsph validate all --quick      all of them, shortened
  rsph validate --list           what there is
  rsph validate tensile --json rows.json --report tensile.html")]
pub struct Arguments {
    /// Which checks; all of them if none is named
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Shorter and coarser versions
    #[arg(long)]
    quick: bool,
    /// Print the names of the checks and what each compares, and run none
    #[arg(long)]
    list: bool,
    /// Where figures and curves go
    #[arg(long, value_name = "DIR", default_value = "out/validation")]
    output: PathBuf,
    /// Write the rows to this file as JSON as well
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with all rows and figures to this file; in a checkout, validation/report.html without it
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<Code, Trouble> {
    if arguments.list {
        print(&list())?;
        return Ok(Code::Good);
    }
    let all = arguments.names.iter().any(|n| n == "all");
    let names = if all { vec![] } else { arguments.names.clone() };
    if let Some(stranger) = names.iter().find(|n| !rsph_validation::names().any(|known| known == *n)) {
        let known: Vec<&str> = rsph_validation::names().collect();
        return Err(Trouble::input(
            format!("there is no validation \"{stranger}\""),
            format!("known: all {}", known.join(" ")),
        ));
    }
    let documents = Path::new(DOCUMENTS);
    let page = arguments
        .report
        .clone()
        .or_else(|| documents.join("README.md").is_file().then(|| documents.join("report.html")));
    let conditions = Conditions::now(arguments.quick, rayon::current_num_threads());
    // Whether files can be written is found out before hours of computing, not after.
    if let Some(path) = &arguments.json {
        write_json(path, &[])?;
    }
    if let Some(path) = &page {
        write_report(path, &[], &conditions)?;
    }
    let mut progress = |name: &str| tracing::info!("{name}");
    let outcomes = rsph_validation::run(&names, arguments.quick, &arguments.output, &mut progress)
        .map_err(|e| Trouble::system(e.to_string(), "see `rsph validate --help`"))?;
    let rows: Vec<Row> = outcomes.iter().flat_map(|o| o.rows.clone()).collect();
    if let Some(path) = &arguments.json {
        write_json(path, &rows)?;
    }
    if let Some(path) = &page {
        write_report(path, &outcomes, &conditions)?;
    }
    print(&table(&rows))?;
    tracing::info!("figures and curves in {}", arguments.output.display());
    if let Some(path) = &page {
        tracing::info!("report in {}", path.display());
    }
    Ok(if rows.iter().all(|r| r.pass) { Code::Good } else { Code::BoundMissed })
}

fn write_json(path: &PathBuf, rows: &[Row]) -> Result<(), Trouble> {
    serde_json::to_string_pretty(rows)
        .map_err(std::io::Error::from)
        .and_then(|text| std::fs::write(path, text))
        .map_err(|e| Trouble::input(format!("cannot write {}: {e}", path.display()), "choose another file"))
}

fn write_report(path: &Path, outcomes: &[Outcome], conditions: &Conditions) -> Result<(), Trouble> {
    report::write(path, outcomes, conditions, Path::new(DOCUMENTS))
        .map_err(|e| Trouble::input(e.to_string(), "choose another file with --report"))
}

/// Names and what they compare, one to a line.
fn list() -> String {
    let width = rsph_validation::names().map(str::len).max().unwrap_or(0);
    CASES.iter().fold(String::new(), |mut text, case| {
        let _ = writeln!(text, "{:width$}  {}", case.name, case.about);
        text
    })
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
            paper: None,
        };
        let text = table(&[row("a long name", true), row("b", false)]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0].find("measured"), lines[2].find("0.0097"));
        assert!(text.contains("NO") && text.ends_with("2 checks, 1 missed\n"), "{text}");
    }
}
