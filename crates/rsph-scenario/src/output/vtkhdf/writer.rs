//! The writer: appends frames and flushes after each one.

use super::{CELL_GROUPS, POLYGONS, VERTICES, VtkHdfError};
use crate::output::polydata::{Cells, PointField, PolyData};
use hdf5::types::FixedAscii;
use hdf5::{Dataset, Extent, File, Group, H5Type, SimpleExtents};
use std::path::{Path, PathBuf};

/// An open VTKHDF file that takes frame after frame.
#[derive(Debug)]
pub struct VtkHdfWriter {
    path: PathBuf,
    file: File,
    root: Group,
    fields: Option<Vec<(String, usize)>>,
    steps: i64,
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
        let writer = Self { path: path.into(), file, root, fields: None, steps: 0 };
        writer.layout().map_err(|e| write_error(path, &e))?;
        Ok(writer)
    }

    /// Appends a frame and flushes, so that the file is readable up to here whatever comes next.
    ///
    /// # Errors
    /// When the frame is inconsistent, has other fields than the first one, or can not be stored.
    pub fn append(&mut self, frame: &PolyData) -> Result<(), VtkHdfError> {
        frame.check().map_err(|what| self.refuse(what))?;
        let fields: Vec<_> = frame.fields.iter().map(|f| (f.name.clone(), f.components)).collect();
        match &self.fields {
            Some(first) if *first != fields => {
                return Err(self.refuse(format!("fields changed from {first:?} to {fields:?}")));
            }
            Some(_) => {}
            None => {
                self.create_fields(&frame.fields).map_err(|e| write_error(&self.path, &e))?;
                self.fields = Some(fields);
            }
        }
        self.write(frame).map_err(|e| write_error(&self.path, &e))
    }

    fn refuse(&self, problem: String) -> VtkHdfError {
        VtkHdfError::new(&self.path, problem, "this is a mistake of the program that writes the file")
    }

    /// Creates every dataset but the fields, empty.
    fn layout(&self) -> hdf5::Result<()> {
        dataset::<f64>(&self.root, "Points", Some(3), POINT_CHUNK)?;
        dataset::<i64>(&self.root, "NumberOfPoints", None, STEP_CHUNK)?;
        for name in CELL_GROUPS {
            let group = self.root.create_group(name)?;
            for counter in ["NumberOfCells", "NumberOfConnectivityIds"] {
                dataset::<i64>(&group, counter, None, STEP_CHUNK)?;
            }
            for ids in ["Offsets", "Connectivity"] {
                dataset::<i64>(&group, ids, None, POINT_CHUNK)?;
            }
        }
        self.root.create_group("PointData")?;
        let steps = self.root.create_group("Steps")?;
        steps.new_attr::<i64>().create("NSteps")?.write_scalar(&0_i64)?;
        dataset::<f64>(&steps, "Values", None, STEP_CHUNK)?;
        for name in ["PartOffsets", "NumberOfParts", "PointOffsets"] {
            dataset::<i64>(&steps, name, None, STEP_CHUNK)?;
        }
        for name in ["CellOffsets", "ConnectivityIdOffsets"] {
            dataset::<i64>(&steps, name, Some(4), STEP_CHUNK)?;
        }
        steps.create_group("PointDataOffsets")?;
        self.file.flush()
    }

    fn create_fields(&self, fields: &[PointField]) -> hdf5::Result<()> {
        let (data, offsets) = (self.root.group("PointData")?, self.root.group("Steps/PointDataOffsets")?);
        for f in fields {
            let columns = (f.components > 1).then_some(f.components);
            dataset::<f64>(&data, &f.name, columns, POINT_CHUNK)?;
            dataset::<i64>(&offsets, &f.name, None, STEP_CHUNK)?;
        }
        Ok(())
    }

    /// The data come first and the number of steps last: a reader never sees half a frame.
    fn write(&mut self, frame: &PolyData) -> hdf5::Result<()> {
        let n = frame.points.len() as i64;
        let steps = self.root.group("Steps")?;
        let start = append_rows(&self.root.dataset("Points")?, &frame.points)?;
        append(&self.root.dataset("NumberOfPoints")?, &[n])?;
        append(&steps.dataset("PointOffsets")?, &[start])?;
        for f in &frame.fields {
            let start = append_field(&self.root.dataset(&format!("PointData/{}", f.name))?, f)?;
            append(&steps.dataset(&format!("PointDataOffsets/{}", f.name))?, &[start])?;
        }

        let (mut cells, mut ids) = ([0_i64; 4], [0_i64; 4]);
        for (i, name) in CELL_GROUPS.iter().enumerate() {
            let group = self.root.group(name)?;
            let (offsets, connectivity): (Vec<i64>, Vec<i64>) = match &frame.cells {
                Cells::Vertices if i == VERTICES => ((0..=n).collect(), (0..n).collect()),
                Cells::Triangles(t) if i == POLYGONS => (
                    (0..=t.len() as i64).map(|k| 3 * k).collect(),
                    t.iter().flatten().map(|&p| i64::from(p)).collect(),
                ),
                _ => (vec![0], Vec::new()),
            };
            // A list of c cells has c + 1 offsets, and readers add one entry a part themselves.
            cells[i] = append(&group.dataset("Offsets")?, &offsets)? - self.steps;
            ids[i] = append(&group.dataset("Connectivity")?, &connectivity)?;
            append(&group.dataset("NumberOfCells")?, &[offsets.len() as i64 - 1])?;
            append(&group.dataset("NumberOfConnectivityIds")?, &[connectivity.len() as i64])?;
        }
        append_rows(&steps.dataset("CellOffsets")?, &[cells])?;
        append_rows(&steps.dataset("ConnectivityIdOffsets")?, &[ids])?;

        append(&steps.dataset("PartOffsets")?, &[self.steps])?;
        append(&steps.dataset("NumberOfParts")?, &[1_i64])?;
        append(&steps.dataset("Values")?, &[frame.time])?;
        self.file.flush()?;
        self.steps += 1;
        steps.attr("NSteps")?.write_scalar(&self.steps)?;
        self.file.flush()
    }
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

