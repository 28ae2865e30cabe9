//! Linear moving least squares: values at any point from the particles around it and, transposed, a
//! force at any point spread over them with its resultant and moment kept exactly. The weights stand for
//! V_b W(r - r_b, h) in Eq. (8), and make linear fields exact up to the surface. Gradients on the surface come from cubic
//! fits.

use crate::kernel::QuarticSpline;
use crate::neighbors::CellList;
use crate::particles::Column;
use crate::sample::Sight;
use crate::tensor::{Mat3, Vec3};
use nalgebra::{Cholesky, Matrix4, SMatrix, SVector, Vector4};
use rayon::prelude::*;

/// Smallest smoothing length of the weights, in spacings.
const SMOOTHING: f64 = 1.0;
/// The same for weights of surfaces, times the smoothing length of the gradient where that is longer: wider kernels want
/// wider weights, or the step of explicit schemes gets shorter.
const SURFACE_SMOOTHING: f64 = 1.2;
/// Points that one task finds weights for.
const POINTS_PER_TASK: usize = 256;
/// What keeps the weight of a particle finite where a point lies on it (in square spacings), for weights
/// that do not smooth.
const SHARPNESS: f64 = 1e-3;
/// Smallest variance of the particles' places around a point, in square spacings and along any direction, with which a
/// fit is well posed; with less it asks for a wider support.
const SMALLEST_VARIANCE: f64 = 0.08;
/// Least sum of the weights of a fit.
const SMALLEST_SUM: f64 = 1e-6;
/// Growth of the support, and how often it may grow.
const GROWTH: (f64, usize) = (1.3, 8);

/// Particles where points find them: on a lattice, or on one that has been deformed a little.
#[derive(Clone, Debug)]
pub struct Cloud<'a> {
    positions: &'a [Vec3],
    volume: &'a [f64],
    spacing: f64,
    smoothing: f64,
    cells: CellList,
    sharp: bool,
    /// What sees what, and the places that the particles stand for.
    sight: Option<(&'a Sight, Vec<Vec3>)>,
    /// 3, or 2 where all particles lie in the plane z = 0; then all points do.
    dimension: usize,
}

/// A linear fit around a place: the value of a field f at y is p(y)^T M^-1 sum_a w_a p(x_a) f_a with
/// p(x) = (1, (x - centre) / h) and M = sum_a w_a p(x_a) p(x_a)^T.
#[derive(Clone, Debug)]
pub struct LinearFit {
    /// Its centre.
    pub centre: Vec3,
    /// Its length h.
    pub h: f64,
    /// M^-1; without rows and columns of directions that the points do not determine.
    pub inverse: Matrix4<f64>,
    /// Number of each point and w_a.
    pub weights: Vec<(u32, f64)>,
}

impl LinearFit {
    /// p(x).
    #[inline]
    pub fn basis(&self, x: &Vec3) -> Vector4<f64> {
        let r = (x - self.centre) / self.h;
        Vector4::new(1.0, r.x, r.y, r.z)
    }
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
            .par_chunks(POINTS_PER_TASK)
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
    /// Particles at `positions`, about `spacing` apart, that stand for these volumes: one with a small share of a cell
    /// weighs little.
    pub fn new(positions: &'a [Vec3], volume: &'a [f64], spacing: f64) -> Self {
        let cells = CellList::new(positions, 1.25 * SMOOTHING * spacing);
        Self {
            positions,
            volume,
            spacing,
            smoothing: SMOOTHING,
            cells,
            sharp: false,
            sight: None,
            dimension: 3,
        }
    }

    /// The same in `dimension` dimensions: in the plane (2) volumes are of height one, and every point counts as the one
    /// below or above it in the plane.
    #[must_use]
    pub fn in_dimension(self, dimension: usize) -> Self {
        Self { dimension, ..self }
    }

