//! Files that are read as a whole: never more of them than they may have.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Why a file was not read, and what to do about it.
#[derive(Debug)]
pub struct Unreadable {
    /// What is wrong.
    pub problem: String,
    /// What to do about it.
    pub remedy: String,
}

/// A file that may be read as a whole.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// What it is, with its article.
    pub what: &'static str,
    /// Most bytes that it may have.
    pub limit: u64,
    /// What to do if it has more.
    pub if_larger: &'static str,
    /// What to do if it is not there.
    pub if_missing: &'static str,
    /// Whether a pipe will do.
    pub from_pipe: bool,
}

impl Kind {
    /// The bytes of the file at `path`.
    ///
    /// # Errors
    /// When it can not be read, is no file, or is larger than the limit.
    pub fn read(self, path: &Path) -> Result<Vec<u8>, Unreadable> {
        let refuse = |problem: String, remedy: &str| Err(Unreadable { problem, remedy: remedy.into() });
        let system = |e: &io::Error| self.system(e);
        let info = std::fs::metadata(path).map_err(|e| system(&e))?;
        if info.is_dir() {
            return refuse("this is a folder".into(), &format!("name {} in it", self.what));
        }
        // A device or a pipe may have no end.
        if !info.is_file() && !self.from_pipe {
            return refuse("this is not a regular file".into(), &format!("name {}", self.what));
        }
        let mut bytes = Vec::new();
        let mut file = File::open(path).map_err(|e| system(&e))?.take(self.limit.saturating_add(1));
        if info.len() <= self.limit {
            file.read_to_end(&mut bytes).map_err(|e| system(&e))?;
        }
        if info.len().max(bytes.len() as u64) > self.limit {
            let megabytes = self.limit / 1_000_000;
            return refuse(
                format!("this is larger than the {megabytes} MB that {} may have", self.what),
                self.if_larger,
            );
        }
        Ok(bytes)
    }

    fn system(self, error: &io::Error) -> Unreadable {
        let remedy = match error.kind() {
            io::ErrorKind::NotFound => self.if_missing,
            io::ErrorKind::PermissionDenied => "check the permissions of the file and its folder",
            io::ErrorKind::NotADirectory => "check the path: a part of it is a file, not a folder",
            _ => "check the path, the file and the disk",
        };
        Unreadable { problem: format!("cannot be read: {error}"), remedy: remedy.into() }
    }
}
