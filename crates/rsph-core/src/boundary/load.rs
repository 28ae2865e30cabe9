//! From a load to the forces on the particles.

use crate::boundary::body_force::body_force;
use crate::boundary::flat_face::{Face, Faces};
use crate::boundary::follower::{Follower, cofactor};
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
use crate::tensor::{Mat3, Vec3};

/// Longest triangle edge of the surface quadrature, in spacings, where the rim of a region cuts a triangle, of which all or nothing is loaded.
const RESOLUTION_AT_RIM: f64 = 0.02;

/// The body as loads see it.
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
    /// The weights of the particles in the gradient of the displacement at a place, under a law for any strain.
    pub gradient_weights: Option<&'a GradientWeights<'a>>,
    /// Flat faces that are loaded by the area vectors of an operator that does not balance its surface.
    pub faces: Option<Faces<'a>>,
}

/// From a place to particles with their weights in the gradient there.
pub type GradientWeights<'a> = dyn Fn(&Vec3) -> Vec<(u32, Vec3)> + Sync + 'a;

/// The forces of every load. A traction on a held part of the surface counts as far as the part is free.
///
/// # Errors
/// `load[i]...` when a load acts on nothing.
pub fn nodal_loads(loads: &[Load], body: &LoadedBody<'_>) -> Result<Vec<NodalLoad>, InvalidInput> {
    let n = body.mass.len();
    let acts = |force: Option<Vec<f64>>, i: usize| force.ok_or_else(|| nowhere(body, i));
    loads
        .iter()
        .enumerate()
        .map(|(i, load)| {
            let force = match &load.kind {
                // A baseline without load is a load of zero, wherever it acts.
                kind if kind.is_zero() => Ok(vec![0.0; 3 * body.mass.len()]),
                LoadKind::Traction { region, traction } => acts(on_region(body, region, &|_| *traction), i),
                LoadKind::Pressure { region, pressure } => {
                    acts(on_region(body, region, &|n| -*pressure * n), i)
                }
                LoadKind::FollowerPressure { region, pressure } => {
                    let gradient = body.gradient_weights.ok_or_else(|| for_any_strain(i))?;
                    let follower = with_region(body, region, &|n| -*pressure * n, |traction| {
                        Follower::new(body.surface, traction, gradient)
                    });
                    let follower = follower.ok_or_else(|| nowhere(body, i))?;
                    return Ok(NodalLoad::following(follower, load.curve.clone()));
                }
                LoadKind::BodyForce { region, acceleration } => {
                    body_force(body.mass, body.positions, region, acceleration, body.tolerance)
                        .ok_or_else(|| no_particle(&format!("load[{i}].region"), region, body.positions))
                }
                LoadKind::Patch { pressure, centre, radius, direction } => {
                    let patch = Patch::on(body.boundary, *pressure, centre, *radius, direction);
                    acts(patch.with_traction(|traction| body.surface.force(n, traction)), i)
                }
            }?;
            Ok(NodalLoad::new(force, load.curve.clone()))
        })
        .collect()
}

/// Any traction on the triangles in a region, or a uniform one on whole flat faces where these are another case; `None` if it acts
/// nowhere.
fn on_region(
    body: &LoadedBody<'_>,
    region: &Region,
    traction: &(dyn Fn(&Vec3) -> Vec3 + Sync),
) -> Option<Vec<f64>> {
    let by_faces = body.faces.as_ref().and_then(|faces| flat_faces(body, faces, region, traction));
    let on_triangles = |traction: &Traction<'_>| body.surface.force(body.mass.len(), traction);
    by_faces.or_else(|| with_region(body, region, traction, on_triangles))
}

/// What `then` makes of a traction, which depends on the normal, in a region.
fn with_region<R>(
    body: &LoadedBody<'_>,
    region: &Region,
    traction: &(dyn Fn(&Vec3) -> Vec3 + Sync),
    then: impl FnOnce(&Traction<'_>) -> R,
) -> R {
    let loaded = |x: &Vec3, n: &Vec3| region.contains_on_surface(x, n, body.tolerance);
    let at = |p: &SurfacePoint| if loaded(&p.x, &p.normal) { traction(&p.normal) } else { Vec3::zeros() };
    let resolution = |corners: &[Vec3; 3], n: &Vec3| {
        let cut = corners.iter().any(|x| loaded(x, n) != loaded(&corners[0], n));
        if cut { RESOLUTION_AT_RIM * body.spacing } else { f64::INFINITY }
    };
    then(&Traction { at: &at, reaches: &|_| true, resolution: &resolution, smooth: 0.0 })
}

/// That load `i` acts on nothing.
fn nowhere(body: &LoadedBody<'_>, i: usize) -> InvalidInput {
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
}

/// That load `i` wants a law for any strain.
fn for_any_strain(i: usize) -> InvalidInput {
    InvalidInput::new(
        format!("load[{i}].kind"),
        "follower_pressure",
        "follows the deformed surface, which a law for small strain takes to be the undeformed one",
        "take kind = \"pressure\", or a law for any strain such as \"neo-hookean\"",
    )
}

/// A load as a traction on the surface at factor 1.
#[derive(Clone, Debug)]
pub enum SurfaceTraction<'a> {
    /// The same in a whole region.
    Traction(&'a Region, Vec3),
    /// Against the outward normal in a region.
    Pressure(&'a Region, f64),
    /// Against the deformed surface in a region.
    FollowerPressure(&'a Region, f64),
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
            LoadKind::FollowerPressure { region, pressure } => Self::FollowerPressure(region, *pressure),
            LoadKind::Patch { pressure, centre, radius, direction } => {
                Self::Patch(Patch::on(surface, *pressure, centre, *radius, direction))
            }
            LoadKind::BodyForce { .. } => Self::Nothing,
        }
    }

    /// The force per undeformed area at `x` of the surface with that outward normal and the deformation gradient `f`; regions are
    /// enlarged by `tolerance`.
    pub fn at(&self, x: &Vec3, normal: &Vec3, f: &Mat3, tolerance: f64) -> Vec3 {
        let inside = |region: &Region| region.contains_on_surface(x, normal, tolerance);
        match self {
            Self::Traction(region, traction) if inside(region) => *traction,
            Self::Pressure(region, pressure) if inside(region) => -*pressure * normal,
            Self::FollowerPressure(region, pressure) if inside(region) => -*pressure * cofactor(f) * normal,
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
