//! The reader: what a file holds, and one frame of it. Every number in the file is checked before
//! it is used to size or index anything.

use super::{CELL_GROUPS, POLYGONS, VERTICES, VtkHdfError};
use crate::output::foreign;
use crate::output::polydata::{Cells, Frame, PointField, PolyData};
use hdf5::{Dataset, File, Group, H5Type};
use std::ops::Range;
use std::path::Path;

/// A field of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldInfo {
    /// Name.
    pub name: String,
    /// Values a point.
    pub components: usize,
}

/// Times, sizes and fields of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct FileInfo {
    /// Time of each step.
    pub times: Vec<f64>,
    /// Number of points of each step.
    pub points: Vec<usize>,
    /// Number of vertex cells of each step.
    pub vertices: Vec<usize>,
    /// Number of polygons of each step.
    pub polygons: Vec<usize>,
    /// Fields on the points, by name.
    pub fields: Vec<FieldInfo>,
    /// Size of the file in bytes.
    pub bytes: u64,
}

impl FileInfo {
    /// Number of steps.
    pub fn steps(&self) -> usize {
        self.times.len()
    }
}

/// Says what the file at `path` holds.
///
/// # Errors
/// When it can not be opened or is not a temporal VTKHDF `PolyData`.
pub fn describe(path: &Path) -> Result<FileInfo, VtkHdfError> {
    Reader::open(path).and_then(|r| r.describe()).map_err(|e| e.at(path))
}

/// Reads one step of the file at `path`, the last one if `step` is `None`.
///
/// # Errors
/// When it can not be opened, is not a temporal VTKHDF `PolyData` or has no such step.
pub fn read_step(path: &Path, step: Option<usize>) -> Result<PolyData, VtkHdfError> {
    Reader::open(path).and_then(|r| r.read(step)).map_err(|e| e.at(path))
}

/// Hands the first `count` steps of the file at `path` to `visit`, in order; returns how many it holds.
///
/// # Errors
/// When it can not be opened, is not a temporal VTKHDF `PolyData`, holds fewer steps, or `visit` fails.
pub fn visit_steps(
    path: &Path,
    count: usize,
    visit: &mut dyn FnMut(PolyData) -> Result<(), VtkHdfError>,
) -> Result<usize, VtkHdfError> {
    let reader = Reader::open(path).map_err(|e| e.at(path))?;
    if reader.count < count {
        let problem = format!("it holds {} steps, {count} are asked for", reader.count);
        return Err(damaged(problem).at(path));
    }
    for step in 0..count {
        visit(reader.read(Some(step)).map_err(|e| e.at(path))?)?;
    }
    Ok(reader.count)
}

/// Reads one field of one step of the file at `path`.
///
/// # Errors
/// As [`read_step`], and when there is no such field.
pub fn read_field(path: &Path, step: usize, name: &str) -> Result<PointField, VtkHdfError> {
    Reader::open(path).and_then(|r| r.read_field(step, name)).map_err(|e| e.at(path))
}

/// A problem and its remedy, not yet tied to a path.
struct Problem(String, String);

impl Problem {
    fn at(self, path: &Path) -> VtkHdfError {
        VtkHdfError::new(path, self.0, self.1)
    }
}

impl From<hdf5::Error> for Problem {
    fn from(e: hdf5::Error) -> Self {
        damaged(e.to_string())
    }
}

fn damaged(what: impl Into<String>) -> Problem {
    Problem(
        format!("not a readable VTKHDF file: {}", what.into()),
        "give a particles.vtkhdf or surface.vtkhdf of a run; if it is one, it is damaged: run again".into(),
    )
}

/// Where the tables of names are in a file of results: they are made before the first frame.
const TABLES: u64 = 1_000_000;

struct Reader {
    root: Group,
    steps: Group,
    count: usize,
    bytes: u64,
}

