//! A solid remeshed on its lattice, where it is now.
//!
//! What a solid carries are fields on the undeformed body: where a particle was, X, its displacement and
//! velocity. They are found at the new nodes by inverting the motion since the last remesh
//! ([`Carried`]); mass and volume follow from the undeformed body itself, of whose cells X says how much
//! is inside. So nothing that a remesh does adds up from one to the next but the interpolation of the
//! displacement.

use super::assemble::LatticeParticles;
use super::held::Held;
use crate::boundary::surface_quadrature::SurfaceQuadrature;
use crate::dynamics::solid::Solid;
use crate::error::{FailureKind, InvalidInput};
use crate::kernel::RemeshKernel;
use crate::mesh::TriangleMesh;
use crate::particles::{Column, Field, Particles};
use crate::remesh::{Arrived, Carried, NodeLattice, NodeValues, RemeshError, fold};
use crate::sample::{Body, InsideFraction, MIN_FRACTION, Sight, is_cut};
use crate::setup::{Setup, SolidSetup};
use crate::shape::Shape;
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// How far, in spacings, the share of a cell that is too little for a particle may travel to one.
const FOLD_REACH: usize = 4;
/// Largest share of the volume that the cells of the deformed body may lack or have too much.
const WORST_VOLUME: f64 = 0.1;
/// Largest share of the volume that may have been turned inside out, in creases of the surface; the particles there are dropped.
const WORST_LOSS: f64 = 0.01;

/// Most by which a gradient that particles have may stretch that of the motion, or be stretched by it: beyond, a particle at the
/// rim of the body has too few neighbours.
const STRAY: f64 = 1.4;

/// Whether dX/dx as particles have it strays from that of the motion.
fn strays(motion: &Mat3, found: &Mat3) -> bool {
    motion.try_inverse().is_none_or(|inverse| {
        let ratio = found * inverse;
        let squares = (ratio.transpose() * ratio).symmetric_eigenvalues();
        let within = squares.min() >= STRAY.powi(-2) && squares.max() <= STRAY.powi(2);
        !within || ratio.determinant() <= 0.0
    })
}

/// The undeformed body, as a remesh needs it.
#[derive(Clone, Debug)]
pub(super) struct Undeformed {
    /// The lattice, of all remeshes.
    pub lattice: NodeLattice<3>,
    /// How much of a cell lies inside; `None` if the particles stay where they are.
    inside: Option<InsideFraction>,
    /// Volume of the particles.
    volume: f64,
    /// 3, or 2 for a body in the plane.
    dimension: usize,
    /// What sees what across gaps of the surface, if it has any.
    pub sight: Option<Arc<Sight>>,
}

/// Why a solid can not be remeshed.
#[derive(Debug, thiserror::Error)]
pub(super) enum SolidRemeshError {
    #[error(transparent)]
    Lattice(#[from] RemeshError),
    #[error("the body has turned inside out between two remeshings")]
    Inverted(Vec3),
    #[error("{:.1} % of the body would be lost or doubled: it has torn, or moved too far between two remeshings", 100.0 * .0)]
    Volume(f64),
    #[error("after remeshing, {0}")]
    Untagged(#[from] InvalidInput),
}

impl SolidRemeshError {
    /// Its kind and place as those of a failure.
    pub fn class(&self) -> (FailureKind, Option<Vec3>) {
        match self {
            Self::Lattice(RemeshError::Lost { position, .. }) if !position.iter().all(|c| c.is_finite()) => {
                (FailureKind::NotFinite, None)
            }
            Self::Lattice(RemeshError::Lost { position, .. }) => (FailureKind::Scattered, Some(*position)),
            Self::Inverted(place) => (FailureKind::Inverted, Some(*place)),
            Self::Lattice(_) | Self::Volume(_) | Self::Untagged(_) => (FailureKind::Scattered, None),
        }
    }
}

/// What a body carries, at the nodes in and around where it is now.
struct Arrivals<'a> {
    undeformed: &'a Undeformed,
    arrived: Arrived,
    /// Values a node, the displacement first.
    columns: usize,
    /// How much of the cell of each node holds the body.
    fraction: Vec<f64>,
}

impl Arrivals<'_> {
    /// Where node `k` was in the undeformed body.
    fn place(&self, k: usize) -> Vec3 {
        let u = Vec3::from_column_slice(&self.arrived.values[k * self.columns..k * self.columns + 3]);
        self.undeformed.lattice.position(self.arrived.nodes[k]) - u
    }

