//! From boundaries to what they hold: parts of the surface, and particles inside the body. Both are found anew after
//! every remesh, by where they were in the undeformed body, because regions survive it and indices do not.

use crate::boundary::fixed::{Fixed, FixedParticle};
use crate::boundary::tag::no_particle;
use crate::error::InvalidInput;
use crate::mesh::TriangleMesh;
use crate::region::{Region, Side};
use crate::setup::{Boundary, Fix, Motion};
use crate::tensor::{Mat3, Vec3};

/// Distance from a plane, in spacings, within which the surface counts as lying on it.
const ON_PLANE: f64 = 1e-3;
/// Cosine of the angle between the outward normal of a plane and that of a surface that lies on it.
const FACING: f64 = 0.9;
/// Most boundaries that can hold parts of the surface: the bits of a set.
const MAX_HELD: usize = 32;

/// A plane with the side of it that a boundary holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldPlane {
    /// A point of it.
    pub point: Vec3,
    /// Unit normal that points into what is held, out of the body.
    pub normal: Vec3,
}

impl HeldPlane {
    /// The plane that bounds `region`, if it is a half-space.
    pub fn of(region: &Region) -> Option<Self> {
        match region {
            Region::Plane { axis, at, side } => {
                let (axis, sign) = (*axis as usize, if *side == Side::Below { -1.0 } else { 1.0 });
                Some(Self { point: Vec3::ith(axis, *at), normal: Vec3::ith(axis, sign) })
            }
            Region::HalfSpace { point, normal } => {
                let normal = -normal.try_normalize(0.0)?;
                Some(Self { point: *point, normal })
            }
            Region::Not(other) => {
                let plane = Self::of(other)?;
                Some(Self { normal: -plane.normal, ..plane })
            }
            _ => None,
        }
    }

    /// Distance of a place beyond the plane.
    pub fn beyond(&self, x: &Vec3) -> f64 {
        (x - self.point).dot(&self.normal)
    }
}

/// Where a boundary holds the body.
#[derive(Clone, Debug)]
enum Place {
    /// On the surface that lies on a plane, up to that distance from it.
    Plane(HeldPlane, f64),
    /// On the part of the surface in a region.
    Patch(Region),
    /// Inside, all particles in a region.
    Inside(Region),
}

/// How a boundary holds what it holds.
#[derive(Clone, Debug)]
pub struct Hold {
    /// Which components.
    pub fix: Fix,
    /// How it moves.
    pub motion: Option<Motion>,
}

/// How the boundaries hold a body: decided on the undeformed body, and the same after every remesh.
#[derive(Clone, Debug, Default)]
pub struct Constraints {
    /// What each boundary holds.
    pub holds: Vec<Hold>,
    places: Vec<Place>,
    tolerance: f64,
}

/// Whether a plane boundary cuts the body: what lies beyond is held as a whole, or beyond a plane of symmetry.
pub fn cuts(boundary: &Boundary) -> Option<HeldPlane> {
    let whole = matches!(boundary.fix, Fix::Normal | Fix::Components([true, true, true]));
    HeldPlane::of(&boundary.region).filter(|_| whole)
}

impl Constraints {
    /// How `boundaries` hold a body with this `surface`, already cut by those that cut it, whose particles are at
    /// `positions`.
    ///
    /// # Errors
    /// `boundary[i].region` when a region neither holds a particle nor touches the surface; `boundary[i].fix` when the
    /// normal of no surface is there to be held.
    pub fn new(
        boundaries: &[Boundary],
        surface: &TriangleMesh,
        positions: &[Vec3],
        spacing: f64,
    ) -> Result<Self, InvalidInput> {
        let tolerance = ON_PLANE * spacing;
        let mut constraints = Self { tolerance, ..Self::default() };
        for (i, boundary) in boundaries.iter().enumerate() {
            let key = format!("boundary[{i}].region");
            if i >= MAX_HELD {
                let remedy = format!("join regions by `or`; {MAX_HELD} boundaries at most");
                return Err(InvalidInput::new(key, "", "is one boundary too many", remedy));
            }
            let place = match HeldPlane::of(&boundary.region) {
                Some(plane) => constraints.place_of_plane(plane, boundary, surface, positions, spacing),
                None => None,
            };
            let place = place.or_else(|| {
                let region = boundary.region.clone();
                if positions.iter().any(|x| region.contains(x, 0.0)) {
                    return Some(Place::Inside(region));
                }
                let touches = |t: usize| {
                    region.contains_on_surface(&surface.centroid(t), &surface.normal(t), tolerance)
                };
                (0..surface.triangles.len()).any(touches).then_some(Place::Patch(region))
            });
            let place = place.ok_or_else(|| no_particle(&key, &boundary.region, positions))?;
            if boundary.fix == Fix::Normal && matches!(place, Place::Inside(_)) {
                return Err(InvalidInput::new(
                    format!("boundary[{i}].fix"),
                    "\"normal\"",
                    "is held on a plane or on a part of the surface only, and this region holds particles inside",
                    "name components, or take a plane or a `surface_patch` as the region",
                ));
            }
            constraints.places.push(place);
            constraints.holds.push(Hold { fix: boundary.fix, motion: boundary.motion.clone() });
        }
        Ok(constraints)
    }

