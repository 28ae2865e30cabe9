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
use crate::dynamics::elastic::Elastic;
use crate::error::{FailureKind, InvalidInput};
use crate::mesh::TriangleMesh;
use crate::particles::{Column, Field, Particles};
use crate::remesh::{Carried, NodeLattice, NodeValues, RemeshError, fold};
use crate::sample::{Body, InsideFraction, MIN_FRACTION, is_cut};
use crate::setup::Setup;
use crate::shape::Shape;
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// How far, in spacings, the share of a cell that is too little for a particle may travel to one.
const FOLD_REACH: usize = 4;
/// Largest share of the volume that the cells of the deformed body may lack or have too much.
const WORST_VOLUME: f64 = 0.1;

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

/// A solid remeshed.
#[derive(Debug)]
pub(super) struct RemeshedSolid {
    pub lattice_particles: LatticeParticles,
    /// Dynamics of the adjoint formulation, without loads.
    pub elastic: Elastic,
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
            LatticeParticles::new(nodes, &undeformed, body.volume.iter().copied(), body.cut());
        let inside = remeshed.then(|| InsideFraction::new(shape, body));
        (
            Self {
                lattice,
                inside,
                volume: lattice_particles.volume.iter().sum(),
                dimension: body.dimension,
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

    /// Lays the particles anew that started at `nodes`; `fields` are what they carry, the displacement
    /// first and the velocity second.
    ///
    /// # Errors
    /// A body that no lattice holds, that has torn or turned inside out.
    pub fn remesh(
        &self,
        setup: &Setup,
        held: &Held,
        (nodes, particles): (&[[i64; 3]], &Particles),
        fields: &[Field],
        time: f64,
        surface: &TriangleMesh,
    ) -> Result<RemeshedSolid, SolidRemeshError> {
        let (n, cell) = (particles.len(), self.lattice.spacing.powi(self.dimension as i32));
        let (x0, u) = (particles.column(Field::Reference), particles.column(Field::Displacement));
        let shift: Vec<Vec3> =
            (0..n).map(|a| x0.vector(a) + u.vector(a) - self.lattice.position(nodes[a])).collect();
        let components: Vec<(Field, usize)> =
            fields.iter().flat_map(|f| (0..f.spec().components).map(|c| (*f, c))).collect();
        let mut values = Vec::with_capacity(n * components.len());
        for a in 0..n {
            values.extend(components.iter().map(|(f, c)| particles.column(*f).component(*c)[a]));
        }
        let columns = components.len();
        let kernel = setup.remesh.kernel;
        let NodeLattice { origin, spacing } = self.lattice;
        let shift = &shift;
        let values = &values;
        let arrived = match self.dimension {
            2 => Carried::<2> { lattice: NodeLattice { origin, spacing }, nodes, shift, columns, values }
                .follow(kernel),
            _ => Carried { lattice: self.lattice, nodes, shift, columns, values }.follow(kernel),
        }?;

        // Where each node was in the undeformed body, dX/dx there, and how much of its cell holds the body.
        let count = arrived.nodes.len();
        let place = |k: usize| {
            let x = self.lattice.position(arrived.nodes[k]);
            x - Vec3::from_column_slice(&arrived.values[k * columns..k * columns + 3])
        };
        let back = |k: usize| Mat3::identity() - arrived.gradients[k];
        let fraction: Vec<f64> =
            (0..count).into_par_iter().map(|k| self.fraction_of(&place(k), &back(k))).collect();
        let inside: Vec<usize> = (0..count).filter(|k| fraction[*k] > 0.0).collect();
        let nodes: Vec<[i64; 3]> = inside.iter().map(|&k| arrived.nodes[k]).collect();
        let shares: Vec<f64> = inside.iter().map(|&k| fraction[k]).collect();
        let shares = NodeValues::from_nodes(self.lattice, &nodes, 1, &shares)?;

        // Which nodes hold a particle.
        let least = MIN_FRACTION * (1.0 - 1e-9);
        let enough = |k: &usize| {
            // Far outside of its neighbours a node of a squeezed rim has no gradient.
            fraction[*k] >= least
                && self.fraction_of(&place(*k), &Mat3::identity()) >= least
                && back(*k).determinant() > 0.0
        };
        let mut kept: Vec<usize> = inside.into_iter().filter(enough).collect();
        let (mut lattice_particles, gradient, folded) = loop {
            if kept.is_empty() {
                return Err(SolidRemeshError::Volume(1.0));
            }
            let mut shares = shares.clone();
            let mut keep = vec![false; shares.len()];
            let numbers: Vec<usize> = kept.iter().filter_map(|&k| shares.number(arrived.nodes[k])).collect();
            for number in &numbers {
                keep[*number] = true;
            }
            let folded = fold(&mut shares, &keep, FOLD_REACH);
            let undeformed: Vec<Vec3> = kept.iter().map(|k| place(*k)).collect();
            let lattice_particles = LatticeParticles::new(
                kept.iter().map(|k| arrived.nodes[*k]),
                &undeformed,
                numbers.iter().map(|number| shares.values[*number] * cell),
                self.cut_at(undeformed.iter()),
            );
            let len = kept.len();
            let mut u = vec![0.0; 3 * len];
            for (a, k) in kept.iter().enumerate() {
                (0..3).for_each(|i| u[i * len + a] = arrived.values[k * columns + i]);
            }
            let gradient =
                lattice_particles.elastic(setup, &self.lattice, held, surface, true)?.gradient(time, &u);
            let strays = |(k, g): (&usize, &Mat3)| strays(&back(*k), &(Mat3::identity() - g));
            let stray: Vec<bool> = kept.par_iter().zip(&gradient).map(strays).collect();
            if !stray.contains(&true) {
                break (lattice_particles, gradient, folded);
            }
            let mut stray = stray.into_iter();
            kept.retain(|_| stray.next() != Some(true));
        };
        let len = kept.len();
        let column = |first: usize, components: usize| {
            let mut data = vec![0.0; components * len];
            for (a, k) in kept.iter().enumerate() {
                for c in 0..components {
                    data[c * len + a] = arrived.values[k * columns + first + c];
                }
            }
            Column::from_vec(data, len)
        };
        let mut new = Particles::new(len);
        let mut first = 0;
        for field in fields {
            new.set(*field, column(first, field.spec().components));
            first += field.spec().components;
        }
        let u = new.column(Field::Displacement).values();

        // A cell of the deformed body holds det(dX/dx) times its volume of the undeformed one.
        let volume = Arc::make_mut(&mut lattice_particles.volume);
        for (a, g) in gradient.iter().enumerate() {
            let share = (Mat3::identity() - g).determinant();
            if share.is_nan() || share <= 0.0 {
                return Err(SolidRemeshError::Inverted(lattice_particles.reference.vector(a)));
            }
            volume[a] *= share;
        }
        let scale = self.volume / volume.iter().sum::<f64>();
        if scale.is_nan() || (scale - 1.0).abs() > WORST_VOLUME {
            return Err(SolidRemeshError::Volume((1.0 / scale - 1.0).abs()));
        }
        for v in volume {
            *v *= scale;
        }
        let (elastic, quadrature) = self.deformed(setup, &lattice_particles, held, time, u, surface)?;
        new.set(Field::Reference, lattice_particles.reference.clone());
        new.set(Field::Mass, Column::shared(Arc::clone(&elastic.mass), len));
        new.set(Field::Volume, Column::shared(Arc::clone(&lattice_particles.volume), len));
        let folded_mass = folded.moved[0] * cell * setup.material.density();
        let undeformed = (0..count).map(place).collect();
        let around = (arrived.nodes, undeformed);
        Ok(RemeshedSolid {
            around,
            lattice_particles,
            elastic,
            quadrature,
            particles: new,
            folded_mass,
            rescaling: scale - 1.0,
        })
    }

    /// The dynamics, without loads, of particles remeshed at `time` with the displacement `u`, and the undeformed
    /// `surface` with their weights.
    ///
    /// # Errors
    /// A body that has turned inside out, a boundary that holds none of it.
    pub fn deformed(
        &self,
        setup: &Setup,
        lattice_particles: &LatticeParticles,
        held: &Held,
        time: f64,
        u: &[f64],
        surface: &TriangleMesh,
    ) -> Result<(Elastic, SurfaceQuadrature), SolidRemeshError> {
        let mut elastic = lattice_particles.elastic(setup, &self.lattice, held, surface, true)?;
        let gradient = elastic.gradient(time, u);
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
            lattice_particles.quadrature(setup, surface, self.lattice.spacing, held, &elastic.lift.folds);
        let elastic = elastic.remeshed(&gradients);
        let elastic = match held {
            Held::Surface(constraints) => elastic.with_surface(
                &quadrature,
                &constraints.holds,
                &lattice_particles.cut,
                &lattice_particles.positions(),
            ),
            Held::Layers(_) => elastic,
        };
        Ok((elastic, quadrature))
    }
}
