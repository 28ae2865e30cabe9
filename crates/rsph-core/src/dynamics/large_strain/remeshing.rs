//! The remesh of a body at large strain: a new lattice through the deformed body, with reference positions,
//! volumes and velocities by map inversion.

use super::LargeStrain;
use super::body::{Cells, HOURGLASS, LargeBody, LastRemesh};
use super::configuration::Configuration;
use crate::error::InvalidInput;
use crate::remesh::inversion::{AxisLattice, Landed, OldMap, inside_fraction, invert};
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// A place whose dX/dx has a smaller determinant is no part of the body.
const SMALLEST_DETERMINANT: f64 = 0.02;
/// Singular values of F_0 relative to the old F beyond this factor are noise.
const GUARD: f64 = 1.4;

/// Why a body at large strain can not be laid anew.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LargeRemeshError {
    /// The map can not be inverted anywhere.
    #[error("no node of a new lattice lies in the body")]
    Empty,
    /// The reference positions around a new particle make no sense.
    #[error("the deformation gradient at a new particle is meaningless")]
    Torn(Vec3),
    /// A boundary or load acts on nothing any more.
    #[error(transparent)]
    Lost(#[from] InvalidInput),
}

/// What a remesh has done.
#[derive(Clone, Debug)]
pub struct LargeRemesh {
    /// Velocities of the new particles, which are at their nodes.
    pub velocity: Vec<Vec3>,
    /// Momentum before, as interpolated, and after it was corrected.
    pub momentum: [Vec3; 3],
    /// Relative error of the mass before it was scaled.
    pub raw_mass_error: f64,
    /// Angular momentum about the centre of mass before and after.
    pub angular_momentum: [Vec3; 2],
    /// Particles whose reference position was taken from the nearest old particle.
    pub guarded: usize,
}

impl<const D: usize> LargeBody<D> {
    /// Lays the particles anew, which are at `x` with velocities `v` at time `t`.
    ///
    /// # Errors
    /// The body stays as it was.
    pub fn remesh(&mut self, t: f64, x: &[Vec3], v: &[Vec3]) -> Result<LargeRemesh, LargeRemeshError> {
        let old = self.dynamics.all_points(t, x, v);
        let lattice = self.lattice_at(t);
        let map = OldMap {
            nodes: &self.dynamics.configuration.nodes,
            x: &old.x,
            reference: &self.dynamics.configuration.reference,
            velocity: &old.v,
            len: x.len(),
        };
        let landed = invert::<D>(&map, &self.lattice, &lattice, &|p| self.is_inside_planes(p, t));
        let fraction: Vec<f64> = landed
            .par_iter()
            .map(|l| {
                if l.gradient.determinant() <= SMALLEST_DETERMINANT {
                    return 0.0;
                }
                inside_fraction::<D>(&l.reference, &l.gradient, &lattice.spacing, &|x| {
                    self.distance_within(x)
                })
            })
            .collect();
        let cells = Cells {
            nodes: landed.iter().map(|l| l.position).collect(),
            reference: landed.iter().map(|l| l.reference).collect(),
            fraction,
        };
        let mut new = self.configuration_of(&cells, t, lattice.cell_volume::<D>());
        if new.is_empty() {
            return Err(LargeRemeshError::Empty);
        }
        let by_node = matching(&landed, &new);
        let guarded = guard(&mut new, &by_node, x, map.reference, self.dynamics.deformation());
        let held = self.held_among(&new.reference[..new.len])?;
        new.place_held(&held, t);
        let torn = |f: &Mat3| f.iter().any(|c| !c.is_finite()) || f.determinant() <= 0.0;
        if let Some(a) = new.first_gradient.iter().position(torn) {
            return Err(LargeRemeshError::Torn(new.reference[a]));
        }
        let density = self.material.density();
        let mass: f64 = self.dynamics.mass.iter().sum();
        let raw: f64 = density * new.reference_volume.iter().sum::<f64>();
        new.scale_volumes(mass / raw);

        let laid = LastRemesh { time: t, nodes: new.nodes[..new.len].to_vec() };
        let mut velocity: Vec<Vec3> = by_node.iter().map(|l| l.velocity).collect();
        let masses: Vec<f64> = new.reference_volume.iter().map(|v| v * density).collect();
        let before = Moments::of(&self.dynamics.mass, x, v);
        let free = self.is_free();
        let mut shift = Vec3::zeros();
        if free {
            shift = before.centre - Moments::of(&masses, &new.nodes[..new.len], &velocity).centre;
            new.nodes.iter_mut().for_each(|p| *p += shift);
        }
        let raw_moments = Moments::of(&masses, &new.nodes[..new.len], &velocity);
        let drift = (before.momentum - raw_moments.momentum) / mass;
        for v in &mut velocity {
            *v += drift;
        }
        if free {
            correct_spin::<D>(&before, &masses, &new.nodes, &mut velocity);
        }
        let after = Moments::of(&masses, &new.nodes[..new.len], &velocity);

        let mut dynamics =
            LargeStrain::new(new, Arc::clone(&self.material), HOURGLASS * self.solver.hourglass)?;
        dynamics.fixed = held;
        let kept = std::mem::replace(&mut self.dynamics, dynamics);
        if let Err(error) = self.tag_loads() {
            self.dynamics = kept;
            return Err(error.into());
        }
        self.laid = Some(laid);
        self.lattice = AxisLattice { origin: lattice.origin + shift, ..lattice };
        Ok(LargeRemesh {
            velocity,
            momentum: [before.momentum, raw_moments.momentum, after.momentum],
            raw_mass_error: raw / mass - 1.0,
            angular_momentum: [before.spin, after.spin],
            guarded,
        })
    }
}

