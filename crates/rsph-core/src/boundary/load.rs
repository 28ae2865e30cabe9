//! From a load to the forces on the particles.

use crate::boundary::body_force::body_force;
use crate::boundary::flat_face::Face;
use crate::boundary::nodal_load::NodalLoad;
use crate::boundary::patch::Patch;
use crate::boundary::skin::{Carriers, Skin};
use crate::boundary::surface_load::{SurfacePoint, Traction};
use crate::boundary::tag::no_particle;
use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::region::Region;
use crate::setup::{Load, LoadKind};
use crate::shape::Shape;
use crate::tensor::Vec3;

/// Longest triangle edge of the surface quadrature, in spacings, where the rim of a region cuts a triangle, of which all or nothing is loaded.
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
}

/// Forces on the particles of a load, by its number, that is a traction on the triangles.
type OnSurface<'a> = dyn FnMut(usize, &Traction<'_>) -> Result<Vec<f64>, InvalidInput> + 'a;

/// The forces of every load. Where there is a place for the `skin` it is made of `carriers` when the first load
/// needs it; if not, a single load makes what it reaches.
///
/// # Errors
/// `load[i]...` when a load acts on nothing.
pub fn nodal_loads(
    loads: &[Load],
    body: &LoadedBody<'_>,
    skin: Option<&mut Option<Skin>>,
    carriers: &Carriers<'_>,
) -> Result<Vec<NodalLoad>, InvalidInput> {
    let (surface, n) = (body.shape.surface(), body.mass.len());
    let mut shared = None;
    let mut skin = skin.or_else(|| (loads.len() > 1).then_some(&mut shared));
    let mut on_surface = |i: usize, traction: &Traction<'_>| {
        let force = match &mut skin {
            Some(kept) => {
                kept.get_or_insert_with(|| Skin::new(surface, body.spacing, carriers)).force(n, traction)
            }
            None => Skin::reached(surface, body.spacing, carriers, traction.reaches).force(n, traction),
        };
        force.ok_or_else(|| {
            let Bounds { min, max } = body.shape.bounds();
            let place = |v: &Vec3| format!("({:.4}, {:.4}, {:.4})", v.x, v.y, v.z);
            InvalidInput::new(
                format!("load[{i}]"),
                "(this load)",
                format!(
                    "acts on no part of the surface, which lies between {} and {}",
                    place(&min),
                    place(&max)
                ),
                "check the region or centre, its units, the direction and the signs",
            )
        })
    };
    // A uniform traction on whole flat faces, or any other on the triangles.
    let on_region = |on_surface: &mut OnSurface<'_>,
                     i: usize,
                     region: &Region,
                     traction: &(dyn Fn(&Vec3) -> Vec3 + Sync)| {
        flat_faces(body, region, traction).map_or_else(
            || {
                let loaded = |x: &Vec3, n: &Vec3| region.contains_on_surface(x, n, body.tolerance);
                let at = |p: &SurfacePoint| {
                    if loaded(&p.x, &p.normal) { traction(&p.normal) } else { Vec3::zeros() }
                };
                let resolution = |corners: &[Vec3; 3], n: &Vec3| {
                    let cut = corners.iter().any(|x| loaded(x, n) != loaded(&corners[0], n));
                    if cut { RESOLUTION_AT_RIM * body.spacing } else { f64::INFINITY }
                };
                on_surface(i, &Traction { at: &at, reaches: &|_| true, resolution: &resolution, smooth: 0.0 })
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
                LoadKind::Traction { region, traction } => {
                    on_region(&mut on_surface, i, region, &|_| *traction)
                }
                LoadKind::Pressure { region, pressure } => {
                    on_region(&mut on_surface, i, region, &|n| -*pressure * n)
                }
                LoadKind::BodyForce { region, acceleration } => {
                    body_force(body.mass, body.positions, region, acceleration, body.tolerance)
                        .ok_or_else(|| no_particle(&format!("load[{i}].region"), region, body.positions))
                }
                LoadKind::Patch { pressure, centre, radius, direction } => {
                    let patch = Patch::on(body.shape.surface(), *pressure, centre, *radius, direction);
                    patch.with_traction(|traction| on_surface(i, traction))
                }
            }?;
            Ok(NodalLoad::new(force, load.ramp))
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
