//! One V-cycle of multigrid on a clamped cube.

use rsph_core::boundary::constraints::Constraints;
use rsph_core::boundary::fixed::Fixed;
use rsph_core::boundary::fold::Folds;
use rsph_core::boundary::surface_quadrature::{LoadedParticles, SurfaceQuadrature};
use rsph_core::dynamics::Scales;
use rsph_core::dynamics::solid::Solid;
use rsph_core::lattice::Lattice;
use rsph_core::material::KelvinVoigt;
use rsph_core::mls::Cloud;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::{Resolution, sample};
use rsph_core::setup::{Boundary, Fix, Solver};
use rsph_core::shape::{BoxShape, Shape};
use rsph_core::solve::multigrid::Multigrid;
use rsph_core::solve::operator::{Preconditioner, Shifted};
use rsph_core::solve::sums::noise;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// A body with its hierarchy and a residual.
pub struct Cycle {
    solid: Solid,
    multigrid: Multigrid,
    residual: Vec<f64>,
    correction: Vec<f64>,
}

impl Cycle {
    /// n^3 particles with h = 0.8 dx, clamped below.
    pub fn new(n: usize) -> Self {
        let spacing = 1.0 / n as f64;
        let cube = BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).expect("a unit cube");
        let body = sample(&cube, Resolution::Spacing(spacing), &[]).expect("whole cells");
        let positions: Vec<Vec3> = body.cells.iter().map(|c| body.grid.centre(*c)).collect();
        let region = Region::Plane { axis: Axis::Z, at: 0.0, side: Side::Below };
        let clamp = Boundary { name: None, region, fix: Fix::ALL, motion: None };
        let constraints =
            Constraints::new(&[clamp], cube.surface(), &positions, spacing).expect("a clamped face");
        let lattice = Lattice::new(&body.grid, &body.cells, 0.8, 3);
        let folds = Folds::new(&constraints, cube.surface(), &lattice, false);
        let doubled = folds.doubled(&positions, &body.volume, spacing);
        let cloud = Cloud::new(&doubled.positions, &doubled.volume, spacing);
        let fits = |places: &[Vec3]| places.iter().map(|x| cloud.fit_at(x)).collect();
        let particles = LoadedParticles { particles: &doubled, fits: &fits, sight: None };
        let held = |x: &Vec3, n: &Vec3| constraints.held_at(x, n);
        let surface =
            SurfaceQuadrature::new(cube.surface(), 3, spacing, &particles, &constraints.holds, &held);
        let material = Arc::new(KelvinVoigt::new(1.0, 100.0, 0.3, 0.2).expect("liver"));
        let hourglass = Solver::ACCURATE.hourglass_modulus(100.0);
        let mut solid = Solid::new(lattice, &body.volume, Fixed::default(), material, hourglass)
            .folded(folds, &constraints.holds)
            .with_surface(&surface, &constraints.holds, &body.cut(), &positions);
        let multigrid = Multigrid::new(&mut solid);
        let mut residual = vec![0.0; 3 * n.pow(3)];
        noise(&mut residual);
        Self { solid, multigrid, correction: residual.clone(), residual }
    }

    /// Applies the preconditioner once.
    pub fn run(&mut self) {
        let mut stiffness = Shifted { solid: &mut self.solid, scales: Scales::STATIC };
        self.multigrid.apply(&mut stiffness, &self.residual, &mut self.correction);
    }
}
