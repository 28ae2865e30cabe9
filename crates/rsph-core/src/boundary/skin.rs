//! The surface of a body as its loads see it: small panels in clusters, each with one fit of the particles
//! around it.
//!
//! A force f at x goes to particle a as w_a(x) f, with the weights w_a(x) = p(x)^T M^-1 p(x_a) W_a of a linear
//! fit: they make the resultant and the moment of the forces on the particles those of f. One fit around the
//! middle of a cluster serves all of its points, because x enters by p(x) = (1, (x - c) / h) alone: what
//! a cluster hands on is sum f and sum (x - c) f^T, however many points it has. So the work of a load that
//! changes in every frame is one look at each panel and 12 products for each pair of a cluster and a particle.

use super::surface_load::{Panel, SurfacePoint, Traction, for_each_panel, three_points};
use crate::fit::LinearFit;
use crate::mesh::TriangleMesh;
use crate::particles::Column;
use crate::tensor::Vec3;
use nalgebra::{Matrix4, Matrix4x3, Vector4};
use rayon::prelude::*;
use std::collections::HashSet;
use std::fmt;
use std::ops::Range;

/// Longest edge of a panel, in spacings.
const EDGE: f64 = 0.5;
/// Edge of the cubes that a cluster's panels have their centres in, in spacings.
const CLUSTER: f64 = 1.0;
/// Fewest clusters or particles in a task.
const TASK: usize = 64;

/// Panels that share a fit.
#[derive(Clone, Debug)]
struct Cluster {
    panels: Range<usize>,
    centre: Vec3,
    h: f64,
    inverse: Matrix4<f64>,
}

/// What a cluster's load does: a force W_a (A^T p(x_a)) on each particle, if there is any.
type Pattern = Option<Matrix4x3<f64>>;

/// The surface of a body with the particles that carry its loads.
#[derive(Clone, Debug)]
pub struct Skin {
    panels: Vec<Panel>,
    corners: Vec<[Vec3; 3]>,
    clusters: Vec<Cluster>,
    shares: Shares,
}

/// The particles that carry loads.
#[derive(Clone, Copy)]
pub struct Carriers<'a> {
    /// Their places.
    pub positions: &'a [Vec3],
    /// Fits of them around a list of places.
    pub fits: &'a dyn Fn(&[Vec3]) -> Vec<LinearFit>,
}

impl fmt::Debug for Carriers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Carriers").field("positions", &self.positions.len()).finish_non_exhaustive()
    }
}

/// What each particle carries.
#[derive(Clone, Debug)]
struct Shares {
    /// Particles that carry anything, with their places.
    particles: Vec<(u32, Vec3)>,
    /// Clusters of the k-th of them with its weights W_a there: `pairs[starts[k]..starts[k + 1]]`.
    starts: Vec<usize>,
    pairs: Vec<(u32, f64)>,
}

impl Skin {
    /// The skin `surface` of particles `spacing` apart.
    pub fn new(surface: &TriangleMesh, spacing: f64, carriers: &Carriers<'_>) -> Self {
        Self::of_cells(surface, spacing, carriers, |_| true)
    }

    /// The clusters of the skin of which `reaches` holds for some panel: enough for one load, and a small part
    /// of the memory for one on a small part of a large body.
    pub fn reached(
        surface: &TriangleMesh,
        spacing: f64,
        carriers: &Carriers<'_>,
        reaches: &(dyn Fn(&Panel) -> bool + Sync),
    ) -> Self {
        let mut cells = HashSet::new();
        for_each_panel(surface, EDGE * spacing, |panel, _| {
            if reaches(&panel) {
                cells.insert(cell_of(&panel, spacing));
            }
        });
        Self::of_cells(surface, spacing, carriers, |cell| cells.contains(cell))
    }

