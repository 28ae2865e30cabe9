//! One self-contained page about a validation: every check with its bound, the words of the case's README, its
//! figures of today and those in the repository.

mod readme;

use super::{Outcome, Row};
use base64::Engine;
use rsph_scenario::output::html::{escape, fill};
use rsph_scenario::output::{VERSION, atomic, number};
use rsph_scenario::sink::SinkError;
use std::fmt::Write;
use std::path::Path;

const TEMPLATE: &str = include_str!("report/report.html");
const STYLE: &str = include_str!("report/report.css");

/// Under what conditions the checks ran.
#[derive(Clone, Debug)]
pub struct Conditions {
    /// Whether they were shortened.
    pub quick: bool,
    /// Date and time, for people.
    pub date: String,
    /// Name of the processor.
    pub processor: String,
    /// Number of threads.
    pub threads: usize,
}

impl Conditions {
    /// Now and here.
    pub fn now(quick: bool, threads: usize) -> Self {
        let date = jiff::Timestamp::now().strftime("%-d %B %Y, %H:%M UTC").to_string();
        Self { quick, date, processor: processor(), threads }
    }
}

/// The processor's name where the system tells it, else its architecture.
fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").ok();
    let line = told.as_deref().and_then(|text| text.lines().find(|l| l.starts_with("model name")));
    let name = line.and_then(|l| l.split_once(':')).map(|(_, name)| name.trim().to_owned());
    name.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

/// Writes the page to `path`. READMEs and figures of the repository are read from `documents`, the folder
/// `validation/` of a checkout, where they are there.
///
/// # Errors
/// When it can not be stored.
pub fn write(
    path: &Path,
    outcomes: &[Outcome],
    conditions: &Conditions,
    documents: &Path,
) -> Result<(), SinkError> {
    atomic::write(path, page(outcomes, conditions, documents).as_bytes())
}

fn page(outcomes: &[Outcome], conditions: &Conditions, documents: &Path) -> String {
    let rows: Vec<&Row> = outcomes.iter().flat_map(|o| &o.rows).collect();
    let missed = rows.iter().filter(|r| !r.pass).count();
    let seconds: f64 = outcomes.iter().map(|o| o.seconds).sum();
    fill(TEMPLATE, &|name| match name {
        "style" => STYLE.to_owned(),
        "verdict" if missed == 0 => format!("All {} bounds are kept.", rows.len()),
        "verdict" => format!("{missed} of {} bounds missed.", rows.len()),
        "kind" if missed == 0 => "kept".into(),
        "kind" => "missed".into(),
        "shortened" if conditions.quick => "Shortened (<code>--quick</code>). ".into(),
        "date" => escape(&conditions.date),
        "version" => VERSION.into(),
        "processor" => escape(&conditions.processor),
        "threads" => conditions.threads.to_string(),
        "seconds" => duration(seconds),
        "missed" => list_of_missed(outcomes),
        "contents" => outcomes.iter().map(entry).collect(),
        "cases" => outcomes.iter().map(|o| section(o, documents)).collect(),
        _ => String::new(),
    })
}

/// The missed checks, with links to their cases.
fn list_of_missed(outcomes: &[Outcome]) -> String {
    let mut items = String::new();
    for outcome in outcomes {
        for row in outcome.rows.iter().filter(|r| !r.pass) {
            let _ = write!(
                items,
                "<li><a href=\"#{}\">{}</a>: {} {}, bound {}</li>",
                outcome.case.name,
                escape(&row.name),
                number(row.measured),
                unit(row),
                bound(row)
            );
        }
    }
    if items.is_empty() { items } else { format!("<ul>{items}</ul>") }
}

/// A line of the table of contents.
fn entry(outcome: &Outcome) -> String {
    let missed = outcome.rows.iter().filter(|r| !r.pass).count();
    let (class, verdict) = if missed == 0 {
        ("", "kept".to_owned())
    } else {
        (" class=\"missed\"", format!("✗ {missed} missed"))
    };
    format!(
        "<tr{class}><td><a href=\"#{0}\">{0}</a></td><td>{1}</td><td class=\"n\">{2}</td><td>{verdict}</td>\
         <td class=\"n\">{3}</td></tr>\n",
        outcome.case.name,
        escape(outcome.case.about),
        outcome.rows.len(),
        duration(outcome.seconds)
    )
}