    /// The surface on a plane that bounds the body: on it, or at most a spacing before it.
    fn place_of_plane(
        &self,
        plane: HeldPlane,
        boundary: &Boundary,
        surface: &TriangleMesh,
        positions: &[Vec3],
        spacing: f64,
    ) -> Option<Place> {
        if cuts(boundary).is_none() && positions.iter().any(|x| plane.beyond(x) > self.tolerance) {
            return None;
        }
        let nearest = surface.vertices.iter().map(|x| -plane.beyond(x)).fold(f64::INFINITY, f64::min);
        (nearest <= spacing).then(|| Place::Plane(plane, nearest.max(0.0) + self.tolerance))
    }

    /// The boundaries that hold the surface at `x` with that outward normal, a bit each; `None` where it is free.
    pub fn held_at(&self, x: &Vec3, normal: &Vec3) -> Option<u32> {
        let holds = |place: &Place| match place {
            Place::Plane(plane, depth) => plane.beyond(x) >= -depth && plane.normal.dot(normal) > FACING,
            Place::Patch(region) => region.contains_on_surface(x, normal, self.tolerance),
            Place::Inside(_) => false,
        };
        let set = self.places.iter().enumerate().fold(0, |set, (i, p)| set | (u32::from(holds(p)) << i));
        (set != 0).then_some(set)
    }

    /// The planes with surface on them that is held.
    pub fn planes(&self) -> impl Iterator<Item = &HeldPlane> {
        self.places
            .iter()
            .filter_map(|place| if let Place::Plane(plane, _) = place { Some(plane) } else { None })
    }

    /// The held particles among those that were at `positions` in the undeformed body.
    ///
    /// # Errors
    /// `boundary[i].region` when it holds none.
    pub fn fixed(&self, positions: &[Vec3]) -> Result<Fixed, InvalidInput> {
        let mut fixed = Fixed::default();
        for (i, (place, hold)) in self.places.iter().zip(&self.holds).enumerate() {
            let Place::Inside(region) = place else { continue };
            let before = fixed.particles.len();
            let held = (0..positions.len()).filter(|&a| region.contains(&positions[a], 0.0));
            let fix = hold.fix.components();
            fixed.particles.extend(held.map(|particle| FixedParticle {
                particle,
                fix,
                motion: hold.motion.clone(),
                boundary: Some(i),
            }));
            if fixed.particles.len() == before {
                return Err(no_particle(&format!("boundary[{i}].region"), region, positions));
            }
        }
        Ok(fixed)
    }
}

/// What a set of boundaries holds of a surface with that outward normal: for each of them the projector on what it holds
/// and no later one does.
pub fn projectors(holds: &[Hold], set: u32, normal: &Vec3) -> Vec<(usize, Mat3)> {
    let mut free = Mat3::identity();
    let mut found = Vec::new();
    for i in (0..holds.len()).rev().filter(|i| set >> i & 1 == 1) {
        let wanted = match holds[i].fix {
            Fix::Normal => normal * normal.transpose(),
            Fix::Components(held) => Mat3::from_diagonal(&Vec3::from(held.map(|h| f64::from(u8::from(h))))),
        };
        // What is still free of what this one wants: the range of a product of projectors.
        let eigen = (free * wanted * free).symmetric_eigen();
        let mut held = Mat3::zeros();
        for (value, v) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            if *value > 1e-6 {
                held += v * v.transpose();
            }
        }
        if held != Mat3::zeros() {
            free -= held;
            found.push((i, held));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hold(fix: Fix) -> Hold {
        Hold { fix, motion: None }
    }

    #[test]
    fn later_boundaries_win_and_nothing_is_held_twice() {
        let n = Vec3::new(0.6, 0.0, 0.8);
        let holds = [hold(Fix::Components([true, true, false])), hold(Fix::Normal), hold(Fix::ALL)];
        let both = projectors(&holds, 0b011, &n);
        assert_eq!(both.iter().map(|p| p.0).collect::<Vec<_>>(), [1, 0]);
        let sum: Mat3 = both.iter().map(|p| p.1).sum();
        // x, y and the normal: everything.
        assert!((sum - Mat3::identity()).amax() < 1e-12);
        assert!((both[0].1 - n * n.transpose()).amax() < 1e-12);
        let all = projectors(&holds, 0b111, &n);
        assert_eq!((all.len(), all[0].0), (1, 2));
    }

    #[test]
    fn half_spaces_in_any_words_are_planes() {
        let below = Region::Plane { axis: crate::region::Axis::Y, at: 0.3, side: Side::Below };
        let above = Region::Plane { axis: crate::region::Axis::Y, at: 0.3, side: Side::Above };
        let not = Region::Not(Box::new(above));
        let half = Region::HalfSpace { point: Vec3::new(5.0, 0.3, -1.0), normal: Vec3::new(0.0, 2.0, 0.0) };
        let plane = HeldPlane::of(&below).unwrap();
        for region in [not, half] {
            let other = HeldPlane::of(&region).unwrap();
            assert_eq!(plane.normal, other.normal);
            assert!(other.beyond(&plane.point).abs() < 1e-15);
        }
        assert!(plane.beyond(&Vec3::zeros()) > 0.0);
        assert!(HeldPlane::of(&Region::All).is_none());
    }
}
