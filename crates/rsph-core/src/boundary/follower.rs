//! A pressure that follows the deformed surface: its force is that of the undeformed surface turned and stretched with it.
//!
//! By Nanson's formula the force of a pressure p on an element N dA of the undeformed surface is -p cof(F) N dA, with
//! cof(F) = J F^-T. F is that of a fit of the displacement gradient at the middle of each cluster of the surface, and the
//! forces of a cluster go to the particles by the weights of any other load, so that the force is that of a dead pressure
//! as long as the body is undeformed, and balances a constant stress under any homogeneous deformation.
//!
//! The load of a closed surface, or of one whose rim is held, has a potential, and a symmetric derivative; that of the
//! discrete force is symmetric up to the error of the fit. [`Follower::tangent`] gives its symmetric part, for Newton's
//! method with conjugate gradients.

use super::surface_load::Traction;
use super::surface_quadrature::{Cluster, SurfaceQuadrature};
use crate::tensor::{Mat3, Vec3};
use nalgebra::{Matrix4x3, Vector4};
use rayon::prelude::*;

/// Fewest clusters or particles in a task.
const TASK: usize = 32;

/// The pressure on one part of the surface, with its forces at one displacement.
#[derive(Clone, Debug)]
pub struct Follower {
    clusters: Vec<Loaded>,
    /// Weights g of the particles in the gradient of the displacement, sum u (x) g, in each cluster, and in the other order.
    gradient: Links<Vec3>,
    gradient_of: Links<Vec3>,
    /// How the particles carry the forces of each cluster, and in the other order.
    carry: Links<Carried>,
    carry_of: Links<Carried>,
    /// Pattern of the forces of each cluster, then of their change.
    pattern: Vec<Matrix4x3<f64>>,
    /// What the gradient in each cluster is multiplied by in the transpose of the tangent.
    adjoint: Vec<Mat3>,
    /// cof(F) of the forces, and F in the state of the tangent.
    state: Vec<Mat3>,
    /// Factor of the load in the state of the tangent; 0: there is none.
    factor: f64,
    /// The forces on the particles that carry any or that the gradient rests on, in rising order.
    force: Vec<(u32, Vec3)>,
    /// Their change in the tangent.
    change: Vec<Vec3>,
}

/// A cluster that is loaded.
#[derive(Clone, Copy, Debug)]
struct Loaded {
    /// Pattern of its forces where the body is undeformed: W_a (A^T p(x_a)) is the force on particle a.
    pattern: Matrix4x3<f64>,
    /// Projector on what is not held.
    free: Mat3,
}

/// W_a p(x_a) of a particle at a cluster, with the signs of its image.
#[derive(Clone, Copy, Debug)]
struct Carried {
    weight: Vector4<f64>,
    signs: Vec3,
}

/// Entries of a sparse matrix by rows.
#[derive(Clone, Debug)]
struct Links<T> {
    starts: Vec<usize>,
    entries: Vec<(u32, T)>,
}

impl<T: Copy> Links<T> {
    /// Of rows of (column, value).
    fn new(rows: impl Iterator<Item = Vec<(u32, T)>>) -> Self {
        let mut links = Self { starts: vec![0], entries: Vec::new() };
        for row in rows {
            links.entries.extend(row);
            links.starts.push(links.entries.len());
        }
        links
    }

    fn row(&self, k: usize) -> &[(u32, T)] {
        &self.entries[self.starts[k]..self.starts[k + 1]]
    }

    /// By columns, of which there are so many.
    fn transposed(&self, columns: usize) -> Self {
        let mut rows = vec![Vec::new(); columns];
        for k in 0..self.starts.len() - 1 {
            for (column, value) in self.row(k) {
                rows[*column as usize].push((k as u32, *value));
            }
        }
        Self::new(rows.into_iter())
    }
}

