//! The grid of voxels of an image, without their values.

use super::{Axes, LabelMapError, Problem, image};
use rsph_core::shape::Placement;
use std::path::Path;

/// The voxels of a CT or MR image and where they are.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageGrid {
    /// Number of voxels along each index.
    pub size: [usize; 3],
    /// Where they are, in the units of the file: x to the patient's right, y to the front, z up.
    pub placement: Placement,
    /// From these units to metres.
    pub metres: f64,
}

impl ImageGrid {
    /// Edges of a voxel, in the units of the file.
    pub fn edges(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.placement.axes.column(i).norm())
    }

    /// Where the indices grow to, as three letters: to the Right or Left of the patient, Anterior or Posterior, Superior or Inferior.
    pub fn orientation(&self) -> String {
        let letter = |i: usize| {
            let axis = self.placement.axes.column(i);
            let main = axis.iamax();
            ["LR", "PA", "IS"][main].as_bytes()[usize::from(axis[main] > 0.0)] as char
        };
        (0..3).map(letter).collect()
    }

    /// Where the voxels are in metres, or in units of which `scale` make one of the file's.
    pub fn placement(&self, scale: Option<f64>, axes: Axes) -> Placement {
        let (scale, turn) = (scale.unwrap_or(self.metres), axes.turn());
        Placement { axes: turn * self.placement.axes * scale, origin: turn * self.placement.origin * scale }
    }
}

/// The grid of the NIfTI or NRRD file `path`, of which the header is read.
///
/// # Errors
/// A file that can not be read, is broken, has more than three dimensions, or voxels that lie in a plane.
pub fn read_grid(path: &Path) -> Result<ImageGrid, LabelMapError> {
    let read = || {
        let header = image::read_header(path)?;
        let volume = header.placement.axes.determinant();
        if !(volume.is_finite() && volume != 0.0) {
            return Err(Problem(
                "says of its voxels that they have no volume".into(),
                "export the image again, with its orientation".into(),
            ));
        }
        Ok(ImageGrid { size: header.size, placement: header.placement, metres: header.metres })
    };
    read().map_err(|Problem(problem, remedy)| LabelMapError { path: path.into(), problem, remedy })
}