fn section(outcome: &Outcome, documents: &Path) -> String {
    let folder = documents.join(outcome.case.name);
    let readme = std::fs::read_to_string(folder.join("README.md")).ok();
    let (lead, rest) = readme.as_deref().map(readme::halves).unwrap_or_default();
    let mut html = format!(
        "<section id=\"{0}\">\n<h2>{0}</h2>\n<p class=\"about\">{1}</p>\n{lead}\n",
        outcome.case.name,
        escape(outcome.case.about)
    );
    html += &figures(outcome, &folder);
    html += &table(&outcome.rows);
    let _ = writeln!(html, "<p class=\"small\">Bounds: {}.</p>", escape(outcome.case.bounds));
    if !rest.is_empty() {
        let _ = writeln!(
            html,
            "<details><summary>What is compared, and where it differs</summary>{rest}</details>"
        );
    }
    html + "</section>\n"
}

/// Today's figure and that of the repository.
fn figures(outcome: &Outcome, folder: &Path) -> String {
    let mut html = String::new();
    let mut add = |inside: &str, caption: &str| {
        let _ = write!(html, "<figure>{inside}<figcaption>{caption}</figcaption></figure>");
    };
    if let Some(svg) = outcome.figure.as_ref().and_then(|path| std::fs::read_to_string(path).ok()) {
        add(svg.find("<svg").map_or("", |start| &svg[start..]), "Today");
    }
    if let Ok(png) = std::fs::read(folder.join("figure.png")) {
        let data = base64::engine::general_purpose::STANDARD.encode(png);
        let image = format!("<img alt=\"{}\" src=\"data:image/png;base64,{data}\">", outcome.case.name);
        add(&image, "In the repository");
    }
    if html.is_empty() { html } else { format!("<div class=\"figures\">{html}</div>\n") }
}

fn table(rows: &[Row]) -> String {
    let mut html = String::from(
        "<div class=\"wide\"><table class=\"rows\"><thead><tr><th>check</th><th class=\"n\">measured</th>\
         <th class=\"n\">reference</th><th>paper</th><th>bound</th><th>unit</th><th>verdict</th></tr></thead><tbody>\n",
    );
    for row in rows {
        let (class, verdict) = if row.pass { ("", "kept") } else { (" class=\"missed\"", "✗ missed") };
        let _ = writeln!(
            html,
            "<tr{class}><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td><td>{}</td><td>{}</td>\
             <td>{verdict}</td></tr>",
            escape(&row.name),
            number(row.measured),
            row.reference.map_or_else(String::new, number),
            escape(row.paper.as_deref().unwrap_or_default()),
            bound(row),
            unit(row),
        );
    }
    html + "</tbody></table></div>\n"
}

/// The unit; none for a mere number.
fn unit(row: &Row) -> String {
    if row.unit == "1" { String::new() } else { escape(&row.unit) }
}

fn bound(row: &Row) -> String {
    row.bound.replace("<=", "≤").replace(">=", "≥")
}

/// Seconds as one says them.
fn duration(seconds: f64) -> String {
    if seconds < 100.0 { format!("{seconds:.1} s") } else { format!("{:.1} min", seconds / 60.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CASES;

    fn outcome(pass: bool) -> Outcome {
        let mut row = Row::at_most("deformation: <pieces>", 2.0, 3.0, "1").paper("about 900");
        row.pass = pass;
        Outcome { case: CASES[0], rows: vec![row], seconds: 1.0, figure: None }
    }

    #[test]
    fn the_page_is_whole_alone_and_marks_what_is_missed() {
        let documents = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../validation");
        let conditions = Conditions::now(true, 2);
        let good = page(&[outcome(true)], &conditions, &documents);
        assert!(!good.contains("{{") && !good.contains("http-equiv") && !good.contains("<script"));
        assert!(good.contains("All 1 bounds are kept") && good.contains("&lt;pieces&gt;"));
        assert!(good.contains("about 900") && good.contains("data:image/png;base64,"));
        assert!(
            !good.contains("src=\"http") && !good.contains("href=\"http"),
            "a page that needs no network"
        );
        let bad = page(&[outcome(false)], &conditions, &documents);
        assert!(bad.contains("1 of 1 bounds missed") && bad.matches("class=\"missed\"").count() >= 2);
    }

    #[test]
    fn a_page_without_a_checkout_still_has_its_rows() {
        let page = page(&[outcome(true)], &Conditions::now(false, 1), Path::new("nowhere"));
        assert!(page.contains("&lt;pieces&gt;") && !page.contains("Shortened"));
    }

    #[test]
    fn every_case_has_a_readme_and_a_figure() {
        let documents = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../validation");
        let list = std::fs::read_to_string(documents.join("README.md")).unwrap();
        for case in CASES {
            for file in ["README.md", "figure.png"] {
                let path = documents.join(case.name).join(file);
                assert!(path.is_file(), "{} is missing", path.display());
            }
            assert!(list.contains(&format!("]({}/README.md)", case.name)), "{} is not listed", case.name);
        }
    }
}
