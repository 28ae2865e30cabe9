//! A solid laid anew on its lattice, where it is now.
//!
//! What a solid carries are fields on the undeformed body: where a particle was, X, its displacement and
//! velocity. They are found at the new nodes by inverting the motion since the last remesh
//! ([`Carried`]); mass and volume follow from the undeformed body itself, of whose cells X says how much
//! is inside. So nothing that a remesh does adds up from one to the next but the interpolation of the
//! displacement.

use super::assemble::Laid;
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
use std::sync::Arc;

/// How far, in spacings, the share of a cell that is too little for a particle may travel to one.
const FOLD_REACH: usize = 4;
/// Largest share of the volume that the cells of the deformed body may lack or have too much.
const WORST_VOLUME: f64 = 0.1;

/// The undeformed body, as a remesh needs it.
#[derive(Clone, Debug)]
pub(super) struct Undeformed {
    /// The lattice, of all remeshes.
    pub lattice: NodeLattice<3>,
    /// How much of a cell lies inside; `None` if the particles stay where they are.
    inside: Option<InsideFraction>,
    /// Volume of the particles.
    volume: f64,
}

/// Why a solid can not be laid anew.
#[derive(Debug, thiserror::Error)]
pub(super) enum LayError {
    #[error(transparent)]
    Lattice(#[from] RemeshError),
    #[error("the body has turned inside out between two remeshings")]
    Inverted(Vec3),
    #[error("{:.1} % of the body would be lost or doubled: it has torn, or moved too far between two remeshings", 100.0 * .0)]
    Volume(f64),
    #[error("after remeshing, {0}")]
    Untagged(#[from] InvalidInput),
}

impl LayError {
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

/// A solid laid anew.
#[derive(Debug)]
pub(super) struct Anew {
    pub laid: Laid,
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
    pub fn new(shape: &dyn Shape, body: &Body, remeshed: bool) -> (Self, Laid) {
        let dx = body.grid.spacing;
        let lattice = NodeLattice { origin: body.grid.origin, spacing: dx };
        let nodes = body.cells.iter().map(|c| c.map(|i| i as i64));
        let undeformed: Vec<Vec3> = body.cells.iter().map(|c| body.grid.centre(*c)).collect();
        let laid = Laid::new(nodes, &undeformed, body.volume.iter().copied(), body.cut());
        let inside = remeshed.then(|| InsideFraction::new(shape, body));
        (Self { lattice, inside, volume: laid.volume.iter().sum() }, laid)
    }

    /// Inside fraction of the cell around `x`.
    fn fraction_at(&self, x: &Vec3) -> f64 {
        self.inside.as_ref().map_or(0.0, |inside| inside.at(x))
    }

    /// Whether the surface cuts the cells of particles that were at these places of the undeformed body.
    pub fn cut_at<'a>(&self, places: impl Iterator<Item = &'a Vec3>) -> Vec<bool> {
        places.map(|x| is_cut(self.fraction_at(x))).collect()
    }

    /// Lays the particles anew that started at `nodes`; `fields` are what they carry, the displacement
    /// first and the velocity second.
    ///
    /// # Errors
    /// A body that no lattice holds, that has torn or turned inside out.
    pub fn lay(
        &self,
        setup: &Setup,
        held: &Held,
        (nodes, particles): (&[[i64; 3]], &Particles),
        fields: &[Field],
        time: f64,
        surface: &TriangleMesh,
    ) -> Result<Anew, LayError> {
        let (n, dx) = (particles.len(), self.lattice.spacing);
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
        let carried = Carried { lattice: self.lattice, nodes, shift: &shift, columns, values: &values };
        let arrived = carried.follow(setup.remesh.kernel)?;

        // Which nodes hold a particle, and how much of the body.
        let place = |k: usize| {
            let x = self.lattice.position(arrived.nodes[k]);
            (x, x - Vec3::from_column_slice(&arrived.values[k * columns..k * columns + 3]))
        };
        let fraction: Vec<f64> = (0..arrived.nodes.len()).map(|k| self.fraction_at(&place(k).1)).collect();
        let inside: Vec<usize> = (0..fraction.len()).filter(|k| fraction[*k] > 0.0).collect();
        let pick = |of: &[[i64; 3]]| -> Vec<[i64; 3]> { inside.iter().map(|&k| of[k]).collect() };
        let shares: Vec<f64> = inside.iter().map(|&k| fraction[k]).collect();
        let mut shares = NodeValues::from_nodes(self.lattice, &pick(&arrived.nodes), 1, &shares)?;
        let mut keep = vec![false; shares.len()];
        let mut kept = Vec::new();
        for &k in &inside {
            let enough = fraction[k] >= MIN_FRACTION * (1.0 - 1e-9);
            if enough && let Some(number) = shares.number(arrived.nodes[k]) {
                keep[number] = true;
                kept.push((k, number));
            }
        }
        let folded = fold(&mut shares, &keep, FOLD_REACH);

        let undeformed: Vec<Vec3> = kept.iter().map(|(k, _)| place(*k).1).collect();
        let mut laid = Laid::new(
            kept.iter().map(|(k, _)| arrived.nodes[*k]),
            &undeformed,
            kept.iter().map(|(_, number)| shares.values[*number] * dx.powi(3)),
            self.cut_at(undeformed.iter()),
        );
        let len = kept.len();
        if len == 0 {
            return Err(LayError::Volume(1.0));
        }
        let column = |first: usize, components: usize| {
            let mut data = vec![0.0; components * len];
            for (a, (k, _)) in kept.iter().enumerate() {
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

        // A cell of the deformed body holds dx^3 det(dX/dx) of the undeformed one.
        let gradient = laid.elastic(setup, &self.lattice, held)?.gradient(time, u);
        let volume = Arc::make_mut(&mut laid.volume);
        for (a, g) in gradient.iter().enumerate() {
            let share = (Mat3::identity() - g).determinant();
            if share.is_nan() || share <= 0.0 {
                return Err(LayError::Inverted(undeformed[a]));
            }
            volume[a] *= share;
        }
        let scale = self.volume / volume.iter().sum::<f64>();
        if scale.is_nan() || (scale - 1.0).abs() > WORST_VOLUME {
            return Err(LayError::Volume((1.0 / scale - 1.0).abs()));
        }
        for v in volume {
            *v *= scale;
        }
        let (elastic, quadrature) = self.deformed(setup, &laid, held, time, u, surface)?;
        new.set(Field::Reference, laid.reference.clone());
        new.set(Field::Mass, Column::shared(Arc::clone(&elastic.mass), len));
        new.set(Field::Volume, Column::shared(Arc::clone(&laid.volume), len));
        let folded_mass = folded.moved[0] * dx.powi(3) * setup.material.density();
        let undeformed = (0..arrived.nodes.len()).map(|k| place(k).1).collect();
        let around = (arrived.nodes, undeformed);
        Ok(Anew { around, laid, elastic, quadrature, particles: new, folded_mass, rescaling: scale - 1.0 })
    }

    /// The dynamics, without loads, of particles remeshed at `time` with the displacement `u`, and the undeformed
    /// `surface` with their weights.
    ///
    /// # Errors
    /// A body that has turned inside out, a boundary that holds none of it.
    pub fn deformed(
        &self,
        setup: &Setup,
        laid: &Laid,
        held: &Held,
        time: f64,
        u: &[f64],
        surface: &TriangleMesh,
    ) -> Result<(Elastic, SurfaceQuadrature), LayError> {
        let mut elastic = laid.elastic(setup, &self.lattice, held)?;
        let gradient = elastic.gradient(time, u);
        let stretch = gradient
            .iter()
            .enumerate()
            .map(|(a, g)| {
                (Mat3::identity() - g).try_inverse().ok_or(LayError::Inverted(laid.reference.vector(a)))
            })
            .collect::<Result<_, _>>()?;
        let quadrature = laid.quadrature(setup, surface, self.lattice.spacing, held);
        let elastic = elastic.stretched(stretch);
        let elastic = match held {
            Held::Surface(constraints) => {
                elastic.with_surface(&quadrature, &constraints.holds, &laid.cut, &laid.positions())
            }
            Held::Layers(_) => elastic,
        };
        Ok((elastic, quadrature))
    }
}
