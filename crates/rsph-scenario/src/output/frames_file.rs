//! A file of frames that is whole at every moment.
//!
//! HDF5 changes its tables in place: a program that is killed between two of these changes leaves a file that
//! nobody can read. So frames are appended to a second copy, which then changes names with the file; the copy that
//! is left behind gets them next time. A kill at any moment leaves a file with all frames up to the last change of
//! names, for twice the space on the disk while the run goes on.

use super::atomic::{beside, sync, sync_folder};
use super::polydata::{Frame, PolyData};
use super::vtkhdf::{VtkHdfError, VtkHdfWriter, visit_steps};
use crate::sink::SinkError;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Frames wait in memory no longer than this.
const LONGEST_WAIT: Duration = Duration::from_millis(500);
/// Frames of more bytes than this do not wait.
const MOST_BYTES: usize = 8 << 20;

/// A file of frames.
#[derive(Debug)]
pub struct FramesFile {
    path: PathBuf,
    /// The second copy.
    spare: PathBuf,
    /// Frames that are not in the file yet, and their size.
    waiting: Vec<Box<dyn Frame>>,
    waiting_bytes: usize,
    /// Whether there is a second copy, which lacks the frames that were stored last.
    copied: bool,
    stored: Instant,
}

impl FramesFile {
    /// A new file without frames; an existing one is replaced.
    ///
    /// # Errors
    /// When it can not be written.
    pub fn create(path: &Path) -> Result<Self, SinkError> {
        let file = Self::at(path);
        file.clear()?;
        VtkHdfWriter::create(&file.spare)?;
        fs::rename(&file.spare, path).map_err(|e| SinkError::io(path, e))?;
        Ok(file)
    }

    /// Goes on with the file at `path` behind its first `frames` frames, which are handed to `visit`; further
    /// ones are dropped.
    ///
    /// # Errors
    /// When it can not be read or written, or has fewer frames.
    pub fn resume(path: &Path, frames: usize, visit: &mut dyn FnMut(&PolyData)) -> Result<Self, SinkError> {
        let file = Self::at(path);
        file.clear()?;
        let mut copy = VtkHdfWriter::create(&file.spare)?;
        let stored = visit_steps(path, frames, &mut |frame| {
            visit(&frame);
            copy.append(&frame)
        });
        drop(copy);
        if stored? > frames {
            sync(&file.spare)
                .and_then(|()| fs::rename(&file.spare, path))
                .and_then(|()| sync_folder(path))
                .map_err(|e| SinkError::io(path, e))?;
        } else {
            file.clear()?;
        }
        Ok(file)
    }

    fn at(path: &Path) -> Self {
        Self {
            path: path.into(),
            spare: beside(path, ".next"),
            waiting: Vec::new(),
            waiting_bytes: 0,
            copied: false,
            stored: Instant::now(),
        }
    }

    /// Removes the second copy.
    fn clear(&self) -> Result<(), SinkError> {
        for old in [self.spare.clone(), self.aside()] {
            match fs::remove_file(&old) {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(SinkError::io(&old, e)),
                _ => {}
            }
        }
        Ok(())
    }

    fn aside(&self) -> PathBuf {
        beside(&self.path, ".last")
    }

    /// Takes a frame; it is stored now or soon.
    ///
    /// # Errors
    /// When it can not be stored.
    pub fn append(&mut self, frame: Box<dyn Frame>) -> Result<(), SinkError> {
        self.waiting_bytes += size(&*frame);
        self.waiting.push(frame);
        if self.waiting_bytes > MOST_BYTES { self.store() } else { self.tick() }
    }

    /// Stores frames that have waited long enough; called from time to time.
    ///
    /// # Errors
    /// When they can not be stored.
    pub fn tick(&mut self) -> Result<(), SinkError> {
        if self.waiting.is_empty() || self.stored.elapsed() < LONGEST_WAIT {
            return Ok(());
        }
        self.store()
    }

    /// Stores all frames.
    ///
    /// # Errors
    /// When they can not be stored; the file is then as it was.
    pub fn store(&mut self) -> Result<(), SinkError> {
        self.stored = Instant::now();
        if self.waiting.is_empty() {
            return Ok(());
        }
        let stored = self.write().and_then(|()| self.change_names());
        if stored.is_err() {
            // Room for what is still to be written.
            self.copied = false;
            let _ = self.clear();
        }
        stored
    }

    /// Stores all frames and waits until they are on the disk.
    ///
    /// # Errors
    /// When they can not be stored.
    pub fn settle(&mut self) -> Result<(), SinkError> {
        self.store()?;
        sync(&self.path).and_then(|()| sync_folder(&self.path)).map_err(|e| SinkError::io(&self.path, e))
    }

    /// Stores all frames and removes the second copy.
    ///
    /// # Errors
    /// When they can not be stored.
    pub fn finish(&mut self) -> Result<(), SinkError> {
        self.store()?;
        self.copied = false;
        self.clear()
    }

    /// Brings the second copy up to date.
    fn write(&mut self) -> Result<(), SinkError> {
        // Fails if somebody looks at what was the file before the last change of names.
        let caught_up = || {
            let mut copy = VtkHdfWriter::open(&self.spare).ok()?;
            copy.catch_up(&self.path).ok()?;
            Some(copy)
        };
        let copied = if std::mem::take(&mut self.copied) { caught_up() } else { None };
        let mut copy = if let Some(copy) = copied {
            copy
        } else {
            self.clear()?;
            fs::copy(&self.path, &self.spare).map_err(|e| SinkError::io(&self.path, e))?;
            VtkHdfWriter::open(&self.spare)?
        };
        Ok(self.waiting.iter().try_for_each(|frame| copy.append(&**frame))?)
    }

    /// Makes the second copy the file, and the file the second copy. There is a file at every moment.
    fn change_names(&mut self) -> Result<(), SinkError> {
        let aside = self.aside();
        // Not every file system has a second name for a file: then the next copy is made anew.
        let kept = fs::hard_link(&self.path, &aside).is_ok();
        fs::rename(&self.spare, &self.path).map_err(|e| SinkError::io(&self.path, e))?;
        self.waiting.clear();
        self.waiting_bytes = 0;
        self.copied = kept && fs::rename(&aside, &self.spare).is_ok();
        Ok(())
    }
}

impl Drop for FramesFile {
    fn drop(&mut self) {
        // Nobody is left to tell.
        let _ = self.clear();
    }
}

impl From<VtkHdfError> for SinkError {
    fn from(e: VtkHdfError) -> Self {
        let message = format!("{}; {}", e.problem, e.remedy);
        Self::new(e.path, message)
    }
}

/// Bytes of a frame in memory.
fn size(frame: &dyn Frame) -> usize {
    let values: usize = frame.fields().iter().map(|(_, components)| components).sum();
    8 * (3 + values) * frame.point_count() + 12 * frame.triangles().map_or(0, <[_]>::len)
}
