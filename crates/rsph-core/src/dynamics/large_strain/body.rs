//! A body at large strain with what survives a remesh: its shape, its boundaries and loads as regions of the
//! undeformed body, and its mass.

use super::LargeStrain;
use super::configuration::Configuration;
use super::ghosts::{Ghosts, displacement};
use crate::boundary::fixed::Fixed;
use crate::boundary::flat_face::Faces;
use crate::boundary::load::{LoadedBody, nodal_loads};
use crate::boundary::mirror::MirrorPlane;
use crate::boundary::surface_quadrature::{LoadedParticles, SurfaceQuadrature};
use crate::boundary::tag::{self, Holds};
use crate::error::InvalidInput;
use crate::fit::{Degree, LocalFit};
use crate::kernel::QuarticSpline;
use crate::material::Material;
use crate::mls::PointWeights;
use crate::neighbors::CellList;
use crate::region::Region;
use crate::remesh::inversion::AxisLattice;
use crate::sample::{Alignment, Body, MIN_FRACTION, sample};
use crate::setup::{Load, Setup, Solver};
use crate::shape::Shape;
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Depth below a flat face, in smoothing lengths, over which its area vectors spread.
const FACE_DEPTH: f64 = 2.7;
/// Largest relative deviation of their sum from the area of the face: far from exact on a deformed lattice,
/// and scaled.
const FACE_TOLERANCE: f64 = 0.2;

/// Default weight of the hourglass term.
pub(super) const HOURGLASS: f64 = 0.2;

/// A body at large strain.
#[derive(Clone, Debug)]
pub struct LargeBody<const D: usize> {
    /// The forces on its particles.
    pub dynamics: LargeStrain<D>,
    /// Lattice of the last remesh.
    pub lattice: AxisLattice,
    /// Spacing of the undeformed lattice.
    pub spacing: f64,
    pub(super) shape: Arc<dyn Shape>,
    pub(super) material: Arc<dyn Material>,
    pub(super) solver: Solver,
    holds: Holds,
    loads: Vec<Load>,
    /// Mirror planes where they are in the undeformed state, and the side of them where the body lies.
    pub(super) planes: Vec<(MirrorPlane, f64)>,
    /// What the last remesh was made from, if there was one.
    pub(super) laid: Option<LastRemesh>,
}

/// What the configuration that a remesh leaves is made from again.
#[derive(Clone, Debug)]
pub(super) struct LastRemesh {
    /// When it was.
    pub time: f64,
    /// Nodes of the particles before a free body was moved back to its centre of mass.
    pub nodes: Vec<Vec3>,
}

/// Cells of a lattice that the body may fill.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    /// Nodes.
    pub nodes: Vec<Vec3>,
    /// Inside fractions.
    pub fraction: Vec<f64>,
    /// Reference positions.
    pub reference: Vec<Vec3>,
}

impl<const D: usize> LargeBody<D> {
    /// Samples the undeformed body of `setup`, whose shape has `D` dimensions.
    ///
    /// # Errors
    /// The first input that can not be simulated.
    pub fn sampled(setup: &Setup) -> Result<(Self, Body), InvalidInput> {
        let body = sample(&*setup.shape, setup.resolution, &alignment(setup))?;
        let (grid, dx) = (&body.grid, body.grid.spacing);
        let lattice = AxisLattice { origin: grid.origin, spacing: Vec3::repeat(dx) };
        let nodes: Vec<Vec3> = body.cells.iter().map(|c| grid.centre(*c)).collect();
        let large = Self::new(setup, lattice, dx, nodes, body.fraction.clone())?;
        Ok((large, body))
    }

