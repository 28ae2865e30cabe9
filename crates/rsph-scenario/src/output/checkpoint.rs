//! `checkpoint.h5`: everything that a run needs to go on as if it had never stopped.

use super::atomic;
use super::foreign;
use super::vtkhdf::reason;
use crate::sink::SinkError;
use hdf5::{Dataset, File, Group};
use rsph_core::state::State;
use std::path::{Path, PathBuf};

/// Changes whenever older programs can not read what newer ones write, or the other way round.
const FORMAT: i64 = 1;
/// The file's name in the folder of a run.
pub const FILE: &str = "checkpoint.h5";

/// A checkpoint that a run can not go on from.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct CheckpointError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong.
    pub problem: String,
    /// What to do about it.
    pub remedy: String,
}

impl CheckpointError {
    /// A problem with the checkpoint of `folder`.
    pub fn new(folder: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { path: folder.join(FILE), problem: problem.into(), remedy: remedy.into() }
    }
}

/// State of a run from which it can be continued.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The scenario as run.
    pub scenario: String,
    /// Version of the program that wrote it.
    pub version: String,
    /// Simulation, run loop and results.
    pub state: State,
}

impl Checkpoint {
    /// Replaces the checkpoint of `folder`. The old one stays until the new one is on the disk.
    ///
    /// # Errors
    /// When it can not be stored.
    pub fn write(&self, folder: &Path) -> Result<(), SinkError> {
        let path = folder.join(FILE);
        atomic::replace(&path, |part| self.store(part).map_err(|e| SinkError::new(&path, reason(&e))))
    }

    fn store(&self, path: &Path) -> hdf5::Result<()> {
        let file = File::create(path)?;
        let mut open = Vec::new();
        let stored = self.fill(&file, &mut open).and_then(|()| file.flush());
        if stored.is_err() {
            // HDF5 crashes when it closes what it could not write.
            std::mem::forget((file, open));
            return stored;
        }
        drop(open);
        file.close()
    }

    /// Writes everything to `file`; datasets stay open.
    fn fill(&self, file: &File, open: &mut Vec<Dataset>) -> hdf5::Result<()> {
        let root = file.create_group("rsph")?;
        root.new_attr::<i64>().create("format")?.write_scalar(&FORMAT)?;
        let mut keep = |dataset: Dataset| {
            open.push(dataset.clone());
            dataset
        };
        for (name, text) in [("version", &self.version), ("scenario", &self.scenario)] {
            let bytes = text.as_bytes();
            keep(root.new_dataset::<u8>().shape(bytes.len()).create(name)?).write(bytes)?;
        }
        let state = file.create_group("state")?;
        for (name, values) in self.state.reals() {
            let group = group_of(&state, name)?;
            keep(group.new_dataset::<f64>().shape(values.len()).create(last(name))?).write(values)?;
        }
        for (name, values) in self.state.wholes() {
            let group = group_of(&state, name)?;
            keep(group.new_dataset::<i64>().shape(values.len()).create(last(name))?).write(values)?;
        }
        Ok(())
    }

    /// Reads the checkpoint of `folder`.
    ///
    /// # Errors
    /// When it is not there, damaged or of another format.
    pub fn read(folder: &Path) -> Result<Self, CheckpointError> {
        let again = "run the scenario from its start, with `--force` in place of `--resume`";
        let path = folder.join(FILE);
        std::fs::metadata(&path)
            .map_err(|e| CheckpointError::new(folder, format!("there is no checkpoint: {e}"), again))?;
        let damaged =
            |e: hdf5::Error| CheckpointError::new(folder, format!("not a readable checkpoint: {e}"), again);
        foreign::check_file(&path, u64::MAX).map_err(|e| damaged(e.into()))?;
        let file = File::open(&path).map_err(damaged)?;
        let format = format(&file).map_err(damaged)?;
        if format != FORMAT {
            return Err(CheckpointError::new(
                folder,
                format!("has the format {format}, this program reads {FORMAT}: another version wrote it"),
                "go on with the version of rsph that wrote it, or run from the start with `--force`",
            ));
        }
        Self::load(&file).map_err(damaged)
    }