    /// A point as the fits see it.
    fn place(&self, x: &Vec3) -> Vec3 {
        if self.dimension == 2 { Vec3::new(x.x, x.y, 0.0) } else { *x }
    }

    /// V_b W at the distance `d` of particle `b`; in the plane of a cell of the height dx.
    fn weight(&self, kernel: &QuarticSpline<3>, b: usize, d: f64) -> f64 {
        let height = if self.dimension == 2 { self.spacing } else { 1.0 };
        kernel.value(d) * self.volume[b] * height
    }

    /// The same with weights for the surface of a body whose gradients have that smoothing length, in spacings.
    #[must_use]
    pub fn for_surface(self, smoothing: f64) -> Self {
        Self { smoothing: SMOOTHING.max(SURFACE_SMOOTHING * smoothing), ..self }
    }

    /// The same with weights that pass through the values of the particles instead of smoothing them:
    /// at a particle they give its own value, to 1 %.
    #[must_use]
    pub fn sharp(self) -> Self {
        Self { sharp: true, ..self }
    }

    /// The same where a point rests on particles only that it sees.
    #[must_use]
    pub fn with_sight(self, sight: Option<&'a Sight>) -> Self {
        let homes = |sight: &Sight| self.positions.par_iter().map(|x| sight.home(x)).collect();
        Self { sight: sight.map(|sight| (sight, homes(sight))), ..self }
    }

    /// Whether a place sees each particle.
    fn sight_from(&self, x: &Vec3) -> impl Fn(usize) -> bool {
        let sight = self.sight.as_ref().filter(|(sight, _)| sight.is_near(x));
        let sight = sight.map(|(sight, homes)| (sight, homes, sight.home(x)));
        move |a: usize| sight.as_ref().is_none_or(|(sight, homes, from)| !sight.is_blocked(from, &homes[a]))
    }

    /// Particles within `radius` of `x` that it sees, with their distance.
    fn around(&self, x: &Vec3, radius: f64) -> Vec<(usize, f64)> {
        let mut found = Vec::with_capacity(128);
        let sees = self.sight_from(x);
        self.cells.visit_near(x, radius, |a| {
            let d = (self.positions[a as usize] - x).norm();
            if d < radius && sees(a as usize) {
                found.push((a as usize, d));
            }
        });
        found
    }

