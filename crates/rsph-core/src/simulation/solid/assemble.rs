//! From particles on a lattice to the solid's dynamics: its surface, held particles and loads, by where
//! the particles were in the undeformed body.

use super::held::Held;
use super::materials::compositions;
use crate::boundary::flat_face::{self, Faces};
use crate::boundary::fold::Folds;
use crate::boundary::foundation;
use crate::boundary::load::{LoadedBody, nodal_loads};
use crate::boundary::nodal_load::NodalLoad;
use crate::boundary::surface_quadrature::{LoadedParticles, SurfaceQuadrature};
use crate::dynamics::solid::Solid;
use crate::error::InvalidInput;
use crate::grid::Grid;
use crate::lattice::Lattice;
use crate::mesh::TriangleMesh;
use crate::mls::{Cloud, LinearFit};
use crate::moments::area_vectors;
use crate::particles::{Column, Field, Particles};
use crate::remesh::NodeLattice;
use crate::sample::Sight;
use crate::setup::{Load, LoadKind, Setup, SolidSetup};
use crate::tensor::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Tolerance of regions on the surface, in spacings.
pub(super) const TOLERANCE: f64 = 1e-3;

/// Particles at the nodes of a lattice.
#[derive(Clone, Debug)]
pub(super) struct LatticeParticles {
    /// Node of each particle, by z, y, x. No lattice reaches farther than these numbers do.
    nodes: Vec<[i32; 3]>,
    /// Where each was in the undeformed body, X; the column of the particles.
    pub reference: Column,
    /// The volume of the undeformed body that each stands for.
    pub volume: Arc<Vec<f64>>,
    /// Whether the surface cuts the cell of each.
    pub cut: Vec<bool>,
    /// What sees what across gaps of the surface, if it has any.
    sight: Option<Arc<Sight>>,
}

impl LatticeParticles {
    /// Particles at those nodes, which were at `undeformed` and stand for these volumes; the surface cuts the cells of some.
    pub fn new(
        nodes: impl Iterator<Item = [i64; 3]>,
        undeformed: &[Vec3],
        volume: impl Iterator<Item = f64>,
        cut: Vec<bool>,
    ) -> Self {
        Self {
            nodes: nodes.map(|n| n.map(|i| i as i32)).collect(),
            reference: Column::from_vectors(undeformed),
            volume: Arc::new(volume.collect()),
            cut,
            sight: None,
        }
    }

    /// The same particles where nothing acts across the gaps that `sight` tells of.
    pub fn with_sight(self, sight: Option<&Arc<Sight>>) -> Self {
        Self { sight: sight.cloned(), ..self }
    }

    /// `particles` at those nodes.
    pub fn with_columns(nodes: &[[i64; 3]], particles: &Particles, cut: Vec<bool>) -> Self {
        Self {
            nodes: nodes.iter().map(|n| n.map(|i| i as i32)).collect(),
            reference: particles.column(Field::Reference).clone(),
            volume: particles.column(Field::Volume).share(),
            cut,
            sight: None,
        }
    }

    /// The same particles when their dynamics is made and they stay where they are: without their nodes.
    pub fn for_good(self) -> Self {
        Self { nodes: Vec::new(), cut: Vec::new(), ..self }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.reference.len()
    }

    /// Node of each particle.
    pub fn nodes(&self) -> Vec<[i64; 3]> {
        self.nodes.iter().map(|n| n.map(i64::from)).collect()
    }

