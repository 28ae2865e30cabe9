//! From regions to particles: which face gets mirror ghosts, which particles are held. Particles are
//! found anew after every remesh, by where they were in the undeformed body, because regions survive it
//! and indices do not.

use crate::boundary::fixed::{Fixed, FixedParticle};
use crate::boundary::mirror::MirrorPlane;
use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::region::{Region, Side};
use crate::sample::Alignment;
use crate::setup::{Boundary, Formulation, Motion, Solver};
use crate::tensor::Vec3;

/// How the boundaries hold a body: decided on the undeformed body, and the same after every remesh.
#[derive(Clone, Debug, Default)]
pub struct Holds {
    /// Faces held with mirror ghosts.
    pub planes: Vec<MirrorPlane>,
    regions: Vec<HeldRegion>,
}

/// A part of the undeformed body that is held.
#[derive(Clone, Debug)]
struct HeldRegion {
    key: String,
    region: Region,
    tolerance: f64,
    fix: [bool; 3],
    motion: Option<Motion>,
}

impl Holds {
    /// The held particles among those that were at `positions` in the undeformed body.
    ///
    /// # Errors
    /// `boundary[i].region` when it holds none.
    pub fn fixed(&self, positions: &[Vec3]) -> Result<Fixed, InvalidInput> {
        let mut fixed = Fixed::default();
        for HeldRegion { key, region, tolerance, fix, motion } in &self.regions {
            let held = (0..positions.len()).filter(|&a| region.contains(&positions[a], *tolerance));
            let before = fixed.particles.len();
            fixed.particles.extend(held.map(|particle| FixedParticle {
                particle,
                fix: *fix,
                motion: *motion,
            }));
            if fixed.particles.len() == before {
                return Err(no_particle(key, region, positions));
            }
        }
        Ok(fixed)
    }

    /// The mirror planes where they are at time `t`.
    pub fn planes_at(&self, t: f64) -> Vec<MirrorPlane> {
        let moved = |p: &MirrorPlane| {
            let shift = p.motion.filter(|_| p.fix[p.axis]).map_or(0.0, |m| m.displacement(t)[p.axis]);
            MirrorPlane { at: p.at + shift, ..*p }
        };
        self.planes.iter().map(moved).collect()
    }
}

/// Distance, in spacings, from the last layer of a thick clamp to the wall that it acts as. It depends
/// on the reach of the kernel: 0.25 at h = 0.8 dx and 0.4 at 1.25 dx gave the smallest errors against
/// finite elements.
fn wall_offset(smoothing: f64) -> f64 {
    (0.25 + (smoothing - 0.8) / 0.45 * 0.15).clamp(0.2, 0.5)
}

/// Lattice positions that make planes inside the body accurate clamps: the last held layer lies one
/// wall offset beyond the plane.
pub fn alignment(boundaries: &[Boundary], bounds: &Bounds, solver: &Solver) -> Vec<Alignment> {
    let mut found: Vec<Alignment> = Vec::new();
    for boundary in boundaries {
        if let Region::Plane { axis, at, side } = boundary.region {
            let axis = axis as usize;
            let inside = at > bounds.min[axis] && at < bounds.max[axis];
            if inside && found.iter().all(|a| a.axis != axis) {
                let offset = wall_offset(solver.smoothing);
                let offset = if side == Side::Below { offset } else { -offset };
                found.push(Alignment { axis, at, offset });
            }
        }
    }
    found
}

/// How `boundaries` hold the body whose particles are at `positions`, undeformed.
///
/// # Errors
/// `boundary[i].region` when a region neither holds a particle nor touches a face.
pub fn holds(
    boundaries: &[Boundary],
    positions: &[Vec3],
    spacing: f64,
    solver: &Solver,
) -> Result<Holds, InvalidInput> {
    let mut holds = Holds::default();
    for (i, boundary) in boundaries.iter().enumerate() {
        let key = format!("boundary[{i}].region");
        let (fix, motion) = (boundary.fix, boundary.motion);
        let mut tolerance = 0.0;
        if let Region::Plane { axis, at, .. } = boundary.region {
            let axis = axis as usize;
            if positions.iter().any(|x| boundary.region.contains(x, 0.0)) {
                tolerance = (wall_offset(solver.smoothing) + 0.5 - 1e-6) * spacing;
            } else {
                let gap = positions.iter().map(|x| (x[axis] - at).abs()).fold(f64::INFINITY, f64::min);
                if gap <= spacing {
                    if solver.formulation == Formulation::Adjoint {
                        add_plane(&mut holds.planes, MirrorPlane { axis, at, fix, motion }, spacing, &key)?;
                        continue;
                    }
                    // The paper fixes the particles at the bottom.
                    tolerance = gap + 0.5 * spacing;
                }
            }
        }
        holds.regions.push(HeldRegion { key, region: boundary.region.clone(), tolerance, fix, motion });
    }
    holds.fixed(positions)?;
    Ok(holds)
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
