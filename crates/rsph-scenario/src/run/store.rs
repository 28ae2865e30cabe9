//! The sink of a run's folder.

use super::RunStart;
use crate::sink::{Outcome, RunSink, SinkError};
use rsph_core::simulation::{Conservation, Reading};
use rsph_core::snapshot::Snapshot;
use rsph_core::surface::Surface;

/// Opens the files of a run's folder.
pub fn open(start: &RunStart<'_>) -> Result<Box<dyn RunSink>, SinkError> {
    let path = start.folder.join("scenario.toml");
    std::fs::write(&path, start.scenario.as_run()).map_err(|e| SinkError::io(&path, e))?;
    Ok(Box::new(Nowhere))
}

struct Nowhere;

impl RunSink for Nowhere {
    fn frame(&mut self, _: &Snapshot, _: &Surface, _: &Conservation) -> Result<(), SinkError> {
        Ok(())
    }
    fn sample(&mut self, _: f64, _: &[Reading], _: &Conservation) -> Result<(), SinkError> {
        Ok(())
    }
    fn finish(&mut self, _: &Outcome) -> Result<(), SinkError> {
        Ok(())
    }
}