/// Appends to a list; returns where the new part begins.
fn append<T: H5Type>(dataset: &Dataset, values: &[T]) -> hdf5::Result<i64> {
    let start = dataset.size();
    if !values.is_empty() {
        dataset.resize(start + values.len())?;
        dataset.write_slice(values, start..start + values.len())?;
    }
    Ok(start as i64)
}

/// Appends rows to a table; returns where the new part begins.
fn append_rows<T: H5Type, const C: usize>(dataset: &Dataset, rows: &[[T; C]]) -> hdf5::Result<i64> {
    let start = dataset.shape().first().copied().unwrap_or(0);
    if !rows.is_empty() {
        dataset.resize((start + rows.len(), C))?;
        dataset.write_slice::<_, T, _, _>(rows, (start..start + rows.len(), ..))?;
    }
    Ok(start as i64)
}

fn append_field(dataset: &Dataset, field: &PointField) -> hdf5::Result<i64> {
    match field.components {
        1 => append(dataset, &field.values),
        2 => append_rows(dataset, field.values.as_chunks::<2>().0),
        3 => append_rows(dataset, field.values.as_chunks::<3>().0),
        6 => append_rows(dataset, field.values.as_chunks::<6>().0),
        9 => append_rows(dataset, field.values.as_chunks::<9>().0),
        c => Err(format!("field `{}` has {c} components; 1, 2, 3, 6 or 9 can be stored", field.name).into()),
    }
}

fn write_error(path: &Path, e: &hdf5::Error) -> VtkHdfError {
    VtkHdfError::new(
        path,
        format!("cannot be written: {e}"),
        "check that the folder exists and is writable, that the disk has room, and that no other program \
         holds the file open",
    )
}
