//! Segmentations of CT and MR images, in which numbers stand for organs. One format a file.

mod grid;
mod gzip;
mod image;
mod lookup;
mod nifti;
mod nrrd;
mod number;

pub use grid::{ImageGrid, read_grid};
pub use lookup::{OfLabel, volume_field};

use rsph_core::shape::{Placement, Run};
use rsph_core::tensor::{Mat3, Vec3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A segmentation that can not be read, or does not hold what is asked for.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}; {remedy}", path.display())]
pub struct LabelMapError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong.
    pub problem: String,
    /// What to do about it.
    pub remedy: String,
}

/// The voxels of one label.
#[derive(Clone, Debug, PartialEq)]
pub struct Labelled {
    /// The voxels.
    pub runs: Vec<Run>,
    /// Size of the image.
    pub size: [usize; 3],
    /// Where it is, in the units of the file.
    pub placement: Placement,
    /// From these units to metres.
    pub metres: f64,
}

/// Which axes a body gets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axes {
    /// Axes of the image.
    #[default]
    Image,
    /// From a patient's (x to the right, y to the front, z up) to those of organs: x to the left, y up, z to
    /// the front.
    Organ,
}

/// The values of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Values, x fastest.
    pub values: Vec<f32>,
    /// Its voxels.
    pub grid: ImageGrid,
}

/// What an image holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// Its voxels.
    pub grid: ImageGrid,
    /// Lowest and highest value.
    pub range: [f64; 2],
    /// Voxels of each label; `None` for an image whose values are no labels.
    pub labels: Option<BTreeMap<i64, u64>>,
    /// Voxels without a value: not a number, or infinite.
    pub without: u64,
}

impl Labelled {
    /// Where the image is in metres, or in units of which `scale` make one of the file's.
    pub fn placement(&self, scale: Option<f64>, axes: Axes) -> Placement {
        let Self { size, placement, metres, .. } = *self;
        ImageGrid { size, placement, metres }.placement(scale, axes)
    }
}

impl Axes {
    /// From the axes of the image to these.
    pub fn turn(self) -> Mat3 {
        match self {
            Self::Image => Mat3::identity(),
            Self::Organ => Mat3::from_columns(&[-Vec3::x(), Vec3::z(), Vec3::y()]),
        }
    }
}

/// The voxels of the number `label` in the NIfTI or NRRD file `path`.
///
/// # Errors
/// A file that can not be read, is broken, has more than three dimensions, or holds no such voxel.
pub fn read_label(path: &Path, label: u32) -> Result<Labelled, LabelMapError> {
    image::read(path, label).map_err(|Problem(problem, remedy)| LabelMapError {
        path: path.into(),
        problem,
        remedy,
    })
}

/// All values of the NIfTI or NRRD file `path`.
///
/// # Errors
/// A file that can not be read, is broken, has more than three dimensions, or is very large.
pub fn read_values(path: &Path) -> Result<Volume, LabelMapError> {
    image::values(path).map_err(|Problem(problem, remedy)| LabelMapError {
        path: path.into(),
        problem,
        remedy,
    })
}

/// What the NIfTI or NRRD file `path` holds.
///
/// # Errors
/// A file that can not be read, is broken, or has more than three dimensions.
pub fn survey(path: &Path) -> Result<Survey, LabelMapError> {
    image::survey(path).map_err(|Problem(problem, remedy)| LabelMapError {
        path: path.into(),
        problem,
        remedy,
    })
}

/// A problem and its remedy, in words.
struct Problem(String, String);

fn broken(what: impl Into<String>) -> Problem {
    Problem(what.into(), "export the segmentation again, as one file (.nii, .nii.gz or .nrrd)".into())
}
