//! HDF5 files that may come from anywhere: what is checked before the library reads numbers from them.

mod heaps;

use hdf5::Dataset;
use hdf5::dataset::Layout;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The first bytes of an HDF5 file.
const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";

/// Refuses a file that is no HDF5 file, or whose tables of names in its first `limit` bytes would be too much for the
/// library.
///
/// # Errors
/// What it is instead.
pub fn check_file(path: &Path, limit: u64) -> Result<(), String> {
    let mut start = [0; 8];
    let is_file = std::fs::metadata(path).is_ok_and(|info| info.is_file());
    if !is_file {
        return Err("it is not a regular file".into());
    }
    let mut file = File::open(path).map_err(|e| e.to_string())?;
    if file.read_exact(&mut start).is_err() || start != SIGNATURE {
        return Err("it does not begin as an HDF5 file does".into());
    }
    heaps::trouble(&mut file, limit).map_err(|e| e.to_string())?.map_or(Ok(()), |what| Err(what.into()))
}

/// Refuses to read `count` values of a dataset, called `name`, that does not hold them itself: announced only, packed, or
/// kept in another file than the one called `file`.
///
/// # Errors
/// What is wrong with it.
pub fn check_dataset(dataset: &Dataset, name: &str, file: &str, count: u64) -> hdf5::Result<()> {
    let layout = dataset.create_plist()?;
    let elsewhere = dataset.filename() != file || !layout.external().is_empty();
    if elsewhere || layout.layout() == Layout::Virtual {
        return Err(format!("`{name}` lies in another file").into());
    }
    if !layout.filters().is_empty() {
        return Err(
            format!("`{name}` is compressed, which is not read here; h5repack -f NONE unpacks it").into()
        );
    }
    // Rows that were never written take no room in the file, however many are announced.
    let bytes = count.saturating_mul(dataset.dtype()?.size() as u64);
    if bytes > dataset.storage_size() {
        return Err(format!("`{name}` claims more values than the file holds").into());
    }
    Ok(())
}