    /// The particles with these volumes at their reference `positions`, that far apart.
    pub fn cloud<'a>(
        &'a self,
        positions: &'a [Vec3],
        volume: &'a [f64],
        spacing: f64,
        dimension: usize,
    ) -> Cloud<'a> {
        Cloud::new(positions, volume, spacing).in_dimension(dimension).with_sight(self.sight.as_deref())
    }

    /// Where each was in the undeformed body.
    pub fn positions(&self) -> Vec<Vec3> {
        (0..self.len()).map(|a| self.reference.vector(a)).collect()
    }

    /// The dynamics of these particles, which have been `remeshed` or not, without loads and the rest of `surface` than folds.
    ///
    /// # Errors
    /// A boundary that holds none of the particles.
    pub fn solid(
        &self,
        setup: &Setup<SolidSetup>,
        nodes: &NodeLattice<3>,
        held: &Held,
        surface: &TriangleMesh,
        remeshed: bool,
    ) -> Result<Solid, InvalidInput> {
        let low: [i32; 3] = std::array::from_fn(|i| self.nodes.iter().map(|n| n[i]).min().unwrap_or(0));
        let high: [i32; 3] = std::array::from_fn(|i| self.nodes.iter().map(|n| n[i]).max().unwrap_or(0));
        let origin = nodes.origin + Vec3::from_fn(|i, _| f64::from(low[i])) * nodes.spacing;
        let size = std::array::from_fn(|i| (high[i] - low[i] + 1) as usize);
        let cells: Vec<[usize; 3]> =
            self.nodes.iter().map(|n| std::array::from_fn(|i| (n[i] - low[i]) as usize)).collect();
        let grid = Grid { origin, spacing: nodes.spacing, cells: size };
        let mut lattice = Lattice::new(&grid, &cells, setup.solver.smoothing, setup.shape.dimension());
        drop(cells);
        if let Some(sight) = &self.sight {
            let homes: Vec<Vec3> = self.positions().par_iter().map(|x| sight.home(x)).collect();
            let near: Vec<bool> = homes.iter().map(|home| sight.is_near(home)).collect();
            lattice = lattice.cut(|a, b| near[a] && near[b] && sight.is_blocked(&homes[a], &homes[b]));
        }
        let (mut fixed, material) = (held.fixed(&self.positions())?, Arc::clone(&setup.mechanics.material));
        if setup.shape.dimension() == 2 {
            fixed.hold_in_plane(self.len());
        }
        let hourglass = setup.solver.hourglass_modulus(material.young_modulus());
        let folds = match held {
            Held::Surface(constraints) => Folds::new(constraints, surface, &lattice, remeshed),
            Held::Layers(_) => Folds::default(),
        };
        let cells = compositions(&setup.mechanics, &self.positions(), &lattice)?;
        let mut solid = Solid::new(lattice, &self.volume, fixed, material, hourglass);
        if let Some(cells) = cells {
            solid = solid.made_of(setup.mechanics.materials().cloned().collect(), cells);
        }
        Ok(solid.folded(folds, held.holds()))
    }

    /// The undeformed `surface` with the weights of these particles and of their images in `folds`.
    pub fn quadrature(
        &self,
        setup: &Setup<SolidSetup>,
        surface: &TriangleMesh,
        spacing: f64,
        held: &Held,
        folds: &Folds,
    ) -> SurfaceQuadrature {
        let particles = folds.doubled(&self.positions(), &self.volume, spacing);
        let fits = |places: &[Vec3]| -> Vec<LinearFit> {
            let cloud = self
                .cloud(&particles.positions, &particles.volume, spacing, setup.shape.dimension())
                .for_surface(setup.solver.smoothing);
            places.par_iter().map(|x| cloud.fit_at(x)).collect()
        };
        let particles = LoadedParticles { particles: &particles, fits: &fits, sight: self.sight.as_deref() };
        let held_at = |x: &Vec3, n: &Vec3| held.held_at(x, n);
        SurfaceQuadrature::new(surface, setup.shape.dimension(), spacing, &particles, held.holds(), &held_at)
            .on_foundations(&setup.mechanics.foundations, TOLERANCE * spacing, folds)
    }

    /// The loads on the particles of `solid`.
    ///
    /// # Errors
    /// A load that acts on nothing.
    pub fn loads(
        &self,
        setup: &Setup<SolidSetup>,
        solid: &Solid,
        (boundary, surface): (&TriangleMesh, &SurfaceQuadrature),
        held: &Held,
    ) -> Result<Vec<NodalLoad>, InvalidInput> {
        // In the scheme of the paper the faces of a box are loaded by area vectors.
        let on_faces = |l: &Load| matches!(l.kind, LoadKind::Traction { .. } | LoadKind::Pressure { .. });
        let by_faces = matches!(held, Held::Layers(_)) && setup.shape.is_box();
        let area = (by_faces && setup.mechanics.loads.iter().any(on_faces))
            .then(|| area_vectors(&solid.lattice, &solid.moments(), &[]));
        let (spacing, positions) = (solid.lattice.spacing, self.positions());
        let follows = |l: &Load| matches!(l.kind, LoadKind::FollowerPressure { .. });
        let cloud = (!solid.is_linear() && setup.mechanics.loads.iter().any(follows))
            .then(|| Cloud::new(&positions, &self.volume, spacing).in_dimension(setup.shape.dimension()));
        let gradient_weights =
            |x: &Vec3| cloud.as_ref().map_or_else(Vec::new, |cloud| cloud.gradient_weights(x));
        let loaded = LoadedBody {
            shape: &*setup.shape,
            mass: &solid.mass,
            positions: &positions,
            spacing,
            tolerance: TOLERANCE * spacing,
            boundary,
            surface,
            gradient_weights: cloud.as_ref().map(|_| &gradient_weights as _),
            faces: area.as_deref().map(|area_vectors| Faces {
                area_vectors,
                depth: flat_face::DEPTH * solid.lattice.smoothing_length,
                tolerance: flat_face::TOLERANCE,
            }),
        };
        foundation::check(&setup.mechanics.foundations, surface, matches!(held, Held::Layers(_)))?;
        nodal_loads(&setup.mechanics.loads, &loaded)
    }
}
