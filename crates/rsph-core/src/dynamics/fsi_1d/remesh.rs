//! The fluid is remeshed at even distances between wall and interface; the solid's map
//! stays as it is.

use super::FluidStructure;
use crate::dynamics::Dynamics;
use crate::kernel::RemeshKernel;
use crate::particles::{Field, Particles};
use crate::remesh::{NodeLattice, RemeshError, scatter};
use crate::tensor::Vec3;

/// What a remeshing of the fluid did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FluidRemesh {
    /// Momentum sum rho V u of the fluid before and after. They differ by what the ends do: the mirror images
    /// give and take, and the velocities of wall and interface stay.
    pub momentum: [f64; 2],
    /// Length of the fluid by its volumes before and after.
    pub volume: [f64; 2],
}

impl FluidStructure {
    /// Lays the fluid's particles at even distances by sums of volume and of volume times velocity (and
    /// pressure) under `kernel`, Eq. (17), and makes their volumes those of the cells. Beyond both ends are
    /// mirror images: of odd u and even p at the wall, of u and p turned about their values at the interface.
    ///
    /// # Errors
    /// Particles that no lattice holds.
    pub fn remesh(
        &mut self,
        kernel: RemeshKernel,
        particles: &mut Particles,
    ) -> Result<FluidRemesh, RemeshError> {
        self.place(particles);
        let n = self.interface;
        let (left, right) = (self.x[0], self.x[n]);
        let h = (right - left) / n as f64;
        let lattice = NodeLattice::<1> { origin: Vec3::new(left - 0.5 * h, 0.0, 0.0), spacing: h };
        let ghosts = (kernel.reach() + 2).min(n - 1);

        let u = particles.column(Field::Velocity).component(0);
        let p = particles.column(Field::Pressure).values();
        let carried = |i: usize| [self.volume[i], u[i], p.get(i).copied().unwrap_or(0.0)];
        let (u_i, p_i) = (u[n], p.get(n).copied().unwrap_or(0.0));
        let mut positions = Vec::with_capacity(n + 1 + 2 * ghosts);
        let mut values = Vec::with_capacity(3 * positions.capacity());
        let mut add = |x: f64, [v, u, p]: [f64; 3]| {
            positions.push(Vec3::new(x, 0.0, 0.0));
            values.extend([v, v * u, v * p]);
        };
        for i in 0..=n {
            let [v, u, p] = carried(i);
            // The ends have half cells; their mirror images are the other halves.
            add(self.x[i], [if i == 0 || i == n { 2.0 * v } else { v }, u, p]);
        }
        for i in 1..=ghosts {
            let [v, u, p] = carried(i);
            add(2.0 * left - self.x[i], [v, -u, p]);
            let [v, u, p] = carried(n - i);
            add(2.0 * right - self.x[n - i], [v, 2.0 * u_i - u, 2.0 * p_i - p]);
        }
        let sums = scatter(kernel, lattice, &positions, 3, &values)?;

        let mut report =
            FluidRemesh { momentum: [self.momentum(u), 0.0], volume: [self.volume.iter().sum(), 0.0] };
        let mut node = vec![[0.0; 3]; n + 1];
        for (i, node) in node.iter_mut().enumerate() {
            let lost = RemeshError::Lost { particle: i, position: positions[i] };
            let number = sums.number([i as i64, 0, 0]).ok_or(lost)?;
            node.copy_from_slice(sums.at(number));
        }
        fill_cells(&mut node, h);
        let interface_volume = self.volume[n];
        for (i, [_, vu, vp]) in node.into_iter().enumerate() {
            let end = i == 0 || i == n;
            self.volume[i] = if end { 0.5 * h } else { h };
            if !end {
                particles.column_mut(Field::Velocity).values_mut()[i] = vu / h; // Eq. (17)
                particles.column_mut(Field::Reference).values_mut()[i] = left + i as f64 * h;
                particles.column_mut(Field::Displacement).values_mut()[i] = 0.0;
            }
            if particles.has(Field::Pressure) && i != n {
                particles.column_mut(Field::Pressure).values_mut()[i] = vp / h;
            }
        }
        let volume = particles.column_mut(Field::Volume).values_mut();
        volume[..n].copy_from_slice(&self.volume[..n]);
        volume[n] += self.volume[n] - interface_volume;
        report.momentum[1] = self.momentum(particles.column(Field::Velocity).component(0));
        report.volume[1] = self.volume.iter().sum();
        self.impose(0.0, particles);
        Ok(report)
    }

    /// Momentum of the fluid with the volumes of the work space.
    fn momentum(&self, u: &[f64]) -> f64 {
        self.fluid.density() * self.volume.iter().zip(u).map(|(v, u)| v * u).sum::<f64>()
    }
}

/// Makes every node's volume that of a cell, `h`, without changing a sum: what a node has received too
/// much of volume passes to its right neighbour, and takes with it the momentum (the second value, and
/// pressure, the third) of the face between them. `nodes` hold [V, V u, V p]; the first and the last one
/// count half.
fn fill_cells(nodes: &mut [[f64; 3]], h: f64) {
    // Intensive values of the left and the right node, before either changes.
    let intensive = |[v, vu, vp]: [f64; 3]| [vu / v, vp / v];
    let mut left = intensive(nodes[0]);
    let mut passed = 0.0;
    // What passes one half of a cell at an end passes its mirror image as well.
    let last = nodes.len() - 1;
    let whole = |j: usize| if j == 0 || j == last { 2.0 } else { 1.0 };
    for j in 0..last {
        let right = intensive(nodes[j + 1]);
        let over = nodes[j][0] - h;
        passed += over / whole(j);
        for c in 0..2 {
            let moved = passed * 0.5 * (left[c] + right[c]);
            nodes[j][c + 1] -= whole(j) * moved;
            nodes[j + 1][c + 1] += whole(j + 1) * moved;
        }
        nodes[j][0] = h;
        left = right;
    }
    nodes[last][0] = h;
}
