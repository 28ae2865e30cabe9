//! A whole run, as the command line does it.

use crate::errors;
use crate::interrupt::{SOON, interruptible};
use crate::scenario::{Source, loaded};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsph_scenario::run::{self, Begin, Observer, Progress, RunError};
use rsph_scenario::scenario::LoadedScenario;
use rsph_scenario::sink::{Outcome, Status};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How long an interrupted run may take to close its files.
const CLOSING: Duration = Duration::from_secs(10);

/// Tells a Python function `report(time, until)` how far a run is; its error stops the run.
struct Reporter {
    report: Option<Py<PyAny>>,
    stop: Arc<AtomicBool>,
    trouble: Option<PyErr>,
}

impl Observer for Reporter {
    fn progressed(&mut self, progress: &Progress) {
        let Some(report) = &self.report else { return };
        let told = Python::attach(|py| report.call1(py, (progress.time, progress.until)).map(drop));
        if let Err(error) = told {
            self.trouble.get_or_insert(error);
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}

/// What a run leaves: the text of `summary.json`, and the header and the last row of `probes.csv`, both
/// empty where they are in the folder.
struct Left {
    summary: String,
    columns: Vec<String>,
    last: Vec<f64>,
    outcome: Outcome,
}

fn do_run(
    scenario: &LoadedScenario,
    output: Option<&PathBuf>,
    force: bool,
    reporter: &mut Reporter,
) -> Result<Left, RunError> {
    let stop = Arc::clone(&reporter.stop);
    if let Some(folder) = output {
        let begin = if force { Begin::Overwriting } else { Begin::Fresh };
        let outcome = run::run(scenario, folder, begin, reporter, &stop)?;
        return Ok(Left { summary: String::new(), columns: Vec::new(), last: Vec::new(), outcome });
    }
    let (left, outcome) = run::run_in_memory(scenario, reporter, &stop)?;
    let summary = left.summary.to_json().unwrap_or_default();
    Ok(Left { summary, columns: left.columns, last: left.last, outcome })
}

/// Runs a scenario and stores its results in the folder `output`, or remembers only its end: `summary` (the
/// text of summary.json), `probes` (their last readings) and `error`, what made the simulation fail, if it did.
#[pyfunction]
#[pyo3(signature = (source, output=None, force=false, report=None))]
pub fn run_scenario(
    py: Python<'_>,
    source: Source,
    output: Option<PathBuf>,
    force: bool,
    report: Option<Py<PyAny>>,
) -> PyResult<Bound<'_, PyDict>> {
    let stop = Arc::new(AtomicBool::new(false));
    let mut reporter = Reporter { report, stop: Arc::clone(&stop), trouble: None };
    let grace = if output.is_some() { CLOSING } else { SOON };
    let named = !source.0.is_empty();
    let scenario = loaded(source)?;
    let work = move || {
        let left = do_run(&scenario, output.as_ref(), force, &mut reporter);
        (left, reporter.trouble)
    };
    let (left, trouble) = interruptible(py, grace, move || stop.store(true, Ordering::Relaxed), work)?;
    trouble.map_or(Ok(()), Err)?;
    let left = left.map_err(|e| errors::run(&e, named))?;
    let probes = PyDict::new(py);
    for (name, value) in left.columns.into_iter().zip(left.last) {
        probes.set_item(name, value)?;
    }
    let dict = PyDict::new(py);
    dict.set_item("summary", left.summary)?;
    dict.set_item("probes", probes)?;
    let error = if let Status::Failed(failure) = &left.outcome.status {
        Some(errors::failure(failure).into_value(py))
    } else {
        None
    };
    dict.set_item("error", error)?;
    Ok(dict)
}
