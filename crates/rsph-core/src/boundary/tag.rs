//! From regions to particles: which face gets mirror ghosts, which particles are held. Done anew after
//! every remesh, because regions survive it and indices do not.

use crate::boundary::fixed::{Fixed, FixedParticle};
use crate::boundary::mirror::MirrorPlane;
use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::region::{Region, Side};
use crate::sample::Alignment;
use crate::setup::{Boundary, Formulation, Solver};
use crate::tensor::Vec3;

/// What the boundaries of a body become.
#[derive(Clone, Debug, Default)]
pub struct Tags {
    /// Faces held with mirror ghosts.
    pub planes: Vec<MirrorPlane>,
    /// Particles held.
    pub fixed: Fixed,
}

/// Distance, in spacings, from the last layer of a thick clamp to the wall that it acts as. It depends
/// on the reach of the kernel: 0.25 at h = 0.8 dx and 0.4 at 1.25 dx gave the smallest errors against
/// finite elements.
fn wall_offset(smoothing: f64) -> f64 {
    (0.25 + (smoothing - 0.8) / 0.45 * 0.15).clamp(0.2, 0.5)
}

/// An axis-aligned plane and the side of it that a boundary holds.
#[derive(Clone, Copy, Debug)]
struct Plane {
    axis: usize,
    at: f64,
    side: Side,
}

impl Plane {
    /// The plane that bounds `region`, if it is one and lies along an axis.
    fn of(region: &Region) -> Option<Self> {
        match region {
            Region::Plane { axis, at, side } => Some(Self { axis: *axis as usize, at: *at, side: *side }),
            Region::HalfSpace { point, normal } => {
                let axis = normal.iamax();
                let along = normal[axis].abs() > (1.0 - 1e-12) * normal.norm();
                let side = if normal[axis] > 0.0 { Side::Below } else { Side::Above };
                along.then_some(Self { axis, at: point[axis], side })
            }
            _ => None,
        }
    }
}

/// Whether a boundary that cuts the body acts as a mirror plane.
fn mirrors(boundary: &Boundary, solver: &Solver) -> bool {
    boundary.fix == [true; 3] && solver.formulation == Formulation::Adjoint
}

/// Lattice positions that make planes inside the body accurate: a clamp lies on the faces of cells, so that
/// the mirror images of the particles continue the lattice; of any other boundary the last held layer lies
/// one wall offset beyond the plane.
pub fn alignment(boundaries: &[Boundary], bounds: &Bounds, solver: &Solver) -> Vec<Alignment> {
    let mut found: Vec<Alignment> = Vec::new();
    for boundary in boundaries {
        if let Some(Plane { axis, at, side }) = Plane::of(&boundary.region) {
            let inside = at > bounds.min[axis] && at < bounds.max[axis];
            if inside && found.iter().all(|a| a.axis != axis) {
                let offset = if mirrors(boundary, solver) { 0.5 } else { wall_offset(solver.smoothing) };
                let offset = if side == Side::Below { offset } else { -offset };
                found.push(Alignment { axis, at, offset });
            }
        }
    }
    found
}

/// Tags the particles at `positions`.
///
/// # Errors
/// `boundary[i].region` when a region neither holds a particle nor touches a face.
pub fn tag(
    boundaries: &[Boundary],
    positions: &[Vec3],
    spacing: f64,
    solver: &Solver,
) -> Result<Tags, InvalidInput> {
    let mut tags = Tags::default();
    for (i, boundary) in boundaries.iter().enumerate() {
        let key = format!("boundary[{i}].region");
        let held = |tolerance: f64| -> Vec<usize> {
            (0..positions.len()).filter(|&a| boundary.region.contains(&positions[a], tolerance)).collect()
        };
        let mut particles = held(0.0);
        if let Some(Plane { axis, at, side }) = Plane::of(&boundary.region) {
            let mirror = MirrorPlane { axis, at, fix: boundary.fix, motion: boundary.motion };
            let nearest = |beyond: bool| {
                let of_side = |x: &&Vec3| beyond == ((x[axis] < at) == (side == Side::Below));
                let gaps = positions.iter().filter(of_side).map(|x| (x[axis] - at).abs());
                gaps.fold(f64::INFINITY, f64::min)
            };
            if particles.is_empty() {
                let gap = nearest(false);
                if gap <= spacing {
                    if solver.formulation == Formulation::Adjoint {
                        add_plane(&mut tags.planes, mirror, spacing, &key)?;
                        continue;
                    }
                    // The paper fixes the particles at the bottom.
                    particles = held(gap + 0.5 * spacing);
                }
            } else if mirrors(boundary, solver) && (nearest(false) - nearest(true)).abs() < 1e-6 * spacing {
                // The plane lies on the faces of cells: it holds what is before it, and what lies beyond
                // only has to stay with it.
                add_plane(&mut tags.planes, mirror, spacing, &key)?;
                tags.fixed.apart.extend(&particles);
            } else {
                particles = held((wall_offset(solver.smoothing) + 0.5 - 1e-6) * spacing);
            }
        }
        if particles.is_empty() {
            return Err(no_particle(&key, &boundary.region, positions));
        }
        tags.fixed.particles.extend(particles.into_iter().map(|particle| FixedParticle {
            particle,
            fix: boundary.fix,
            motion: boundary.motion,
        }));
    }
    Ok(tags)
}

/// Adds a mirror plane, or what it holds to the plane that is there already.
fn add_plane(
    planes: &mut Vec<MirrorPlane>,
    plane: MirrorPlane,
    spacing: f64,
    key: &str,
) -> Result<(), InvalidInput> {
    let same = |p: &&mut MirrorPlane| p.axis == plane.axis && (p.at - plane.at).abs() < 1e-6 * spacing;
    match planes.iter_mut().find(same) {
        None => planes.push(plane),
        Some(there) if there.motion == plane.motion => {
            for i in 0..3 {
                there.fix[i] |= plane.fix[i];
            }
        }
        Some(_) => {
            return Err(InvalidInput::new(
                key,
                format!("plane at {}", plane.at),
                "another boundary holds the same face and moves otherwise",
                "give a face one boundary, with one motion for all components that it holds",
            ));
        }
    }
    Ok(())
}

/// The error for a region that holds no particle and touches no face.
pub fn no_particle(key: &str, region: &Region, positions: &[Vec3]) -> InvalidInput {
    let low = positions.iter().fold(Vec3::repeat(f64::INFINITY), |m, x| m.inf(x));
    let high = positions.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |m, x| m.sup(x));
    let place = |v: &Vec3| format!("({:.4}, {:.4}, {:.4})", v.x, v.y, v.z);
    InvalidInput::new(
        key,
        format!("{region:?}"),
        format!(
            "holds no particle of the body; its particles lie between {} and {}",
            place(&low),
            place(&high)
        ),
        "move or enlarge the region, or choose a smaller spacing",
    )
}
