//! Folders of runs.

use crate::exit::Trouble;
use crate::output::number;
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;

pub fn describe(path: &Path) -> Result<String, Trouble> {
    let file = path.join("summary.json");
    let refuse = |problem: String| {
        Err(Trouble::input(problem, "give the folder of a run that has ended, or a file such as organ.stl"))
    };
    let Ok(text) = std::fs::read_to_string(&file) else {
        return refuse(format!("{} holds no run: there is no summary.json in it", path.display()));
    };
    let Ok(summary) = serde_json::from_str::<Value>(&text) else {
        return refuse(format!("{} is no summary of a run", file.display()));
    };
    let word = |key: &str| summary[key].as_str().unwrap_or("?");
    let value = |key: &str| summary[key].as_f64().map_or_else(|| "?".into(), number);
    let mut text = String::new();
    let _ = writeln!(text, "run: {}", word("title"));
    let _ = writeln!(text, "status: {}", word("status"));
    if let Some(what) = summary["failure"]["what"].as_str() {
        let _ = writeln!(text, "  {what}; {}", summary["failure"]["remedy"].as_str().unwrap_or_default());
    }
    let _ = writeln!(text, "particles: {}, {} apart", summary["particles"], value("spacing"));
    let _ = writeln!(text, "time: {} after {} steps", value("time"), summary["steps"]);
    for (name, reading) in summary["readings"].as_object().into_iter().flatten() {
        if let Some(reading) = reading.as_f64() {
            let _ = writeln!(text, "reading {name}: {}", number(reading));
        }
    }
    for note in summary["notes"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        let _ = writeln!(text, "note: {note}");
    }
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries.filter_map(|e| e.file_name().into_string().ok()).collect();
    files.sort();
    let _ = writeln!(text, "files: {}", files.join(", "));
    Ok(text)
}
