//! From a load to the forces on the particles.

use crate::boundary::body_force::body_force;
use crate::boundary::flat_face::Face;
use crate::boundary::nodal_load::NodalLoad;
use crate::boundary::patch::Patch;
use crate::boundary::surface_load::{Skin, SurfacePoint, graded_quadrature};
use crate::boundary::tag::no_particle;
use crate::error::InvalidInput;
use crate::mls::PointWeights;
use crate::region::Region;
use crate::setup::{Load, LoadKind};
use crate::shape::Shape;
use crate::tensor::Vec3;

/// Longest triangle edge of the surface quadrature, in spacings.
const RESOLUTION: f64 = 0.5;
/// The same where the rim of a region cuts a triangle, of which all or nothing is loaded.
const RESOLUTION_AT_RIM: f64 = 0.02;

/// The body as loads see it.
#[derive(Debug)]
pub struct LoadedBody<'a> {
    /// Shape with its surface.
    pub shape: &'a dyn Shape,
    /// Masses.
    pub mass: &'a [f64],
    /// Undeformed positions.
    pub positions: &'a [Vec3],
    /// Area vectors.
    pub area_vectors: &'a [Vec3],
    /// Spacing dx.
    pub spacing: f64,
    /// Depth below a flat face over which its area vectors spread.
    pub face_depth: f64,
    /// Largest relative deviation of their sum from the area of the face.
    pub face_tolerance: f64,
    /// Tolerance of regions (a length).
    pub tolerance: f64,
    /// The surface's quadrature, if it is kept.
    pub skin: Option<&'a Skin>,
}

/// Longest triangle edge of the surface quadrature at that spacing.
pub fn quadrature_edge(spacing: f64) -> f64 {
    RESOLUTION * spacing
}

/// The forces of every load; `weights` gives moving-least-squares weights at a list of points.
///
/// # Errors
/// `load[i]...` when a load acts on nothing.
pub fn nodal_loads(
    loads: &[Load],
    body: &LoadedBody<'_>,
    weights: impl Fn(&[Vec3]) -> PointWeights,
) -> Result<Vec<NodalLoad>, InvalidInput> {
    let edge = quadrature_edge(body.spacing);
    let on_surface = |i: usize, points: &[SurfacePoint], traction: &dyn Fn(&SurfacePoint) -> Vec3| {
        let loaded: Vec<(Vec3, Vec3)> = points
            .iter()
            .map(|p| (p.x, traction(p) * p.area))
            .filter(|(_, f)| f.norm_squared() > 0.0)
            .collect();
        if loaded.is_empty() {
            return Err(InvalidInput::new(
                format!("load[{i}]"),
                "(this load)",
                "acts on no part of the surface",
                "check the region or centre, the direction and the signs; the surface lies within the \
                 body's bounding box",
            ));
        }
        let (x, f): (Vec<Vec3>, Vec<Vec3>) = loaded.into_iter().unzip();
        let mut force = vec![0.0; 3 * body.mass.len()];
        weights(&x).spread(&f, &mut force);
        Ok(force)
    };
    // A uniform traction on whole flat faces, or any other on the triangles.
    let on_region = |i: usize, region: &Region, traction: &dyn Fn(&Vec3) -> Vec3| {
        flat_faces(body, region, traction).map_or_else(
            || {
                let loaded = |x: &Vec3, n: &Vec3| region.contains_on_surface(x, n, body.tolerance);
                let points = graded_quadrature(body.shape.surface(), &|corners, n| {
                    let cut = corners.iter().any(|x| loaded(x, n) != loaded(&corners[0], n));
                    if cut { RESOLUTION_AT_RIM * body.spacing } else { edge }
                });
                on_surface(i, &points, &|p| {
                    if loaded(&p.x, &p.normal) { traction(&p.normal) } else { Vec3::zeros() }
                })
            },
            Ok,
        )
    };
    loads
        .iter()
        .enumerate()
        .map(|(i, load)| {
            let force = match &load.kind {
                // A baseline without load is a load of zero, wherever it acts.
                kind if kind.is_zero() => Ok(vec![0.0; 3 * body.mass.len()]),
                LoadKind::Traction { region, traction } => on_region(i, region, &|_| *traction),
                LoadKind::Pressure { region, pressure } => on_region(i, region, &|n| -*pressure * n),
                LoadKind::BodyForce { region, acceleration } => {
                    body_force(body.mass, body.positions, region, acceleration, body.tolerance)
                        .ok_or_else(|| no_particle(&format!("load[{i}].region"), region, body.positions))
                }
                LoadKind::Patch { pressure, centre, radius, direction } => {
                    let patch = Patch::on(body.shape.surface(), *pressure, centre, *radius, direction);
                    if let Some(skin) = body.skin.filter(|s| patch.is_resolved_by(s.edge)) {
                        let force = skin.force(body.mass.len(), &|p| patch.traction(p));
                        if force.iter().any(|f| *f != 0.0) {
                            return Ok(NodalLoad { force, ramp: load.ramp });
                        }
                    }
                    // A patch may be smaller than the particles.
                    let points = graded_quadrature(body.shape.surface(), &|corners, _| {
                        patch.resolution(edge, corners)
                    });
                    on_surface(i, &points, &|p| patch.traction(p))
                }
            }?;
            Ok(NodalLoad { force, ramp: load.ramp })
        })
        .collect()
}

/// Forces of a uniform traction on whole flat faces of a box by its area vectors; `None` where that
/// does not apply.
fn flat_faces(body: &LoadedBody<'_>, region: &Region, traction: &dyn Fn(&Vec3) -> Vec3) -> Option<Vec<f64>> {
    if !body.shape.is_box() {
        return None;
    }
    let bounds = body.shape.bounds();
    let faces = Face::whole_faces(&bounds, region, body.tolerance).filter(|f| !f.is_empty())?;
    let n = body.mass.len();
    let mut force = vec![0.0; 3 * n];
    for face in faces {
        let traction = traction(&face.normal());
        let shares = face.shares(&bounds, body)?;
        for (a, share) in shares.into_iter().enumerate() {
            for i in 0..3 {
                force[i * n + a] += traction[i] * share;
            }
        }
    }
    Some(force)
}
