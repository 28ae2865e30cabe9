//! Linear moving least squares: values at any point from the particles around it and, transposed, a
//! force at any point spread over them with its resultant and moment kept exactly. The weights stand for
//! V_b W(r - r_b, h) in Eq. (8), and make linear fields exact up to the surface.

use crate::fit::LinearFit;
use crate::kernel::QuarticSpline;
use crate::neighbors::CellList;
use crate::particles::Column;
use crate::tensor::Vec3;
use nalgebra::{Matrix4, Vector4};
use rayon::prelude::*;

/// Smallest smoothing length of the weights, in spacings.
const SMOOTHING: f64 = 1.25;
/// Points that one task finds weights for.
const POINTS_A_TASK: usize = 256;
/// Particles that the support must hold at least.
const FEWEST: usize = 8;
/// What keeps the weight of a particle finite where a point lies on it (in square spacings), for weights
/// that do not smooth.
const SHARPNESS: f64 = 1e-3;
/// A moment matrix with a smaller ratio of eigenvalues asks for a wider support.
const WORST_CONDITION: f64 = 1e-4;

/// Particles where points find them: on a lattice, or on one that has been deformed a little.
#[derive(Clone, Debug)]
pub struct Cloud<'a> {
    positions: &'a [Vec3],
    spacing: f64,
    cells: CellList,
    sharp: bool,
}

/// Weights of particles at a list of points (compressed rows).
#[derive(Clone, Debug, Default)]
pub struct PointWeights {
    starts: Vec<usize>,
    particles: Vec<u32>,
    weights: Vec<f64>,
}

impl PointWeights {
    /// Weights at `points` of the particles of `cloud`. They sum to 1 and reproduce linear fields.
    pub fn new(cloud: &Cloud<'_>, points: &[Vec3]) -> Self {
        let parts: Vec<Self> = points
            .par_chunks(POINTS_A_TASK)
            .map(|points| Self::from_rows(points.iter().map(|x| cloud.weights_at(x))))
            .collect();
        let entries = parts.iter().map(|p| p.weights.len()).sum();
        let mut all = Self::with_capacity(points.len(), entries);
        for part in parts {
            let before = all.weights.len();
            all.starts.extend(part.starts[1..].iter().map(|s| s + before));
            all.particles.extend(part.particles);
            all.weights.extend(part.weights);
        }
        all
    }

    fn with_capacity(points: usize, entries: usize) -> Self {
        let mut starts = Vec::with_capacity(points + 1);
        starts.push(0);
        Self { starts, particles: Vec::with_capacity(entries), weights: Vec::with_capacity(entries) }
    }

    /// Weights from a list of (particle, weight) for each point.
    pub fn from_rows(rows: impl IntoIterator<Item = Vec<(u32, f64)>>) -> Self {
        let mut all = Self::with_capacity(0, 0);
        for row in rows {
            all.particles.extend(row.iter().map(|(a, _)| a));
            all.weights.extend(row.iter().map(|(_, w)| w));
            all.starts.push(all.weights.len());
        }
        all
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// (particle, weight) of point `i`.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let here = self.starts[i]..self.starts[i + 1];
        self.particles[here.clone()].iter().copied().zip(self.weights[here].iter().copied())
    }

    /// One component of a column at point `i`.
    pub fn value(&self, column: &Column, component: usize, i: usize) -> f64 {
        let values = column.component(component);
        self.row(i).map(|(a, w)| w * values[a as usize]).sum()
    }

    /// A whole column at all points: for each point its components.
    pub fn interpolate(&self, column: &Column) -> Vec<f64> {
        let c = column.components();
        (0..self.len() * c).into_par_iter().map(|k| self.value(column, k % c, k / c)).collect()
    }

