//! What an image says at a point: whether it lies in some voxels, and the value there.

use super::{Axes, Volume};
use rsph_core::setup::{ModulusField, Place};
use rsph_core::shape::{Placement, Run};
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// How far, in voxels, the value of a voxel without a value may come from.
const NEAREST: i64 = 3;

/// The space of some voxels: where their indicator, interpolated between the centres of voxels, is a half or more.
#[derive(Clone, Debug)]
pub struct InVoxels {
    /// By k, j, i.
    runs: Vec<Run>,
    placement: Placement,
    inverse: Mat3,
}

impl InVoxels {
    /// Of the voxels in `runs`; `None` if the placement is none.
    pub fn new(mut runs: Vec<Run>, placement: Placement) -> Option<Self> {
        runs.sort_unstable_by_key(order);
        let inverse = placement.axes.try_inverse()?;
        Some(Self { runs, placement, inverse })
    }

    fn holds(&self, voxel: [i64; 3]) -> bool {
        if voxel.iter().any(|i| *i < 0) {
            return false;
        }
        let [i, j, k] = voxel.map(|i| i as usize);
        let after = self.runs.partition_point(|run| order(run) <= (k, j, i));
        let before = after.checked_sub(1).and_then(|n| self.runs.get(n));
        before.is_some_and(|run| run.start[1..] == [j, k] && i < run.start[0] + run.length)
    }
}

fn order(run: &Run) -> (usize, usize, usize) {
    (run.start[2], run.start[1], run.start[0])
}

impl Place for InVoxels {
    fn contains(&self, x: &Vec3) -> bool {
        let indicator = |voxel| if self.holds(voxel) { 1.0 } else { 0.0 };
        corners(&(self.inverse * (x - self.placement.origin)))
            .map(|(voxel, w)| w * indicator(voxel))
            .sum::<f64>()
            >= 0.5
    }
}

/// The voxels around a point in voxel coordinates, with their weights.
fn corners(at: &Vec3) -> impl Iterator<Item = ([i64; 3], f64)> {
    let low = at.map(f64::floor);
    let part = at - low;
    (0..8).map(move |c| {
        let upper = [c & 1, c >> 1 & 1, c >> 2];
        let weight = (0..3).map(|i| if upper[i] == 1 { part[i] } else { 1.0 - part[i] }).product();
        (std::array::from_fn(|i| low[i] as i64 + upper[i]), weight)
    })
}

/// The positive values of an image, times `factor`, as a field: interpolated between the centres of voxels, and within three voxels of
/// them that of the nearest; else not a number. Coordinates are in the units of which `scale` make one of the file's, or metres.
pub fn volume_field(volume: Volume, axes: Axes, scale: Option<f64>, factor: f64) -> Option<ModulusField> {
    let Volume { values, grid } = volume;
    let Placement { axes, origin } = grid.placement(scale, axes);
    let inverse = axes.try_inverse()?;
    let value = move |voxel: [i64; 3]| {
        let inside = (0..3).all(|i| voxel[i] >= 0 && voxel[i] < grid.size[i] as i64);
        let [i, j, k] = voxel.map(|i| i as usize);
        let at = inside.then(|| (k * grid.size[1] + j) * grid.size[0] + i)?;
        values.get(at).map(|v| f64::from(*v)).filter(|v| v.is_finite() && *v > 0.0)
    };
    let nearest = move |at: &Vec3, value: &dyn Fn([i64; 3]) -> Option<f64>| {
        let middle = at.map(f64::round);
        let width = 2 * NEAREST + 1;
        let around =
            (0..width.pow(3)).map(|n| [n % width, n / width % width, n / width / width].map(|i| i - NEAREST));
        let found = around.filter_map(|offset| {
            let voxel = std::array::from_fn(|i| middle[i] as i64 + offset[i]);
            let distance = (Vec3::from_fn(|i, _| voxel[i] as f64) - at).norm_squared();
            Some((distance, value(voxel)?))
        });
        found.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(f64::NAN, |found| found.1)
    };
    let at = move |x: &Vec3| {
        let place = inverse * (x - origin);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (voxel, weight) in corners(&place) {
            if let Some(value) = value(voxel) {
                (sum, weights) = (sum + weight * value, weights + weight);
            }
        }
        factor * if weights > 1e-9 { sum / weights } else { nearest(&place, &value) }
    };
    Some(ModulusField(Arc::new(move |places: &[Vec3]| places.iter().map(&at).collect())))
}

#[cfg(test)]
mod tests {
    use super::super::ImageGrid;
    use super::*;

    #[test]
    fn points_are_in_voxels_up_to_half_way_to_the_next() {
        let placement = Placement { axes: Mat3::identity() * 2.0, origin: Vec3::repeat(1.0) };
        let runs = vec![Run { start: [3, 1, 1], length: 2 }, Run { start: [0, 1, 1], length: 1 }];
        let place = InVoxels::new(runs, placement).unwrap();
        let at = |x: f64| place.contains(&Vec3::new(1.0 + 2.0 * x, 3.0, 3.0));
        assert!(
            at(0.0) && at(0.49) && !at(0.51) && !at(2.49) && at(2.51) && at(4.0) && !at(4.51) && !at(-0.6)
        );
        assert!(!place.contains(&Vec3::new(7.0, 3.0, 4.1)));
    }

    #[test]
    fn values_are_interpolated_and_gaps_filled_from_beside() {
        let placement = Placement { axes: Mat3::identity(), origin: Vec3::zeros() };
        let volume = Volume {
            values: vec![0.0, 2.0, 4.0],
            grid: ImageGrid { size: [3, 1, 1], placement, metres: 1.0 },
        };
        let field = volume_field(volume, Axes::Image, None, 10.0).unwrap();
        let found = (field.0)(&[0.0, 0.5, 1.5, 1.75, 4.0, 9.0].map(|x| Vec3::new(x, 0.0, 0.0)));
        assert_eq!(found[..5], [20.0, 20.0, 30.0, 35.0, 40.0]);
        assert!(found[5].is_nan());
    }
}
