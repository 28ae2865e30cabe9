//! A run's folder: particles and surface for ParaView and pyvista, probes as a table, a summary for
//! scripts and a report for people.

pub(crate) mod atomic;
mod info;
mod number;
pub mod polydata;
pub mod probes;
pub mod report;
pub mod summary;
mod units;
pub mod vtkhdf;
pub mod vtp;

pub use info::{Parameter, ProbeColumn, RunInfo};
pub use number::number;

use crate::sink::{Outcome, RunSink, SinkError};
use polydata::PolyData;
use probes::ProbeWriter;
use report::Report;
use rsph_core::simulation::{Conservation, Reading};
use rsph_core::snapshot::Snapshot;
use rsph_core::surface::Surface;
use std::path::{Path, PathBuf};
use summary::Summary;
use vtkhdf::{VtkHdfError, VtkHdfWriter};

/// Version of rsph, as it stands in summaries and reports.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Writes a run's folder.
#[derive(Debug)]
pub struct RunWriters {
    folder: PathBuf,
    info: RunInfo,
    particles: VtkHdfWriter,
    surface: VtkHdfWriter,
    probes: ProbeWriter,
    report: Report,
    last: Conservation,
    particle_count: usize,
    frames: usize,
}

impl RunWriters {
    /// Creates the folder if need be and opens its files. A summary and report of an earlier run
    /// are removed, so that they never stand beside other results.
    ///
    /// # Errors
    /// When the folder or a file in it can not be written.
    pub fn create(folder: &Path, info: RunInfo) -> Result<Self, SinkError> {
        std::fs::create_dir_all(folder).map_err(|e| SinkError::io(folder, e))?;
        for stale in ["summary.json", "report.html"].map(|name| folder.join(name)) {
            match std::fs::remove_file(&stale) {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(SinkError::io(&stale, e)),
                _ => {}
            }
        }
        atomic::write(&folder.join("scenario.toml"), info.scenario.as_bytes())?;
        let columns: Vec<_> = info.probes.iter().map(|p| p.name.clone()).collect();
        Ok(Self {
            particles: VtkHdfWriter::create(&folder.join("particles.vtkhdf"))?,
            surface: VtkHdfWriter::create(&folder.join("surface.vtkhdf"))?,
            probes: ProbeWriter::create(&folder.join("probes.csv"), &columns)?,
            report: Report::default(),
            last: Conservation::default(),
            particle_count: info.description.particles,
            frames: 0,
            folder: folder.into(),
            info,
        })
    }
}

impl RunSink for RunWriters {
    fn frame(
        &mut self,
        snapshot: &Snapshot,
        surface: &Surface,
        conservation: &Conservation,
    ) -> Result<(), SinkError> {
        self.particles.append(&PolyData::from_snapshot(snapshot))?;
        self.surface.append(&PolyData::from_surface(snapshot.time, surface))?;
        self.probes.flush()?;
        self.report.frame(snapshot.time, surface);
        self.last = *conservation;
        self.particle_count = snapshot.len();
        self.frames += 1;
        Ok(())
    }

    fn sample(
        &mut self,
        time: f64,
        readings: &[Reading],
        conservation: &Conservation,
    ) -> Result<(), SinkError> {
        self.last = *conservation;
        self.report.sample(time, readings, conservation);
        self.probes.append(time, readings)
    }

    fn finish(&mut self, outcome: &Outcome) -> Result<(), SinkError> {
        self.probes.flush()?;
        let summary = Summary::new(&self.info, outcome, &self.last, self.particle_count, self.frames);
        let path = self.folder.join("summary.json");
        let json = summary.to_json().map_err(|e| SinkError::new(&path, e))?;
        atomic::write(&path, json.as_bytes())?;
        self.report.write(&self.folder.join("report.html"), &self.info, &summary, outcome)
    }
}

impl From<VtkHdfError> for SinkError {
    fn from(e: VtkHdfError) -> Self {
        let message = format!("{}; {}", e.problem, e.remedy);
        Self::new(e.path, message)
    }
}