    /// The linear fit around `x`: the particles that it rests on, and their moments. Its support grows until
    /// the fit is well posed.
    pub fn fit_at(&self, x: &Vec3) -> LinearFit {
        let x = &self.place(x);
        let (dx, positions) = (self.spacing, self.positions);
        let mut h = self.smoothing * dx;
        let (growth, most) = GROWTH;
        for attempt in 1.. {
            let kernel = QuarticSpline::<3>::new(h);
            let weight = |a: usize, d: f64| {
                let near = if self.sharp { (d / dx).powi(2) + SHARPNESS } else { 1.0 };
                self.weight(&kernel, a, d) / near
            };
            let mut fit = LinearFit { centre: *x, h, inverse: Matrix4::zeros(), weights: Vec::new() };
            let mut moment = Matrix4::zeros();
            for (a, d) in self.around(x, 2.5 * h) {
                let (w, p) = (weight(a, d), fit.basis(&positions[a]));
                if w > 0.0 {
                    moment += w * p * p.transpose();
                    fit.weights.push((a as u32, w));
                }
            }
            // A body of very few particles may have no well-posed fit at all: then the widest one stands.
            if attempt < most
                && !(moment[(0, 0)] > SMALLEST_SUM
                    && variance(&moment, self.dimension) * h * h > SMALLEST_VARIANCE * dx * dx)
            {
                h *= growth;
                continue;
            }
            if fit.weights.is_empty() {
                // Farther from the body than any support: the nearest particle.
                let nearest = self.cells.nearest(positions, x, f64::INFINITY).map_or(0, |n| n.0);
                fit.weights.push((nearest as u32, 1.0));
                moment[(0, 0)] = 1.0;
            }
            let eigen = moment.symmetric_eigen();
            let largest = eigen.eigenvalues.max();
            for (value, v) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
                if *value > 1e-8 * largest {
                    fit.inverse += (v / *value) * v.transpose();
                }
            }
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

/// The smallest variance along any direction of space or of the plane of the places whose moments these are.
fn variance(moment: &Matrix4<f64>, dimension: usize) -> f64 {
    let sum = moment[(0, 0)];
    let mean = moment.fixed_view::<3, 1>(1, 0) / sum;
    let second = moment.fixed_view::<3, 3>(1, 1) / sum;
    let covariance = second - mean * mean.transpose();
    if dimension == 2 {
        return covariance.fixed_view::<2, 2>(0, 0).symmetric_eigenvalues().min();
    }
    covariance.symmetric_eigenvalues().min()
}

/// Smoothing length of cubic fits, in spacings: their support reaches 3.75.
const CUBIC_SMOOTHING: f64 = 1.5;
/// The same of quadratic fits, where the particles do not determine a cubic one: their support reaches 3.1.
const QUADRATIC_SMOOTHING: f64 = 1.24;
/// Terms of a quadratic and of a cubic polynomial.
const QUADRATIC: usize = 10;
const CUBIC: usize = 20;
/// Largest change of a slope by independent unit changes of the values, in spacings and along any axis, with which a cubic
/// fit is taken. With 3 the worst hoop stress of Lame's ring, 8 cells across, is off by 5.7 instead of 4.0 %; from 1.2 to 3
/// the plate with a hole and LE1 stay as they are (`rsph validate surfaces`).
const LARGEST_AMPLIFICATION: f64 = 1.5;
/// Ratio of pivots of a moment matrix below which a polynomial is too much for its points.
const SMALLEST_PIVOT: f64 = 1e-5;
/// Share of the largest eigenvalue below which a combination of terms is left out, where no support was wide enough.
const SMALLEST_EIGENVALUE: f64 = 1e-4;

/// The gradient of a fit around a place: cubic, or quadratic where the particles do not determine a cubic.
#[derive(Clone, Debug)]
pub struct GradientFit {
    centre: Vec3,
    h: f64,
    /// Rows of the inverse moments for the three slopes, over h.
    slopes: SMatrix<f64, 3, CUBIC>,
}

/// 1, x, y, z and their products.
fn quadratic(r: &Vec3) -> SVector<f64, QUADRATIC> {
    let [x, y, z] = [r.x, r.y, r.z];
    SVector::from([1.0, x, y, z, x * x, y * y, z * z, x * y, y * z, x * z])
}

/// The terms of [`quadratic`] and those of third order.
fn cubic(r: &Vec3) -> SVector<f64, CUBIC> {
    let [x, y, z] = [r.x, r.y, r.z];
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let of_third_order = [xx * x, yy * y, zz * z, xx * y, xx * z, yy * x, yy * z, zz * x, zz * y, x * y * z];
    let mut terms = SVector::<f64, CUBIC>::zeros();
    terms.fixed_rows_mut::<QUADRATIC>(0).copy_from(&quadratic(r));
    terms.fixed_rows_mut::<{ CUBIC - QUADRATIC }>(QUADRATIC).copy_from_slice(&of_third_order);
    terms
}

impl Cloud<'_> {
    /// The fit around `x`, for the gradient there.
    pub fn gradient_fit(&self, x: &Vec3) -> GradientFit {
        let x = &self.place(x);
        let fit = |h: f64, slopes| GradientFit { centre: *x, h, slopes };
        let h = CUBIC_SMOOTHING * self.spacing;
        if let Some(slopes) = slopes(self.moment(x, h, cubic)) {
            let fit = fit(h, slopes / h);
            if self.amplification(&fit) < LARGEST_AMPLIFICATION {
                return fit;
            }
        }
        let quadratic_fit = |h: f64, slopes: SMatrix<f64, 3, QUADRATIC>| {
            let mut all = SMatrix::<f64, 3, CUBIC>::zeros();
            all.fixed_view_mut::<3, QUADRATIC>(0, 0).copy_from(&(slopes / h));
            fit(h, all)
        };
        let mut h = QUADRATIC_SMOOTHING * self.spacing;
        let (growth, most) = GROWTH;
        for attempt in 1.. {
            let moment = self.moment(x, h, quadratic);
            if let Some(slopes) = slopes(moment) {
                return quadratic_fit(h, slopes);
            }
            if attempt == most / 2 {
                // A thin body: as much of the polynomial as its particles determine.
                let eigen = moment.symmetric_eigen();
                let least = SMALLEST_EIGENVALUE * eigen.eigenvalues.max();
                let mut inverse = SMatrix::<f64, QUADRATIC, QUADRATIC>::zeros();
                for (value, v) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
                    if *value > least {
                        inverse += (v / *value) * v.transpose();
                    }
                }
                return quadratic_fit(h, inverse.fixed_view::<3, QUADRATIC>(1, 0).into_owned());
            }
            h *= growth;
        }
        unreachable!("the loop returns")
    }

