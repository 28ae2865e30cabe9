//! From regions to particles in the scheme of the paper: layers of particles are held. They are found anew after every
//! remesh, by where they were in the undeformed body, because regions survive it and indices do not.

use crate::boundary::fixed::{Fixed, FixedParticle};
use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::region::{Region, Side};
use crate::sample::Alignment;
use crate::setup::{Boundary, Fix, Motion, Solver};
use crate::tensor::Vec3;

/// How the boundaries hold a body: decided on the undeformed body, and the same after every remesh.
#[derive(Clone, Debug, Default)]
pub struct Holds {
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
        for (i, HeldRegion { key, region, tolerance, fix, motion }) in self.regions.iter().enumerate() {
            let held = (0..positions.len()).filter(|&a| region.contains(&positions[a], *tolerance));
            let before = fixed.particles.len();
            fixed.particles.extend(held.map(|particle| FixedParticle {
                particle,
                fix: *fix,
                motion: motion.clone(),
                boundary: Some(i),
            }));
            if fixed.particles.len() == before {
                return Err(no_particle(key, region, positions));
            }
        }
        Ok(fixed)
    }
}

/// Distance, in spacings, from the last layer of a thick clamp to the wall that it acts as. It depends
/// on the reach of the kernel: 0.25 at h = 0.8 dx and 0.4 at 1.25 dx gave the smallest errors against
/// finite elements.
fn wall_offset(smoothing: f64) -> f64 {
    (0.25 + (smoothing - 0.8) / 0.45 * 0.15).clamp(0.2, 0.5)
}

/// How far before a plane with this normal particles are held, in spacings. The last of them in each row across the
/// plane lies anywhere in the last cell before this distance; in the mean it lies where a wall is at the plane.
fn reach_of_hold(normal: &Vec3, smoothing: f64) -> f64 {
    wall_offset(smoothing) + 0.5 * normal.amax() / normal.norm()
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

/// Lattice positions that make planes inside the body accurate: the last held layer lies one wall offset beyond the
/// plane.
pub fn alignment(boundaries: &[Boundary], bounds: &Bounds, solver: &Solver) -> Vec<Alignment> {
    let mut found: Vec<Alignment> = Vec::new();
    for boundary in boundaries {
        if let Some(Plane { axis, at, side }) = Plane::of(&boundary.region) {
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
        let (fix, motion) = (components(boundary, i)?, boundary.motion.clone());
        let mut tolerance = 0.0;
        if let Some(Plane { axis, at, side }) = Plane::of(&boundary.region) {
            let outside = |x: &&Vec3| (x[axis] < at) != (side == Side::Below);
            if positions.iter().any(|x| boundary.region.contains(x, 0.0)) {
                tolerance = (reach_of_hold(&Vec3::x(), solver.smoothing) - 1e-6) * spacing;
            } else {
                let gaps = positions.iter().filter(outside).map(|x| (x[axis] - at).abs());
                let gap = gaps.fold(f64::INFINITY, f64::min);
                if gap <= spacing {
                    // The paper fixes the particles at the bottom.
                    tolerance = gap + 0.5 * spacing;
                }
            }
        } else if let Region::HalfSpace { normal, .. } = &boundary.region {
            tolerance = reach_of_hold(normal, solver.smoothing) * spacing;
        }
        holds.regions.push(HeldRegion { key, region: boundary.region.clone(), tolerance, fix, motion });
    }
    holds.fixed(positions)?;
    Ok(holds)
}

/// The components that boundary `i` holds; of a plane along an axis the one along it, where the normal is held.
fn components(boundary: &Boundary, i: usize) -> Result<[bool; 3], InvalidInput> {
    match (boundary.fix, Plane::of(&boundary.region)) {
        (Fix::Normal, Some(plane)) => Ok(std::array::from_fn(|i| i == plane.axis)),
        (Fix::Normal, None) => Err(InvalidInput::new(
            format!("boundary[{i}].fix"),
            "\"normal\"",
            "is held on planes along an axis only, in the scheme of the paper",
            "name components, or take the formulation \"adjoint\"",
        )),
        (fix, _) => Ok(fix.components()),
    }
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
        "move or enlarge the region, check its units, or choose a smaller spacing",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;

    /// Rows of particles end at an oblique clamp where, in the mean, the last layer of a clamp along an axis does.
    #[test]
    fn an_oblique_clamp_holds_up_to_the_wall_that_it_acts_as() {
        let (n, dx) = (24, 0.1);
        let grid = Grid { origin: Vec3::repeat(-0.5 * n as f64 * dx), spacing: dx, cells: [n; 3] };
        let positions: Vec<Vec3> =
            (0..grid.len()).map(|q| grid.centre([q % n, q / n % n, q / n / n])).collect();
        for smoothing in [0.8, 1.25] {
            let solver = Solver { smoothing, ..Solver::ACCURATE };
            for normal in
                [Vec3::new(1.0, 2.17, 0.53), Vec3::new(-0.43, 0.31, -0.83), Vec3::new(0.71, 0.2, 0.66)]
            {
                let point = Vec3::new(0.013, -0.027, 0.041);
                let region = Region::HalfSpace { point, normal };
                let boundary = Boundary { name: None, region, fix: Fix::ALL, motion: None };
                let held = holds(&[boundary], &positions, dx, &solver)
                    .and_then(|holds| holds.fixed(&positions))
                    .unwrap();
                // Along the axis that crosses the plane most steeply: its lattice coordinate is the row's.
                let stride = n.pow(normal.iamax() as u32);
                let mut last = vec![None::<f64>; positions.len()];
                for p in &held.particles {
                    let row = p.particle - p.particle / stride % n * stride;
                    let beyond = (positions[p.particle] - point).dot(&normal.normalize()) / dx;
                    last[row] = Some(last[row].map_or(beyond, |l| l.max(beyond)));
                }
                // Rows that the plane cuts well inside the body.
                let ends: Vec<f64> = last.iter().flatten().copied().filter(|l| *l > -0.25).collect();
                assert!(ends.len() > 150, "{} rows", ends.len());
                let mean = ends.iter().sum::<f64>() / ends.len() as f64;
                assert!((mean - wall_offset(smoothing)).abs() < 0.03, "{normal:?}: {mean}");
            }
        }
    }
}
