//! The writer: appends frames and flushes after each one.

use super::{CELL_GROUPS, POLYGONS, VERTICES, VtkHdfError};
use crate::output::polydata::Frame;
use hdf5::types::FixedAscii;
use hdf5::{Dataset, Extent, File, Group, H5Type, SimpleExtents};
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// An open VTKHDF file that takes frame after frame.
#[derive(Debug)]
pub struct VtkHdfWriter {
    path: PathBuf,
    /// `None` after a failure.
    open: Option<Open>,
    fields: Option<Vec<(String, usize)>>,
    steps: i64,
}

/// Parts of a file that are open. HDF5 crashes when it closes what it could not write, as on a full disk: so datasets stay
/// open until all is written, and after a failure nothing is closed any more.
#[derive(Debug)]
struct Open {
    file: File,
    root: Group,
    datasets: HashMap<String, Dataset>,
}

impl Open {
    /// The dataset at `path` below the root.
    fn dataset(&mut self, path: &str) -> hdf5::Result<&Dataset> {
        if !self.datasets.contains_key(path) {
            self.datasets.insert(path.to_owned(), self.root.dataset(path)?);
        }
        self.datasets.get(path).ok_or_else(|| "a dataset is lost".into())
    }
}

impl VtkHdfWriter {
    /// A new, empty file; an existing one is replaced.
    ///
    /// # Errors
    /// When the file can not be created.
    pub fn create(path: &Path) -> Result<Self, VtkHdfError> {
        let open = || -> hdf5::Result<(File, Group)> {
            let file = File::create(path)?;
            let root = file.create_group("VTKHDF")?;
            root.new_attr::<i64>().shape(2).create("Version")?.write(&[2_i64, 0])?;
            let kind = FixedAscii::<8>::from_ascii("PolyData").map_err(|e| e.to_string())?;
            root.new_attr::<FixedAscii<8>>().create("Type")?.write_scalar(&kind)?;
            Ok((file, root))
        };
        let (file, root) = open().map_err(|e| write_error(path, &e))?;
        let mut writer = Self { path: path.into(), open: None, fields: None, steps: 0 };
        writer.open = Some(Open { file, root, datasets: HashMap::new() });
        writer.attempt(layout)?;
        Ok(writer)
    }

    /// Opens a file to append to it.
    ///
    /// # Errors
    /// When it can not be opened or is no file of this writer.
    pub fn open(path: &Path) -> Result<Self, VtkHdfError> {
        let open = || -> hdf5::Result<Self> {
            let file = File::open_rw(path)?;
            let root = file.group("VTKHDF")?;
            let steps: i64 = root.group("Steps")?.attr("NSteps")?.read_scalar()?;
            let data = root.group("PointData")?;
            let mut fields = Vec::new();
            for name in data.member_names()? {
                let components = data.dataset(&name)?.shape().get(1).copied().unwrap_or(1);
                fields.push((name, components));
            }
            fields.sort();
            let open = Open { file, root, datasets: HashMap::new() };
            Ok(Self { path: path.into(), open: Some(open), fields: (steps > 0).then_some(fields), steps })
        };
        open().map_err(|e| write_error(path, &e))
    }

    /// Appends a frame and flushes, so that the file is readable up to here whatever comes next.
    ///
    /// # Errors
    /// When the frame is inconsistent, has other fields than the first one, or can not be stored.
    pub fn append(&mut self, frame: &dyn Frame) -> Result<(), VtkHdfError> {
        frame.check().map_err(|what| self.refuse(what))?;
        let mut fields: Vec<_> =
            frame.fields().into_iter().map(|(name, components)| (name.to_owned(), components)).collect();
        fields.sort();
        match &self.fields {
            Some(first) if *first != fields => {
                return Err(self.refuse(format!("fields changed from {first:?} to {fields:?}")));
            }
            Some(_) => {}
            None => {
                self.attempt(|open| create_fields(open, frame))?;
                self.fields = Some(fields);
            }
        }
        let steps = self.steps;
        self.attempt(|open| write(open, frame, steps))?;
        self.steps += 1;
        Ok(())
    }

    /// Appends what the file at `path`, of the same writer, has more than this one.
    ///
    /// # Errors
    /// When it can not be read, has other fields, or its frames can not be stored.
    pub fn catch_up(&mut self, path: &Path) -> Result<(), VtkHdfError> {
        let mut steps = self.steps;
        self.attempt(|open| {
            let more = File::open(path)?.group("VTKHDF")?;
            steps = more.group("Steps")?.attr("NSteps")?.read_scalar()?;
            let mut names = ["Points", "NumberOfPoints"].map(str::to_owned).to_vec();
            for group in CELL_GROUPS.iter().copied().chain(["PointData", "Steps/PointDataOffsets"]) {
                names.extend(more.group(group)?.member_names()?.iter().map(|name| format!("{group}/{name}")));
            }
            let of_steps = more.group("Steps")?;
            for name in of_steps.member_names()?.iter().filter(|n| of_steps.dataset(n).is_ok()) {
                names.push(format!("Steps/{name}"));
            }
            for name in names {
                copy_rows(&more.dataset(&name)?, open.dataset(&name)?)?;
            }
            open.root.group("Steps")?.attr("NSteps")?.write_scalar(&steps)?;
            open.file.flush()
        })?;
        self.steps = steps;
        Ok(())
    }

