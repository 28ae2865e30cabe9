//! Gradient and its adjoint over neighbour pairs, as solids at large strain use them.

use rsph_core::dynamics::large_strain::configuration::Configuration;
use rsph_core::dynamics::large_strain::ghosts::Ghosts;
use rsph_core::dynamics::large_strain::points::Points;
use rsph_core::dynamics::large_strain::sweeps::{Gradients, Hourglass};
use rsph_core::tensor::{Mat3, Vec3};

/// A cube of points off the nodes of a lattice, with fields on them.
pub struct Irregular {
    configuration: Configuration<3>,
    points: Points,
    gradient: [Vec<Mat3>; 2],
    force: Vec<Vec3>,
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
        let volume = vec![dx.powi(3); nodes.len()];
        let configuration =
            Configuration::<3>::new(nodes.clone(), nodes, volume, Ghosts::default(), 1.25 * dx);
        let len = configuration.len;
        let none = vec![Mat3::zeros(); len];
        let points = Points::new(&configuration);
        Self { configuration, points, gradient: [none.clone(), none], force: vec![Vec3::zeros(); len] }
    }

    /// Pairs a particle.
    pub fn neighbours(&self) -> f64 {
        self.configuration.pairs.len() as f64 / self.configuration.len as f64
    }

    /// Gradients of positions and velocities, the first taken for its stress, and the force of that stress and of
    /// an hourglass term of that stiffness.
    pub fn update(&mut self, hourglass: f64) {
        let Self { configuration: c, points, gradient: [f, f_rate], force } = self;
        points.set(c, |a| (c.nodes[a] * 1.01, c.nodes[a]));
        let hourglass = Hourglass { stiffness: hourglass, of_position: 1.0, of_companion: 0.1 };
        points.gradients(c, hourglass, &|f, _| *f, Gradients { f, f_rate });
        points.forces(c, force);
    }
}
