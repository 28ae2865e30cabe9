//! The folder of a run: found usable before anything is computed, and never overwritten by
//! accident.

use super::Begin;
use crate::output::POST_MORTEM;
use crate::output::checkpoint::FILE as CHECKPOINT;
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Files whose presence makes a folder one with results.
const RESULTS: &[&str] = &[
    "particles.vtkhdf",
    "surface.vtkhdf",
    "probes.csv",
    "summary.json",
    "report.html",
    "scenario.toml",
    CHECKPOINT,
    POST_MORTEM,
];

/// Is locked by the run that writes to the folder; the system gives the lock back when that ends in any way. The
/// file stays: if it were removed, two runs could hold locks of two files of that name.
const LOCK: &str = ".rsph.lock";

/// An output folder that can not be used.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// It holds the results of another run.
    #[error("{} holds results already ({file})", path.display())]
    HoldsResults {
        /// The folder.
        path: PathBuf,
        /// One of the results.
        file: &'static str,
    },
    /// It holds the very scenario that is to be run, under a name that results take.
    #[error("the scenario {} lies in its own output folder and would be overwritten", path.display())]
    HoldsScenario {
        /// The scenario's file.
        path: PathBuf,
    },
    /// Another run writes to it.
    #[error("another run writes to the output folder {}", path.display())]
    InUse {
        /// The folder.
        path: PathBuf,
    },
    /// It holds no checkpoint to resume from.
    #[error("there is nothing to resume: {} holds no {CHECKPOINT}", path.display())]
    NothingToResume {
        /// The folder.
        path: PathBuf,
    },
    /// It can not be made or written.
    #[error("cannot write to the output folder {}: {source}", path.display())]
    NotWritable {
        /// The folder.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
}

impl FolderError {
    /// Whether the system has failed (a full disk, missing permission), rather than the user.
    pub fn is_of_the_system(&self) -> bool {
        matches!(self, Self::NotWritable { source, .. } if source.kind() != io::ErrorKind::NotADirectory)
    }

    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::HoldsResults { .. } => {
                "add `--force` to overwrite them or `--resume` to go on with an interrupted run, or choose another \
                 folder with `--output`"
            }
            Self::InUse { .. } => "wait for its end, or choose another folder with `--output`",
            Self::NothingToResume { .. } => {
                "look whether `--output` names the folder of the run; to run from the start, leave `--resume` out"
            }
            Self::HoldsScenario { .. } => "choose another folder with `--output`, or move the scenario",
            Self::NotWritable { .. } => "choose another folder with `--output`, or check its permissions",
        }
    }
}

/// A folder that a run may write to.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    begin: Begin,
    /// Locked as long as this lives.
    lock: Option<File>,
}

impl OutputFolder {
    /// Looks at `path` without touching it.
    ///
    /// # Errors
    /// When it holds results that are not to be replaced or continued, when there is nothing to continue, or
    /// when it is something else than a folder.
    pub fn new(path: &Path, begin: Begin) -> Result<Self, FolderError> {
        check_results(path, begin)?;
        let nearest = path.ancestors().find(|a| a.exists());
        if let Some(there) = nearest.filter(|a| !a.is_dir()) {
            let source = io::Error::new(
                io::ErrorKind::NotADirectory,
                format!("{} is a file, not a folder", there.display()),
            );
            return Err(FolderError::NotWritable { path: path.into(), source });
        }
        Ok(Self { path: path.into(), begin, lock: None })
    }

    /// Makes sure that the file `scenario` is none of those that results replace.
    ///
    /// # Errors
    /// When it is.
    pub fn spare(&self, scenario: &Path) -> Result<(), FolderError> {
        let Ok(scenario) = scenario.canonicalize() else { return Ok(()) };
        let replaced = |f: &&str| self.path.join(f).canonicalize().is_ok_and(|there| there == scenario);
        if RESULTS.iter().any(replaced) {
            return Err(FolderError::HoldsScenario { path: scenario });
        }
        Ok(())
    }