    /// Changes the file; after a failure nothing of it is touched any more.
    fn attempt(&mut self, change: impl FnOnce(&mut Open) -> hdf5::Result<()>) -> Result<(), VtkHdfError> {
        let Some(open) = &mut self.open else {
            return Err(write_error(&self.path, &"an earlier attempt has failed".into()));
        };
        let changed = change(open);
        if changed.is_err() {
            std::mem::forget(self.open.take());
        }
        changed.map_err(|e| write_error(&self.path, &e))
    }

    fn refuse(&self, problem: String) -> VtkHdfError {
        VtkHdfError::new(&self.path, problem, "this is a mistake of the program that writes the file")
    }
}

/// Creates every dataset but the fields, empty.
fn layout(open: &mut Open) -> hdf5::Result<()> {
    let root = &open.root;
    dataset::<f64>(root, "Points", Some(3), POINT_CHUNK)?;
    dataset::<i64>(root, "NumberOfPoints", None, STEP_CHUNK)?;
    for name in CELL_GROUPS {
        let group = root.create_group(name)?;
        for counter in ["NumberOfCells", "NumberOfConnectivityIds"] {
            dataset::<i64>(&group, counter, None, STEP_CHUNK)?;
        }
        for ids in ["Offsets", "Connectivity"] {
            dataset::<i64>(&group, ids, None, POINT_CHUNK)?;
        }
    }
    root.create_group("PointData")?;
    let steps = root.create_group("Steps")?;
    steps.new_attr::<i64>().create("NSteps")?.write_scalar(&0_i64)?;
    dataset::<f64>(&steps, "Values", None, STEP_CHUNK)?;
    for name in ["PartOffsets", "NumberOfParts", "PointOffsets"] {
        dataset::<i64>(&steps, name, None, STEP_CHUNK)?;
    }
    for name in ["CellOffsets", "ConnectivityIdOffsets"] {
        dataset::<i64>(&steps, name, Some(4), STEP_CHUNK)?;
    }
    steps.create_group("PointDataOffsets")?;
    open.file.flush()
}

fn create_fields(open: &mut Open, frame: &dyn Frame) -> hdf5::Result<()> {
    let (data, offsets) = (open.root.group("PointData")?, open.root.group("Steps/PointDataOffsets")?);
    for (name, components) in frame.fields() {
        let columns = (components > 1).then_some(components);
        dataset::<f64>(&data, name, columns, POINT_CHUNK)?;
        dataset::<i64>(&offsets, name, None, STEP_CHUNK)?;
    }
    Ok(())
}

/// Appends frame number `step`. The data come first and the number of steps last: a reader never sees half a frame.
fn write(open: &mut Open, frame: &dyn Frame, step: i64) -> hdf5::Result<()> {
    let n = frame.point_count();
    let start = append_pieces(open.dataset("Points")?, n, |here, out| frame.put_points(here, out))?;
    append(open.dataset("NumberOfPoints")?, &[n as i64])?;
    append(open.dataset("Steps/PointOffsets")?, &[start])?;
    for (i, (name, _)) in frame.fields().into_iter().enumerate() {
        let dataset = open.dataset(&format!("PointData/{name}"))?;
        let start = append_pieces(dataset, n, |here, out| frame.put_values(i, here, out))?;
        append(open.dataset(&format!("Steps/PointDataOffsets/{name}"))?, &[start])?;
    }

    let (mut cells, mut ids) = ([0_i64; 4], [0_i64; 4]);
    for (i, name) in CELL_GROUPS.iter().enumerate() {
        // Cells of that kind and corners of each.
        let (count, corners) = match frame.triangles() {
            None if i == VERTICES => (n, 1),
            Some(t) if i == POLYGONS => (t.len(), 3),
            _ => (0, 1),
        };
        let mut of = |quantity: &str, rows: usize, put: &mut dyn FnMut(Range<usize>, &mut Vec<i64>)| {
            append_pieces(open.dataset(&format!("{name}/{quantity}"))?, rows, put)
        };
        // A list of c cells has c + 1 offsets, and readers add one entry a part themselves.
        let offset = |here: Range<usize>, out: &mut Vec<i64>| out.extend(here.map(|k| (corners * k) as i64));
        cells[i] = of("Offsets", count + 1, &mut { offset })? - step;
        ids[i] = of("Connectivity", corners * count, &mut |here, out| match frame.triangles() {
            None => out.extend(here.map(|k| k as i64)),
            Some(t) => out.extend(t.as_flattened()[here].iter().map(|&p| i64::from(p))),
        })?;
        of("NumberOfCells", 1, &mut |_, out| out.push(count as i64))?;
        of("NumberOfConnectivityIds", 1, &mut |_, out| out.push((corners * count) as i64))?;
    }
    append(open.dataset("Steps/CellOffsets")?, &cells)?;
    append(open.dataset("Steps/ConnectivityIdOffsets")?, &ids)?;

    append(open.dataset("Steps/PartOffsets")?, &[step])?;
    append(open.dataset("Steps/NumberOfParts")?, &[1_i64])?;
    append(open.dataset("Steps/Values")?, &[frame.time()])?;
    open.file.flush()?;
    open.root.group("Steps")?.attr("NSteps")?.write_scalar(&(step + 1))?;
    open.file.flush()
}

