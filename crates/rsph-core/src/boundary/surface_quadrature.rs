//! Quadrature over the surface of a body, with the weights of the particles at its points.
//!
//! A force f at x goes to particle a as w_a(x) f, with the weights w_a(x) = p(x)^T M^-1 p(x_a) W_a of a linear
//! fit: they make the resultant and the moment of the forces on the particles those of f. One fit around the
//! middle of a cluster serves all of its points, because x enters by p(x) = (1, (x - c) / h) alone: what
//! a cluster hands on is sum f and sum (x - c) f^T, however many points it has. So the work of a load that
//! changes in every frame is one look at each panel and 12 products for each pair of a cluster and a particle.
//! The same weights serve loads, clamps and the balance of the gradient with its surface.

use super::constraints::{Hold, projectors};
use super::fold::{Doubled, Folds};
use super::foundation::Springs;
use super::surface_load::{Panel, SurfacePoint, Traction, for_each_panel, three_points};
use crate::lattice::reflection;
use crate::mesh::TriangleMesh;
use crate::mls::LinearFit;
use crate::particles::Column;
use crate::sample::Sight;
use crate::setup::Foundation;
use crate::tensor::{Mat3, Vec3};
use nalgebra::{Matrix4, Matrix4x3, Vector4};
use rayon::prelude::*;
use std::collections::HashMap;
use std::fmt;
use std::ops::Range;

/// Longest edge of a panel, in spacings.
const EDGE: f64 = 0.5;
/// Edge of the cubes that a cluster's panels have their centres in, in spacings.
const CLUSTER: f64 = 1.0;
/// Longest edge of a panel at the rim of a held part, in spacings.
const EDGE_AT_RIM: f64 = 0.1;
/// Fewest clusters or particles in a task.
const TASK: usize = 64;
/// Height of the rim that stands for the surface of a body in the plane, in spacings: so little that no panel is split
/// along it.
const RIM: f64 = 1e-3;

/// The outline of a body in the plane as a surface: the upright faces of its slab of thickness one, pressed to a rim around
/// the plane. [`SurfaceQuadrature::new`] takes its panels to be in the plane and of height one.
pub fn rim(slab: &TriangleMesh, spacing: f64) -> TriangleMesh {
    let mut rim = slab.retain(|t| slab.normal(t).z.abs() < 0.5);
    for x in &mut rim.vertices {
        x.z *= RIM * spacing;
    }
    rim
}

/// Panels that share a fit.
#[derive(Clone, Debug)]
pub(super) struct Cluster {
    pub(super) panels: Range<usize>,
    pub(super) centre: Vec3,
    pub(super) h: f64,
    inverse: Matrix4<f64>,
    /// The inverse of the fit without images.
    pub(super) without_images: Matrix4<f64>,
    /// Mean outward normal.
    pub(super) normal: Vec3,
    /// Number of each boundary that holds it, with the projector on what it holds; none where it is free.
    pub(super) held: Vec<(usize, Mat3)>,
    /// Elastic foundations that it rests on, with their numbers.
    pub(super) springs: Vec<(usize, Springs)>,
}

impl Cluster {
    /// Projector on all that is held.
    pub(super) fn projector(&self) -> Mat3 {
        self.held.iter().map(|h| h.1).sum()
    }

    /// Whether it is part of a fold.
    pub(super) fn is_folded(&self, folds: &Folds) -> bool {
        self.held.iter().any(|h| folds.has(h.0))
    }
}

/// What a cluster's load does: a force W_a (A^T p(x_a)) on each particle, if there is any.
type Pattern = Option<Matrix4x3<f64>>;

/// The surface of a body in panels, with the particles around them.
#[derive(Clone, Debug)]
pub struct SurfaceQuadrature {
    pub(super) panels: Vec<Panel>,
    pub(super) corners: Vec<[Vec3; 3]>,
    pub(super) clusters: Vec<Cluster>,
    pub(super) shares: Shares,
    /// Number of particles.
    count: usize,
    /// Particle, diagonal of S and reflection of every image, numbered on from the particles.
    images: Vec<(u32, Vec3, Vec3)>,
}

/// The particles that carry loads.
#[derive(Clone, Copy)]
pub struct LoadedParticles<'a> {
    /// The particles, with images.
    pub particles: &'a Doubled,
    /// Fits of them around a list of places.
    pub fits: &'a dyn Fn(&[Vec3]) -> Vec<LinearFit>,
    /// What sees what across gaps of the surface, if it has any.
    pub sight: Option<&'a Sight>,
}

