//! What parts of a body see each other: the surface may face itself across a gap (a fissure, a slit, a lumen, the space between two
//! bodies) that is narrower than a kernel reaches, and nothing acts across it.
//!
//! Two places inside see each other unless the way from one to the other leaves the body through one part of the surface and comes back
//! through another that faces it, or that bounds another body. (T. Belytschko, Y. Y. Lu, L. Gu, Int. J. Numer. Meth. Eng. 37, 1994: the
//! visibility criterion.) A way around an edge or a shallow hollow leaves the body too, but through surfaces that do not face each other.

use crate::grid::Grid;
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use crate::winding::TriangleTree;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::TriMesh;
use rayon::prelude::*;
use std::collections::HashMap;
use std::fmt;

/// How far, in spacings, a sum or a fit reaches across a gap.
const REACH: usize = 4;
/// Cosine of the angle of two normals below which parts of the surface face each other: walls of a notch that opens by less than 60 degrees.
const FACING: f64 = -0.5;
/// Width, in spacings, below which two parts of the surface touch: there is no gap between them.
const TOUCHING: f64 = 1e-6;
/// Distance between the places on the surface that look for a part that faces them, in spacings.
const LOOKOUT: f64 = 0.5;
/// Depth, in spacings, at which a place on the surface counts as inside.
const DEPTH: f64 = 0.01;

/// Where two parts of the surface face each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// The middle between them.
    pub place: Vec3,
    /// Their distance along the normal of one of them.
    pub width: f64,
}

/// What parts of a body see each other.
#[derive(Clone)]
pub struct Sight {
    /// The lattice of the body, extended by [`REACH`] cells.
    grid: Grid,
    /// Whether a gap lies within reach of each of its cells.
    near: Vec<bool>,
    /// Whether each of its cells may hold tissue of both sides of a gap.
    both_sides: Vec<bool>,
    tree: TriangleTree,
    /// Outward normal of each triangle, and the part of the surface that it belongs to.
    triangles: Vec<(Vec3, usize)>,
    nearest: TriMesh,
    /// Where the tissue of cells is whose centre does not stand for it.
    homes: HashMap<usize, Vec3>,
    narrowest: Gap,
    /// The axis that the normals at gaps are nearest to.
    axis: usize,
}

impl fmt::Debug for Sight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Sight").field("narrowest", &self.narrowest).finish_non_exhaustive()
    }
}

impl Sight {
    /// Of a body with this closed `surface` on that lattice; `None` if no part of it faces another within reach.
    pub fn new(surface: &TriangleMesh, lattice: &Grid) -> Option<Self> {
        let dx = lattice.spacing;
        let (part, _) = surface.component_of_triangles();
        let triangles: Vec<(Vec3, usize)> =
            part.iter().enumerate().map(|(t, part)| (surface.normal(t), *part)).collect();
        let tree = TriangleTree::new(surface);
        let gaps: Vec<(Gap, Vec3)> = (0..surface.triangles.len())
            .into_par_iter()
            .flat_map_iter(|t| {
                let normal = triangles[t].0;
                let along = normal * (REACH as f64 * dx);
                let (tree, triangles) = (&tree, &triangles);
                lookouts(&surface.corners(t), LOOKOUT * dx).into_iter().filter_map(move |x| {
                    let mut first = 1.0;
                    tree.passages(&x, &along, usize::MAX, |other, at| {
                        let faces = triangles[other].0.dot(&normal) < FACING;
                        if faces && at * REACH as f64 > TOUCHING && at < first {
                            first = at;
                        }
                    });
                    let gap = Gap { place: x + 0.5 * first * along, width: first * along.norm() };
                    (first < 1.0).then_some((gap, normal))
                })
            })
            .collect();
        let narrowest = gaps.iter().map(|gap| gap.0).min_by(|a, b| a.width.total_cmp(&b.width))?;
        let narrow = gaps.iter().filter(|(gap, _)| gap.width < dx);
        let axis = narrow.map(|(_, normal)| normal.component_mul(normal)).sum::<Vec3>().imax();
        let grid = Grid {
            origin: lattice.origin - Vec3::repeat(REACH as f64 * dx),
            spacing: dx,
            cells: lattice.cells.map(|n| n + 2 * REACH),
        };
        let around = |gaps: &mut dyn Iterator<Item = &(Gap, Vec3)>, reach: usize| {
            let mut cells = vec![false; grid.len()];
            for c in gaps.filter_map(|(gap, _)| grid.cell_at(&gap.place)) {
                cells[c] = true;
            }
            widen(&grid, &mut cells, reach);
            cells
        };
        let near = around(&mut gaps.iter(), REACH);
        let both_sides = around(&mut gaps.iter().filter(|(gap, _)| gap.width < dx), 1);
        let vertices = surface.vertices.iter().map(|v| Vector::new(v.x, v.y, v.z)).collect();
        let nearest = TriMesh::new(vertices, surface.triangles.clone()).ok()?;
        Some(Self {
            grid,
            near,
            both_sides,
            tree,
            triangles,
            nearest,
            homes: HashMap::new(),
            narrowest,
            axis,
        })
    }