    /// sum w p p^T of the terms p of a polynomial around `x`.
    fn moment<const T: usize>(
        &self,
        x: &Vec3,
        h: f64,
        terms: impl Fn(&Vec3) -> SVector<f64, T>,
    ) -> SMatrix<f64, T, T> {
        let mut moment = SMatrix::<f64, T, T>::zeros();
        self.visit_weights(x, h, |_, w, r| {
            let p = terms(r);
            moment.syger(w, &p, &p, 1.0);
        });
        moment.fill_upper_triangle_with_lower_triangle();
        if self.dimension == 2 {
            // Terms with z, which are zero.
            let one = moment[(0, 0)];
            for i in 0..T {
                if moment[(i, i)] == 0.0 {
                    moment[(i, i)] = one;
                }
            }
        }
        moment
    }

    /// Largest change of a slope by independent unit changes of the values, in spacings.
    fn amplification(&self, fit: &GradientFit) -> f64 {
        let mut squares = Vec3::zeros();
        self.visit_weights(&fit.centre, fit.h, |_, w, r| {
            let weights = fit.slopes * cubic(r) * w;
            squares += weights.component_mul(&weights);
        });
        squares.max().sqrt() * self.spacing
    }

    /// The gradient by `fit` of the vector field that has those values at the particles.
    pub fn gradient(&self, fit: &GradientFit, value: impl Fn(usize) -> Vec3) -> Mat3 {
        let mut moments = SMatrix::<f64, CUBIC, 3>::zeros();
        self.visit_weights(&fit.centre, fit.h, |a, w, r| moments += cubic(r) * value(a).transpose() * w);
        (fit.slopes * moments).transpose()
    }

    /// The weights g of the particles in the gradient by the fit around `x`: that of a vector field f is sum f (x) g.
    pub fn gradient_weights(&self, x: &Vec3) -> Vec<(u32, Vec3)> {
        let fit = self.gradient_fit(x);
        let mut weights = Vec::new();
        self.visit_weights(&fit.centre, fit.h, |a, w, r| weights.push((a as u32, fit.slopes * cubic(r) * w)));
        weights
    }

    /// Whether `fit` rests on any particle that is marked.
    pub fn rests_on(&self, fit: &GradientFit, marked: &[bool]) -> bool {
        let mut any = false;
        self.visit_weights(&fit.centre, fit.h, |a, _, _| any |= marked[a]);
        any
    }