    fn of_cells(
        surface: &TriangleMesh,
        spacing: f64,
        carriers: &Carriers<'_>,
        wanted: impl Fn(&[i64; 3]) -> bool,
    ) -> Self {
        // Sorted by number, and visited again for what they are: they are as many as particles of a large body.
        let mut sorted: Vec<([i64; 3], usize)> = Vec::new();
        for_each_panel(surface, EDGE * spacing, |panel, _| {
            let cell = cell_of(&panel, spacing);
            if wanted(&cell) {
                sorted.push((cell, sorted.len()));
            }
        });
        sorted.par_sort_unstable();
        let ranges: Vec<Range<usize>> = sorted
            .chunk_by(|a, b| a.0 == b.0)
            .scan(0, |end, chunk| {
                let start = *end;
                *end += chunk.len();
                Some(start..*end)
            })
            .collect();
        let mut place = vec![0; sorted.len()];
        for (k, (_, number)) in sorted.into_iter().enumerate() {
            place[number] = k;
        }
        let nowhere = SurfacePoint { x: Vec3::zeros(), normal: Vec3::zeros(), area: 0.0 };
        let mut panels = vec![Panel { centre: nowhere, edge: 0.0 }; place.len()];
        let mut corners = vec![[Vec3::zeros(); 3]; place.len()];
        let mut places = place.into_iter();
        for_each_panel(surface, EDGE * spacing, |panel, at| {
            if wanted(&cell_of(&panel, spacing))
                && let Some(k) = places.next()
            {
                (panels[k], corners[k]) = (panel, *at);
            }
        });
        let middle = |range: &Range<usize>| {
            let members = || panels[range.clone()].iter().map(|p| &p.centre);
            members().map(|p| p.x * p.area).sum::<Vec3>() / members().map(|p| p.area).sum::<f64>()
        };
        let middles: Vec<Vec3> = ranges.iter().map(middle).collect();
        let (clusters, weights): (Vec<Cluster>, Vec<Vec<(u32, f64)>>) = ranges
            .into_iter()
            .zip((carriers.fits)(&middles))
            .map(|(panels, fit)| {
                (Cluster { panels, centre: fit.centre, h: fit.h, inverse: fit.inverse }, fit.weights)
            })
            .unzip();
        Self { panels, corners, clusters, shares: Shares::new(&weights, carriers.positions) }
    }

    /// Forces of a traction on `particles` particles, component by component; `None` if it acts nowhere.
    pub fn force(&self, particles: usize, traction: &Traction<'_>) -> Option<Vec<f64>> {
        let patterns: Vec<Pattern> =
            self.clusters.par_iter().with_min_len(TASK).map(|c| self.pattern(c, traction)).collect();
        if patterns.iter().all(Option::is_none) {
            return None;
        }
        Some(self.carried(particles, &patterns))
    }

    /// Quadrature points of the surface, three on each panel.
    pub fn points(&self) -> Vec<SurfacePoint> {
        let mut points = Vec::with_capacity(3 * self.panels.len());
        for (panel, corners) in self.panels.iter().zip(&self.corners) {
            three_points(corners, &panel.centre.normal, panel.centre.area, &mut |p| points.push(*p));
        }
        points
    }

    /// Forces on `particles` particles, component by component, of forces at the [`Skin::points`].
    pub fn carry(&self, particles: usize, points: &[SurfacePoint], forces: &[Vec3]) -> Vec<f64> {
        let pattern = |cluster: &Cluster| {
            let mut sums = Sums::default();
            for k in 3 * cluster.panels.start..3 * cluster.panels.end {
                sums.add(cluster, &points[k].x, &forces[k]);
            }
            Some(sums.pattern(cluster))
        };
        let patterns: Vec<Pattern> = self.clusters.par_iter().with_min_len(TASK).map(pattern).collect();
        self.carried(particles, &patterns)
    }

    /// Values of a column of the particles at the [`Skin::points`], point by point.
    pub fn interpolate(&self, points: &[SurfacePoint], column: &Column) -> Vec<f64> {
        let components = column.components();
        let mut fits = vec![vec![Vector4::zeros(); components]; self.clusters.len()];
        for (k, (a, x)) in self.shares.particles.iter().enumerate() {
            for &(c, w) in self.shares.of(k) {
                let cluster = &self.clusters[c as usize];
                let p = cluster.monomials(x) * w;
                for (i, fit) in fits[c as usize].iter_mut().enumerate() {
                    *fit += p * column.component(i)[*a as usize];
                }
            }
        }
        let mut values = vec![0.0; components * points.len()];
        for (cluster, fit) in self.clusters.iter().zip(fits) {
            let fit: Vec<Vector4<f64>> = fit.into_iter().map(|f| cluster.inverse * f).collect();
            for k in 3 * cluster.panels.start..3 * cluster.panels.end {
                let p = cluster.monomials(&points[k].x);
                for (i, fit) in fit.iter().enumerate() {
                    values[components * k + i] = p.dot(fit);
                }
            }
        }
        values
    }

