//! `probes.csv`: one row a sample.

use crate::sink::SinkError;
use rsph_core::simulation::Reading;
use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// An open `probes.csv`.
#[derive(Debug)]
pub struct ProbeWriter {
    path: PathBuf,
    csv: csv::Writer<File>,
    columns: Vec<String>,
    /// Rows that wait in memory.
    waiting: usize,
    flushed: Instant,
}

/// A sample waits in memory no longer than this, if another one follows.
const FLUSH_EVERY: Duration = Duration::from_secs(1);
/// Rows wait in a buffer of this size (bytes), which only whole rows leave.
const BUFFER: usize = 1 << 20;
/// Longest number with its comma (bytes).
const LONGEST: usize = 340;

impl ProbeWriter {
    /// A new file with the header `time,<column>...`; an existing one is replaced.
    ///
    /// # Errors
    /// When the file can not be created.
    pub fn create(path: &Path, columns: &[String]) -> Result<Self, SinkError> {
        let file = File::create(path).map_err(|e| SinkError::io(path, e))?;
        let mut writer = Self::new(path, file, columns);
        writer
            .csv
            .write_field("time")
            .and_then(|()| writer.csv.write_record(columns))
            .map_err(|e| failed(path, e))?;
        writer.flush()?;
        Ok(writer)
    }

    /// Goes on with the file at `path` behind its first `bytes` bytes.
    ///
    /// # Errors
    /// When the file can not be written or is shorter.
    pub fn resume(path: &Path, columns: &[String], bytes: u64) -> Result<Self, SinkError> {
        let open = || -> std::io::Result<Option<File>> {
            let mut file = File::options().write(true).open(path)?;
            if file.metadata()?.len() < bytes {
                return Ok(None);
            }
            file.set_len(bytes)?;
            file.seek(SeekFrom::End(0))?;
            Ok(Some(file))
        };
        let file = open().map_err(|e| SinkError::io(path, e))?;
        let file = file.ok_or_else(|| SinkError::new(path, "it is shorter than it was at the checkpoint"))?;
        Ok(Self::new(path, file, columns))
    }

    fn new(path: &Path, file: File, columns: &[String]) -> Self {
        let csv = csv::WriterBuilder::new().buffer_capacity(BUFFER).from_writer(file);
        Self { path: path.into(), csv, columns: columns.to_vec(), waiting: 0, flushed: Instant::now() }
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
        self.waiting += 1;
        let full = (self.waiting + 1) * (self.columns.len() + 1) * LONGEST > BUFFER;
        if full { self.flush() } else { self.tick() }
    }

    /// Hands rows that have waited long enough to the system; called from time to time.
    ///
    /// # Errors
    /// When they can not be stored.
    pub fn tick(&mut self) -> Result<(), SinkError> {
        if self.flushed.elapsed() < FLUSH_EVERY {
            return Ok(());
        }
        self.flush()
    }

    /// Hands all rows to the system.
    ///
    /// # Errors
    /// When they can not be stored.
    pub fn flush(&mut self) -> Result<(), SinkError> {
        (self.waiting, self.flushed) = (0, Instant::now());
        self.csv.flush().map_err(|e| SinkError::io(&self.path, e))
    }

    /// Hands all rows to the system, waits until they are on the disk, and returns the length of the file (bytes).
    ///
    /// # Errors
    /// When they can not be stored.
    pub fn settle(&mut self) -> Result<u64, SinkError> {
        self.flush()?;
        let file = self.csv.get_ref();
        let len = file.sync_all().and_then(|()| file.metadata());
        Ok(len.map_err(|e| SinkError::io(&self.path, e))?.len())
    }
}

fn failed(path: &Path, e: csv::Error) -> SinkError {
    match e.into_kind() {
        csv::ErrorKind::Io(e) => SinkError::io(path, e),
        other => SinkError::new(path, format!("{other:?}")),
    }
}
