//! Images in files, read row by row: they are never in memory as a whole.

use super::gzip::{self, Members};
use super::number::Number;
use super::{ImageGrid, Labelled, Problem, Survey, Volume, broken, nifti, nrrd};
use rsph_core::shape::{Placement, Run};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Component, Path};

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
/// Most labels of a segmentation: an image with more values is one of grey levels.
const MOST_LABELS: usize = 256;
/// How far a label may be from a whole number: images are resampled and scaled in single precision.
const NEARLY_WHOLE: f64 = 1e-3;
/// Bytes that are read at once.
const BUFFER: usize = 1 << 16;

/// Size of an image, the type of its voxels and where they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Number of voxels.
    pub size: [usize; 3],
    /// What a voxel is.
    pub number: Number,
    /// From what is stored to its meaning: `slope x + intercept`.
    pub scaling: (f64, f64),
    /// Where the image is.
    pub placement: Placement,
    /// From its units to metres.
    pub metres: f64,
    pub big_endian: bool,
}

/// Where the voxels of an NRRD file are.
pub struct Data {
    /// In a file beside it; `None`: in the file itself.
    pub file: Option<String>,
    /// Whether they are compressed by gzip.
    pub is_packed: bool,
}

/// Voxels that are about to be read.
struct Voxels {
    header: Header,
    /// From the first one on.
    stream: Box<dyn BufRead>,
    /// Bytes that are there, where that is known: where they are no archive.
    available: Option<u64>,
}

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

/// What the file holds.
pub fn survey(path: &Path) -> Result<Survey, Problem> {
    let mut labels: BTreeMap<i64, u64> = BTreeMap::new();
    let (mut range, mut are_labels, mut without) = ([f64::INFINITY, f64::NEG_INFINITY], true, 0);
    let header = each_row(path, &mut |_, _, values| {
        // Neighbours mostly have the same value.
        for equal in values.chunk_by(|a, b| a.to_bits() == b.to_bits()) {
            let (value, count) = (equal[0], equal.len() as u64);
            if !value.is_finite() {
                without += count;
                continue;
            }
            range = [range[0].min(value), range[1].max(value)];
            // As labels are read, to the nearest whole number.
            are_labels &= (value - value.round()).abs() < NEARLY_WHOLE && labels.len() <= MOST_LABELS;
            if are_labels {
                *labels.entry(value.round() as i64).or_default() += count;
            }
        }
        Ok(())
    })?;
    let grid = ImageGrid { size: header.size, placement: header.placement, metres: header.metres };
    Ok(Survey { grid, range, labels: are_labels.then_some(labels), without })
}

/// Hands the file to `visit` row by row.
fn each_row(path: &Path, visit: &mut Row<'_>) -> Result<Header, Problem> {
    let mut voxels = open_image(path)?;
    rows_of(&mut voxels, visit)?;
    if voxels.available.is_none() {
        // Whether the archive is whole is known at its end.
        io::copy(&mut voxels.stream.take(MAX_REST), &mut io::sink())
            .map_err(|e| broken(format!("is a damaged archive: {e}")))?;
    }
    Ok(voxels.header)
}

/// The header of the file.
pub fn read_header(path: &Path) -> Result<Header, Problem> {
    Ok(open_image(path)?.header)
}

/// The image in the file, by its first bytes.
fn open_image(path: &Path) -> Result<Voxels, Problem> {
    let (mut stream, length) = open(path)?;
    let start = stream.fill_buf().map_err(|e| broken(format!("{} at its start", cut_or_damaged(&e))))?;
    if start.starts_with(nrrd::START) {
        return open_nrrd(path, stream, length);
    }
    let (header, offset) = nifti_header(&mut stream)?;
    Ok(Voxels { header, stream, available: length.map(|length| length.saturating_sub(offset)) })
}