/// What has moved to each particle of `new`, whose nodes are some of the landed ones, in their order.
fn matching<'a, const D: usize>(landed: &'a [Landed], new: &Configuration<D>) -> Vec<&'a Landed> {
    let mut rest = landed.iter();
    new.nodes[..new.len].iter().filter_map(|node| rest.find(|l| l.position == *node)).collect()
}

/// Where F_0 strays too far from the F of the nearest old particle, the reference position is continued from
/// that particle by its F; what still strays gets that F. Returns how many particles it was.
fn guard<const D: usize>(
    new: &mut Configuration<D>,
    landed: &[&Landed],
    x: &[Vec3],
    reference: &[Vec3],
    f: &[Mat3],
) -> usize {
    let stray = |c: &Configuration<D>| -> Vec<usize> {
        let strays = |a: &usize| {
            let ratio = f[landed[*a].nearest].try_inverse().map(|inverse| c.first_gradient[*a] * inverse);
            ratio.is_none_or(|r| {
                let squares = (r.transpose() * r).symmetric_eigenvalues();
                let within = squares.min() >= GUARD.powi(-2) && squares.max() <= GUARD.powi(2);
                !within || r.determinant() <= 0.0
            })
        };
        (0..c.len).into_par_iter().filter(strays).collect()
    };
    let first = stray(new);
    if first.is_empty() {
        return 0;
    }
    for &a in &first {
        let old = landed[a].nearest;
        let inverse = f[old].try_inverse().unwrap_or_else(Mat3::identity);
        new.reference[a] = reference[old] + inverse * (landed[a].position - x[old]);
    }
    new.take_reference();
    for a in stray(new) {
        new.set_first_gradient(a, f[landed[a].nearest]);
    }
    first.len()
}

/// Sums of a set of particles.
#[derive(Clone, Copy, Debug)]
struct Moments {
    centre: Vec3,
    momentum: Vec3,
    /// Angular momentum about the centre.
    spin: Vec3,
}

impl Moments {
    fn of(mass: &[f64], x: &[Vec3], v: &[Vec3]) -> Self {
        let total: f64 = mass.iter().sum();
        let sum = |f: &dyn Fn(usize) -> Vec3| (0..mass.len()).map(|a| f(a) * mass[a]).sum::<Vec3>();
        let centre = sum(&|a| x[a]) / total;
        Self { centre, momentum: sum(&|a| v[a]), spin: sum(&|a| (x[a] - centre).cross(&v[a])) }
    }
}

/// Adds the rigid rotation that gives the particles the angular momentum they had.
fn correct_spin<const D: usize>(before: &Moments, mass: &[f64], nodes: &[Vec3], velocity: &mut [Vec3]) {
    // Twice: the second time takes away the rounding of the first.
    for _ in 0..2 {
        let now = Moments::of(mass, &nodes[..mass.len()], velocity);
        let arm = |a: usize| nodes[a] - now.centre;
        let inertia: Mat3 = (0..mass.len())
            .map(|a| (Mat3::identity() * arm(a).norm_squared() - arm(a) * arm(a).transpose()) * mass[a])
            .sum();
        let missing = before.spin - now.spin;
        let Some(rate) = inertia.try_inverse().map(|i| i * missing) else { return };
        velocity.iter_mut().enumerate().for_each(|(a, v)| *v += rate.cross(&arm(a)));
    }
}
