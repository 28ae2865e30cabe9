//! From a load to the forces on the particles.

use crate::boundary::body_force::body_force;
use crate::boundary::flat_face::{Face, Faces};
use crate::boundary::nodal_load::NodalLoad;
use crate::boundary::patch::Patch;
use crate::boundary::surface_load::{SurfacePoint, Traction};
use crate::boundary::surface_quadrature::SurfaceQuadrature;
use crate::boundary::tag::no_particle;
use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::mesh::TriangleMesh;
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
    /// Spacing dx.
    pub spacing: f64,
    /// Tolerance of regions (a length).
    pub tolerance: f64,
    /// The surface that is loaded and held.
    pub boundary: &'a TriangleMesh,
    /// The same with the weights of the particles.
    pub surface: &'a SurfaceQuadrature,
    /// Flat faces that are loaded by the area vectors of an operator that does not balance its surface.
    pub faces: Option<Faces<'a>>,
}

/// The forces of every load. A traction on a held part of the surface counts as far as the part is free.
///
/// # Errors
/// `load[i]...` when a load acts on nothing.
pub fn nodal_loads(loads: &[Load], body: &LoadedBody<'_>) -> Result<Vec<NodalLoad>, InvalidInput> {
    let n = body.mass.len();
    let on_surface = |i: usize, traction: &Traction<'_>| {
        body.surface.force(n, traction).ok_or_else(|| {
            let Bounds { min, max } = body.boundary.bounds().unwrap_or_else(|| body.shape.bounds());
            let place = |v: &Vec3| format!("({:.4}, {:.4}, {:.4})", v.x, v.y, v.z);
            InvalidInput::new(
                format!("load[{i}]"),
                "(this load)",
                format!(
                    "acts on no free part of the surface, which lies between {} and {}",
                    place(&min),
                    place(&max)
                ),
                "check the region or centre, its units, the direction and the signs, and what boundaries hold",
            )
        })
    };
    // Any traction on the triangles, or a uniform one on whole flat faces where these are another case.
    let on_region = |i: usize, region: &Region, traction: &(dyn Fn(&Vec3) -> Vec3 + Sync)| {
        let by_faces = body.faces.as_ref().and_then(|faces| flat_faces(body, faces, region, traction));
        by_faces.map_or_else(
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
                LoadKind::Traction { region, traction } => on_region(i, region, &|_| *traction),
                LoadKind::Pressure { region, pressure } => on_region(i, region, &|n| -*pressure * n),
                LoadKind::BodyForce { region, acceleration } => {
                    body_force(body.mass, body.positions, region, acceleration, body.tolerance)
                        .ok_or_else(|| no_particle(&format!("load[{i}].region"), region, body.positions))
                }
                LoadKind::Patch { pressure, centre, radius, direction } => {
                    let patch = Patch::on(body.boundary, *pressure, centre, *radius, direction);
                    patch.with_traction(|traction| on_surface(i, traction))
                }
            }?;
            Ok(NodalLoad::new(force, load.ramp))
        })
        .collect()
}

/// A load as a traction on the surface at factor 1.
#[derive(Clone, Debug)]
pub enum SurfaceTraction<'a> {
    /// The same in a whole region.
    Traction(&'a Region, Vec3),
    /// Against the outward normal in a region.
    Pressure(&'a Region, f64),
    /// A smeared local load.
    Patch(Patch),
    /// None: it acts inside.
    Nothing,
}

impl<'a> SurfaceTraction<'a> {
    /// The traction of a load on a body with that surface.
    pub fn new(kind: &'a LoadKind, surface: &TriangleMesh) -> Self {
        match kind {
            LoadKind::Traction { region, traction } => Self::Traction(region, *traction),
            LoadKind::Pressure { region, pressure } => Self::Pressure(region, *pressure),
            LoadKind::Patch { pressure, centre, radius, direction } => {
                Self::Patch(Patch::on(surface, *pressure, centre, *radius, direction))
            }
            LoadKind::BodyForce { .. } => Self::Nothing,
        }
    }

    /// The traction at `x` of the surface with that outward normal; regions are enlarged by `tolerance`.
    pub fn at(&self, x: &Vec3, normal: &Vec3, tolerance: f64) -> Vec3 {
        let inside = |region: &Region| region.contains_on_surface(x, normal, tolerance);
        match self {
            Self::Traction(region, traction) if inside(region) => *traction,
            Self::Pressure(region, pressure) if inside(region) => -*pressure * normal,
            Self::Patch(patch) => patch.traction(&SurfacePoint { x: *x, normal: *normal, area: 0.0 }),
            _ => Vec3::zeros(),
        }
    }
}

/// Forces of a uniform traction on whole flat faces of a box by its area vectors; `None` where that
/// does not apply.
fn flat_faces(
    body: &LoadedBody<'_>,
    faces: &Faces<'_>,
    region: &Region,
    traction: &dyn Fn(&Vec3) -> Vec3,
) -> Option<Vec<f64>> {
    if !body.shape.is_box() {
        return None;
    }
    let bounds = body.shape.bounds();
    let whole = Face::whole_faces(&bounds, region, body.tolerance).filter(|f| !f.is_empty())?;
    let n = body.mass.len();
    let mut force = vec![0.0; 3 * n];
    for face in whole {
        let traction = traction(&face.normal());
        let shares = face.shares(&bounds, body.positions, faces)?;
        for (a, share) in shares.into_iter().enumerate() {
            for i in 0..3 {
                force[i * n + a] += traction[i] * share;
            }
        }
    }
    Some(force)
}