    /// Forces on the particles of the patterns of all clusters.
    fn carried(&self, particles: usize, patterns: &[Pattern]) -> Vec<f64> {
        let shares = &self.shares;
        let carried: Vec<Vec3> = (0..shares.particles.len())
            .into_par_iter()
            .with_min_len(TASK)
            .map(|k| {
                let x = &shares.particles[k].1;
                let mut force = Vec3::zeros();
                for &(c, w) in shares.of(k) {
                    if let Some(a) = &patterns[c as usize] {
                        let cluster = &self.clusters[c as usize];
                        let r = (x - cluster.centre) / cluster.h;
                        for i in 0..3 {
                            force[i] += w * (a[(0, i)] + a[(1, i)] * r.x + a[(2, i)] * r.y + a[(3, i)] * r.z);
                        }
                    }
                }
                force
            })
            .collect();
        let mut force = vec![0.0; 3 * particles];
        for ((a, _), f) in shares.particles.iter().zip(carried) {
            for i in 0..3 {
                force[i * particles + *a as usize] = f[i];
            }
        }
        force
    }

    /// A = M^-1 sum p(x) f^T over the points of a cluster.
    fn pattern(&self, cluster: &Cluster, traction: &Traction<'_>) -> Pattern {
        let mut sums = Sums::default();
        for k in cluster.panels.clone() {
            traction.on(&self.panels[k], &self.corners[k], |x, f| sums.add(cluster, x, f));
        }
        sums.loaded.then(|| sums.pattern(cluster))
    }
}

/// The cube that the centre of a panel lies in.
fn cell_of(panel: &Panel, spacing: f64) -> [i64; 3] {
    (panel.centre.x / (CLUSTER * spacing)).map(|x| x.floor() as i64).into()
}

impl Cluster {
    /// p(x) = (1, (x - c) / h).
    fn monomials(&self, x: &Vec3) -> Vector4<f64> {
        let r = (x - self.centre) / self.h;
        Vector4::new(1.0, r.x, r.y, r.z)
    }
}

/// Resultant and moments of the forces on a cluster.
#[derive(Default)]
struct Sums {
    force: Vec3,
    moments: [Vec3; 3],
    loaded: bool,
}

impl Sums {
    fn add(&mut self, cluster: &Cluster, x: &Vec3, f: &Vec3) {
        let r = (x - cluster.centre) / cluster.h;
        self.force += f;
        for (moment, r) in self.moments.iter_mut().zip(r.iter()) {
            *moment += f * *r;
        }
        self.loaded = true;
    }

    fn pattern(&self, cluster: &Cluster) -> Matrix4x3<f64> {
        let rows = [self.force, self.moments[0], self.moments[1], self.moments[2]].map(|v| v.transpose());
        cluster.inverse * Matrix4x3::from_rows(&rows)
    }
}

impl Shares {
    /// Those of clusters with these lists of (particle, weight), by particle.
    fn new(weights: &[Vec<(u32, f64)>], positions: &[Vec3]) -> Self {
        let n = positions.len();
        let mut end = vec![0_usize; n + 1];
        weights.iter().flatten().for_each(|(a, _)| end[*a as usize + 1] += 1);
        for a in 0..n {
            end[a + 1] += end[a];
        }
        let mut next = end.clone();
        let mut pairs = vec![(0, 0.0); end[n]];
        for (c, row) in weights.iter().enumerate() {
            for &(a, w) in row {
                pairs[next[a as usize]] = (c as u32, w);
                next[a as usize] += 1;
            }
        }
        let carries = || (0..n).filter(|&a| end[a + 1] > end[a]);
        Self {
            particles: carries().map(|a| (a as u32, positions[a])).collect(),
            starts: std::iter::once(0).chain(carries().map(|a| end[a + 1])).collect(),
            pairs,
        }
    }

    /// The clusters whose loads the k-th particle carries, with its weights there.
    fn of(&self, k: usize) -> &[(u32, f64)] {
        &self.pairs[self.starts[k]..self.starts[k + 1]]
    }
}