    /// The mean over the points with these weights, as one (particle, weight) list.
    pub fn mean(&self, point_weight: &[f64], particles: usize) -> Vec<(u32, f64)> {
        let total: f64 = point_weight.iter().sum();
        let mut dense = vec![0.0; particles];
        for (i, p) in point_weight.iter().enumerate() {
            for (a, w) in self.row(i) {
                dense[a as usize] += w * p / total;
            }
        }
        let nonzero = |(a, w): (usize, &f64)| (*w != 0.0).then_some((a as u32, *w));
        dense.iter().enumerate().filter_map(nonzero).collect()
    }
}

impl<'a> Cloud<'a> {
    /// Particles at `positions`, about `spacing` apart.
    pub fn new(positions: &'a [Vec3], spacing: f64) -> Self {
        let cells = CellList::new(positions, 1.25 * SMOOTHING * spacing);
        Self { positions, spacing, cells, sharp: false }
    }

    /// The same with weights that pass through the values of the particles instead of smoothing them:
    /// at a particle they give its own value, to 1 %.
    #[must_use]
    pub fn sharp(self) -> Self {
        Self { sharp: true, ..self }
    }

    /// Particles within `radius` of `x`, with their distance.
    fn around(&self, x: &Vec3, radius: f64) -> Vec<(usize, f64)> {
        let mut found = Vec::with_capacity(128);
        self.cells.visit_near(x, radius, |a| {
            let d = (self.positions[a as usize] - x).norm();
            if d < radius {
                found.push((a as usize, d));
            }
        });
        found
    }

    /// The linear fit around `x`: the particles that it rests on, and their moments. Its support grows until
    /// the fit is well posed.
    pub fn fit_at(&self, x: &Vec3) -> LinearFit {
        let (dx, positions) = (self.spacing, self.positions);
        let enough = FEWEST.min(positions.len());
        let mut radius = 2.5 * SMOOTHING * dx;
        let mut near = self.around(x, radius);
        while near.len() < enough {
            radius *= 1.5;
            near = self.around(x, radius);
        }
        let mut distances: Vec<f64> = near.iter().map(|p| p.1).collect();
        let (_, farthest_needed, _) = distances.select_nth_unstable_by(enough - 1, f64::total_cmp);
        let mut h = (SMOOTHING * dx).max(*farthest_needed / 2.2);
        // A body of very few particles may have no well-posed fit at all: then the widest one stands.
        for attempt in 0.. {
            if 2.5 * h > radius {
                radius = 2.5 * h;
                near = self.around(x, radius);
            }
            let kernel = QuarticSpline::<3>::new(h);
            let weight = |d: f64| {
                let near = if self.sharp { (d / dx).powi(2) + SHARPNESS } else { 1.0 };
                kernel.value(d) / near
            };
            let mut fit = LinearFit { centre: *x, h, inverse: Matrix4::zeros(), weights: Vec::new() };
            let mut moment = Matrix4::zeros();
            for &(a, d) in &near {
                let p = fit.basis(&positions[a]);
                moment += weight(d) * p * p.transpose();
            }
            let eigen = moment.symmetric_eigen();
            let largest = eigen.eigenvalues.max();
            let well_posed = eigen.eigenvalues.min() > WORST_CONDITION * largest;
            if !well_posed && attempt < 12 {
                h *= 1.2;
                continue;
            }
            for (value, v) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
                if *value > 1e-12 * largest {
                    fit.inverse += (v / *value) * v.transpose();
                }
            }
            fit.weights =
                near.iter().map(|&(a, d)| (a as u32, weight(d))).filter(|(_, w)| *w != 0.0).collect();
            return fit;
        }
        unreachable!("the loop returns")
    }

    fn weights_at(&self, x: &Vec3) -> Vec<(u32, f64)> {
        let fit = self.fit_at(x);
        let coefficient: Vector4<f64> = fit.inverse.column(0).into();
        let weight = |&(a, w): &(u32, f64)| (a, coefficient.dot(&fit.basis(&self.positions[a as usize])) * w);
        fit.weights.iter().map(weight).filter(|(_, w)| *w != 0.0).collect()
    }
}
