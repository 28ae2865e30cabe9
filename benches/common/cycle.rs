//! One V-cycle of multigrid on a clamped cube.

use rsph_core::boundary::fixed::Fixed;
use rsph_core::boundary::mirror::{Mirror, MirrorPlane};
use rsph_core::dynamics::elastic::Elastic;
use rsph_core::grid::Grid;
use rsph_core::lattice::Lattice;
use rsph_core::material::KelvinVoigt;
use rsph_core::solve::multigrid::Multigrid;
use rsph_core::solve::operator::{Preconditioner, Shifted};
use rsph_core::solve::sums::noise;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// A body with its hierarchy and a residual.
pub struct Cycle {
    elastic: Elastic,
    multigrid: Multigrid,
    residual: Vec<f64>,
    correction: Vec<f64>,
}

impl Cycle {
    /// n^3 particles with h = 0.8 dx, clamped below.
    pub fn new(n: usize) -> Self {
        let spacing = 1.0 / n as f64;
        let grid = Grid { origin: Vec3::zeros(), spacing, cells: [n; 3] };
        let cells: Vec<[usize; 3]> = (0..n.pow(3)).map(|a| [a % n, a / n % n, a / n / n]).collect();
        let positions: Vec<Vec3> = cells.iter().map(|c| grid.centre(*c)).collect();
        let lattice = Lattice::new(&grid, &cells, 0.8);
        let clamp = MirrorPlane { axis: 2, at: 0.0, fix: [true; 3], motion: None };
        let mirror = Mirror::new(&lattice, &positions, vec![clamp], |_| true);
        let material = Arc::new(KelvinVoigt::new(1.0, 100.0, 0.3, 0.2).expect("liver"));
        let volume = vec![spacing.powi(3); n.pow(3)];
        let mut elastic = Elastic::new(lattice, &volume, mirror, Fixed::default(), material, 0.4);
        let multigrid = Multigrid::new(&mut elastic);
        let mut residual = vec![0.0; 3 * n.pow(3)];
        noise(&mut residual);
        Self { elastic, multigrid, correction: residual.clone(), residual }
    }

    /// Applies the preconditioner once.
    pub fn run(&mut self) {
        let mut stiffness = Shifted { elastic: &mut self.elastic, mass: 0.0, stiffness: 1.0 };
        self.multigrid.apply(&mut stiffness, &self.residual, &mut self.correction);
    }
}
