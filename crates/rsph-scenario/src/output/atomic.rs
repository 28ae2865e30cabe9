//! Files that appear whole or not at all.

use crate::sink::SinkError;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A neighbour of `path` with `ending` behind its name.
pub(super) fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(ending);
    path.with_file_name(name)
}

/// Writes `contents` to `path`: whoever looks sees the old file or the new one, never a part.
///
/// # Errors
/// When the folder can not be written or the disk is full; an old file is then untouched.
pub fn write(path: &Path, contents: &[u8]) -> Result<(), SinkError> {
    replace(path, |part| {
        let stored = File::create(part).and_then(|mut f| f.write_all(contents));
        stored.map_err(|e| SinkError::io(path, e))
    })
}

/// Replaces `path` by what `fill` writes to a neighbour of it; the new file is on the disk before the old one
/// goes, and its name as well when this returns.
///
/// # Errors
/// When `fill` fails, the folder can not be written or the disk is full; an old file is then untouched.
pub(super) fn replace(
    path: &Path,
    fill: impl FnOnce(&Path) -> Result<(), SinkError>,
) -> Result<(), SinkError> {
    let part = beside(path, ".part");
    let stored = fill(&part).and_then(|()| {
        sync(&part)
            .and_then(|()| fs::rename(&part, path))
            .and_then(|()| sync_folder(path))
            .map_err(|e| SinkError::io(path, e))
    });
    if stored.is_err() {
        let _ = fs::remove_file(&part);
    }
    stored
}

/// Waits until the contents of `path` are on the disk.
///
/// # Errors
/// The system's.
pub(super) fn sync(path: &Path) -> io::Result<()> {
    File::open(path)?.sync_all()
}

/// Waits until the name of `path` is on the disk.
///
/// # Errors
/// The system's.
pub(super) fn sync_folder(path: &Path) -> io::Result<()> {
    // Only where a folder can be opened like a file.
    if cfg!(unix) {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        sync(folder)?;
    }
    Ok(())
}