/// Rows a chunk of the arrays over points and cells, and of those over steps.
const POINT_CHUNK: usize = 2048;
const STEP_CHUNK: usize = 128;

/// A new, empty list or table that can grow.
fn dataset<T: H5Type>(
    group: &Group,
    name: &str,
    columns: Option<usize>,
    chunk: usize,
) -> hdf5::Result<Dataset> {
    let builder = group.new_dataset::<T>();
    match columns {
        None => builder.chunk(chunk).shape(SimpleExtents::resizable([0])).create(name),
        Some(c) => builder
            .chunk((chunk, c))
            .shape(SimpleExtents::new([Extent::resizable(0), Extent::fixed(c)]))
            .create(name),
    }
}

/// Appends one value to a list or one row to a table; returns where it stands.
fn append<T: H5Type + Copy>(dataset: &Dataset, row: &[T]) -> hdf5::Result<i64> {
    append_pieces(dataset, 1, |_, out| out.extend_from_slice(row))
}

/// Appends `rows` rows to a list or table, of which `put` gives those of a range at a time; returns where the new
/// part begins.
fn append_pieces<T: H5Type>(
    dataset: &Dataset,
    rows: usize,
    mut put: impl FnMut(Range<usize>, &mut Vec<T>),
) -> hdf5::Result<i64> {
    let shape = dataset.shape();
    let (start, columns) = (shape.first().copied().unwrap_or(0), shape.get(1).copied());
    let (mut done, mut piece) = (0, Vec::new());
    if rows > 0 {
        match columns {
            None => dataset.resize(start + rows)?,
            Some(columns) => dataset.resize((start + rows, columns))?,
        }
    }
    while done < rows {
        let next = rows.min(done + ROWS_AT_ONCE);
        piece.clear();
        put(done..next, &mut piece);
        let here = start + done..start + next;
        match columns {
            None => dataset.write_slice(&piece, here)?,
            Some(2) => write_rows::<T, 2>(dataset, &piece, here)?,
            Some(3) => write_rows::<T, 3>(dataset, &piece, here)?,
            Some(4) => write_rows::<T, 4>(dataset, &piece, here)?,
            Some(6) => write_rows::<T, 6>(dataset, &piece, here)?,
            Some(9) => write_rows::<T, 9>(dataset, &piece, here)?,
            Some(c) => return Err(format!("rows of {c} values; 1, 2, 3, 6 or 9 can be stored").into()),
        }
        done = next;
    }
    Ok(start as i64)
}

fn write_rows<T: H5Type, const C: usize>(
    dataset: &Dataset,
    values: &[T],
    rows: Range<usize>,
) -> hdf5::Result<()> {
    dataset.write_slice::<_, T, _, _>(values.as_chunks::<C>().0, (rows, ..))
}

/// Rows that are written or copied at once.
const ROWS_AT_ONCE: usize = 32 * POINT_CHUNK;

/// Appends the rows of a list or table that `to` has not.
fn copy_rows(from: &Dataset, to: &Dataset) -> hdf5::Result<()> {
    let rows = |dataset: &Dataset| dataset.shape().first().copied().unwrap_or(0);
    let (mut start, end) = (rows(to), rows(from));
    let real = from.dtype()?.is::<f64>();
    while start < end {
        let next = end.min(start + ROWS_AT_ONCE);
        if real {
            copy_part::<f64>(from, to, start..next)?;
        } else {
            copy_part::<i64>(from, to, start..next)?;
        }
        start = next;
    }
    Ok(())
}

fn copy_part<T: H5Type>(from: &Dataset, to: &Dataset, rows: Range<usize>) -> hdf5::Result<()> {
    if from.ndim() == 1 {
        let part = from.read_slice_1d::<T, _>(rows.clone())?;
        to.resize(rows.end)?;
        return to.write_slice(&part, rows);
    }
    let part = from.read_slice_2d::<T, _>((rows.clone(), ..))?;
    to.resize((rows.end, part.ncols()))?;
    to.write_slice(&part, (rows, ..))
}

fn write_error(path: &Path, e: &hdf5::Error) -> VtkHdfError {
    VtkHdfError::new(
        path,
        format!("cannot be written: {}", reason(e)),
        "check that the folder exists and is writable, that the disk has room, and that no other program \
         holds the file open",
    )
}

/// What the system said, out of the long story that HDF5 makes of it.
pub fn reason(e: &hdf5::Error) -> String {
    let story = e.to_string();
    let said = story.split_once("error message = '").and_then(|(_, rest)| rest.split_once('\''));
    said.map_or_else(|| story.clone(), |(said, _)| said.to_owned())
}