    /// Makes the folder, takes it for this run alone, makes sure that it can be written, and removes older
    /// results from it unless they are to be continued.
    ///
    /// # Errors
    /// When another run has it, or it can not be written.
    pub fn claim(&mut self) -> Result<&Path, FolderError> {
        let failed = |source| FolderError::NotWritable { path: self.path.clone(), source };
        std::fs::create_dir_all(&self.path).map_err(failed)?;
        let lock = File::options().create(true).truncate(false).write(true).open(self.path.join(LOCK));
        let lock = lock.map_err(failed)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(FolderError::InUse { path: self.path.clone() }),
            // A file system without locks.
            Err(TryLockError::Error(e)) if e.kind() == io::ErrorKind::Unsupported => {}
            Err(TryLockError::Error(e)) => return Err(failed(e)),
        }
        // Another run may have come and gone since the first look.
        check_results(&self.path, self.begin)?;
        self.try_clear().map_err(failed)?;
        self.lock = Some(lock);
        Ok(&self.path)
    }

    fn try_clear(&self) -> io::Result<()> {
        let trial = self.path.join(format!(".rsph-trial-{}", std::process::id()));
        let written = std::fs::write(&trial, b"rsph");
        let removed = std::fs::remove_file(&trial);
        written.and(removed)?;
        if self.begin == Begin::Resumed {
            return Ok(());
        }
        for file in RESULTS.iter().map(|f| self.path.join(f)).filter(|f| f.exists()) {
            std::fs::remove_file(file)?;
        }
        Ok(())
    }
}

/// Whether a run may begin so with what is in the folder.
fn check_results(path: &Path, begin: Begin) -> Result<(), FolderError> {
    let held = RESULTS.iter().find(|f| path.join(f).exists());
    match (begin, held) {
        (Begin::Fresh, Some(file)) => Err(FolderError::HoldsResults { path: path.into(), file }),
        (Begin::Resumed, _) if !path.join(CHECKPOINT).exists() => {
            Err(FolderError::NothingToResume { path: path.into() })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_that_came_meanwhile_are_kept() {
        let dir = tempfile::tempdir().unwrap();
        let mut folder = OutputFolder::new(dir.path(), Begin::Fresh).unwrap();
        std::fs::write(dir.path().join("summary.json"), "{}").unwrap();
        let refused = folder.claim().unwrap_err();
        assert!(refused.to_string().contains("summary.json"), "{refused}");
        assert!(dir.path().join("summary.json").exists());
    }

    #[test]
    fn results_are_kept_unless_forced() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("summary.json"), "{}").unwrap();
        std::fs::write(dir.path().join("notes.txt"), "mine").unwrap();
        let refused = OutputFolder::new(dir.path(), Begin::Fresh).unwrap_err();
        assert!(refused.to_string().contains("summary.json") && refused.remedy().contains("--force"));
        OutputFolder::new(dir.path(), Begin::Overwriting).unwrap().claim().unwrap();
        assert!(!dir.path().join("summary.json").exists());
        assert!(dir.path().join("notes.txt").exists());
    }

    #[test]
    fn the_scenario_that_is_run_is_spared() {
        let dir = tempfile::tempdir().unwrap();
        let scenario = dir.path().join("scenario.toml");
        std::fs::write(&scenario, "mine").unwrap();
        let folder = OutputFolder::new(dir.path(), Begin::Overwriting).unwrap();
        let refused = folder.spare(&scenario).unwrap_err();
        assert!(refused.to_string().contains("its own output folder"), "{refused}");
        folder.spare(&dir.path().join("other.toml")).unwrap();
    }

    #[test]
    fn looking_writes_nothing_and_claiming_leaves_a_lock() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a/b");
        let mut folder = OutputFolder::new(&path, Begin::Fresh).unwrap();
        assert!(!dir.path().join("a").exists());
        folder.claim().unwrap();
        let left: Vec<_> = std::fs::read_dir(&path).unwrap().map(|f| f.unwrap().file_name()).collect();
        assert_eq!(left, [LOCK]);
    }

    #[test]
    fn a_folder_has_one_run_at_a_time() {
        let dir = tempfile::tempdir().unwrap();
        let mut first = OutputFolder::new(dir.path(), Begin::Fresh).unwrap();
        let mut second = OutputFolder::new(dir.path(), Begin::Overwriting).unwrap();
        first.claim().unwrap();
        let refused = second.claim().unwrap_err();
        assert!(refused.to_string().contains("another run"), "{refused}");
        drop(first);
        second.claim().unwrap();
    }

    #[test]
    fn there_must_be_something_to_resume() {
        let dir = tempfile::tempdir().unwrap();
        let refused = OutputFolder::new(dir.path(), Begin::Resumed).unwrap_err();
        assert!(refused.to_string().contains("nothing to resume"), "{refused}");
        std::fs::write(dir.path().join(CHECKPOINT), "").unwrap();
        OutputFolder::new(dir.path(), Begin::Resumed).unwrap().claim().unwrap();
        assert!(dir.path().join(CHECKPOINT).exists());
    }

    #[test]
    fn a_file_in_the_way_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("file");
        std::fs::write(&file, "").unwrap();
        let error = OutputFolder::new(&file.join("out"), Begin::Fresh).unwrap_err();
        assert!(error.to_string().contains("is a file, not a folder"), "{error}");
    }
}