    /// The narrowest gap that was found.
    pub fn narrowest(&self) -> Gap {
        self.narrowest
    }

    /// The axis that the normals at gaps narrower than a spacing are nearest to.
    pub(super) fn axis(&self) -> usize {
        self.axis
    }

    /// Whether a gap lies within reach of a place.
    pub fn is_near(&self, x: &Vec3) -> bool {
        self.grid.cell_at(x).is_some_and(|c| self.near[c])
    }

    /// Whether the cell around a place may hold tissue of both sides of a gap: lines through it may miss a narrow one.
    pub(super) fn may_part(&self, x: &Vec3) -> bool {
        self.grid.cell_at(x).is_some_and(|c| self.both_sides[c])
    }

    /// Lets the cell around `centre` stand for tissue at `home`.
    pub(super) fn set_home(&mut self, centre: &Vec3, home: Vec3) {
        if let Some(c) = self.grid.cell_at(centre) {
            self.homes.insert(c, home);
        }
    }

    /// The place inside the body that a place stands for: itself, or for one that is on the surface or outside a place just below the
    /// nearest part of the surface. The centre of a cell stands for the tissue in it.
    pub fn home(&self, x: &Vec3) -> Vec3 {
        let Some(c) = self.grid.cell_at(x).filter(|c| self.near[*c]) else { return *x };
        if let Some(home) = self.homes.get(&c) {
            let [nx, ny, _] = self.grid.cells;
            let centre = self.grid.centre([c % nx, c / nx % ny, c / (nx * ny)]);
            if (centre - x).norm() < TOUCHING * self.grid.spacing {
                return *home;
            }
        }
        let p = Vector::new(x.x, x.y, x.z);
        let (projection, (triangle, _)) = self.nearest.project_local_point_and_get_location(p, false);
        let foot = Vec3::new(projection.point.x, projection.point.y, projection.point.z);
        let normal = self.triangles.get(triangle as usize).map_or_else(Vec3::zeros, |t| t.0);
        let depth = DEPTH * self.grid.spacing;
        if (x - foot).dot(&normal) < -depth { *x } else { foot - normal * depth }
    }

    /// Whether a gap lies between two places inside the body.
    pub fn is_blocked(&self, a: &Vec3, b: &Vec3) -> bool {
        let along = b - a;
        let mut passages: Vec<(f64, usize)> = Vec::new();
        self.tree.passages(a, &along, usize::MAX, |t, at| passages.push((at, t)));
        passages.sort_unstable_by(|x, y| x.0.total_cmp(&y.0));
        let touching = TOUCHING * self.grid.spacing / along.norm();
        let mut left: Option<(f64, usize)> = None;
        for (at, t) in passages {
            let (normal, part) = self.triangles[t];
            if normal.dot(&along) > 0.0 {
                left = Some((at, t));
            } else if let Some((before, out)) = left {
                let (other, of) = self.triangles[out];
                if at - before > touching && (of != part || other.dot(&normal) < FACING) {
                    return true;
                }
                left = None;
            }
        }
        false
    }

    /// Where the way from one place to another passes through the surface, from 0 to 1, and whether it leaves the body there.
    pub(super) fn passages(&self, a: &Vec3, b: &Vec3) -> Vec<(f64, bool)> {
        let along = b - a;
        let mut passages: Vec<(f64, bool)> = Vec::new();
        self.tree.passages(a, &along, usize::MAX, |t, at| {
            passages.push((at, self.triangles[t].0.dot(&along) > 0.0));
        });
        passages.sort_unstable_by(|x, y| x.0.total_cmp(&y.0));
        passages
    }
}

/// Places on a triangle, about that far apart.
fn lookouts([a, b, c]: &[Vec3; 3], apart: f64) -> Vec<Vec3> {
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let n = (longest / apart).ceil().clamp(1.0, 4096.0) as usize;
    let mut places = Vec::with_capacity(n * n);
    let at = |i: f64, j: f64| a + ((b - a) * i + (c - a) * j) / n as f64;
    for i in 0..n {
        for j in 0..n - i {
            let (i, j) = (i as f64, j as f64);
            places.push(at(i + 1.0 / 3.0, j + 1.0 / 3.0));
            if i + j + 1.5 < n as f64 {
                places.push(at(i + 2.0 / 3.0, j + 2.0 / 3.0));
            }
        }
    }
    places
}

/// Adds the cells within `reach` along every axis.
fn widen(grid: &Grid, near: &mut [bool], reach: usize) {
    let mut stride = 1;
    for n in grid.cells {
        let narrow = near.to_vec();
        for (c, _) in narrow.iter().enumerate().filter(|(_, near)| **near) {
            let at = c / stride % n;
            for other in at.saturating_sub(reach)..=(at + reach).min(n - 1) {
                near[c + other * stride - at * stride] = true;
            }
        }
        stride *= n;
    }
}