impl Reader {
    fn open(path: &Path) -> Result<Self, Problem> {
        let info = std::fs::metadata(path).map_err(|e| {
            Problem(format!("cannot be opened: {e}"), "check the path and its permissions".into())
        })?;
        let bytes = info.len();
        foreign::check_file(path, TABLES).map_err(damaged)?;
        let file = File::open(path)?;
        let root = file.group("VTKHDF").map_err(|_| damaged("it has no group `VTKHDF`"))?;
        let steps = root
            .group("Steps")
            .map_err(|_| damaged("it has no group `VTKHDF/Steps`; only files with a time axis are read"))?;
        let count: i64 = steps.attr("NSteps")?.read_scalar()?;
        let stored = steps.dataset("Values")?.size();
        let count = usize::try_from(count)
            .ok()
            .filter(|c| *c <= stored)
            .ok_or_else(|| damaged(format!("`NSteps` is {count}, but {stored} time values are stored")))?;
        let reader = Self { root, steps, count, bytes };
        if reader.list::<i64>(&reader.steps, "NumberOfParts", 0..count)?.iter().any(|p| *p != 1) {
            return Err(damaged("a step has several parts; only one part a step is read"));
        }
        Ok(reader)
    }

    fn describe(&self) -> Result<FileInfo, Problem> {
        let cells = |name: &str| -> Result<Vec<usize>, Problem> {
            (0..self.count)
                .map(|s| self.number(&self.root.group(name)?, "NumberOfCells", self.part(s)?))
                .collect()
        };
        let mut fields = Vec::new();
        for name in self.root.group("PointData")?.member_names()? {
            let shape = self.root.dataset(&format!("PointData/{name}"))?.shape();
            fields.push(FieldInfo { name, components: shape.get(1).copied().unwrap_or(1) });
        }
        Ok(FileInfo {
            times: self.list(&self.steps, "Values", 0..self.count)?,
            points: (0..self.count)
                .map(|s| self.number(&self.root, "NumberOfPoints", self.part(s)?))
                .collect::<Result<_, _>>()?,
            vertices: cells(CELL_GROUPS[VERTICES])?,
            polygons: cells(CELL_GROUPS[POLYGONS])?,
            fields,
            bytes: self.bytes,
        })
    }

    fn read(&self, step: Option<usize>) -> Result<PolyData, Problem> {
        if self.count == 0 {
            return Err(Problem(
                "holds no step".into(),
                "the run stopped before its first frame: see its summary.json and run again".into(),
            ));
        }
        let step = step.unwrap_or(self.count - 1);
        self.check_step(step)?;
        let part = self.part(step)?;
        let n = self.number(&self.root, "NumberOfPoints", part)?;
        let start = self.number(&self.steps, "PointOffsets", step)?;
        let points = self.table(&self.root, "Points", span(start, n)?)?;
        let (points, rest) = points.1.as_chunks::<3>();
        if !rest.is_empty() || points.len() != n {
            return Err(damaged("`Points` does not have three columns"));
        }

        let mut fields = Vec::new();
        for name in self.root.group("PointData")?.member_names()? {
            fields.push(self.field(name, step, start, n)?);
        }

        let frame = PolyData {
            time: self.list(&self.steps, "Values", step..step + 1)?[0],
            points: points.to_vec(),
            cells: self.cells(step, part, n)?,
            fields,
        };
        frame.check().map_err(damaged)?;
        Ok(frame)
    }

    fn check_step(&self, step: usize) -> Result<(), Problem> {
        if step < self.count {
            return Ok(());
        }
        Err(Problem(
            format!("has no step {step}"),
            format!("choose a step from 0 to {}", self.count.saturating_sub(1)),
        ))
    }

    fn read_field(&self, step: usize, name: &str) -> Result<PointField, Problem> {
        self.check_step(step)?;
        let n = self.number(&self.root, "NumberOfPoints", self.part(step)?)?;
        let start = self.number(&self.steps, "PointOffsets", step)?;
        let there = self.root.group("PointData")?.member_names()?;
        if !there.iter().any(|t| t == name) {
            return Err(Problem(format!("has no field `{name}`"), format!("it has {}", there.join(", "))));
        }
        self.field(name.into(), step, start, n)
    }

    /// A field of a step whose `n` points begin at `start`.
    fn field(&self, name: String, step: usize, start: usize, n: usize) -> Result<PointField, Problem> {
        let start = match self.steps.group("PointDataOffsets") {
            Ok(g) if g.link_exists(&name) => self.number(&g, &name, step)?,
            _ => start,
        };
        let (components, values) = self.table(&self.root.group("PointData")?, &name, span(start, n)?)?;
        Ok(PointField { name, components, values })
    }

