//! NIfTI files, plain or compressed, read row by row: an image is never in memory as a whole.

use super::header::{Header, kind, understand};
use super::{ImageGrid, Labelled, Problem, Volume, broken};
use flate2::read::MultiGzDecoder;
use rsph_core::shape::Run;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Most voxels of an image; a CT scan of a whole body has a quarter of them.
const MAX_VOXELS: u64 = 2_000_000_000;
/// Most voxels of a map of values, of 4 bytes each.
const MAX_VALUES: usize = 500_000_000;
/// Most runs of a label, of 32 bytes each; a liver in voxels of half a millimetre has 200,000.
const MAX_RUNS: usize = 10_000_000;
/// Most bytes after the voxels of an archive that are looked at.
const MAX_REST: u64 = 100_000_000;
/// Labels that a message lists.
const LISTED: usize = 20;
/// The first bytes of a file compressed by gzip.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// What to do with a row of voxels: of the header, (j, k), and their values.
type Row<'a> = dyn FnMut(&Header, [usize; 2], &[f64]) -> Result<(), Problem> + 'a;

/// The voxels of `label` in the file.
pub fn read(path: &Path, label: u32) -> Result<Labelled, Problem> {
    let mut runs: Vec<Run> = Vec::new();
    let mut seen = BTreeSet::new();
    let header = each_row(path, &mut |_, [j, k], values| {
        let mut inside: Option<Run> = None;
        for (i, value) in values.iter().enumerate() {
            if (value - f64::from(label)).abs() < 0.5 {
                inside.get_or_insert(Run { start: [i, j, k], length: 0 }).length += 1;
                continue;
            }
            runs.extend(inside.take());
            if seen.len() < LISTED && value.is_finite() && *value != 0.0 {
                seen.insert(value.round() as i64);
            }
        }
        runs.extend(inside);
        if runs.len() > MAX_RUNS {
            return Err(Problem(
                format!("has more than {MAX_RUNS} pieces of rows with the label {label}: this is noise"),
                "smooth the segmentation, or save it with whole numbers".into(),
            ));
        }
        Ok(())
    })?;
    if runs.is_empty() {
        let list: Vec<String> = seen.iter().map(ToString::to_string).collect();
        let remedy = match (list.is_empty(), seen.len() < LISTED) {
            (true, _) => "the image is empty".into(),
            (false, true) => format!("it has the labels {}", list.join(", ")),
            (false, false) => format!("it has the labels {}, ...", list.join(", ")),
        };
        return Err(Problem(format!("no voxel has the label {label}"), remedy));
    }
    Ok(Labelled { runs, size: header.size, placement: header.placement, metres: header.metres })
}

/// All values of the file.
pub fn values(path: &Path) -> Result<Volume, Problem> {
    let mut values = Vec::new();
    let header = each_row(path, &mut |header, _, row| {
        let count: usize = header.size.iter().product();
        if count > MAX_VALUES {
            return Err(Problem(
                format!("has {count} voxels; {MAX_VALUES} are allowed for a map of values"),
                "cut the image to the organ, or make it coarser".into(),
            ));
        }
        values.extend(row.iter().map(|value| *value as f32));
        Ok(())
    })?;
    let grid = ImageGrid { size: header.size, placement: header.placement, metres: header.metres };
    Ok(Volume { values, grid })
}

/// Hands the file to `visit` row by row.
fn each_row(path: &Path, visit: &mut Row<'_>) -> Result<Header, Problem> {
    let (mut stream, length) = open(path)?;
    let header = rows_of(&mut stream, length, visit)?;
    if length.is_none() {
        // Whether the archive is whole is known at its end.
        io::copy(&mut stream.take(MAX_REST), &mut io::sink())
            .map_err(|e| broken(format!("is a damaged archive: {e}")))?;
    }
    Ok(header)
}

/// The header of the file.
pub fn read_header(path: &Path) -> Result<Header, Problem> {
    header(&mut open(path)?.0)
}

