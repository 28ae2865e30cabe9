//! Particles that have left their nodes, remeshed.

use rsph_core::kernel::RemeshKernel;
use rsph_core::particles::{Column, Field, Particles};
use rsph_core::remesh::{NewVolume, NodeLattice, Remeshed, Remesher};
use rsph_core::tensor::Vec3;

/// A cube of particles off their nodes with eight columns: two vectors, one of them the place, and two scalars.
pub struct Remeshing {
    particles: Particles,
    positions: Vec<Vec3>,
    remesher: Remesher<3>,
}

impl Remeshing {
    /// n^3 particles.
    pub fn new(n: usize) -> Self {
        let spacing = 1.0 / n as f64;
        let lattice = NodeLattice::<3> { origin: Vec3::zeros(), spacing };
        let count = n.pow(3);
        let positions: Vec<Vec3> = (0..count)
            .map(|a| lattice.position([a % n, a / n % n, a / n / n].map(|i| i as i64)))
            .map(|x| x + 0.3 * spacing * Vec3::new((9.0 * x.y).sin(), (7.0 * x.z).sin(), (8.0 * x.x).sin()))
            .collect();
        let mut particles = Particles::new(count);
        let scalar = |value: f64| Column::from_vec(vec![value; count], count);
        particles.set(Field::Reference, Column::from_vectors(&positions));
        particles.set(Field::Velocity, Column::from_vectors(&positions));
        particles.set(Field::Mass, scalar(lattice.cell_volume()));
        particles.set(Field::Volume, scalar(lattice.cell_volume()));
        let remesher = Remesher { kernel: RemeshKernel::M4Prime, lattice, volume: NewVolume::Conserved };
        Self { particles, positions, remesher }
    }

    /// Lays the particles anew once.
    pub fn run(&mut self) -> Remeshed {
        let fields = [Field::Reference, Field::Velocity, Field::Mass];
        let least = 0.5 * self.remesher.lattice.cell_volume();
        let keep = |_: &Vec3, values: &[f64]| values[6] > least;
        self.remesher.remesh(&self.particles, &self.positions, &fields, &keep).expect("a lattice")
    }
}