    fn load(file: &File) -> hdf5::Result<Self> {
        let text = |name: &str| -> hdf5::Result<String> {
            let dataset = checked(file.dataset(&format!("rsph/{name}"))?, name, file)?;
            String::from_utf8(dataset.read_raw::<u8>()?).map_err(|e| e.to_string().into())
        };
        let mut state = State::default();
        let root = file.group("state")?;
        for part in root.member_names()? {
            let group = root.group(&part)?;
            for quantity in group.member_names()? {
                let name = format!("{part}/{quantity}");
                let dataset = checked(group.dataset(&quantity)?, &name, file)?;
                if dataset.dtype()?.is::<f64>() {
                    state.put(&name, dataset.read_raw::<f64>()?);
                } else {
                    state.put_whole(&name, dataset.read_raw::<i64>()?);
                }
            }
        }
        Ok(Self { scenario: text("scenario")?, version: text("version")?, state })
    }
}

/// A list that the file holds itself.
fn checked(dataset: Dataset, name: &str, file: &File) -> hdf5::Result<Dataset> {
    if dataset.ndim() != 1 {
        return Err(format!("`{name}` is no list").into());
    }
    foreign::check_dataset(&dataset, name, &file.filename(), dataset.size() as u64)?;
    Ok(dataset)
}

fn format(file: &File) -> hdf5::Result<i64> {
    file.group("rsph")?.attr("format")?.read_scalar()
}

/// The group of an array, made if need be.
fn group_of(state: &Group, name: &str) -> hdf5::Result<Group> {
    let part = name.split('/').next().unwrap_or_default();
    if state.link_exists(part) { state.group(part) } else { state.create_group(part) }
}

/// The name of an array in its group.
fn last(name: &str) -> &str {
    name.split_once('/').map_or(name, |(_, quantity)| quantity)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkpoint() -> Checkpoint {
        let mut state = State::default();
        state.put("a/x", [1.0, -0.0, 1e-310]);
        state.put("a/none", Vec::new());
        state.put("b/x", [2.0]);
        state.put_whole("b/n", [-1, i64::MAX]);
        Checkpoint { scenario: "title = \"ä\"\n".into(), version: "0".into(), state }
    }

    #[test]
    fn what_is_stored_is_read_back() {
        let dir = tempfile::tempdir().unwrap();
        checkpoint().write(dir.path()).unwrap();
        checkpoint().write(dir.path()).unwrap();
        assert_eq!(Checkpoint::read(dir.path()).unwrap(), checkpoint());
        let left: Vec<_> = std::fs::read_dir(dir.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
        assert_eq!(left, [FILE]);
    }

    #[test]
    fn other_formats_and_damage_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        assert!(Checkpoint::read(dir.path()).unwrap_err().problem.contains("there is no checkpoint"));
        checkpoint().write(dir.path()).unwrap();
        let path = dir.path().join(FILE);
        let file = File::open_rw(&path).unwrap();
        file.group("rsph").unwrap().attr("format").unwrap().write_scalar(&99_i64).unwrap();
        file.close().unwrap();
        let other = Checkpoint::read(dir.path()).unwrap_err();
        assert!(other.problem.contains("format 99") && other.problem.contains("another version"), "{other}");
        let whole = std::fs::read(&path).unwrap();
        for keep in [0, 100, whole.len() / 2] {
            std::fs::write(&path, &whole[..keep]).unwrap();
            assert!(Checkpoint::read(dir.path()).is_err(), "{keep} bytes");
        }
    }

    #[test]
    fn a_checkpoint_that_can_not_be_stored_leaves_the_old_one() {
        let dir = tempfile::tempdir().unwrap();
        checkpoint().write(dir.path()).unwrap();
        std::fs::create_dir(dir.path().join("checkpoint.h5.part")).unwrap();
        assert!(checkpoint().write(dir.path()).is_err());
        assert_eq!(Checkpoint::read(dir.path()).unwrap(), checkpoint());
    }
}
