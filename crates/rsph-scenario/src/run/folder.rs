//! The folder of a run: found usable before anything is computed, and never overwritten by
//! accident.

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
    "checkpoint.h5",
];

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
    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::HoldsResults { .. } => {
                "add `--force` to overwrite them, or choose another folder with `--output`"
            }
            Self::HoldsScenario { .. } => "choose another folder with `--output`, or move the scenario",
            Self::NotWritable { .. } => "choose another folder with `--output`, or check its permissions",
        }
    }
}

/// A folder that a run may write to.
#[derive(Clone, Debug)]
pub struct OutputFolder {
    path: PathBuf,
}

impl OutputFolder {
    /// Looks at `path` without touching it.
    ///
    /// # Errors
    /// When it holds results and `force` is not given, or when it is something else than a folder.
    pub fn new(path: &Path, force: bool) -> Result<Self, FolderError> {
        let held = RESULTS.iter().find(|f| path.join(f).exists());
        if let (Some(file), false) = (held, force) {
            return Err(FolderError::HoldsResults { path: path.into(), file });
        }
        let nearest = path.ancestors().find(|a| a.exists());
        if let Some(there) = nearest.filter(|a| !a.is_dir()) {
            let source = io::Error::new(
                io::ErrorKind::NotADirectory,
                format!("{} is a file, not a folder", there.display()),
            );
            return Err(FolderError::NotWritable { path: path.into(), source });
        }
        Ok(Self { path: path.into() })
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

    /// Makes the folder, makes sure that it can be written, and removes older results from it.
    ///
    /// # Errors
    /// When it can not be written.
    pub fn claim(&self) -> Result<&Path, FolderError> {
        self.try_claim().map_err(|source| FolderError::NotWritable { path: self.path.clone(), source })?;
        Ok(&self.path)
    }

    fn try_claim(&self) -> io::Result<()> {
        std::fs::create_dir_all(&self.path)?;
        let trial = self.path.join(format!(".rsph-trial-{}", std::process::id()));
        std::fs::write(&trial, b"rsph")?;
        std::fs::remove_file(&trial)?;
        for file in RESULTS.iter().map(|f| self.path.join(f)).filter(|f| f.exists()) {
            std::fs::remove_file(file)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_kept_unless_forced() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("summary.json"), "{}").unwrap();
        std::fs::write(dir.path().join("notes.txt"), "mine").unwrap();
        let refused = OutputFolder::new(dir.path(), false).unwrap_err();
        assert!(refused.to_string().contains("summary.json") && refused.remedy().contains("--force"));
        OutputFolder::new(dir.path(), true).unwrap().claim().unwrap();
        assert!(!dir.path().join("summary.json").exists());
        assert!(dir.path().join("notes.txt").exists());
    }

    #[test]
    fn the_scenario_that_is_run_is_spared() {
        let dir = tempfile::tempdir().unwrap();
        let scenario = dir.path().join("scenario.toml");
        std::fs::write(&scenario, "mine").unwrap();
        let folder = OutputFolder::new(dir.path(), true).unwrap();
        let refused = folder.spare(&scenario).unwrap_err();
        assert!(refused.to_string().contains("its own output folder"), "{refused}");
        folder.spare(&dir.path().join("other.toml")).unwrap();
    }

    #[test]
    fn looking_writes_nothing_and_claiming_leaves_an_empty_folder() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a/b");
        let folder = OutputFolder::new(&path, false).unwrap();
        assert!(!dir.path().join("a").exists());
        folder.claim().unwrap();
        assert_eq!(std::fs::read_dir(&path).unwrap().count(), 0);
    }

    #[test]
    fn a_file_in_the_way_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("file");
        std::fs::write(&file, "").unwrap();
        let error = OutputFolder::new(&file.join("out"), false).unwrap_err();
        assert!(error.to_string().contains("is a file, not a folder"), "{error}");
    }
}
