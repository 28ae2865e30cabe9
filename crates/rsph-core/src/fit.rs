//! Moving least squares around any point of a cloud: a polynomial through the nearest points, weighted by
//! their distance. Linear or quadratic, in the plane or in space.

use crate::neighbors::CellList;
use crate::tensor::Vec3;
use nalgebra::{Cholesky, Const, Matrix4, SMatrix, SVector, Vector4};

/// Most terms of a polynomial: 1, x, y, z and six products.
const TERMS: usize = 10;
/// A polynomial whose moment matrix has a smaller ratio of pivots is too much for its points.
const SMALLEST_PIVOT: f64 = 1e-7;

type Terms = SVector<f64, TERMS>;

/// Degree of the polynomial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Degree {
    /// Exact for linear fields.
    Linear,
    /// Exact for quadratic fields.
    Quadratic,
}

impl Degree {
    /// Points that a fit in `D` dimensions takes.
    pub fn points<const D: usize>(self) -> usize {
        match (self, D) {
            (Self::Linear, 2) => 12,
            (Self::Quadratic, 2) => 18,
            (Self::Linear, _) => 30,
            (Self::Quadratic, _) => 50,
        }
    }
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

/// A fit around an anchor, good for points near it. Its weights sum to 1 and reproduce polynomials of its
/// degree, as far as its points determine them.
#[derive(Clone, Debug)]
pub struct LocalFit<const D: usize> {
    anchor: Vec3,
    radius: f64,
    terms: usize,
    moment: Cholesky<f64, Const<TERMS>>,
    /// Number of the point, and its terms times its weight.
    points: Vec<(u32, Terms)>,
}

impl<const D: usize> LocalFit<D> {
    /// A fit around `anchor` through the nearest of `positions` (not empty), which `cells` holds.
    pub fn new(degree: Degree, cells: &CellList, positions: &[Vec3], anchor: &Vec3) -> Self {
        let near = cells.nearest_of(positions, anchor, degree.points::<D>());
        let farthest = near.last().map_or(0.0, |n| n.1);
        let radius = if farthest > 0.0 { 1.001 * farthest } else { 1.0 };
        let counts = [(D + 1) * (D + 2) / 2, D + 1, 1];
        let first = usize::from(degree == Degree::Linear);
        for terms in counts.into_iter().skip(first) {
            // Terms that are not in use keep a one on the diagonal.
            let mut moment = SMatrix::<f64, TERMS, TERMS>::zeros();
            for i in terms..TERMS {
                moment[(i, i)] = 1.0;
            }
            let points: Vec<(u32, Terms)> = near
                .iter()
                .map(|&(b, d)| {
                    let p = basis::<D>(&((positions[b as usize] - anchor) / radius), terms);
                    let s2 = (d / radius).powi(2);
                    let w = ((1.0 - s2).powi(2) * (-3.0 * s2).exp()).max(1e-6);
                    moment.syger(w, &p, &p, 1.0);
                    (b, p * w)
                })
                .collect();
            moment.fill_upper_triangle_with_lower_triangle();
            let scale = moment[(0, 0)];
            if let Some(cholesky) = Cholesky::new(moment)
                && (terms == 1
                    || (0..terms).all(|i| cholesky.l_dirty()[(i, i)].powi(2) > SMALLEST_PIVOT * scale))
            {
                return Self { anchor: *anchor, radius, terms, moment: cholesky, points };
            }
        }
        unreachable!("the sum of positive weights is positive")
    }

    /// The fit as a linear one, without the products of coordinates that it may have.
    pub fn linear(&self) -> LinearFit {
        let terms = self.terms.min(D + 1);
        let whole = self.moment.inverse();
        let inverse = Matrix4::from_fn(|i, j| if i.max(j) < terms { whole[(i, j)] } else { 0.0 });
        let weights = self.points.iter().map(|(b, p)| (*b, p[0])).collect();
        LinearFit { centre: self.anchor, h: self.radius, inverse, weights }
    }

    /// Weights of the points for the value of their field at `x`.
    pub fn weights_at(&self, x: &Vec3) -> impl Iterator<Item = (u32, f64)> + '_ {
        let mut y = basis::<D>(&((x - self.anchor) / self.radius), self.terms);
        self.moment.solve_mut(&mut y);
        self.points.iter().map(move |(b, p)| (*b, y.dot(p)))
    }
}

/// The first `terms` of 1, x, y, (z), and their products.
fn basis<const D: usize>(z: &Vec3, terms: usize) -> Terms {
    let mut p = Terms::zeros();
    p[0] = 1.0;
    if terms > 1 {
        for i in 0..D {
            p[1 + i] = z[i];
        }
    }
    if terms > D + 1 {
        let mut t = D + 1;
        for i in 0..D {
            for j in i..D {
                p[t] = z[i] * z[j];
                t += 1;
            }
        }
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value<const D: usize>(degree: Degree, points: &[Vec3], x: &Vec3, f: impl Fn(&Vec3) -> f64) -> f64 {
        let cells = CellList::new(points, 0.5);
        let anchor = points[cells.nearest(points, x, 10.0).unwrap().0];
        let fit = LocalFit::<D>::new(degree, &cells, points, &anchor);
        fit.weights_at(x).map(|(b, w)| w * f(&points[b as usize])).sum()
    }

    proptest! {
        #[test]
        fn polynomials_are_reproduced(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 80..120),
            x in prop::array::uniform3(-1.0..1.0_f64),
            c in prop::array::uniform10(-1.0..1.0_f64),
        ) {
            let space: Vec<Vec3> = points.iter().map(|p| Vec3::from(*p)).collect();
            let plane: Vec<Vec3> = points.iter().map(|p| Vec3::new(p[0], p[1], 0.0)).collect();
            let x = Vec3::from(x);
            for (degree, terms) in [(Degree::Linear, 4), (Degree::Quadratic, 10)] {
                let f = |x: &Vec3| basis::<3>(x, terms).iter().zip(&c).map(|(p, c)| p * c).sum::<f64>();
                prop_assert!((value::<3>(degree, &space, &x, f) - f(&x)).abs() < 1e-7);
                let flat = Vec3::new(x.x, x.y, 0.0);
                prop_assert!((value::<2>(degree, &plane, &flat, f) - f(&flat)).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn too_few_points_lower_the_degree() {
        let line = [Vec3::zeros(), Vec3::new(0.1, 0.0, 0.0), Vec3::new(0.2, 0.0, 0.0)];
        let x = Vec3::new(0.15, 0.0, 0.0);
        assert!((value::<3>(Degree::Quadratic, &line, &x, |_| 2.0) - 2.0).abs() < 1e-12);
    }
}
