//! Gradient and its adjoint over neighbour pairs, as solids at large strain use them.

use rsph_core::dynamics::large_strain::columns::Packed;
use rsph_core::dynamics::large_strain::configuration::Configuration;
use rsph_core::dynamics::large_strain::ghosts::Ghosts;
use rsph_core::dynamics::large_strain::sweeps::Stressed;
use rsph_core::tensor::{Mat3, Vec3};

/// A cube of points off the nodes of a lattice, with fields on them.
pub struct Irregular {
    configuration: Configuration<3>,
    field: Vec<Vec3>,
    gradient: Vec<Mat3>,
    tensor: Vec<Mat3>,
    force: Vec<Vec3>,
    packed: Packed,
}

impl Irregular {
    /// n^3 points with 122 neighbours inside (h = 1.25 dx).
    pub fn new(n: usize) -> Self {
        let dx = 1.0 / n as f64;
        let node = |a: usize| Vec3::new((a % n) as f64, (a / n % n) as f64, (a / n / n) as f64) * dx;
        let nodes: Vec<Vec3> = (0..n.pow(3))
            .map(node)
            .map(|x| x + 0.002 * dx * Vec3::new((9.0 * x.y).sin(), (7.0 * x.z).sin(), (8.0 * x.x).sin()))
            .collect();
        let field: Vec<Vec3> = nodes.iter().map(|x| x * 1.01).collect();
        let volume = vec![dx.powi(3); nodes.len()];
        let configuration =
            Configuration::<3>::new(nodes.clone(), nodes, volume, Ghosts::default(), 1.25 * dx);
        let len = field.len();
        let none = vec![Mat3::zeros(); len];
        Self {
            configuration,
            field,
            gradient: none.clone(),
            tensor: none,
            force: vec![Vec3::zeros(); len],
            packed: Packed::default(),
        }
    }

    /// Pairs a particle.
    pub fn neighbours(&self) -> f64 {
        self.configuration.pairs.len() as f64 / self.field.len() as f64
    }

    /// Gradient of the field, taken for its stress, and the force of that stress; with the hourglass term if
    /// `hourglass` is not zero.
    pub fn update(&mut self, hourglass: f64) {
        let Self { configuration, packed, .. } = self;
        configuration.gradients(&self.field, packed, &mut self.gradient);
        let piola = &self.gradient;
        let stressed = Stressed { piola, hourglass, field: &self.field, gradient: &self.gradient };
        configuration.pair_tensors(&stressed, packed, &mut self.tensor);
        configuration.forces(&stressed, &self.tensor, packed, &mut self.force);
    }
}