/// The file as a stream, and how many bytes it has where that is known: where it is no archive.
fn open(path: &Path) -> Result<(Box<dyn Read>, Option<u64>), Problem> {
    let unreadable = |e: &io::Error| {
        let remedy = match e.kind() {
            io::ErrorKind::NotFound => "check the path; a relative one in a scenario starts beside its file",
            _ => "check the file and its permissions",
        };
        Problem(format!("cannot be read: {e}"), remedy.into())
    };
    let info = std::fs::metadata(path).map_err(|e| unreadable(&e))?;
    if !info.is_file() {
        return Err(Problem("is not a regular file".into(), "give the path of a NIfTI file".into()));
    }
    if info.len() == 0 {
        return Err(broken("is empty"));
    }
    let mut file = File::open(path).map_err(|e| unreadable(&e))?;
    let mut start = Vec::new();
    (&mut file).take(2).read_to_end(&mut start).map_err(|e| unreadable(&e))?;
    file.seek(SeekFrom::Start(0)).map_err(|e| unreadable(&e))?;
    let file = BufReader::with_capacity(1 << 16, file);
    if start == GZIP {
        Ok((Box::new(BufReader::with_capacity(1 << 16, MultiGzDecoder::new(file))), None))
    } else {
        Ok((Box::new(file), Some(info.len())))
    }
}

/// Hands a stream of `length` bytes, if that is known, to `visit` row by row.
fn rows_of(stream: &mut dyn Read, length: Option<u64>, visit: &mut Row<'_>) -> Result<Header, Problem> {
    let header = header(stream)?;
    let [nx, ny, nz] = header.size;
    // Sizes are below 1e5 each, so that this fits.
    let count = nx as u64 * ny as u64 * nz as u64;
    if count > MAX_VOXELS {
        return Err(Problem(
            format!("has {nx} x {ny} x {nz} voxels; {MAX_VOXELS} are allowed in all"),
            "cut the image to the organ, or make it coarser".into(),
        ));
    }
    let needed = header.offset + count * header.number.bytes() as u64;
    if let Some(length) = length.filter(|length| *length < needed) {
        return Err(broken(format!(
            "ends too early: an image of {nx} x {ny} x {nz} voxels needs {needed} bytes, the file has {length}"
        )));
    }
    let mut row = vec![0; nx * header.number.bytes()];
    let mut values = vec![0.0; nx];
    let (slope, intercept) = header.scaling;
    for k in 0..nz {
        for j in 0..ny {
            stream.read_exact(&mut row).map_err(|e| {
                broken(format!("{} in slice {k} of {nz}, where voxels should be", cut_or_damaged(&e)))
            })?;
            for (value, bytes) in values.iter_mut().zip(row.chunks_exact(header.number.bytes())) {
                *value = slope * header.number.read(bytes, header.big_endian) + intercept;
            }
            visit(&header, [j, k], &values)?;
        }
    }
    Ok(header)
}

fn cut_or_damaged(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "ends".into(),
        _ => format!("can not be read ({error})"),
    }
}

/// Reads the header and what lies between it and the voxels.
fn header(stream: &mut dyn Read) -> Result<Header, Problem> {
    let short = |e: io::Error| broken(format!("{} within its header", cut_or_damaged(&e)));
    let mut start = [0; 4];
    stream.read_exact(&mut start).map_err(short)?;
    let (size, _) = kind(start).ok_or_else(|| broken("is no NIfTI file"))?;
    let mut bytes = start.to_vec();
    bytes.resize(size, 0);
    stream.read_exact(&mut bytes[4..]).map_err(short)?;
    let header = understand(&bytes)?;
    let between = header.offset.saturating_sub(size as u64);
    let skipped = io::copy(&mut stream.take(between), &mut io::sink()).map_err(short)?;
    if skipped < between {
        return Err(broken("ends before its first voxel"));
    }
    Ok(header)
}
