//! A body at rest, and what is read on its surface.

use rsph_core::material::KelvinVoigt;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Boundary, Curve, Fix, Load, LoadKind, Setup, SolidSetup, Solver, Units};
use rsph_core::shape::Shape;
use rsph_core::simulation::{Equilibrium, Simulation};
use rsph_core::tensor::{SymTensor, Vec3};
use std::sync::Arc;

/// Young's modulus of all bodies: displacements stay small against them. Results are for E = 1.
pub const YOUNG: f64 = 1e6;

/// A body at rest.
#[derive(Clone)]
pub struct Case {
    pub shape: Arc<dyn Shape>,
    pub spacing: f64,
    /// Poisson's ratio.
    pub nu: f64,
    pub boundaries: Vec<Boundary>,
    pub loads: Vec<LoadKind>,
}

impl Case {
    /// The equilibrium by the accurate solver, with the compliance for E = 1.
    pub fn solve(self) -> Result<(Simulation, Equilibrium), String> {
        self.solve_by(Solver::ACCURATE)
    }

    /// The equilibrium by `solver`, with the compliance for E = 1.
    pub fn solve_by(self, solver: Solver) -> Result<(Simulation, Equilibrium), String> {
        let mut body = self.body(solver)?;
        let found = body.solve_static(0.0, &mut |_, _| true).map_err(|e| e.to_string())?;
        Ok((body, Equilibrium { compliance: YOUNG * found.compliance, ..found }))
    }

    /// The body before it is loaded.
    pub fn body(self, solver: Solver) -> Result<Simulation, String> {
        let Self { shape, spacing, nu, boundaries, loads } = self;
        let load = |kind| Load { kind, curve: Curve::default() };
        Simulation::new(Setup {
            units: Units::Normalised,
            solver,
            ..Setup::new(
                shape,
                Resolution::Spacing(spacing),
                SolidSetup {
                    foundations: Vec::new(),
                    material: Arc::new(KelvinVoigt::new(1.0, YOUNG, nu, 0.0).map_err(|e| e.to_string())?),
                    boundaries,
                    loads: loads.into_iter().map(load).collect(),
                },
            )
        })
        .map_err(|e| e.to_string())
    }
}

/// The half-space beyond the plane through `point` with the outward normal `out`.
pub fn beyond(point: Vec3, out: Vec3) -> Region {
    Region::HalfSpace { point, normal: -out }
}

pub fn hold(region: Region, fix: Fix) -> Boundary {
    Boundary { name: None, region, fix, motion: None }
}

/// A plane of symmetry through the origin, with the body on its upper side.
pub fn symmetry(axis: Axis) -> Boundary {
    hold(Region::Plane { axis, at: 0.0, side: Side::Below }, Fix::Normal)
}

/// Undeformed place of a vertex of the surface and the fields there, displacement and strain for E = 1.
pub struct VertexFields {
    pub x: Vec3,
    /// Outward normal of the undeformed surface.
    pub normal: Vec3,
    /// A third of the triangles around it.
    pub area: f64,
    pub u: Vec3,
    pub strain: SymTensor,
    pub stress: SymTensor,
    pub normal_strain: f64,
}

/// The fields at the vertices of the surface of `body`, times `scale` for displacement and strain.
pub fn read(body: &mut Simulation, scale: f64) -> Vec<VertexFields> {
    let snapshot = body.snapshot();
    let surface = body.surface(&snapshot);
    let field = |name: &str| surface.field(name).map_or(&[][..], |f| &f.values);
    let (u, strain, stress) = (field("displacement"), field("strain"), field("stress"));
    let normal_strain = field("normal_strain");
    let tensor = |values: &[f64], i: usize| SymTensor(std::array::from_fn(|c| values[6 * i + c]));
    let moved = &surface.mesh;
    let u: Vec<Vec3> = u.chunks_exact(3).map(Vec3::from_column_slice).collect();
    let x: Vec<Vec3> = moved.vertices.iter().zip(&u).map(|(x, u)| x - u).collect();
    // Twice the area vectors of the triangles around a vertex.
    let mut around = vec![(0.0, Vec3::zeros()); x.len()];
    for t in &moved.triangles {
        let [a, b, c] = t.map(|v| x[v as usize]);
        let area = (b - a).cross(&(c - a));
        for v in t {
            let (sum, vector) = &mut around[*v as usize];
            (*sum, *vector) = (*sum + area.norm(), *vector + area);
        }
    }
    let vertex = |(i, (area, normal)): (usize, (f64, Vec3))| VertexFields {
        x: x[i],
        normal: normal.normalize(),
        area: area / 6.0,
        u: u[i] * scale,
        strain: tensor(strain, i) * scale,
        stress: tensor(stress, i),
        normal_strain: normal_strain[i] * scale,
    };
    around.into_iter().enumerate().map(vertex).collect()
}
