//! A solid body from a surface that is none: open, overlapping, crossing itself, turned the wrong way in parts.
//!
//! The inside is where the generalised winding number is above one half. What the surface does not say
//! is not hidden: [`Repair`] has its figures.

mod layers;
mod level;
mod lines;
mod notes;
mod parts;
mod sides;

use crate::grid::Bounds;
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use crate::winding::{TriangleTree, WindingField};
use level::{LEVEL, MOST_CELLS, Sampled, affordable_cells, lattice};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;
use parts::Parts;
use rayon::prelude::*;
use sides::wrong_parts;

/// Pieces of the found surface with less of the body's volume than this are dropped, voids filled.
const LEAST_PIECE: f64 = 0.01;
/// More of the body may not be uncertain.
const MOST_UNCERTAIN: f64 = 0.4;
/// Winding numbers from here to the level, and from the level to one less this, are uncertain.
const DOUBT: f64 = 0.25;

/// How a surface that was not closed became a body, and how sure that is.
#[derive(Clone, Debug, PartialEq)]
pub struct Repair {
    /// Edges that were not shared by exactly two triangles turned the same way.
    pub open_edges: usize,
    /// Parts of the surface: triangles that hang together by edges which no third one shares.
    pub parts: usize,
    /// Edge length of the cells on which the inside was looked for.
    pub spacing: f64,
    /// Volume of the body: where the winding number is above 1/2.
    pub volume: f64,
    /// Volume where the winding number is above 3/4, and where it is above 1/4, within the bounds of the surface.
    pub between: [f64; 2],
    /// Share of the body where its winding number is below 3/4.
    pub uncertain: f64,
    /// Share of the body where its winding number is above 3/2: solids overlap.
    pub overlapping: f64,
    /// Share of the area of the given surface that lies on another part of it.
    pub layered: f64,
    /// Share of the body's surface that is farther than `spacing` from every given triangle.
    pub made_up: f64,
    /// The point of the body's surface that is farthest from every given triangle: the middle of the widest gap.
    pub gap_at: Vec3,
    /// Its distance.
    pub gap: f64,
    /// Pieces and voids too small to be kept: their number and volume.
    pub dropped: (usize, f64),
}

/// What can be made of a surface.
pub(super) enum Found {
    Body(TriangleMesh, Repair),
    /// Nowhere is the winding number above one half.
    Nothing,
    /// So much of the body is uncertain.
    Doubtful(f64),
}

/// A surface in parts that are turned outward, and what was done for that, one sentence each.
pub(super) fn outward(surface: &TriangleMesh, name: &str) -> (Parts, Vec<String>) {
    let mut parts = Parts::of(surface);
    let wrong = parts.mesh.bounds().map_or_else(Vec::new, |b| wrong_parts(&parts, layer_reach(&b)));
    parts.turn(&wrong);
    let notes = notes::of_parts(&parts, &wrong, name);
    (parts, notes)
}

/// Sheets nearer than this lie on each other: what the finest lattice can not tell apart.
fn layer_reach(bounds: &Bounds) -> f64 {
    lattice(bounds, MOST_CELLS).spacing
}

/// The winding number by which the inside of a surface is found that is not closed: its parts turned outward, sheets that
/// lie on each other counted once. `None` for a surface without triangles.
///
/// # Panics
/// When a triangle names a vertex that is not there.
pub fn winding_field(surface: &TriangleMesh) -> Option<WindingField> {
    let (parts, _) = outward(&surface.merged(), "");
    Some(field_of(&parts, &parts.mesh.bounds()?).0)
}

/// The field of parts that are turned outward, and the weights of their triangles.
fn field_of(parts: &Parts, bounds: &Bounds) -> (WindingField, Vec<f64>) {
    let weights = layers::weights(parts, &TriangleTree::new(&parts.mesh), layer_reach(bounds));
    (WindingField::new(&parts.mesh, &weights), weights)
}

/// The body inside of parts that are turned outward.
pub(super) fn repaired(parts: &Parts) -> Found {
    let Some(bounds) = parts.mesh.bounds() else { return Found::Nothing };
    let (field, weights) = field_of(parts, &bounds);
    let sampled = Sampled::new(&field, lattice(&bounds, affordable_cells(&field, &bounds)));
    let inside = sampled.volume_above(LEVEL);
    let between = [sampled.volume_above(1.0 - DOUBT), sampled.volume_above(DOUBT)];
    let uncertain = (inside - between[0]) / inside;
    if uncertain > MOST_UNCERTAIN {
        return Found::Doubtful(uncertain);
    }
    let (surface, dropped) = without_crumbs(&sampled.surface());
    let spacing = sampled.grid.spacing;
    let volume = surface.volume();
    let Some((made_up, gap_at, gap)) = far_from(&parts.mesh, &surface, spacing).filter(|_| volume > 0.0)
    else {
        return Found::Nothing;
    };
    let in_layers = (0..weights.len()).filter(|&t| weights[t] < 1.0);
    let layered = in_layers.fold(0.0, |sum, t| sum + parts.mesh.triangle_area(t));
    let repair = Repair {
        open_edges: parts.mesh.open_edges().len(),
        parts: parts.count(),
        spacing,
        volume,
        between,
        uncertain,
        overlapping: sampled.volume_above(1.0 + LEVEL) / inside,
        layered: layered / parts.mesh.area(),
        made_up,
        gap_at,
        gap,
        dropped,
    };
    Found::Body(surface, repair)
}

/// The surface without pieces and voids of less than [`LEAST_PIECE`] of its volume; their number and volume.
fn without_crumbs(surface: &TriangleMesh) -> (TriangleMesh, (usize, f64)) {
    let (piece_of, volumes) = surface.component_volumes();
    let least = LEAST_PIECE * volumes.iter().copied().fold(0.0, f64::max);
    let small: Vec<f64> = volumes.iter().copied().filter(|v| v.abs() < least).collect();
    let kept = surface.retain(|t| volumes[piece_of[t]].abs() >= least);
    (kept, (small.len(), small.iter().fold(0.0, |sum, v| sum + v.abs())))
}

/// Share of a surface that is farther than `reach` from the given one, and the farthest vertex with its distance.
fn far_from(given: &TriangleMesh, surface: &TriangleMesh, reach: f64) -> Option<(f64, Vec3, f64)> {
    let vertices = given.vertices.iter().map(|v| Vector::new(v.x, v.y, v.z)).collect();
    let given = TriMesh::new(vertices, given.triangles.clone()).ok()?;
    let distance = |v: &Vec3| {
        let p = Vector::new(v.x, v.y, v.z);
        (given.project_local_point(p, false).point - p).length()
    };
    let distances: Vec<f64> = surface.vertices.par_iter().map(distance).collect();
    let far =
        |t: &usize| surface.triangles[*t].iter().map(|&v| distances[v as usize]).sum::<f64>() > 3.0 * reach;
    let far = (0..surface.triangles.len()).filter(far).fold(0.0, |sum, t| sum + surface.triangle_area(t));
    let farthest = (0..distances.len()).max_by(|&a, &b| distances[a].total_cmp(&distances[b]))?;
    Some((far / surface.area(), surface.vertices[farthest], distances[farthest]))
}
