//! Particles to lattice, Eq. (17), by gathering: each row of nodes sums over the particles around it
//! in a fixed order, so that rows need no locks and the result does not depend on the thread count.

use super::nodes::{NodeLattice, NodeValues, Row};
use super::{RemeshError, row_length};
use crate::kernel::{MAX_WEIGHTS, RemeshKernel};
use crate::tensor::Vec3;
use rayon::prelude::*;

/// Values are summed in groups of this many: rows of them fit into vector registers.
const LANES: usize = 4;
/// Rows that one task works on.
const ROWS_PER_TASK: usize = 16;

/// A particle where its row of cells finds it.
#[derive(Clone, Copy)]
struct Placed {
    node: [i64; 3],
    index: u32,
    weights: [[f64; MAX_WEIGHTS]; 3],
}

/// Sums over particles of `values` times the kernel at all nodes within reach. `values` holds
/// `columns` extensive values a particle, particle by particle.
///
/// # Errors
/// A position that is not finite or so far away that no lattice holds it.
///
/// # Panics
/// When `values` does not have `columns` values a particle.
pub fn scatter<const D: usize>(
    kernel: RemeshKernel,
    lattice: NodeLattice<D>,
    positions: &[Vec3],
    columns: usize,
    values: &[f64],
) -> Result<NodeValues<D>, RemeshError> {
    assert_eq!(values.len(), columns * positions.len(), "values a particle");
    let width = columns.next_multiple_of(LANES);
    let placed = place(kernel, &lattice, positions)?;
    let mut sorted = vec![0.0; width * placed.len()];
    sorted.par_chunks_mut(width.max(1)).zip(&placed).for_each(|(to, p)| {
        let a = p.index as usize;
        to[..columns].copy_from_slice(&values[a * columns..(a + 1) * columns]);
    });

    let reach = kernel.reach() as i64;
    let sources = rows_of(&placed)?;
    let targets = target_rows::<D>(&sources, reach);
    let summed = targets
        .par_chunks(ROWS_PER_TASK)
        .map(|rows| {
            let (mut out, mut values, mut sums) = (Vec::with_capacity(rows.len()), Vec::new(), Vec::new());
            for &(z, y) in rows {
                if let Some((x, len)) = sum_row::<D>(&sources, &placed, &sorted, reach, (z, y), &mut sums)? {
                    out.push(Row { z, y, x, len, first: 0 });
                    if columns == width {
                        values.extend_from_slice(&sums);
                    } else {
                        values.extend(sums.chunks_exact(width).flat_map(|s| &s[..columns]).copied());
                    }
                }
            }
            Ok((out, values))
        })
        .collect::<Result<Vec<_>, RemeshError>>()?;

    let mut field = NodeValues { lattice, rows: Vec::new(), columns, values: Vec::new() };
    for (rows, values) in summed {
        for mut row in rows {
            row.first = field.rows.last().map_or(0, |r| r.first + r.len);
            field.rows.push(row);
        }
        field.values.extend(values);
    }
    Ok(field)
}

/// Particles with their weights, by row and along it.
fn place<const D: usize>(
    kernel: RemeshKernel,
    lattice: &NodeLattice<D>,
    positions: &[Vec3],
) -> Result<Vec<Placed>, RemeshError> {
    let lost = |a: usize| RemeshError::Lost { particle: a, position: positions[a] };
    let mut order = (0..positions.len())
        .into_par_iter()
        .map(|a| {
            let ([x, y, z], _) = lattice.locate(&positions[a]).ok_or_else(|| lost(a))?;
            Ok((z, y, x, a as u32))
        })
        .collect::<Result<Vec<_>, RemeshError>>()?;
    order.par_sort_unstable();
    order
        .into_par_iter()
        .map(|(z, y, x, index)| {
            let a = index as usize;
            let (_, fraction) = lattice.locate(&positions[a]).ok_or_else(|| lost(a))?;
            // Along an axis that is not there, the one weight of the only node.
            let weights =
                std::array::from_fn(|i| if i < D { kernel.weights(fraction[i]) } else { [1.0; MAX_WEIGHTS] });
            Ok(Placed { node: [x, y, z], index, weights })
        })
        .collect()
}