    /// dX/dx at node `k`.
    fn back(&self, k: usize) -> Mat3 {
        Mat3::identity() - self.arrived.gradients[k]
    }

    /// The nodes in and around the body, and where they were in the undeformed one.
    fn around(self) -> (Vec<[i64; 3]>, Vec<Vec3>) {
        let places = (0..self.arrived.nodes.len()).map(|k| self.place(k)).collect();
        (self.arrived.nodes, places)
    }

    /// How much of their cells holds the body, at all nodes where that is something.
    fn shares(&self) -> Result<NodeValues<3>, RemeshError> {
        let inside: Vec<usize> = (0..self.fraction.len()).filter(|k| self.fraction[*k] > 0.0).collect();
        let nodes: Vec<[i64; 3]> = inside.iter().map(|&k| self.arrived.nodes[k]).collect();
        let shares: Vec<f64> = inside.iter().map(|&k| self.fraction[k]).collect();
        NodeValues::from_nodes(self.undeformed.lattice, &nodes, 1, &shares)
    }

    /// The nodes with enough of the body in their cells for a particle, now and in the undeformed body.
    fn with_particles(&self) -> Vec<usize> {
        let least = MIN_FRACTION * (1.0 - 1e-9);
        let enough = |k: &usize| {
            // Far outside of its neighbours a node of a squeezed rim has no gradient.
            self.fraction[*k] >= least
                && self.undeformed.fraction_of(&self.place(*k), &Mat3::identity()) >= least
                && self.back(*k).determinant() > 0.0
        };
        (0..self.fraction.len()).filter(enough).collect()
    }

    /// Particles at the `kept` nodes with the volumes of their cells that hold the body, and the volume of `shares` that went to them
    /// from nodes without a particle.
    fn particles(&self, kept: &[usize], shares: &NodeValues<3>) -> (LatticeParticles, f64) {
        let (body, mut shares) = (self.undeformed, shares.clone());
        let cell = body.lattice.spacing.powi(body.dimension as i32);
        let numbers: Vec<usize> = kept.iter().filter_map(|&k| shares.number(self.arrived.nodes[k])).collect();
        let mut keep = vec![false; shares.len()];
        for number in &numbers {
            keep[*number] = true;
        }
        let folded = fold(&mut shares, &keep, FOLD_REACH);
        let places: Vec<Vec3> = kept.iter().map(|k| self.place(*k)).collect();
        let particles = LatticeParticles::new(
            kept.iter().map(|k| self.arrived.nodes[*k]),
            &places,
            numbers.iter().map(|number| shares.values[*number] * cell),
            body.cut_at(places.iter()),
        )
        .with_sight(body.sight.as_ref());
        (particles, folded.moved[0] * cell)
    }

    /// Columns of what the particles at the `kept` nodes carry.
    fn columns(&self, kept: &[usize], first: usize, components: usize) -> Column {
        let value = |c: usize, k: &usize| self.arrived.values[k * self.columns + first + c];
        let values = (0..components).flat_map(|c| kept.iter().map(move |k| value(c, k)));
        Column::from_vec(values.collect(), kept.len())
    }
}

/// Drops the nodes for which that is true.
fn drop_those(kept: &mut Vec<usize>, dropped: &[bool]) {
    let mut dropped = dropped.iter();
    kept.retain(|_| dropped.next() != Some(&true));
}

/// A solid remeshed.
#[derive(Debug)]
pub(super) struct RemeshedSolid {
    pub lattice_particles: LatticeParticles,
    /// Dynamics of the adjoint formulation, without loads.
    pub solid: Solid,
    /// The undeformed surface with the weights of the particles.
    pub quadrature: SurfaceQuadrature,
    /// Reference, mass, volume and what was carried.
    pub particles: Particles,
    /// The nodes in and around the body, and where they were in the undeformed one.
    pub around: (Vec<[i64; 3]>, Vec<Vec3>),
    /// Mass of cells that hold too little for a particle, which went to the nearest particle.
    pub folded_mass: f64,
    /// By how much all volumes were multiplied, less 1, so that their sum stays.
    pub rescaling: f64,
}

