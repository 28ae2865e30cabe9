//! The motion on the old lattice, continued into a band around the body, and interpolated by M'4.

use super::{AxisLattice, OldMap, bounds};
use crate::fit::{Degree, LocalFit};
use crate::kernel::m4_prime_weights_and_slopes;
use crate::neighbors::CellList;
use crate::tensor::Vec3;
use nalgebra::SVector;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Width of the band around the body in spacings.
const BAND: f64 = 4.0;

/// x, X and v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapValues(pub SVector<f64, 9>);

impl MapValues {
    fn new(x: &Vec3, reference: &Vec3, velocity: &Vec3) -> Self {
        Self(SVector::from_fn(|i, _| [x, reference, velocity][i / 3][i % 3]))
    }

    /// Position x.
    pub fn x(&self) -> Vec3 {
        self.0.fixed_rows::<3>(0).into()
    }

    /// Reference position X.
    pub fn reference(&self) -> Vec3 {
        self.0.fixed_rows::<3>(3).into()
    }

    /// Velocity v.
    pub fn velocity(&self) -> Vec3 {
        self.0.fixed_rows::<3>(6).into()
    }
}

/// Values at the nodes of the old lattice in and around the body; beyond the band there are none.
#[derive(Clone, Debug)]
pub struct MapGrid<const D: usize> {
    lattice: AxisLattice,
    low: [i64; 3],
    count: [usize; 3],
    values: Vec<Option<MapValues>>,
}

impl<const D: usize> MapGrid<D> {
    /// The old state at the nodes where there is a particle or a ghost; elsewhere in the band quadratic
    /// moving least squares around the nearest of them. The fit is centred there, and not at the new node,
    /// from where it would see two layers of particles only.
    pub fn new(old: &OldMap<'_>, lattice: &AxisLattice) -> Self {
        let dx = (0..D).map(|i| lattice.spacing[i]).fold(0.0, f64::max);
        let (low, high) = bounds(&old.nodes[..old.len]);
        let margin = Vec3::repeat((BAND + 1.0) * dx);
        let first = lattice.coordinates::<D>(&(low - margin)).map(f64::floor);
        let last = lattice.coordinates::<D>(&(high + margin)).map(f64::ceil);
        let low: [i64; 3] = std::array::from_fn(|i| first[i] as i64);
        let count: [usize; 3] = std::array::from_fn(|i| (last[i] - first[i]) as usize + 1);
        let cells = CellList::new(old.nodes, dx);
        let value = |b: usize| MapValues::new(&old.x[b], &old.reference[b], &old.velocity[b]);

        // Nodes of the band by the point that is nearest to them.
        let nearest = |q: usize| {
            let node = [q % count[0], q / count[0] % count[1], q / count[0] / count[1]];
            let p = lattice.position::<D>(std::array::from_fn(|i| low[i] + node[i] as i64));
            Some((q, p, cells.nearest(old.nodes, &p, (BAND + 0.6) * dx)?))
        };
        let near: Vec<_> = (0..count.iter().product::<usize>()).into_par_iter().filter_map(nearest).collect();
        let mut values = vec![None; count.iter().product()];
        let mut band = BTreeMap::<usize, Vec<(usize, Vec3)>>::new();
        for (q, p, (b, distance)) in near {
            if distance < 1e-6 * dx {
                values[q] = Some(value(b));
            } else {
                band.entry(b).or_default().push((q, p));
            }
        }
        let fitted: Vec<Vec<(usize, MapValues)>> = band
            .par_iter()
            .map(|(anchor, nodes)| {
                let anchor = &old.nodes[*anchor];
                let fit = LocalFit::<D>::new(Degree::Quadratic, &cells, old.nodes, anchor);
                let at = |p: &Vec3| {
                    let sum = |s: SVector<f64, 9>, (b, w): (u32, f64)| s + value(b as usize).0 * w;
                    MapValues(fit.weights_at(p).fold(SVector::zeros(), sum))
                };
                nodes.iter().map(|(q, p)| (*q, at(p))).collect()
            })
            .collect();
        for (q, v) in fitted.into_iter().flatten() {
            values[q] = Some(v);
        }
        Self { lattice: *lattice, low, count, values }
    }

    /// Values at xi and their derivatives along the axes; `None` beyond the band.
    pub fn interpolate(&self, xi: &Vec3) -> Option<(MapValues, [MapValues; 3])> {
        let y = self.lattice.coordinates::<D>(xi);
        let mut base = [0_i64; 3];
        let (mut weight, mut slope) = ([[1.0; 4]; 3], [[0.0; 4]; 3]);
        for i in 0..D {
            let floor = y[i].floor();
            base[i] = floor as i64 - self.low[i] - 1;
            // The negation is true of NaN, too.
            if base[i] < 0 || base[i] + 4 > self.count[i] as i64 {
                return None;
            }
            (weight[i], slope[i]) = m4_prime_weights_and_slopes(y[i] - floor);
            slope[i] = slope[i].map(|s| s / self.lattice.spacing[i]);
        }
        let (mut value, mut slopes) = (SVector::<f64, 9>::zeros(), [SVector::<f64, 9>::zeros(); 3]);
        for k in 0..if D > 2 { 4 } else { 1 } {
            for j in 0..4 {
                for i in 0..4 {
                    let m = [i, j, k];
                    let at: [usize; 3] = std::array::from_fn(|i| base[i] as usize + m[i]);
                    let v = self.values[(at[2] * self.count[1] + at[1]) * self.count[0] + at[0]]?.0;
                    let w: [f64; 3] = std::array::from_fn(|i| weight[i][m[i]]);
                    value += v * (w[0] * w[1] * w[2]);
                    slopes[0] += v * (slope[0][i] * w[1] * w[2]);
                    slopes[1] += v * (w[0] * slope[1][j] * w[2]);
                    slopes[2] += v * (w[0] * w[1] * slope[2][k]);
                }
            }
        }
        Some((MapValues(value), slopes.map(MapValues)))
    }
}