    /// Visits (particle, weight, place over h) of the particles around `x`.
    fn visit_weights(&self, x: &Vec3, h: f64, mut visit: impl FnMut(usize, f64, &Vec3)) {
        let kernel = QuarticSpline::<3>::new(h);
        let sees = self.sight_from(x);
        self.cells.visit_near(x, 2.5 * h, |a| {
            let r = self.positions[a as usize] - x;
            let w = self.weight(&kernel, a as usize, r.norm());
            if w > 0.0 && sees(a as usize) {
                visit(a as usize, w, &(r / h));
            }
        });
    }
}

/// The rows of the inverse of a moment matrix for the three slopes, if it has one.
fn slopes<const T: usize>(moment: SMatrix<f64, T, T>) -> Option<SMatrix<f64, 3, T>> {
    let cholesky = Cholesky::new(moment)?;
    let pivots = cholesky.l_dirty().diagonal().map(|l| l * l);
    let is_determined = pivots.min() > SMALLEST_PIVOT * pivots.max();
    is_determined.then(|| cholesky.inverse().fixed_view::<3, T>(1, 0).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a ball of a lattice.
    fn cloud() -> Vec<Vec3> {
        let nodes =
            (0..1000).map(|k| Vec3::new(f64::from(k % 10), f64::from(k / 10 % 10), f64::from(k / 100)));
        nodes.map(|x| (x - Vec3::repeat(4.5)) * 0.1).filter(|x| x.norm() < 0.45 && x.z < 0.1).collect()
    }

    #[test]
    fn the_gradient_of_a_quadratic_field_is_exact_on_the_surface() {
        let positions = cloud();
        let volume = vec![1e-3; positions.len()];
        let cloud = Cloud::new(&positions, &volume, 0.1);
        let field = |x: &Vec3| Vec3::new(x.x * x.y + 0.3, x.z * x.z - x.x, 2.0 * x.y * x.y + x.x * x.z);
        for x in [Vec3::new(0.02, 0.03, 0.1), Vec3::new(0.3, -0.2, -0.26), Vec3::zeros()] {
            let g = cloud.gradient(&cloud.gradient_fit(&x), |a| field(&positions[a]));
            let exact = Mat3::new(x.y, x.x, 0.0, -1.0, 0.0, 2.0 * x.z, x.z, 4.0 * x.y, x.x);
            assert!((g - exact).amax() < 1e-9, "{g} {exact}");
        }
    }

    #[test]
    fn a_cubic_has_its_gradient_where_the_particles_determine_it() {
        let positions = cloud();
        let volume = vec![1e-3; positions.len()];
        let cloud = Cloud::new(&positions, &volume, 0.1);
        let field = |x: &Vec3| Vec3::new(x.x * x.y * x.z, x.z.powi(3) - x.x * x.x * x.y, x.y.powi(3));
        for x in [Vec3::new(0.02, 0.03, 0.05), Vec3::zeros()] {
            let g = cloud.gradient(&cloud.gradient_fit(&x), |a| field(&positions[a]));
            let exact = Mat3::new(
                x.y * x.z,
                x.x * x.z,
                x.x * x.y,
                -2.0 * x.x * x.y,
                -x.x * x.x,
                3.0 * x.z * x.z,
                0.0,
                3.0 * x.y * x.y,
                0.0,
            );
            assert!((g - exact).amax() < 1e-9, "{g} {exact}");
        }
    }

    #[test]
    fn a_sheet_has_the_slopes_that_it_determines() {
        let positions: Vec<Vec3> = cloud().into_iter().filter(|x| x.z.abs() < 0.06 && x.z > 0.0).collect();
        let volume = vec![1e-3; positions.len()];
        let cloud = Cloud::new(&positions, &volume, 0.1);
        let x = Vec3::new(0.0, 0.1, 0.05);
        let g = cloud.gradient(&cloud.gradient_fit(&x), |a| Vec3::new(positions[a].x, positions[a].y, 0.0));
        assert!((g - Mat3::from_diagonal(&Vec3::new(1.0, 1.0, 0.0))).amax() < 1e-6, "{g}");
    }
}