    /// The undeformed body with a particle in every cell of `lattice` at `nodes` that is filled by
    /// `fraction`; boundaries and loads are those of `setup`.
    ///
    /// # Errors
    /// The first input that can not be simulated.
    pub fn new(
        setup: &Setup,
        lattice: AxisLattice,
        spacing: f64,
        nodes: Vec<Vec3>,
        fraction: Vec<f64>,
    ) -> Result<Self, InvalidInput> {
        let holds = tag::holds(&setup.boundaries, &nodes, spacing, &setup.solver)?;
        let middle = nodes.iter().sum::<Vec3>() / nodes.len() as f64;
        let side = |p: &MirrorPlane| (middle[p.axis] - p.at).signum();
        if let Some(i) = setup.boundaries.iter().position(|b| leaves_plane::<D>(&b.region)) {
            return Err(InvalidInput::new(
                format!("boundary[{i}].region"),
                "plane across z",
                "a plane body has no extent in z",
                "hold it at a plane across x or y",
            ));
        }
        let planes: Vec<_> = holds.planes.iter().map(|p| (*p, side(p))).collect();
        let cells = Cells { reference: nodes.clone(), nodes, fraction };
        let configuration =
            configuration(&cells, &planes, 0.0, setup.solver.smoothing * spacing, lattice.cell_volume::<D>());
        let dynamics =
            LargeStrain::new(configuration, Arc::clone(&setup.material), HOURGLASS * setup.solver.hourglass)?;
        let mut body = Self {
            dynamics,
            lattice,
            spacing,
            shape: Arc::clone(&setup.shape),
            material: Arc::clone(&setup.material),
            solver: setup.solver,
            holds,
            loads: setup.loads.clone(),
            planes,
            laid: None,
        };
        body.dynamics.fixed = body.held_among(body.reference())?;
        body.tag_loads()?;
        Ok(body)
    }

    /// Nodes of the particles.
    pub fn nodes(&self) -> &[Vec3] {
        &self.dynamics.configuration.nodes[..self.dynamics.len()]
    }

    /// Reference positions of the particles.
    pub fn reference(&self) -> &[Vec3] {
        &self.dynamics.configuration.reference[..self.dynamics.len()]
    }

    /// Whether nothing holds the body.
    pub fn is_free(&self) -> bool {
        self.planes.is_empty() && self.dynamics.fixed.particles.is_empty()
    }

    /// The configuration of some cells at time `t`.
    pub(super) fn configuration_of(&self, cells: &Cells, t: f64, cell_volume: f64) -> Configuration<D> {
        configuration(cells, &self.planes, t, self.solver.smoothing * self.spacing, cell_volume)
    }

    /// Reference positions by which regions find the particles.
    pub fn tagging_positions(&self) -> Vec<Vec3> {
        self.pulled_inside(self.reference())
    }

    /// Reference positions as regions see them: the node of a cut cell may lie outside of the body and counts
    /// as just inside.
    fn pulled_inside(&self, reference: &[Vec3]) -> Vec<Vec3> {
        let margin = 1e-3 * self.spacing;
        let pulled = |x: &Vec3| {
            let beyond = self.shape.signed_distance(x) + margin;
            if beyond <= 0.0 {
                return *x;
            }
            let slope = Vec3::from_fn(|i, _| {
                let e = Vec3::ith(i, margin);
                self.shape.signed_distance(&(x + e)) - self.shape.signed_distance(&(x - e))
            });
            slope.try_normalize(0.0).map_or(*x, |normal| x - normal * beyond)
        };
        reference.par_iter().map(pulled).collect()
    }

    /// Signed distances of the particles to the surface of the undeformed body.
    pub fn level_set(&self) -> Vec<f64> {
        self.reference().par_iter().map(|x| self.shape.signed_distance(x)).collect()
    }

    /// The particles with these reference positions that thick clamps hold.
    pub(super) fn held_among(&self, reference: &[Vec3]) -> Result<Fixed, InvalidInput> {
        let positions = self.pulled_inside(reference);
        self.holds.fixed(&positions)
    }