impl Follower {
    /// The forces of a `traction` on that surface, which is normal to it, as they follow the surface; `gradient` gives the
    /// weights of the particles in the gradient of the displacement at a place. `None` if it acts nowhere.
    pub fn new(
        surface: &SurfaceQuadrature,
        traction: &Traction<'_>,
        gradient: impl Fn(&Vec3) -> Vec<(u32, Vec3)> + Sync,
    ) -> Option<Self> {
        let load = |cluster: &Cluster| {
            let free = Mat3::identity() - cluster.projector();
            Some(Loaded { pattern: surface.pattern(cluster, traction)?, free })
        };
        let loads: Vec<Option<Loaded>> = surface.clusters.par_iter().map(load).collect();
        let mut number = vec![u32::MAX; loads.len()];
        let mut clusters = Vec::new();
        let mut centres = Vec::new();
        for (c, loaded) in loads.into_iter().enumerate() {
            if let Some(loaded) = loaded {
                number[c] = clusters.len() as u32;
                clusters.push(loaded);
                centres.push(surface.clusters[c].centre);
            }
        }
        if clusters.is_empty() {
            return None;
        }
        let fits: Vec<Vec<(u32, Vec3)>> = centres.par_iter().map(&gradient).collect();
        let mut carried: Vec<(u32, u32, Carried)> = Vec::new();
        for (k, (a, x)) in surface.shares.particles.iter().enumerate() {
            let (particle, signs) = surface.particle(*a);
            for &(c, w) in surface.shares.of(k).iter().filter(|(c, _)| number[*c as usize] != u32::MAX) {
                let weight = surface.clusters[c as usize].monomials(x) * w;
                carried.push((particle, number[c as usize], Carried { weight, signs }));
            }
        }
        let mut particles: Vec<u32> = carried.iter().map(|pair| pair.0).collect();
        particles.extend(fits.iter().flatten().map(|pair| pair.0));
        particles.sort_unstable();
        particles.dedup();
        let place = |a: u32| particles.binary_search(&a).unwrap_or(0) as u32;
        let (n, m) = (clusters.len(), particles.len());
        let of = |row: Vec<(u32, Vec3)>| row.into_iter().map(|(a, g)| (place(a), g)).collect();
        let gradient = Links::new(fits.into_iter().map(of));
        let mut rows = vec![Vec::new(); m];
        for (a, c, carried) in carried {
            rows[place(a) as usize].push((c, carried));
        }
        let carry_of = Links::new(rows.into_iter());
        let mut follower = Self {
            gradient_of: gradient.transposed(m),
            gradient,
            carry: carry_of.transposed(n),
            carry_of,
            pattern: vec![Matrix4x3::zeros(); n],
            adjoint: vec![Mat3::zeros(); n],
            state: vec![Mat3::identity(); n],
            factor: 0.0,
            force: particles.into_iter().map(|a| (a, Vec3::zeros())).collect(),
            change: vec![Vec3::zeros(); m],
            clusters,
        };
        follower.follow(&[]);
        Some(follower)
    }

    /// The forces at factor 1 on particles in rising order, at the displacement that was followed last.
    pub fn forces(&self) -> &[(u32, Vec3)] {
        &self.force
    }

    /// Takes the forces of the displacement u, component by component; of the undeformed body if there is none.
    pub fn follow(&mut self, u: &[f64]) {
        let Self { clusters, gradient, carry_of, pattern, force, .. } = self;
        let particles = &*force;
        (&mut *pattern, &*clusters).into_par_iter().enumerate().with_min_len(TASK).for_each(
            |(c, (pattern, loaded))| {
                let f = Mat3::identity() + gradient_at(gradient.row(c), particles, u);
                *pattern = loaded.pattern * cofactor(&f).transpose() * loaded.free;
            },
        );
        force
            .par_iter_mut()
            .enumerate()
            .with_min_len(TASK)
            .for_each(|(k, (_, force))| *force = carried(carry_of.row(k), pattern));
    }