/// The file as a stream, and how many bytes it has where that is known: where it is no archive.
fn open(path: &Path) -> Result<(Box<dyn BufRead>, Option<u64>), Problem> {
    let unreadable = |e: &io::Error| {
        let remedy = match e.kind() {
            io::ErrorKind::NotFound => "check the path; a relative one in a scenario starts beside its file",
            _ => "check the file and its permissions",
        };
        Problem(format!("cannot be read: {e}"), remedy.into())
    };
    let info = std::fs::metadata(path).map_err(|e| unreadable(&e))?;
    if !info.is_file() {
        return Err(Problem("is not a regular file".into(), "give the path of a NIfTI or NRRD file".into()));
    }
    if info.len() == 0 {
        return Err(broken("is empty"));
    }
    let mut file = BufReader::with_capacity(BUFFER, File::open(path).map_err(|e| unreadable(&e))?);
    if file.fill_buf().map_err(|e| unreadable(&e))?.starts_with(&gzip::START) {
        Ok((unpacked(file), None))
    } else {
        Ok((Box::new(file), Some(info.len())))
    }
}

fn unpacked(stream: impl BufRead + 'static) -> Box<dyn BufRead> {
    Box::new(BufReader::with_capacity(BUFFER, Members::new(stream)))
}

/// The image of an NRRD file.
fn open_nrrd(path: &Path, mut stream: Box<dyn BufRead>, mut length: Option<u64>) -> Result<Voxels, Problem> {
    let mut text = Vec::new();
    loop {
        let before = text.len();
        let longest = (nrrd::LONGEST - before) as u64;
        (&mut stream)
            .take(longest)
            .read_until(b'\n', &mut text)
            .map_err(|e| broken(format!("{} within its header", cut_or_damaged(&e))))?;
        if text[before..].trim_ascii().is_empty() || text.len() >= nrrd::LONGEST {
            break;
        }
    }
    let (header, data) = nrrd::understand(&String::from_utf8_lossy(&text))?;
    length = length.map(|length| length.saturating_sub(text.len() as u64));
    if let Some(name) = &data.file {
        let file = Path::new(name);
        if file.components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir))
            || name.contains('%')
            || name.starts_with("LIST")
        {
            return Err(Problem(
                format!("has its voxels in \"{name}\", which is no single file beside it"),
                "save it as one file (.nrrd)".into(),
            ));
        }
        (stream, length) =
            open(&path.parent().unwrap_or(Path::new("")).join(file)).map_err(|Problem(what, remedy)| {
                Problem(format!("has its voxels in \"{name}\", which {what}"), remedy)
            })?;
    }
    // A file of voxels beside it is known as an archive by its first bytes.
    if data.is_packed && length.is_some() {
        (stream, length) = (unpacked(stream), None);
    }
    Ok(Voxels { header, stream, available: length })
}

/// Hands voxels to `visit` row by row.
fn rows_of(voxels: &mut Voxels, visit: &mut Row<'_>) -> Result<(), Problem> {
    let Voxels { header, stream, available } = voxels;
    let [nx, ny, nz] = header.size;
    // Sizes are below 1e5 each, so that this fits.
    let count = nx as u64 * ny as u64 * nz as u64;
    if count > MAX_VOXELS {
        return Err(Problem(
            format!("has {nx} x {ny} x {nz} voxels; {MAX_VOXELS} are allowed in all"),
            "cut the image to the organ, or make it coarser".into(),
        ));
    }
    let needed = count * header.number.bytes() as u64;
    if let Some(there) = available.filter(|there| *there < needed) {
        return Err(broken(format!(
            "ends too early: {nx} x {ny} x {nz} voxels need {needed} bytes, and {there} are there"
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
            visit(header, [j, k], &values)?;
        }
    }
    Ok(())
}

fn cut_or_damaged(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "ends".into(),
        _ => format!("can not be read ({error})"),
    }
}

/// Reads a NIfTI header and what lies between it and the voxels; returns where these begin, too.
fn nifti_header(stream: &mut dyn Read) -> Result<(Header, u64), Problem> {
    let short = |e: io::Error| broken(format!("{} within its header", cut_or_damaged(&e)));
    let mut start = [0; 4];
    stream.read_exact(&mut start).map_err(short)?;
    let (size, _) = nifti::kind(start).ok_or_else(|| broken("is no NIfTI or NRRD file"))?;
    let mut bytes = start.to_vec();
    bytes.resize(size, 0);
    stream.read_exact(&mut bytes[4..]).map_err(short)?;
    let (header, offset) = nifti::understand(&bytes)?;
    let between = offset.saturating_sub(size as u64);
    let skipped = io::copy(&mut stream.take(between), &mut io::sink()).map_err(short)?;
    if skipped < between {
        return Err(broken("ends before its first voxel"));
    }
    Ok((header, offset))
}