    /// Spreads the loads over the particles, by their reference positions.
    pub(super) fn tag_loads(&mut self) -> Result<(), InvalidInput> {
        let positions = self.tagging_positions();
        let area: Vec<Vec3> = self.dynamics.surface_forces(&Mat3::identity());
        let surface = self.surface_quadrature();
        let loaded = LoadedBody {
            shape: &*self.shape,
            mass: &self.dynamics.mass,
            positions: &positions,
            spacing: self.spacing,
            tolerance: 1e-3 * self.spacing,
            surface: &surface,
            faces: Some(Faces {
                area_vectors: &area,
                depth: FACE_DEPTH * self.dynamics.configuration.smoothing_length,
                tolerance: FACE_TOLERANCE,
            }),
        };
        self.dynamics.loads = nodal_loads(&self.loads, &loaded)?;
        Ok(())
    }

    /// The surface of the undeformed body with the particles that carry its loads.
    pub fn surface_quadrature(&self) -> SurfaceQuadrature {
        let fits =
            |places: &[Vec3]| self.fits(Degree::Linear, self.reference(), places, |_, fit| fit.linear());
        let particles = LoadedParticles { positions: self.reference(), fits: &fits };
        SurfaceQuadrature::new(self.shape.surface(), self.spacing, &particles, &[], &|_, _| None)
    }

    /// Weights of the particles at points of the undeformed body.
    pub fn weights(&self, degree: Degree, points: &[Vec3]) -> PointWeights {
        let rows: Vec<_> = self.fits(degree, self.reference(), points, |x, fit| fit.weights_at(x).collect());
        PointWeights::from_rows(rows)
    }

    /// Where points of the undeformed body are when its particles are at `x` at time `t`: quadratic moving
    /// least squares over particles and mirror ghosts.
    pub fn positions_of(&mut self, points: &[Vec3], x: &[Vec3], t: f64) -> Vec<Vec3> {
        let c = &mut self.dynamics.configuration;
        c.ghosts.set_time(t);
        let mut all = x.to_vec();
        let images = c.ghosts.list.iter().enumerate();
        all.extend(images.map(|(i, ghost)| c.ghosts.position(i, &c.nodes, x[ghost.partner])));
        let reference = &self.dynamics.configuration.reference;
        let rows: Vec<Vec<_>> =
            self.fits(Degree::Quadratic, reference, points, |x, fit| fit.weights_at(x).collect());
        rows.iter().map(|r| r.iter().map(|(b, w)| all[*b as usize] * *w).sum()).collect()
    }

    /// What `read` makes of each point and the fit around the particle nearest to it.
    fn fits<T: Send>(
        &self,
        degree: Degree,
        reference: &[Vec3],
        points: &[Vec3],
        read: impl Fn(&Vec3, &LocalFit<D>) -> T + Sync,
    ) -> Vec<T> {
        let cells = CellList::new(reference, self.spacing);
        let fit = |x: &Vec3| {
            let x = if D == 2 { Vec3::new(x.x, x.y, 0.0) } else { *x };
            let anchor = cells.nearest(reference, &x, f64::INFINITY).map_or(x, |n| reference[n.0]);
            read(&x, &LocalFit::<D>::new(degree, &cells, reference, &anchor))
        };
        points.par_iter().map(fit).collect()
    }

    /// Signed distance of the undeformed body without its clamped faces: nothing is cut off there.
    pub(super) fn distance_within(&self, x: &Vec3) -> f64 {
        let mut x = *x;
        for (plane, side) in &self.planes {
            let depth = (x[plane.axis] - plane.at) * side;
            if depth < self.spacing {
                x[plane.axis] = plane.at + side * self.spacing;
            }
        }
        self.shape.signed_distance(&x)
    }

    /// The lattice for a remesh at time `t`: of the spacing of the undeformed one, with every clamped plane
    /// half way between two nodes.
    pub(super) fn lattice_at(&self, t: f64) -> AxisLattice {
        let mut new = AxisLattice { origin: self.lattice.origin, spacing: Vec3::repeat(self.spacing) };
        for axis in 0..D {
            let on_axis = self.planes.iter().map(|p| &p.0).filter(|p| p.axis == axis);
            let mut at: Vec<f64> = on_axis.map(|p| p.at + displacement(p, t)[axis]).collect();
            at.sort_by(f64::total_cmp);
            if let (Some(first), Some(last)) = (at.first(), at.last()) {
                new.origin[axis] = *first;
                if last > first {
                    let cells = ((last - first) / self.spacing).round().max(1.0);
                    new.spacing[axis] = (last - first) / cells;
                }
            }
        }
        new
    }