    /// Takes the displacement u, at which the load has that factor, as the state of the tangent.
    pub fn linearise(&mut self, factor: f64, u: &[f64]) {
        let Self { gradient, state, force, .. } = self;
        self.factor = factor;
        state.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(c, state)| {
            *state = Mat3::identity() + gradient_at(gradient.row(c), force, u);
        });
    }

    /// Leaves the load out of the tangent until the next state.
    pub fn leave_out(&mut self) {
        self.factor = 0.0;
    }

    /// Adds `scale` (D + D^T)/2 x to y, with D the derivative of the forces at the state of the tangent, of fields component by
    /// component.
    pub fn tangent(&mut self, scale: f64, x: &[f64], y: &mut [f64]) {
        if self.factor == 0.0 || scale == 0.0 {
            return;
        }
        let Self { clusters, gradient, gradient_of, carry, carry_of, pattern, adjoint, state, .. } = self;
        let (force, change) = (&self.force, &mut self.change);
        let n = x.len() / 3;
        let values = |k: u32| {
            let a = force[k as usize].0 as usize;
            Vec3::new(x[a], x[n + a], x[2 * n + a])
        };
        (&mut *pattern, &mut *adjoint, &*clusters, &*state)
            .into_par_iter()
            .enumerate()
            .with_min_len(TASK)
            .for_each(|(c, (pattern, adjoint, loaded, f))| {
                let g = gradient_at(gradient.row(c), force, x);
                *pattern = loaded.pattern * cofactor_change(f, &g).transpose() * loaded.free;
                let mut moments = Matrix4x3::zeros();
                for (k, Carried { weight, signs }) in carry.row(c) {
                    moments += weight * signs.component_mul(&values(*k)).transpose();
                }
                // tr(dcof(F)[G] A^T m P) = G : dcof(F)[P m^T A], as cof is the derivative of det.
                *adjoint = cofactor_change(f, &(loaded.free * moments.tr_mul(&loaded.pattern)));
            });
        change.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(k, change)| {
            *change = carried(carry_of.row(k), pattern);
            for (c, g) in gradient_of.row(k) {
                *change += adjoint[*c as usize] * g;
            }
        });
        let half = 0.5 * scale * self.factor;
        for ((a, _), change) in self.force.iter().zip(&self.change) {
            for i in 0..3 {
                y[i * n + *a as usize] += half * change[i];
            }
        }
    }
}

/// sum u (x) g over particles by their numbers in a list; zero if there is no u.
fn gradient_at(row: &[(u32, Vec3)], particles: &[(u32, Vec3)], u: &[f64]) -> Mat3 {
    let n = u.len() / 3;
    let mut gradient = Mat3::zeros();
    if n > 0 {
        for (k, g) in row {
            let a = particles[*k as usize].0 as usize;
            gradient += Vec3::new(u[a], u[n + a], u[2 * n + a]) * g.transpose();
        }
    }
    gradient
}

/// The force on a particle of the patterns of the clusters.
fn carried(row: &[(u32, Carried)], patterns: &[Matrix4x3<f64>]) -> Vec3 {
    let of = |(c, Carried { weight, signs }): &(u32, Carried)| {
        patterns[*c as usize].tr_mul(weight).component_mul(signs)
    };
    row.iter().map(of).sum()
}

/// cof(F) = det(F) F^-T.
pub fn cofactor(f: &Mat3) -> Mat3 {
    0.5 * cofactor_change(f, f)
}

/// The derivative of cof(F) along G.
fn cofactor_change(f: &Mat3, g: &Mat3) -> Mat3 {
    let column = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        f.column(j).cross(&g.column(k)) + g.column(j).cross(&f.column(k))
    };
    Mat3::from_columns(&[column(0), column(1), column(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cofactor_and_its_derivative_are_those_of_the_inverse() {
        let f = Mat3::new(1.2, 0.1, -0.3, 0.2, 0.9, 0.15, -0.05, 0.25, 1.1);
        let g = Mat3::new(0.3, -0.2, 0.1, 0.5, 0.4, -0.6, 0.2, 0.1, -0.35);
        let exact = f.determinant() * f.try_inverse().unwrap().transpose();
        assert!((cofactor(&f) - exact).amax() < 1e-14);
        let h = 1e-6;
        let numeric = (cofactor(&(f + g * h)) - cofactor(&(f - g * h))) / (2.0 * h);
        assert!((cofactor_change(&f, &g) - numeric).amax() < 1e-9);
    }
}