impl Undeformed {
    /// `shape` as it was sampled, with its particles, which are `remeshed` or stay where they are.
    pub fn new(shape: &dyn Shape, body: &Body, remeshed: bool) -> (Self, LatticeParticles) {
        let dx = body.grid.spacing;
        let lattice = NodeLattice { origin: body.grid.origin, spacing: dx };
        let nodes = body.cells.iter().map(|c| c.map(|i| i as i64));
        let undeformed: Vec<Vec3> = body.cells.iter().map(|c| body.grid.centre(*c)).collect();
        let lattice_particles =
            LatticeParticles::new(nodes, &undeformed, body.volume.iter().copied(), body.cut())
                .with_sight(body.sight.as_ref());
        let inside = remeshed.then(|| InsideFraction::new(shape, body));
        (
            Self {
                lattice,
                inside,
                volume: lattice_particles.volume.iter().sum(),
                dimension: body.dimension,
                sight: body.sight.clone(),
            },
            lattice_particles,
        )
    }

    /// Inside fraction of a cell that a linear map takes to around `x`.
    fn fraction_of(&self, x: &Vec3, map: &Mat3) -> f64 {
        self.inside.as_ref().map_or(0.0, |inside| inside.of_image(x, map))
    }

    /// Whether the surface cuts the cells of particles that were at these places of the undeformed body.
    pub fn cut_at<'a>(&self, places: impl Iterator<Item = &'a Vec3>) -> Vec<bool> {
        places.map(|x| is_cut(self.fraction_of(x, &Mat3::identity()))).collect()
    }

    /// Particles on the lattice where those are now that started at `nodes`; `fields` are what they carry, the displacement
    /// first and the velocity second.
    ///
    /// # Errors
    /// A body that no lattice holds, that has torn or turned inside out.
    pub fn remesh(
        &self,
        setup: &Setup<SolidSetup>,
        held: &Held,
        (nodes, particles): (&[[i64; 3]], &Particles),
        fields: &[Field],
        time: f64,
        surface: &TriangleMesh,
    ) -> Result<RemeshedSolid, SolidRemeshError> {
        let arrivals = self.arrivals(setup.remesh.kernel, nodes, particles, fields)?;
        let shares = arrivals.shares()?;
        let mut kept = arrivals.with_particles();
        let mut lost = 0.0;
        loop {
            if kept.is_empty() {
                return Err(SolidRemeshError::Volume(1.0));
            }
            let (mut lattice_particles, folded_mass) = arrivals.particles(&kept, &shares);
            let u = arrivals.columns(&kept, 0, 3);
            let gradient = lattice_particles
                .solid(setup, &self.lattice, held, surface, true)?
                .gradient(time, u.values());
            let stray: Vec<bool> = (kept.par_iter().zip(&gradient))
                .map(|(k, g)| strays(&arrivals.back(*k), &(Mat3::identity() - g)))
                .collect();
            if stray.contains(&true) {
                drop_those(&mut kept, &stray);
                continue;
            }
            let rescaling = self.weigh(&mut lattice_particles, &gradient)?;
            let (mut solid, quadrature) =
                self.deformed(setup, &lattice_particles, held, time, u.values(), surface)?;
            solid.linearise(time, u.values());
            let inverted = solid.inverted_in_state();
            if let Some(first) = inverted.iter().position(|inverted| *inverted) {
                let volume =
                    lattice_particles.volume.iter().zip(&inverted).filter(|(_, inverted)| **inverted);
                lost += volume.map(|(v, _)| v).sum::<f64>();
                if lost > WORST_LOSS * self.volume {
                    return Err(SolidRemeshError::Inverted(lattice_particles.reference.vector(first)));
                }
                drop_those(&mut kept, &inverted);
                continue;
            }
            let mut new = Particles::new(kept.len());
            let mut first = 0;
            for field in fields {
                let components = field.spec().components;
                new.set(*field, arrivals.columns(&kept, first, components));
                first += components;
            }
            new.set(Field::Reference, lattice_particles.reference.clone());
            new.set(Field::Mass, Column::shared(Arc::clone(&solid.mass), kept.len()));
            new.set(Field::Volume, Column::shared(Arc::clone(&lattice_particles.volume), kept.len()));
            return Ok(RemeshedSolid {
                around: arrivals.around(),
                lattice_particles,
                solid,
                quadrature,
                particles: new,
                folded_mass: folded_mass * setup.mechanics.material.density(),
                rescaling,
            });
        }
    }

    /// What `particles` that started at `nodes` carry, at the nodes around where they are now.
    fn arrivals(
        &self,
        kernel: RemeshKernel,
        nodes: &[[i64; 3]],
        particles: &Particles,
        fields: &[Field],
    ) -> Result<Arrivals<'_>, RemeshError> {
        let n = particles.len();
        let (x0, u) = (particles.column(Field::Reference), particles.column(Field::Displacement));
        let shift: Vec<Vec3> =
            (0..n).map(|a| x0.vector(a) + u.vector(a) - self.lattice.position(nodes[a])).collect();
        let components: Vec<(Field, usize)> =
            fields.iter().flat_map(|f| (0..f.spec().components).map(|c| (*f, c))).collect();
        let columns = components.len();
        let mut values = Vec::with_capacity(n * columns);
        for a in 0..n {
            values.extend(components.iter().map(|(f, c)| particles.column(*f).component(*c)[a]));
        }
        let (NodeLattice { origin, spacing }, shift, values) = (self.lattice, &shift, &values);
        let arrived = match self.dimension {
            2 => Carried::<2> { lattice: NodeLattice { origin, spacing }, nodes, shift, columns, values }
                .follow(kernel),
            _ => Carried { lattice: self.lattice, nodes, shift, columns, values }.follow(kernel),
        }?;
        let mut arrivals = Arrivals { undeformed: self, arrived, columns, fraction: Vec::new() };
        let fraction = |k: usize| self.fraction_of(&arrivals.place(k), &arrivals.back(k));
        arrivals.fraction = (0..arrivals.arrived.nodes.len()).into_par_iter().map(fraction).collect();
        Ok(arrivals)
    }

    /// Turns the volumes of particles with those gradients of u from those of their cells, of the deformed body, into those of the
    /// undeformed one, and multiplies them so that their sum stays; returns by how much, less 1.
    ///
    /// # Errors
    /// A body that has torn.
    fn weigh(&self, particles: &mut LatticeParticles, gradient: &[Mat3]) -> Result<f64, SolidRemeshError> {
        let volume = Arc::make_mut(&mut particles.volume);
        for (v, g) in volume.iter_mut().zip(gradient) {
            *v *= (Mat3::identity() - g).determinant();
        }
        let scale = self.volume / volume.iter().sum::<f64>();
        if scale.is_nan() || (scale - 1.0).abs() > WORST_VOLUME {
            return Err(SolidRemeshError::Volume((1.0 / scale - 1.0).abs()));
        }
        for v in volume {
            *v *= scale;
        }
        Ok(scale - 1.0)
    }

    /// The dynamics, without loads, of particles remeshed at `time` with the displacement `u`, and the undeformed
    /// `surface` with their weights.
    ///
    /// # Errors
    /// A body that has turned inside out, a boundary that holds none of it.
    pub fn deformed(
        &self,
        setup: &Setup<SolidSetup>,
        lattice_particles: &LatticeParticles,
        held: &Held,
        time: f64,
        u: &[f64],
        surface: &TriangleMesh,
    ) -> Result<(Solid, SurfaceQuadrature), SolidRemeshError> {
        let mut solid = lattice_particles.solid(setup, &self.lattice, held, surface, true)?;
        let gradient = solid.gradient(time, u);
        let gradients: Vec<Mat3> = gradient
            .iter()
            .enumerate()
            .map(|(a, g)| {
                (Mat3::identity() - g)
                    .try_inverse()
                    .ok_or(SolidRemeshError::Inverted(lattice_particles.reference.vector(a)))
            })
            .collect::<Result<_, _>>()?;
        let quadrature =
            lattice_particles.quadrature(setup, surface, self.lattice.spacing, held, &solid.lift.folds);
        let solid = solid.remeshed(&gradients);
        let solid = match held {
            Held::Surface(constraints) => solid.with_surface(
                &quadrature,
                &constraints.holds,
                &lattice_particles.cut,
                &lattice_particles.positions(),
            ),
            Held::Layers(_) => solid,
        };
        Ok((solid, quadrature))
    }
}