    fn cells(&self, step: usize, part: usize, points: usize) -> Result<Cells, Problem> {
        let polygons = self.root.group(CELL_GROUPS[POLYGONS])?;
        let count = self.number(&polygons, "NumberOfCells", part)?;
        if count == 0 && self.number(&self.root.group(CELL_GROUPS[VERTICES])?, "NumberOfCells", part)? > 0 {
            return Ok(Cells::Vertices);
        }
        let ids = self.number(&polygons, "NumberOfConnectivityIds", part)?;
        if count.checked_mul(3) != Some(ids) {
            return Err(damaged("it has polygons that are no triangles"));
        }
        let starts = self.table_i64("ConnectivityIdOffsets", step)?;
        let start =
            usize::try_from(starts[POLYGONS]).map_err(|_| damaged("negative `ConnectivityIdOffsets`"))?;
        let flat: Vec<i64> = self.list(&polygons, "Connectivity", span(start, ids)?)?;
        let index = |i: &i64| {
            u32::try_from(*i)
                .ok()
                .filter(|i| (*i as usize) < points)
                .ok_or_else(|| damaged(format!("a triangle names point {i} of {points}")))
        };
        let flat = flat.iter().map(index).collect::<Result<Vec<u32>, _>>()?;
        Ok(Cells::Triangles(flat.as_chunks::<3>().0.to_vec()))
    }

    fn part(&self, step: usize) -> Result<usize, Problem> {
        self.number(&self.steps, "PartOffsets", step)
    }

    /// Entry `index` of a list of counts or offsets.
    fn number(&self, group: &Group, name: &str, index: usize) -> Result<usize, Problem> {
        let value = self.list::<i64>(group, name, span(index, 1)?)?[0];
        usize::try_from(value).map_err(|_| damaged(format!("`{name}` holds {value}")))
    }

    /// A part of a list.
    fn list<T: H5Type>(&self, group: &Group, name: &str, rows: Range<usize>) -> Result<Vec<T>, Problem> {
        let dataset = self.checked(group, name, &rows)?;
        if dataset.ndim() != 1 {
            return Err(damaged(format!("`{name}` has {} dimensions, expected 1", dataset.ndim())));
        }
        Ok(dataset.read_slice_1d::<T, _>(rows)?.into_iter().collect())
    }

    /// Some rows of a list or table of numbers, with the number of columns.
    fn table(&self, group: &Group, name: &str, rows: Range<usize>) -> Result<(usize, Vec<f64>), Problem> {
        let dataset = self.checked(group, name, &rows)?;
        match dataset.shape()[..] {
            [_] => Ok((1, dataset.read_slice_1d::<f64, _>(rows)?.to_vec())),
            [_, columns] if columns > 0 => {
                Ok((columns, dataset.read_slice_2d::<f64, _>((rows, ..))?.into_iter().collect()))
            }
            ref shape => Err(damaged(format!("`{name}` has the shape {shape:?}"))),
        }
    }

    /// A row of a table over steps with one column for each group of cells.
    fn table_i64(&self, name: &str, step: usize) -> Result<[i64; 4], Problem> {
        let dataset = self.checked(&self.steps, name, &span(step, 1)?)?;
        match dataset.shape()[..] {
            [_, 4] => {
                let row = dataset.read_slice_2d::<i64, _>((step..step + 1, ..))?;
                Ok(std::array::from_fn(|i| row[[0, i]]))
            }
            ref shape => Err(damaged(format!("`{name}` has the shape {shape:?}, expected 4 columns"))),
        }
    }

    /// A dataset of this file that holds those rows.
    fn checked(&self, group: &Group, name: &str, rows: &Range<usize>) -> Result<Dataset, Problem> {
        let dataset = group.dataset(name).map_err(|_| damaged(format!("it has no dataset `{name}`")))?;
        let shape = dataset.shape();
        let stored = shape.first().copied().unwrap_or(0);
        if rows.end > stored {
            return Err(damaged(format!("`{name}` has {stored} rows, row {} is asked for", rows.end - 1)));
        }
        let row_values = shape.iter().skip(1).fold(1_u64, |p, d| p.saturating_mul(*d as u64));
        let count = (rows.len() as u64).saturating_mul(row_values);
        foreign::check_dataset(&dataset, name, &self.root.filename(), count)?;
        Ok(dataset)
    }
}

fn span(start: usize, len: usize) -> Result<Range<usize>, Problem> {
    let end = start.checked_add(len).ok_or_else(|| damaged("an offset is out of all bounds"))?;
    Ok(start..end)
}
