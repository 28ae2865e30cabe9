//! `probes.csv`: one row a sample.

use crate::sink::SinkError;
use rsph_core::simulation::Reading;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// An open `probes.csv`.
#[derive(Debug)]
pub struct ProbeWriter {
    path: PathBuf,
    csv: csv::Writer<File>,
    columns: Vec<String>,
    flushed: Instant,
}

/// A sample waits in memory no longer than this, if another one follows.
const FLUSH_EVERY: Duration = Duration::from_secs(1);

impl ProbeWriter {
    /// A new file with the header `time,<column>...`; an existing one is replaced.
    ///
    /// # Errors
    /// When the file can not be created.
    pub fn create(path: &Path, columns: &[String]) -> Result<Self, SinkError> {
        let mut csv = csv::Writer::from_path(path).map_err(|e| failed(path, e))?;
        csv.write_field("time").and_then(|()| csv.write_record(columns)).map_err(|e| failed(path, e))?;
        csv.flush().map_err(|e| SinkError::io(path, e))?;
        Ok(Self { path: path.into(), csv, columns: columns.to_vec(), flushed: Instant::now() })
    }

    /// Appends one row.
    ///
    /// # Errors
    /// When the readings are not those of the header or can not be stored.
    pub fn append(&mut self, time: f64, readings: &[Reading]) -> Result<(), SinkError> {
        if !readings.iter().map(|r| &r.name).eq(&self.columns) {
            let names: Vec<_> = readings.iter().map(|r| r.name.as_str()).collect();
            return Err(SinkError::new(
                &self.path,
                format!("readings changed from {:?} to {names:?}: a mistake of the program", self.columns),
            ));
        }
        let row = std::iter::once(time).chain(readings.iter().map(|r| r.value)).map(|x| x.to_string());
        self.csv.write_record(row).map_err(|e| failed(&self.path, e))?;
        if self.flushed.elapsed() >= FLUSH_EVERY {
            self.flush()?;
        }
        Ok(())
    }

    /// Hands all rows to the system.
    ///
    /// # Errors
    /// When they can not be stored.
    pub fn flush(&mut self) -> Result<(), SinkError> {
        self.flushed = Instant::now();
        self.csv.flush().map_err(|e| SinkError::io(&self.path, e))
    }
}

fn failed(path: &Path, e: csv::Error) -> SinkError {
    match e.into_kind() {
        csv::ErrorKind::Io(e) => SinkError::io(path, e),
        other => SinkError::new(path, format!("{other:?}")),
    }
}
