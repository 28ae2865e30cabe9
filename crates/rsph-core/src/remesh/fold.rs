//! What lands on nodes that are not kept goes to the nearest kept node, so that sums are conserved.

use super::nodes::{NodeValues, Row};
use rayon::prelude::*;

/// Marks a node without a target.
const NONE: u32 = u32::MAX;

/// What became of the values of nodes that were not kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Folded {
    /// Sum of the absolute values that moved to another node, a column.
    pub moved: Vec<f64>,
    /// Sum of the values that found no kept node near and were dropped, a column.
    pub dropped: Vec<f64>,
}

/// Moves the values of nodes with `keep` false to the nearest node with `keep` true, up to `reach`
/// spacings away; those without one are dropped and counted. Of equally near nodes the same one is
/// taken always.
pub fn fold<const D: usize>(field: &mut NodeValues<D>, keep: &[bool], reach: usize) -> Folded {
    let target = targets(field, keep, reach);
    let columns = field.columns;
    let mut folded = Folded { moved: vec![0.0; columns], dropped: vec![0.0; columns] };
    for (n, target) in target.iter().enumerate().filter(|(n, _)| !keep[*n]) {
        for c in 0..columns {
            let value = std::mem::take(&mut field.values[n * columns + c]);
            if *target == NONE {
                folded.dropped[c] += value;
            } else {
                field.values[*target as usize * columns + c] += value;
                folded.moved[c] += value.abs();
            }
        }
    }
    folded
}

/// For every node that is not kept and has a value, the kept node that takes it.
fn targets<const D: usize>(field: &NodeValues<D>, keep: &[bool], reach: usize) -> Vec<u32> {
    let kept_in_row = nearest_in_rows(field, keep);
    let offsets = row_offsets::<D>(reach as i64);
    let mut target = vec![NONE; field.len()];
    let mut rest = target.as_mut_slice();
    let mut rows = Vec::with_capacity(field.rows.len());
    for row in &field.rows {
        let (of_row, after) = rest.split_at_mut(row.len);
        rows.push((row, of_row));
        rest = after;
    }
    rows.into_par_iter().for_each(|(row, targets)| {
        let mut around = Around { field, offsets: &offsets, row, found: Vec::new() };
        for (i, target) in targets.iter_mut().enumerate() {
            let n = row.first + i;
            if !keep[n] && field.at(n).iter().any(|v| *v != 0.0) {
                *target = around.nearest(row.x + i as i64, &kept_in_row, reach);
            }
        }
    });

    target
}

/// The rows around a row, nearest first, looked up as far as they are asked for.
struct Around<'a, const D: usize> {
    field: &'a NodeValues<D>,
    offsets: &'a [(i64, i64, i64)],
    row: &'a Row,
    found: Vec<Option<&'a Row>>,
}

impl<const D: usize> Around<'_, D> {
    /// The kept node nearest to the one at `x` of the row.
    fn nearest(&mut self, x: i64, kept_in_row: &[u32], reach: usize) -> u32 {
        let (mut best, mut best_d2) = (NONE, (reach * reach) as i64 + 1);
        for (k, (row_d2, dz, dy)) in self.offsets.iter().enumerate() {
            if *row_d2 >= best_d2 {
                break;
            }
            if k == self.found.len() {
                self.found.push(self.field.row(self.row.z + dz, self.row.y + dy));
            }
            let Some(row) = self.found[k] else { continue };
            let i = (x - row.x).clamp(0, row.len as i64 - 1) as usize;
            let n = kept_in_row[row.first + i];
            if n != NONE {
                let d2 = row_d2 + (row.x + (n as usize - row.first) as i64 - x).pow(2);
                if d2 < best_d2 {
                    (best, best_d2) = (n, d2);
                }
            }
        }
        best
    }
}

/// For every node the nearest kept one of its row.
fn nearest_in_rows<const D: usize>(field: &NodeValues<D>, keep: &[bool]) -> Vec<u32> {
    let mut nearest = vec![NONE; keep.len()];
    for row in &field.rows {
        let (first, end) = (row.first, row.first + row.len);
        let mut last = NONE;
        for n in first..end {
            last = if keep[n] { n as u32 } else { last };
            nearest[n] = last;
        }
        let mut next = NONE;
        for n in (first..end).rev() {
            next = if keep[n] { n as u32 } else { next };
            let below = nearest[n];
            if below == NONE || (next != NONE && next as usize - n < n - below as usize) {
                nearest[n] = next;
            }
        }
    }
    nearest
}

/// Rows within `reach` of a row: square of the distance, dz, dy; nearest first.
fn row_offsets<const D: usize>(reach: i64) -> Vec<(i64, i64, i64)> {
    let range = |axis: usize| if axis < D { -reach..=reach } else { 0..=0 };
    let mut offsets: Vec<(i64, i64, i64)> = range(2)
        .flat_map(|z| range(1).map(move |y| (z * z + y * y, z, y)))
        .filter(|o| o.0 <= reach * reach)
        .collect();
    offsets.sort_unstable();
    offsets
}