impl fmt::Debug for LoadedParticles<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LoadedParticles")
            .field("positions", &self.particles.positions.len())
            .finish_non_exhaustive()
    }
}

/// The boundaries that hold the surface at a point with that outward normal, a bit each; `None` where it is free.
pub type HeldPart<'a> = dyn Fn(&Vec3, &Vec3) -> Option<u32> + Sync + 'a;

/// What of a cluster's load acts on the body: its free components, if there are any.
fn acting(cluster: &Cluster, pattern: Matrix4x3<f64>) -> Pattern {
    if cluster.held.is_empty() {
        return Some(pattern);
    }
    let acting = pattern * (Mat3::identity() - cluster.projector());
    (acting != Matrix4x3::zeros()).then_some(acting)
}

/// What each particle carries.
#[derive(Clone, Debug)]
pub(super) struct Shares {
    /// Particles that carry anything, with their places.
    pub(super) particles: Vec<(u32, Vec3)>,
    /// Clusters of the k-th of them with its weights W_a there: `pairs[starts[k]..starts[k + 1]]`.
    starts: Vec<usize>,
    pairs: Vec<(u32, f64)>,
}

impl SurfaceQuadrature {
    /// The quadrature of `surface`, in the plane (`dimension` 2) of a [`rim`], for particles `spacing` apart, held by boundaries that hold as `holds` says; no cluster reaches from one held part to another,
    /// to where the surface is free, or across a gap.
    pub fn new(
        surface: &TriangleMesh,
        dimension: usize,
        spacing: f64,
        particles: &LoadedParticles<'_>,
        holds: &[Hold],
        held: &HeldPart<'_>,
    ) -> Self {
        // Smaller panels at the rim of a held part, of which a panel is all or nothing.
        let flat = |x: &Vec3| if dimension == 2 { Vec3::new(x.x, x.y, 0.0) } else { *x };
        let height = if dimension == 2 { RIM * spacing } else { 1.0 };
        let longest = |corners: &[Vec3; 3], normal: &Vec3| {
            let part = |x: &Vec3| held(&flat(x), normal);
            let cut = corners.iter().any(|x| part(x) != part(&corners[0]));
            if cut { EDGE_AT_RIM * spacing } else { EDGE * spacing }
        };
        // A place below the first panel of every cluster near a gap, by what its panels have in common.
        let mut firsts: HashMap<_, Vec<Vec3>> = HashMap::new();
        let mut cluster_of = |panel: &Panel| {
            let SurfacePoint { x, normal, .. } = &panel.centre;
            let x = flat(x);
            let cell: [i64; 3] = (x / (CLUSTER * spacing)).map(|x| x.floor() as i64).into();
            let held = held(&x, normal);
            let Some(sight) = particles.sight.filter(|sight| sight.is_near(&x)) else {
                return (held, cell, 0, 0);
            };
            // Walls that face each other never share the axis that their normals are nearest to.
            let axis = normal.iamax();
            let side = 1 + 2 * axis + usize::from(normal[axis] > 0.0);
            let home = sight.home(&x);
            let firsts = firsts.entry((held, cell, side)).or_default();
            let seen = firsts.iter().position(|first| !sight.is_blocked(first, &home));
            let group = seen.unwrap_or_else(|| {
                firsts.push(home);
                firsts.len() - 1
            });
            (held, cell, side, group)
        };
        // Sorted by number, and visited again for what they are: they are as many as particles of a large body.
        let mut sorted = Vec::new();
        for_each_panel(surface, longest, |panel, _| sorted.push((cluster_of(&panel), sorted.len())));
        sorted.par_sort_unstable();
        let clusters: Vec<(Option<u32>, Range<usize>)> = sorted
            .chunk_by(|a, b| a.0 == b.0)
            .scan(0, |end, chunk| {
                let start = *end;
                *end += chunk.len();
                Some((chunk[0].0.0, start..*end))
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
        for_each_panel(surface, longest, |panel, at| {
            if let Some(k) = places.next() {
                let SurfacePoint { x, normal, area } = panel.centre;
                let centre = SurfacePoint { x: flat(&x), normal, area: area / height };
                (panels[k], corners[k]) = (Panel { centre, ..panel }, at.each_ref().map(flat));
            }
        });
        let middle = |(_, range): &(Option<u32>, Range<usize>)| {
            let members = || panels[range.clone()].iter().map(|p| &p.centre);
            members().map(|p| p.x * p.area).sum::<Vec3>() / members().map(|p| p.area).sum::<f64>()
        };
        let normal = |range: &Range<usize>| {
            let areas = panels[range.clone()].iter().map(|p| p.centre.normal * p.centre.area);
            areas.sum::<Vec3>().try_normalize(0.0).unwrap_or_else(Vec3::zeros)
        };
        let middles: Vec<Vec3> = clusters.iter().map(middle).collect();
        let doubled = particles.particles;
        let count = doubled.positions.len() - doubled.images.len();
        let (clusters, weights): (Vec<Cluster>, Vec<Vec<(u32, f64)>>) = clusters
            .into_iter()
            .zip((particles.fits)(&middles))
            .map(|((held, panels), fit)| {
                let normal = normal(&panels);
                let held = held.map_or_else(Vec::new, |set| projectors(holds, set, &normal));
                let without_images = without_images(&fit, &doubled.positions, count);
                let LinearFit { centre, h, inverse, weights } = fit;
                (
                    Cluster { panels, centre, h, inverse, without_images, normal, held, springs: Vec::new() },
                    weights,
                )
            })
            .unzip();
        let images = doubled.images.iter();
        Self {
            panels,
            corners,
            clusters,
            shares: Shares::new(&weights, &doubled.positions),
            count,
            images: images.map(|(a, set)| (*a, doubled.signs[*set as usize], reflection(*set))).collect(),
        }
    }

    /// The same surface on those foundations, whose regions are enlarged by `tolerance`; folds hold where they are.
    #[must_use]
    pub fn on_foundations(mut self, foundations: &[Foundation], tolerance: f64, folds: &Folds) -> Self {
        let mut clusters = std::mem::take(&mut self.clusters);
        for cluster in clusters.iter_mut().filter(|cluster| !cluster.is_folded(folds)) {
            for (i, foundation) in foundations.iter().enumerate() {
                let springs = foundation.on(&self, cluster, tolerance);
                cluster.springs.extend(springs.map(|springs| (i, springs)));
            }
        }
        self.clusters = clusters;
        self
    }

    /// Whether any of the surface rests on that foundation.
    pub fn rests_on(&self, foundation: usize) -> bool {
        self.clusters.iter().flat_map(|cluster| &cluster.springs).any(|(i, _)| *i == foundation)
    }

    /// int w_a n dS over the whole surface but `folds`, component by component: the area vectors that the surface wants of
    /// each of `particles` particles.
    pub fn area_vectors(&self, particles: usize, folds: &Folds) -> Vec<f64> {
        let pattern = |cluster: &Cluster| {
            if cluster.is_folded(folds) {
                return None;
            }
            let mut sums = Sums::default();
            for panel in &self.panels[cluster.panels.clone()] {
                let SurfacePoint { x, normal, area } = &panel.centre;
                sums.add(cluster, x, &(normal * *area));
            }
            Some(sums.pattern(cluster))
        };
        let patterns: Vec<Pattern> = self.clusters.par_iter().with_min_len(TASK).map(pattern).collect();
        self.carried(particles, &patterns, |(_, _, reflection)| *reflection)
    }

    /// Forces of a traction on `particles` particles, component by component; `None` if it acts nowhere. Of a traction
    /// on a held part only free components act on the body.
    pub fn force(&self, particles: usize, traction: &Traction<'_>) -> Option<Vec<f64>> {
        let pattern = |c: &Cluster| acting(c, self.pattern(c, traction)?);
        let patterns: Vec<Pattern> = self.clusters.par_iter().with_min_len(TASK).map(pattern).collect();
        if patterns.iter().all(Option::is_none) {
            return None;
        }
        Some(self.carried(particles, &patterns, |(_, sign, _)| *sign))
    }

    /// Quadrature points of the surface, three on each panel.
    pub fn points(&self) -> Vec<SurfacePoint> {
        let mut points = Vec::with_capacity(3 * self.panels.len());
        for k in 0..self.panels.len() {
            self.three_points_of(k, |p| points.push(*p));
        }
        points
    }

    /// Visits the quadrature points of a panel.
    pub(super) fn three_points_of(&self, panel: usize, mut visit: impl FnMut(&SurfacePoint)) {
        let centre = &self.panels[panel].centre;
        three_points(&self.corners[panel], &centre.normal, centre.area, &mut visit);
    }

    /// Forces on `particles` particles, component by component, of forces at the [`SurfaceQuadrature::points`]; on a held
    /// part only their free components.
    pub fn carry(&self, particles: usize, points: &[SurfacePoint], forces: &[Vec3]) -> Vec<f64> {
        let pattern = |cluster: &Cluster| {
            let mut sums = Sums::default();
            for k in 3 * cluster.panels.start..3 * cluster.panels.end {
                sums.add(cluster, &points[k].x, &forces[k]);
            }
            acting(cluster, sums.pattern(cluster))
        };
        let patterns: Vec<Pattern> = self.clusters.par_iter().with_min_len(TASK).map(pattern).collect();
        self.carried(particles, &patterns, |(_, sign, _)| *sign)
    }

    /// Values of a column of the particles at the [`SurfaceQuadrature::points`], point by point.
    pub fn interpolate(&self, points: &[SurfacePoint], column: &Column) -> Vec<f64> {
        let components = column.components();
        let mut fits = vec![vec![Vector4::zeros(); components]; self.clusters.len()];
        let particles = self.shares.particles.iter().enumerate();
        for (k, (a, x)) in particles.filter(|(_, (a, _))| !self.is_image(*a)) {
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
            let fit: Vec<Vector4<f64>> = fit.into_iter().map(|f| cluster.without_images * f).collect();
            for k in 3 * cluster.panels.start..3 * cluster.panels.end {
                let p = cluster.monomials(&points[k].x);
                for (i, fit) in fit.iter().enumerate() {
                    values[components * k + i] = p.dot(fit);
                }
            }
        }
        values
    }

    /// Whether a number among those that carry loads is that of an image.
    pub(super) fn is_image(&self, a: u32) -> bool {
        a as usize >= self.count
    }

    /// Forces on the particles of the patterns of all clusters; those on images go to their particles with these signs.
    fn carried(
        &self,
        particles: usize,
        patterns: &[Pattern],
        signs: impl Fn(&(u32, Vec3, Vec3)) -> Vec3,
    ) -> Vec<f64> {
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
            let image = (*a as usize).checked_sub(self.count).map(|k| &self.images[k]);
            let (a, f) = image.map_or((*a, f), |image| (image.0, f.component_mul(&signs(image))));
            for i in 0..3 {
                force[i * particles + a as usize] += f[i];
            }
        }
        force
    }

    /// The particle of a number among those that carry loads, with the signs of its image if it is one.
    pub(super) fn particle(&self, a: u32) -> (u32, Vec3) {
        let image = (a as usize).checked_sub(self.count).map(|k| &self.images[k]);
        image.map_or((a, Vec3::repeat(1.0)), |(a, signs, _)| (*a, *signs))
    }

    /// A = M^-1 sum p(x) f^T over the points of a cluster.
    pub(super) fn pattern(&self, cluster: &Cluster, traction: &Traction<'_>) -> Pattern {
        let mut sums = Sums::default();
        for k in cluster.panels.clone() {
            traction.on(&self.panels[k], &self.corners[k], |x, f| sums.add(cluster, x, f));
        }
        sums.loaded.then(|| sums.pattern(cluster))
    }
}

/// M^-1 of a fit without points from number `count` on; that of the fit if they leave none.
fn without_images(fit: &LinearFit, positions: &[Vec3], count: usize) -> Matrix4<f64> {
    let is_image = |(a, _): &(u32, f64)| *a as usize >= count;
    if !fit.weights.iter().any(is_image) {
        return fit.inverse;
    }
    let of = |(a, w): &(u32, f64)| {
        let p = fit.basis(&positions[*a as usize]);
        p * p.transpose() * *w
    };
    let sum: Matrix4<f64> = fit.weights.iter().filter(|pair| !is_image(pair)).map(of).sum();
    sum.try_inverse().unwrap_or(fit.inverse)
}

impl Cluster {
    /// p(x) = (1, (x - c) / h).
    pub(super) fn monomials(&self, x: &Vec3) -> Vector4<f64> {
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
    /// Shares of clusters with these lists of (particle, weight), by particle.
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
    pub(super) fn of(&self, k: usize) -> &[(u32, f64)] {
        &self.pairs[self.starts[k]..self.starts[k + 1]]
    }
}
