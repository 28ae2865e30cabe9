//! VTKHDF temporal `PolyData`: the results format that ParaView and pyvista open with its time axis.
//!
//! All frames lie one after the other in chunked, extendible datasets; the `Steps` group says where
//! each frame begins. The number of points and cells may change from frame to frame.

mod reader;
mod writer;

pub use reader::{FieldInfo, FileInfo, describe, read_field, read_step, visit_steps};
pub use writer::VtkHdfWriter;
pub(super) use writer::reason;

use std::path::{Path, PathBuf};

/// A VTKHDF file that could not be written or read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct VtkHdfError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong.
    pub problem: String,
    /// What to do about it.
    pub remedy: String,
}

impl VtkHdfError {
    fn new(path: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { path: path.into(), problem: problem.into(), remedy: remedy.into() }
    }
}

/// The four groups of cells of a `PolyData` in VTKHDF, in the order of the columns of `CellOffsets`.
const CELL_GROUPS: [&str; 4] = ["Vertices", "Lines", "Polygons", "Strips"];
const VERTICES: usize = 0;
const POLYGONS: usize = 2;
