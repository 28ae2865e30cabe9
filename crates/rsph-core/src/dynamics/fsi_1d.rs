//! A fluid and an elastic solid on a line in one particle formulation, Eqs. (19) to (21).
//!
//! Particles are ordered along x: fluid particles 0 to N with number 0 at the wall, solid particles N to
//! N + M with the last one held. Particle N is the interface: it belongs to both, with half a cell of
//! each, so that velocities agree there by construction and stresses by its equation of motion.

mod budget;
mod derivatives;
mod order;
mod remesh;

pub use order::Crossing;
pub use remesh::FluidRemesh;

use super::{Account, Dynamics, Energy, ForceSums, Imposed};
use crate::fluid::FluidLaw;
use crate::particles::{Column, Field, Particles};
use crate::setup::Interaction;
use crate::tensor::Vec3;
use derivatives::Line;
use std::sync::Arc;

/// Smallest smoothing length, in spacings, whose sums surely reach both neighbours.
pub const SMALLEST_SMOOTHING: f64 = 0.85;
/// Largest rate times step along the imaginary and the real axis at which RK4 is stable.
const WAVES: f64 = 2.82;
const DECAY: f64 = 2.78;

/// A fluid and an elastic solid that meet.
#[derive(Clone, Debug)]
pub struct FluidStructure {
    fluid: Arc<dyn FluidLaw>,
    elasticity: f64,
    solid_density: f64,
    /// Number N of the interface particle.
    interface: usize,
    /// Length of a solid element at rest.
    solid_spacing: f64,
    /// Smoothing length of the fluid's sums in spacings.
    smoothing: f64,
    /// Positions of the fluid particles, work space.
    x: Vec<f64>,
    /// Fluid volumes of the fluid particles, work space.
    volume: Vec<f64>,
}

impl FluidStructure {
    /// The interaction with that smoothing length, in spacings.
    pub fn new(interaction: &Interaction, smoothing: f64) -> Self {
        let n = interaction.elements[0];
        Self {
            fluid: Arc::clone(&interaction.fluid),
            elasticity: interaction.elasticity,
            solid_density: interaction.solid_density,
            interface: n,
            solid_spacing: interaction.spacings()[1],
            smoothing,
            x: vec![0.0; n + 1],
            volume: vec![0.0; n + 1],
        }
    }

    /// The particles at rest, with the x components of `velocity` (one value for each position).
    pub fn particles(&self, interaction: &Interaction, velocity: impl Fn(&[Vec3]) -> Vec<Vec3>) -> Particles {
        let ([n, m], [h, dxi]) = (interaction.elements, interaction.spacings());
        let count = n + m + 1;
        let at = |i: usize| match i {
            _ if i <= n => interaction.left + i as f64 * h,
            _ => interaction.interface + (i - n) as f64 * dxi,
        };
        let positions: Vec<Vec3> = (0..count).map(|i| Vec3::new(at(i), 0.0, 0.0)).collect();
        let mut u: Vec<Vec3> = velocity(&positions).iter().map(|v| Vec3::new(v.x, 0.0, 0.0)).collect();
        (u[0], u[count - 1]) = (Vec3::zeros(), Vec3::zeros()); // Eq. (21)
        let cell = |i: usize| {
            let (left, right) =
                (if i == 0 { 0.0 } else { at(i) - at(i - 1) }, at((i + 1).min(count - 1)) - at(i));
            0.5 * (left + right)
        };
        let share_of_fluid = |i: usize| match i.cmp(&n) {
            std::cmp::Ordering::Less => 1.0,
            std::cmp::Ordering::Equal => 0.5,
            std::cmp::Ordering::Greater => 0.0,
        };
        let mut particles = Particles::new(count);
        particles.set(Field::Reference, Column::from_vectors(&positions));
        particles.set(Field::Displacement, Column::zeros(3, count)); // Eq. (20)
        particles.set(Field::Velocity, Column::from_vectors(&u));
        particles.set(Field::Volume, Column::from_vec((0..count).map(cell).collect(), count));
        particles.set(Field::Colour, Column::from_vec((0..count).map(share_of_fluid).collect(), count));
        particles.set(Field::Mass, Column::zeros(1, count));
        if self.fluid.bulk_modulus().is_some() {
            particles.set(Field::Pressure, Column::zeros(1, count));
        }
        self.impose(0.0, &mut particles);
        particles
    }

    /// Largest stable time steps while the fluid's particles are at least `spacing` apart: that of waves in
    /// the solid and sound in the fluid along the imaginary axis, and that of viscosity along the real one.
    pub fn step_limits(&self, spacing: f64) -> [f64; 2] {
        let solid = 0.5 * WAVES * self.solid_spacing / (self.elasticity / self.solid_density).sqrt();
        let sound = 0.5 * WAVES * spacing / self.fluid.sound_speed();
        let viscous = 0.25 * DECAY * self.fluid.density() * spacing.powi(2) / self.fluid.viscosity();
        [solid.min(sound), viscous]
    }

    /// Largest |du/dx| between two fluid particles.
    pub fn largest_rate(&mut self, particles: &Particles) -> f64 {
        self.place(particles);
        let u = particles.column(Field::Velocity).component(0);
        let rates = u.windows(2).zip(self.x.windows(2)).map(|(u, x)| ((u[1] - u[0]) / (x[1] - x[0])).abs());
        rates.fold(0.0, f64::max)
    }

    /// Number of the interface particle.
    pub fn interface(&self) -> usize {
        self.interface
    }

