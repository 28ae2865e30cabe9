//! The lattice of remeshing, and values at its nodes: rows along x, kept only where
//! something is.

use super::RemeshError;
use crate::tensor::Vec3;

/// Coordinates beyond this many spacings from the origin are an error: no lattice reaches there.
const FARTHEST: f64 = 1e9;

/// An unbounded lattice of nodes at `origin + (i + 1/2) spacing` for all integers i. In one or two
/// dimensions the nodes have y = 0 or z = 0 at index 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeLattice<const D: usize> {
    /// Lower corner of the cell of node 0.
    pub origin: Vec3,
    /// Spacing.
    pub spacing: f64,
}

impl<const D: usize> NodeLattice<D> {
    /// Position of a node.
    pub fn position(&self, node: [i64; 3]) -> Vec3 {
        Vec3::from_fn(|i, _| if i < D { self.origin[i] + (node[i] as f64 + 0.5) * self.spacing } else { 0.0 })
    }

    /// Volume (area, length) of a cell.
    pub fn cell_volume(&self) -> f64 {
        self.spacing.powi(D as i32)
    }

    /// The node below `x` along each axis and the distance from it in spacings, 0 to 1.
    #[inline(always)]
    pub(super) fn locate(&self, x: &Vec3) -> Option<([i64; 3], [f64; 3])> {
        let (mut node, mut fraction) = ([0; 3], [0.0; 3]);
        for i in 0..D {
            let q = (x[i] - self.origin[i]) / self.spacing - 0.5;
            if q.is_nan() || q.abs() >= FARTHEST {
                return None;
            }
            let floor = q.floor();
            (node[i], fraction[i]) = (floor as i64, q - floor);
        }
        Some((node, fraction))
    }
}

/// A stretch of nodes with consecutive x.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// z index.
    pub z: i64,
    /// y index.
    pub y: i64,
    /// x index of the first node.
    pub x: i64,
    /// Number of nodes.
    pub len: usize,
    /// Number of the first node in the order of all nodes.
    pub first: usize,
}

/// `columns` values at each of a sparse set of nodes.
#[derive(Clone, Debug)]
pub struct NodeValues<const D: usize> {
    /// The lattice.
    pub lattice: NodeLattice<D>,
    /// Rows in the order of (z, y).
    pub rows: Vec<Row>,
    /// Values a node.
    pub columns: usize,
    /// Values, node by node.
    pub values: Vec<f64>,
}

impl<const D: usize> NodeValues<D> {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.rows.last().map_or(0, |r| r.first + r.len)
    }

    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The values of a node by its number.
    #[inline(always)]
    pub fn at(&self, number: usize) -> &[f64] {
        &self.values[number * self.columns..(number + 1) * self.columns]
    }

    /// The row at (z, y).
    #[inline(always)]
    pub fn row(&self, z: i64, y: i64) -> Option<&Row> {
        self.rows.binary_search_by_key(&(z, y), |r| (r.z, r.y)).ok().map(|i| &self.rows[i])
    }

    /// The number of a node, if it is there.
    pub fn number(&self, [x, y, z]: [i64; 3]) -> Option<usize> {
        let row = self.row(z, y)?;
        let i = usize::try_from(x - row.x).ok()?;
        (i < row.len).then_some(row.first + i)
    }

    /// Indices of all nodes, in order.
    pub fn indices(&self) -> impl Iterator<Item = [i64; 3]> + '_ {
        self.rows.iter().flat_map(|r| (0..r.len).map(move |i| [r.x + i as i64, r.y, r.z]))
    }

    /// Values given at some nodes: `nodes` sorted by z, y, x, each once; gaps of a row are filled
    /// with zeros.
    ///
    /// # Errors
    /// When a row would be longer than memory holds.
    pub fn from_nodes(
        lattice: NodeLattice<D>,
        nodes: &[[i64; 3]],
        columns: usize,
        values: &[f64],
    ) -> Result<Self, RemeshError> {
        let mut rows: Vec<Row> = Vec::new();
        let mut len = 0;
        for [x, y, z] in nodes {
            match rows.last_mut() {
                Some(row) if (row.z, row.y) == (*z, *y) => row.len = super::row_length(row.x, x + 1)?,
                _ => rows.push(Row { z: *z, y: *y, x: *x, len: 1, first: 0 }),
            }
        }
        for row in &mut rows {
            row.first = len;
            len += row.len;
        }
        let mut field = Self { lattice, rows, columns, values: vec![0.0; len * columns] };
        for (node, value) in nodes.iter().zip(values.chunks_exact(columns)) {
            if let Some(n) = field.number(*node) {
                field.values[n * columns..(n + 1) * columns].copy_from_slice(value);
            }
        }
        Ok(field)
    }
}
