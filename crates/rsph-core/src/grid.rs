//! Regular grids of cubic cells, and bounding boxes.

use crate::tensor::Vec3;

/// A regular grid of cubic cells, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Lower corner of cell (0, 0, 0).
    pub origin: Vec3,
    /// Edge length dx of a cell.
    pub spacing: f64,
    /// Number of cells along x, y, z.
    pub cells: [usize; 3],
}

impl Grid {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.cells.iter().product()
    }

    /// Whether there is no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Centre of the cell with integer coordinates `c`.
    pub fn centre(&self, c: [usize; 3]) -> Vec3 {
        self.origin + Vec3::new(c[0] as f64 + 0.5, c[1] as f64 + 0.5, c[2] as f64 + 0.5) * self.spacing
    }

    /// Index of the cell around a place; `None` outside of the grid.
    pub fn cell_at(&self, x: &Vec3) -> Option<usize> {
        let q = (x - self.origin) / self.spacing;
        (0..3)
            .all(|i| q[i] >= 0.0 && q[i] < self.cells[i] as f64)
            .then(|| self.index(std::array::from_fn(|i| q[i] as usize)))
    }

    /// Index of the cell with integer coordinates `c`, x fastest.
    pub fn index(&self, c: [usize; 3]) -> usize {
        (c[2] * self.cells[1] + c[1]) * self.cells[0] + c[0]
    }
}

/// An axis-aligned bounding box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl Bounds {
    /// Edge lengths.
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }
}
