//! Small files appear whole or not at all.

use crate::sink::SinkError;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

/// Writes `contents` to a neighbour of `path` and renames it: whoever looks sees the old file or the
/// new one, never a part.
///
/// # Errors
/// When the folder can not be written or the disk is full; an old file is then untouched.
pub fn write(path: &Path, contents: &[u8]) -> Result<(), SinkError> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    let part = path.with_file_name(name);
    let stored = File::create(&part)
        .and_then(|mut f| {
            f.write_all(contents)?;
            f.sync_all()
        })
        .and_then(|()| fs::rename(&part, path));
    stored.map_err(|e| {
        let _ = fs::remove_file(&part);
        SinkError::io(path, e)
    })
}
