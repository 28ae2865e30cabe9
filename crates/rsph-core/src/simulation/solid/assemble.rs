//! From particles on a lattice to the solid's dynamics: mirror planes, held particles and loads, by where
//! the particles were in the undeformed body.

use crate::boundary::flat_face;
use crate::boundary::load::{LoadedBody, nodal_loads};
use crate::boundary::mirror::Mirror;
use crate::boundary::nodal_load::NodalLoad;
use crate::boundary::skin::{Carriers, Skin};
use crate::boundary::tag::Holds;
use crate::dynamics::elastic::Elastic;
use crate::error::InvalidInput;
use crate::fit::LinearFit;
use crate::grid::Grid;
use crate::lattice::Lattice;
use crate::mls::Cloud;
use crate::moments::area_vectors;
use crate::particles::{Column, Field, Particles};
use crate::remesh::NodeLattice;
use crate::setup::{Load, LoadKind, Setup};
use crate::shape::Shape;
use crate::tensor::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Particles laid on a lattice.
#[derive(Clone, Debug)]
pub(super) struct Laid {
    /// Node of each particle, by z, y, x. No lattice reaches farther than these numbers do.
    nodes: Vec<[i32; 3]>,
    /// Where each was in the undeformed body, X; the column of the particles.
    pub reference: Column,
    /// The volume of the undeformed body that each stands for.
    pub volume: Arc<Vec<f64>>,
}

impl Laid {
    /// Particles at those nodes, which were at `undeformed` and stand for these volumes.
    pub fn new(
        nodes: impl Iterator<Item = [i64; 3]>,
        undeformed: &[Vec3],
        volume: impl Iterator<Item = f64>,
    ) -> Self {
        Self {
            nodes: nodes.map(|n| n.map(|i| i as i32)).collect(),
            reference: Column::from_vectors(undeformed),
            volume: Arc::new(volume.collect()),
        }
    }

    /// `particles` at those nodes.
    pub fn with_columns(nodes: &[[i64; 3]], particles: &Particles) -> Self {
        Self {
            nodes: nodes.iter().map(|n| n.map(|i| i as i32)).collect(),
            reference: particles.column(Field::Reference).clone(),
            volume: particles.column(Field::Volume).share(),
        }
    }

    /// The same particles when their dynamics is made and they stay where they are: without their nodes.
    pub fn for_good(self) -> Self {
        Self { nodes: Vec::new(), ..self }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.reference.len()
    }

    /// Node of each particle.
    pub fn nodes(&self) -> Vec<[i64; 3]> {
        self.nodes.iter().map(|n| n.map(i64::from)).collect()
    }

    /// Where each was in the undeformed body.
    pub fn positions(&self) -> Vec<Vec3> {
        (0..self.len()).map(|a| self.reference.vector(a)).collect()
    }

    /// The dynamics of these particles, without loads, with its mirror planes where they are at `time`.
    ///
    /// # Errors
    /// A boundary that holds none of the particles.
    pub fn elastic(
        &self,
        setup: &Setup,
        nodes: &NodeLattice<3>,
        holds: &Holds,
        time: f64,
    ) -> Result<Elastic, InvalidInput> {
        let low: [i32; 3] = std::array::from_fn(|i| self.nodes.iter().map(|n| n[i]).min().unwrap_or(0));
        let high: [i32; 3] = std::array::from_fn(|i| self.nodes.iter().map(|n| n[i]).max().unwrap_or(0));
        let origin = nodes.origin + Vec3::from_fn(|i, _| f64::from(low[i])) * nodes.spacing;
        let size = std::array::from_fn(|i| (high[i] - low[i] + 1) as usize);
        let cells: Vec<[usize; 3]> =
            self.nodes.iter().map(|n| std::array::from_fn(|i| (n[i] - low[i]) as usize)).collect();
        let grid = Grid { origin, spacing: nodes.spacing, cells: size };
        let lattice = Lattice::new(&grid, &cells, setup.solver.smoothing);
        drop(cells);
        let (fixed, material) = (holds.fixed(&self.positions())?, Arc::clone(&setup.material));
        let positions: Vec<Vec3> = self.nodes.iter().map(|n| nodes.position(n.map(i64::from))).collect();
        let body = |a: usize| fixed.apart.binary_search(&a).is_err();
        let mirror = Mirror::new(&lattice, &positions, holds.planes_at(time), body);
        drop(positions);
        Ok(Elastic::new(lattice, &self.volume, mirror, fixed, material, setup.solver.hourglass))
    }

    /// The loads on the particles of `elastic`; `skin` as for [`nodal_loads`].
    ///
    /// # Errors
    /// A load that acts on nothing.
    pub fn loads(
        &self,
        setup: &Setup,
        elastic: &Elastic,
        skin: Option<&mut Option<Skin>>,
    ) -> Result<Vec<NodalLoad>, InvalidInput> {
        // Only the faces of a box are loaded by them.
        let on_faces = |l: &Load| matches!(l.kind, LoadKind::Traction { .. } | LoadKind::Pressure { .. });
        let area = if setup.shape.is_box() && setup.loads.iter().any(on_faces) {
            area_vectors(&elastic.lattice, &elastic.moments(), &elastic.mirror, &elastic.stretch)
        } else {
            Vec::new()
        };
        let (spacing, positions) = (elastic.lattice.spacing, self.positions());
        let loaded = LoadedBody {
            shape: &*setup.shape,
            mass: &elastic.mass,
            positions: &positions,
            area_vectors: &area,
            spacing,
            face_depth: flat_face::DEPTH * elastic.lattice.smoothing_length,
            face_tolerance: flat_face::TOLERANCE,
            tolerance: 1e-3 * spacing,
        };
        let fits = |places: &[Vec3]| fits(&positions, spacing, places);
        let carriers = Carriers { positions: &positions, fits: &fits };
        nodal_loads(&setup.loads, &loaded, skin, &carriers)
    }

    /// The surface of the undeformed body with the particles that carry its loads.
    pub fn skin(&self, shape: &dyn Shape, spacing: f64) -> Skin {
        let positions = self.positions();
        let fits = |places: &[Vec3]| fits(&positions, spacing, places);
        Skin::new(shape.surface(), spacing, &Carriers { positions: &positions, fits: &fits })
    }
}

/// Linear fits of the particles around places.
fn fits(positions: &[Vec3], spacing: f64, places: &[Vec3]) -> Vec<LinearFit> {
    let cloud = Cloud::new(positions, spacing);
    places.par_iter().map(|x| cloud.fit_at(x)).collect()
}