/// The rows of cells that hold particles; `first` and `len` count particles, `x` is that of the first.
fn rows_of(placed: &[Placed]) -> Result<Vec<Row>, RemeshError> {
    let mut rows: Vec<Row> = Vec::new();
    for (i, p) in placed.iter().enumerate() {
        let [x, y, z] = p.node;
        match rows.last_mut() {
            Some(row) if (row.z, row.y) == (z, y) => {
                row_length(row.x, x)?;
                row.len += 1;
            }
            _ => rows.push(Row { z, y, x, len: 1, first: i }),
        }
    }
    Ok(rows)
}

/// Cells around a node whose particles reach it, along an axis: -reach ..= reach - 1, or only its own
/// along an axis that is not there.
fn around<const D: usize>(axis: usize, reach: i64) -> (i64, i64) {
    if axis < D { (-reach, reach - 1) } else { (0, 0) }
}

/// All rows (z, y) of nodes that particles reach, in order.
fn target_rows<const D: usize>(sources: &[Row], reach: i64) -> Vec<(i64, i64)> {
    let ((y0, y1), (z0, z1)) = (around::<D>(1, reach), around::<D>(2, reach));
    let mut targets: Vec<(i64, i64)> = sources
        .par_iter()
        .flat_map_iter(|r| (-z1..=-z0).flat_map(move |z| (-y1..=-y0).map(move |y| (r.z + z, r.y + y))))
        .collect();
    targets.par_sort_unstable();
    targets.dedup();
    targets
}

/// The sums of a row of nodes into `sums`; its first x and its length. `None`: nothing reaches it.
fn sum_row<const D: usize>(
    sources: &[Row],
    placed: &[Placed],
    sorted: &[f64],
    reach: i64,
    (z, y): (i64, i64),
    sums: &mut Vec<f64>,
) -> Result<Option<(i64, usize)>, RemeshError> {
    let ((y0, y1), (z0, z1)) = (around::<D>(1, reach), around::<D>(2, reach));
    let near = |dz: i64| {
        let from = sources.partition_point(|r| (r.z, r.y) < (z + dz, y + y0));
        let count = sources[from..].partition_point(|r| (r.z, r.y) <= (z + dz, y + y1));
        &sources[from..from + count]
    };
    let (mut low, mut high) = (i64::MAX, i64::MIN);
    for row in (z0..=z1).flat_map(near) {
        low = low.min(row.x);
        high = high.max(placed[row.first + row.len - 1].node[0]);
    }
    if low > high {
        return Ok(None);
    }
    let first = low - reach + 1;
    let len = row_length(first, high + reach + 1)?;
    let width = sorted.len() / placed.len();
    sums.clear();
    sums.resize(len * width, 0.0);
    let source = Source { placed, sorted, width, reach, low };
    for row in (z0..=z1).flat_map(near) {
        pulp::Arch::new().dispatch(|| source.add_row::<D>(row, (z, y), sums));
    }
    Ok(Some((first, len)))
}

/// What rows of nodes are summed from.
struct Source<'a> {
    placed: &'a [Placed],
    sorted: &'a [f64],
    width: usize,
    reach: i64,
    /// The cell of the first particle that reaches the row of nodes.
    low: i64,
}

impl Source<'_> {
    /// Adds the particles of a row of cells to the row (z, y) of nodes.
    #[inline(always)]
    fn add_row<const D: usize>(&self, row: &Row, (z, y): (i64, i64), sums: &mut [f64]) {
        let (width, reach) = (self.width, self.reach);
        // Number of the weight of this row of nodes among those of a particle of that row of cells.
        let along = |axis: usize, node: i64, cell: i64| {
            if axis < D { (node - cell + reach - 1) as usize } else { 0 }
        };
        let (wy, wz) = (along(1, y, row.y), along(2, z, row.z));
        for i in row.first..row.first + row.len {
            let p = &self.placed[i];
            let w_yz = p.weights[1][wy] * p.weights[2][wz];
            let start = (p.node[0] - self.low) as usize * width;
            let (values, _) = self.sorted[i * width..(i + 1) * width].as_chunks::<LANES>();
            let nodes = &mut sums[start..start + 2 * reach as usize * width];
            for (node, w_x) in nodes.chunks_exact_mut(width).zip(&p.weights[0]) {
                let w = w_x * w_yz; // Eq. (17)
                for (sum, value) in node.as_chunks_mut::<LANES>().0.iter_mut().zip(values) {
                    for (sum, value) in sum.iter_mut().zip(value) {
                        *sum += w * value;
                    }
                }
            }
        }
    }
}