    /// Copies positions and fluid volumes into the work space.
    fn place(&mut self, particles: &Particles) {
        let (x0, d) = (particles.column(Field::Reference), particles.column(Field::Displacement));
        let n = self.interface;
        for ((x, x0), d) in self.x.iter_mut().zip(x0.component(0)).zip(d.component(0)) {
            *x = x0 + d;
        }
        self.volume.copy_from_slice(&particles.column(Field::Volume).values()[..=n]);
        self.volume[n] -= 0.5 * self.solid_spacing;
    }

    fn line(&self) -> Line<'_> {
        Line { x: &self.x, volume: &self.volume, smoothing: self.smoothing }
    }

    /// Gradients of velocity and pressure at fluid particle `i`: [u_x, u_xx], [p_x, p_xx].
    fn gradients(&self, i: usize, u: &[f64], p: &[f64]) -> [[f64; 2]; 2] {
        if p.is_empty() {
            let [u] = self.line().derivatives(i, [(u, -1.0)]);
            [u, [0.0; 2]]
        } else {
            self.line().derivatives(i, [(u, -1.0), (p, 1.0)])
        }
    }

    /// Acceleration of the interface: half a cell of each material, the solid's stress on one side and the
    /// fluid's, half an element away, on the other.
    fn interface_acceleration(&self, u: &[f64], p: &[f64], d: &[f64]) -> f64 {
        let (n, law) = (self.interface, &*self.fluid);
        let h = self.x[n] - self.x[n - 1];
        let u_x = (u[n] - u[n - 1]) / h;
        let pressure = if p.is_empty() { 0.0 } else { 0.5 * (p[n] + p[n - 1]) };
        let fluid_stress = law.viscosity() * u_x - pressure;
        let solid_stress = self.elasticity * (d[n + 1] - d[n]) / self.solid_spacing;
        let source = 0.5 * h * law.density() * law.source(u[n], u_x);
        let mass = 0.5 * (self.solid_density * self.solid_spacing + law.density() * h);
        (solid_stress - fluid_stress + source) / mass
    }
}

impl Dynamics for FluidStructure {
    fn integrated(&self) -> &'static [Field] {
        const STATE: [Field; 4] = [Field::Displacement, Field::Velocity, Field::Volume, Field::Pressure];
        if self.fluid.bulk_modulus().is_some() { &STATE } else { &STATE[..3] }
    }

    /// Neither law has a balance of mass: densities are constant while volumes change.
    fn account(&self) -> Account {
        Account { conserves_mass: false, sums_dissipation: true }
    }

    fn rates(&mut self, _t: f64, particles: &Particles, rates: &mut [Column]) -> ForceSums {
        self.place(particles);
        let (n, last, law) = (self.interface, particles.len() - 1, &*self.fluid);
        let u = particles.column(Field::Velocity).component(0);
        let d = particles.column(Field::Displacement).component(0);
        let p = particles.column(Field::Pressure).values();
        let (fluid_u, fluid_p) = (&u[..=n], if p.is_empty() { p } else { &p[..=n] });
        let rho = law.density();

        let [displacement, velocity, volume, pressure @ ..] = rates else {
            unreachable!("one rate for each integrated column")
        };
        displacement.values_mut()[..=last].copy_from_slice(u); // Eq. (4)
        let (a, volume) = (velocity.values_mut(), volume.values_mut());
        let mut sums = ForceSums::default();
        for i in 0..=n {
            let [[u_x, u_xx], [p_x, _]] = self.gradients(i, fluid_u, fluid_p);
            let source = law.source(u[i], u_x);
            a[i] = (law.viscosity() * u_xx - p_x) / rho + source; // Eq. (19), fluid
            let (left, right) = (i.saturating_sub(1), (i + 1).min(n));
            volume[i] = self.volume[i] * (u[right] - u[left]) / (self.x[right] - self.x[left]);
            if let ([pressure], Some(k)) = (&mut *pressure, law.bulk_modulus()) {
                pressure.values_mut()[i] = -k * u_x;
            }
            if i == 0 {
                a[0] = 0.0; // Eq. (21)
                sums.reaction.x = -law.viscosity() * u_x + p.first().unwrap_or(&0.0);
            }
            sums.load.x += rho * self.volume[i] * (source + u[i] * u_x);
        }
        a[n] = self.interface_acceleration(fluid_u, fluid_p, d);
        let stiffness = self.elasticity / (self.solid_density * self.solid_spacing.powi(2));
        for j in n + 1..last {
            a[j] = stiffness * (d[j + 1] - 2.0 * d[j] + d[j - 1]); // Eq. (19), solid
        }
        a[last] = 0.0; // Eq. (21)
        sums.reaction.x += self.elasticity * (d[last] - d[last - 1]) / self.solid_spacing;
        sums.dissipation = self.dissipation(fluid_u);
        sums
    }

    /// The fluid's mass follows its volume; of what is prescribed, the ends are at rest already.
    fn impose(&self, _t: f64, particles: &mut Particles) -> Imposed {
        let n = self.interface;
        let volume = particles.column(Field::Volume).share();
        let (rho, solid) = (self.fluid.density(), self.solid_density);
        let half = 0.5 * self.solid_spacing;
        for (i, (m, v)) in particles.column_mut(Field::Mass).values_mut().iter_mut().zip(&*volume).enumerate()
        {
            *m = match i.cmp(&n) {
                std::cmp::Ordering::Less => rho * v,
                std::cmp::Ordering::Equal => rho * (v - half) + solid * half,
                std::cmp::Ordering::Greater => solid * v,
            };
        }
        Imposed::default()
    }

    fn derive(&mut self, _t: f64, particles: &mut Particles) {
        self.add_stress_and_strain(particles);
    }

    fn energy(&mut self, _t: f64, particles: &Particles) -> Energy {
        self.energies(particles)
    }
}
