//! A run's folder: particles and surface for ParaView and pyvista, probes as a table, a summary for
//! scripts and a report for people.

pub mod atomic;
pub mod checkpoint;
mod foreign;
mod frames_file;
pub mod html;
mod info;
mod machine;
pub mod nifti;
mod number;
pub mod polydata;
pub mod probes;
pub mod report;
pub mod summary;
pub(crate) mod units;
pub mod voxels;
pub mod vtkhdf;
pub mod vtp;

pub use info::{Course, Parameter, ProbeColumn, RunInfo};
pub use number::{interval, number};

use crate::sink::{Event, Outcome, RunSink, SinkError};
use checkpoint::Checkpoint;
use frames_file::FramesFile;
use polydata::PolyData;
use probes::ProbeWriter;
use report::Report;
use rsph_core::error::InvalidInput;
use rsph_core::simulation::{Conservation, Reading};
use rsph_core::snapshot::Snapshot;
use rsph_core::state::State;
use rsph_core::surface::Surface;
use std::path::{Path, PathBuf};
use summary::Summary;
use vtkhdf::VtkHdfWriter;

/// Version of rsph, as it stands in summaries and reports.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The file of the frame that a failed run leaves besides its last good one.
pub const POST_MORTEM: &str = "post_mortem.vtkhdf";

/// Writes a run's folder.
#[derive(Debug)]
pub struct RunWriters {
    folder: PathBuf,
    info: RunInfo,
    particles: FramesFile,
    surface: FramesFile,
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
        remove_ends(folder)?;
        atomic::write(&folder.join("scenario.toml"), info.scenario.as_bytes())?;
        let columns: Vec<_> = info.probes.iter().map(|p| p.name.clone()).collect();
        Ok(Self {
            particles: FramesFile::create(&folder.join("particles.vtkhdf"))?,
            surface: FramesFile::create(&folder.join("surface.vtkhdf"))?,
            probes: ProbeWriter::create(&folder.join("probes.csv"), &columns)?,
            report: Report::default(),
            last: Conservation::default(),
            particle_count: info.description.particles,
            frames: 0,
            folder: folder.into(),
            info,
        })
    }

    /// Goes on with the results of a run as they were when `state` was stored, a moment of `particles` particles
    /// and these conserved sums; what was written after that is dropped.
    ///
    /// # Errors
    /// When they can not be read or written, or are not those of that run.
    pub fn resume(
        folder: &Path,
        info: RunInfo,
        state: &State,
        particles: usize,
        conservation: Conservation,
    ) -> Result<Self, SinkError> {
        let damaged =
            |e: InvalidInput| SinkError::new(folder.join(checkpoint::FILE), format!("{e}; {}", e.remedy));
        let [frames, bytes] = state.counts(RESULTS).map_err(damaged)?;
        let frames = frames as usize;
        let columns: Vec<_> = info.probes.iter().map(|p| p.name.clone()).collect();
        let mut report = Report::default();
        report.restore(state, columns.len()).map_err(damaged)?;
        remove_ends(folder)?;
        Ok(Self {
            particles: FramesFile::resume(&folder.join("particles.vtkhdf"), frames, &mut |_| ())?,
            surface: FramesFile::resume(&folder.join("surface.vtkhdf"), frames, &mut |s| report.frame(s))?,
            probes: ProbeWriter::resume(&folder.join("probes.csv"), &columns, bytes)?,
            report,
            last: conservation,
            particle_count: particles,
            frames,
            folder: folder.into(),
            info,
        })
    }
}

/// Name of the counts of frames and of bytes of probes in a state.
const RESULTS: &str = "results/counts";

/// Removes what only the end of a run writes.
fn remove_ends(folder: &Path) -> Result<(), SinkError> {
    for stale in ["summary.json", "report.html", POST_MORTEM].map(|name| folder.join(name)) {
        match std::fs::remove_file(&stale) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(SinkError::io(&stale, e)),
            _ => {}
        }
    }
    Ok(())
}

impl RunSink for RunWriters {
    fn take(&mut self, event: Event) -> Result<(), SinkError> {
        match event {
            Event::Frame(frame) => {
                let (snapshot, surface, conservation) = *frame;
                self.frame(snapshot, surface, &conservation)
            }
            Event::Sample(time, readings, now) => self.sample(time, &readings, &now),
            Event::Tick => self.tick(),
            Event::Checkpoint(state) => self.checkpoint(state),
            Event::PostMortem(snapshot) => self.post_mortem(&snapshot),
            Event::Finish(outcome) => self.finish(&outcome),
        }
    }
}

impl RunWriters {
    /// Stores a frame.
    ///
    /// # Errors
    /// When it can not be stored.
    pub fn frame(
        &mut self,
        snapshot: Snapshot,
        surface: Surface,
        conservation: &Conservation,
    ) -> Result<(), SinkError> {
        let surface = PolyData::from_surface(snapshot.time, surface);
        self.report.frame(&surface);
        self.particle_count = snapshot.len();
        self.particles.append(Box::new(snapshot))?;
        self.surface.append(Box::new(surface))?;
        self.last = *conservation;
        self.frames += 1;
        Ok(())
    }

    /// Stores the probes' readings at one time.
    ///
    /// # Errors
    /// When it can not be stored.
    pub fn sample(
        &mut self,
        time: f64,
        readings: &[Reading],
        conservation: &Conservation,
    ) -> Result<(), SinkError> {
        self.last = *conservation;
        self.report.sample(time, readings, conservation);
        self.probes.append(time, readings)
    }

    /// Stores what has waited long enough.
    ///
    /// # Errors
    /// When it can not be stored.
    pub fn tick(&mut self) -> Result<(), SinkError> {
        self.particles.tick()?;
        self.surface.tick()?;
        self.probes.tick()
    }

    /// Stores `state`, from which the run can go on, and all results so far.
    ///
    /// # Errors
    /// When it can not be stored.
    pub fn checkpoint(&mut self, mut state: State) -> Result<(), SinkError> {
        // First the results that it counts on.
        self.particles.settle()?;
        self.surface.settle()?;
        let bytes = self.probes.settle()?;
        state.put_counts(RESULTS, &[self.frames as u64, bytes]);
        self.report.save(&mut state);
        let (scenario, version) = (self.info.scenario.clone(), VERSION.to_owned());
        Checkpoint { scenario, version, state }.write(&self.folder)
    }

    /// Stores the particles as a failure left them.
    ///
    /// # Errors
    /// When it can not be stored.
    pub fn post_mortem(&mut self, snapshot: &Snapshot) -> Result<(), SinkError> {
        let path = self.folder.join(POST_MORTEM);
        Ok(VtkHdfWriter::create(&path)?.append(snapshot)?)
    }

    /// Closes everything.
    ///
    /// # Errors
    /// When it can not be stored.
    pub fn finish(&mut self, outcome: &Outcome) -> Result<(), SinkError> {
        self.particles.finish()?;
        self.surface.finish()?;
        self.probes.flush()?;
        let summary = Summary::new(
            &self.info,
            outcome,
            (&self.last, self.report.last_readings()),
            self.particle_count,
            self.frames,
        );
        let path = self.folder.join("summary.json");
        let json = summary.to_json().map_err(|e| SinkError::new(&path, e))?;
        atomic::write(&path, json.as_bytes())?;
        self.report.write(&self.folder.join("report.html"), &self.info, &summary, outcome)
    }
}