    /// Whether a place lies on the body's side of every clamped plane at time `t`.
    pub(super) fn is_inside_planes(&self, p: &Vec3, t: f64) -> bool {
        let beyond = |(plane, side): &(MirrorPlane, f64)| {
            (p[plane.axis] - plane.at - displacement(plane, t)[plane.axis]) * side <= 0.0
        };
        !self.planes.iter().any(beyond)
    }
}

/// Whether a region is a plane across z of a plane body.
fn leaves_plane<const D: usize>(region: &Region) -> bool {
    matches!(region, Region::Plane { axis, .. } if *axis as usize >= D)
}

/// Where the lattice must lie: planes inside the body as thick clamps want it, those on its faces half way
/// between two nodes. The faces of boxes are there without asking.
fn alignment(setup: &Setup) -> Vec<Alignment> {
    if setup.shape.is_box() {
        return Vec::new();
    }
    let bounds = setup.shape.bounds();
    let mut found = tag::alignment(&setup.boundaries, &bounds, &setup.solver);
    for boundary in &setup.boundaries {
        if let Region::Plane { axis, at, .. } = boundary.region {
            let axis = axis as usize;
            if (at <= bounds.min[axis] || at >= bounds.max[axis]) && found.iter().all(|a| a.axis != axis) {
                found.push(Alignment { axis, at, offset: 0.5 });
            }
        }
    }
    found
}

/// The mirror images of particles that are laid at `nodes` at time `t`.
pub(super) fn ghosts<const D: usize>(
    planes: &[(MirrorPlane, f64)],
    t: f64,
    nodes: &[Vec3],
    smoothing_length: f64,
) -> Ghosts {
    let undeformed: Vec<MirrorPlane> = planes.iter().map(|p| p.0).collect();
    Ghosts::new(&undeformed, t, nodes, QuarticSpline::<D>::new(smoothing_length).support())
}

/// Particles in the cells that are filled by a tenth and have neighbours on all sides; what is in the others
/// goes to the nearest of these.
fn configuration<const D: usize>(
    cells: &Cells,
    planes: &[(MirrorPlane, f64)],
    t: f64,
    smoothing_length: f64,
    cell_volume: f64,
) -> Configuration<D> {
    let mut kept: Vec<usize> =
        (0..cells.nodes.len()).filter(|&c| cells.fraction[c] >= MIN_FRACTION).collect();
    loop {
        let nodes: Vec<Vec3> = kept.iter().map(|&c| cells.nodes[c]).collect();
        let mut volume: Vec<f64> = kept.iter().map(|&c| cells.fraction[c] * cell_volume).collect();
        let near = CellList::new(&nodes, smoothing_length);
        let mut next = kept.iter().peekable();
        for c in 0..cells.nodes.len() {
            if next.next_if(|k| **k == c).is_none()
                && cells.fraction[c] > 0.0
                && let Some((k, _)) = near.nearest(&nodes, &cells.nodes[c], 4.0 * smoothing_length)
            {
                volume[k] += cells.fraction[c] * cell_volume;
            }
        }
        let reference = kept.iter().map(|&c| cells.reference[c]).collect();
        let ghosts = ghosts::<D>(planes, t, &nodes, smoothing_length);
        let new = Configuration::new(nodes, reference, volume, ghosts, smoothing_length);
        let poor = new.without_gradient();
        if poor.is_empty() || poor.len() == kept.len() {
            return new;
        }
        let mut poor = poor.into_iter().peekable();
        let mut number = 0;
        kept.retain(|_| {
            number += 1;
            poor.next_if(|p| p + 1 == number).is_none()
        });
    }
}
