//! What an image says at a point: whether it lies in some voxels, and the value there.

use super::{Axes, Volume};
use rsph_core::setup::{ModulusField, Place};
use rsph_core::shape::{Placement, Run};
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// How far, in voxels, the value of a voxel without a value may come from.
const NEAREST: i64 = 3;

/// The space of one label among several: where its indicator, interpolated between the centres of voxels, is larger than those of the
/// others. So a point of the body between the last voxels and the background belongs to the label that is nearest.
#[derive(Clone, Debug)]
pub struct OfLabel {
    own: Voxels,
    others: Vec<Voxels>,
    placement: Placement,
    inverse: Mat3,
}

impl OfLabel {
    /// Of the voxels in the runs `own`, beside those of other labels; `None` if the placement is none.
    pub fn new(own: Vec<Run>, others: Vec<Vec<Run>>, placement: Placement) -> Option<Self> {
        let inverse = placement.axes.try_inverse()?;
        let others = others.into_iter().map(Voxels::new).collect();
        Some(Self { own: Voxels::new(own), others, placement, inverse })
    }
}

impl Place for OfLabel {
    fn contains(&self, x: &Vec3) -> bool {
        let at = self.inverse * (x - self.placement.origin);
        let own = self.own.indicator(&at);
        own > 0.0 && self.others.iter().all(|other| other.indicator(&at) < own)
    }
}

/// Runs of voxels by k, j, i.
#[derive(Clone, Debug)]
struct Voxels(Vec<Run>);

impl Voxels {
    fn new(mut runs: Vec<Run>) -> Self {
        runs.sort_unstable_by_key(order);
        Self(runs)
    }

    fn holds(&self, voxel: [i64; 3]) -> bool {
        if voxel.iter().any(|i| *i < 0) {
            return false;
        }
        let [i, j, k] = voxel.map(|i| i as usize);
        let after = self.0.partition_point(|run| order(run) <= (k, j, i));
        let before = after.checked_sub(1).and_then(|n| self.0.get(n));
        before.is_some_and(|run| run.start[1..] == [j, k] && i < run.start[0] + run.length)
    }

    /// 1 at the centres of these voxels, 0 at those of others, linear between them.
    fn indicator(&self, at: &Vec3) -> f64 {
        corners(at).map(|(voxel, weight)| if self.holds(voxel) { weight } else { 0.0 }).sum()
    }
}

fn order(run: &Run) -> (usize, usize, usize) {
    (run.start[2], run.start[1], run.start[0])
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
    fn points_belong_to_the_label_that_is_nearest() {
        let placement = Placement { axes: Mat3::identity() * 2.0, origin: Vec3::repeat(1.0) };
        let runs = vec![Run { start: [3, 1, 1], length: 2 }, Run { start: [0, 1, 1], length: 1 }];
        let others = vec![vec![Run { start: [1, 1, 1], length: 2 }]];
        let place = OfLabel::new(runs, others, placement).unwrap();
        let at = |x: f64, z: f64| place.contains(&Vec3::new(1.0 + 2.0 * x, 3.0, 1.0 + 2.0 * z));
        assert!(
            at(0.0, 1.0)
                && at(0.49, 1.0)
                && !at(0.51, 1.0)
                && !at(2.49, 1.0)
                && at(2.51, 1.0)
                && at(4.0, 1.0)
        );
        // Beside the last voxels, too.
        assert!(at(4.7, 1.0) && at(3.0, 1.8) && !at(2.0, 1.8) && !at(5.1, 1.0) && !at(3.0, 2.1));
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
