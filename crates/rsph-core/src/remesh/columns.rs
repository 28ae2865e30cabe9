//! The column table through the remesher: what each column is conserved under, and back.

use super::nodes::NodeLattice;
use super::{RemeshError, fold, scatter};
use crate::kernel::RemeshKernel;
use crate::particles::{Column, Extensive, Field, Particles};
use crate::tensor::Vec3;
use rayon::prelude::*;

/// How far, in spacings, what lands on a node that is not kept may travel to a kept one.
const FOLD_REACH: usize = 16;

/// The volume of new particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NewVolume {
    /// That of a cell of the lattice: for a field that fills space, such as a colour.
    Cell,
    /// Conserved, Eq. (17): for a body with a free surface.
    Conserved,
}

/// Remeshing on a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remesher<const D: usize> {
    /// Interpolation kernel.
    pub kernel: RemeshKernel,
    /// The lattice.
    pub lattice: NodeLattice<D>,
    /// Volume of the new particles.
    pub volume: NewVolume,
}

/// New particles.
#[derive(Clone, Debug)]
pub struct Remeshed {
    /// Their nodes, by z, y, x.
    pub nodes: Vec<[i64; 3]>,
    /// Positions of those nodes.
    pub positions: Vec<Vec3>,
    /// The columns that were transferred, and the volume.
    pub particles: Particles,
    /// What happened.
    pub report: RemeshReport,
}

/// What one remeshing did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RemeshReport {
    /// Particles before and after.
    pub particles: [usize; 2],
    /// Total mass before and after (0 where there is no mass).
    pub mass: [f64; 2],
    /// Total momentum before and after (0 where there is no mass or velocity).
    pub momentum: [Vec3; 2],
    /// Sum of |mass| that moved from a node that was not kept to its nearest kept one.
    pub folded_mass: f64,
    /// Mass that found no kept node near and was lost.
    pub dropped_mass: f64,
}

impl<const D: usize> Remesher<D> {
    /// Lays `particles`, which are at `positions`, on the lattice: transfers `fields` (and the volume,
    /// which need not be among them) and keeps the nodes for which `keep(position, intensive values)`
    /// is true; values come in the order of `fields`, component by component. What lands elsewhere
    /// goes to the nearest kept node. Columns that are not named are absent afterwards.
    ///
    /// # Errors
    /// Particles that no lattice holds, or a field whose weight (mass, volume) is not carried.
    pub fn remesh(
        &self,
        particles: &Particles,
        positions: &[Vec3],
        fields: &[Field],
        keep: &(dyn Fn(&Vec3, &[f64]) -> bool + Sync),
    ) -> Result<Remeshed, RemeshError> {
        let plan = Plan::new(fields, particles, self.volume)?;
        let columns = plan.columns;
        let extensive = plan.extensive(particles);
        let mut sums = scatter(self.kernel, self.lattice, positions, columns, &extensive)?;

        let cell = self.lattice.cell_volume();
        let nodes: Vec<[i64; 3]> = sums.indices().collect();
        let kept: Vec<bool> = nodes
            .par_iter()
            .enumerate()
            .map_init(
                || vec![0.0; columns],
                |values, (n, node)| {
                    let sums = sums.at(n);
                    // Gaps within a row that nothing reaches.
                    if sums.iter().all(|s| *s == 0.0) {
                        return false;
                    }
                    plan.intensive(sums, cell, values);
                    keep(&self.lattice.position(*node), &values[..plan.transferred])
                },
            )
            .collect();
        let folded = fold(&mut sums, &kept, FOLD_REACH);

        let kept: Vec<usize> = (0..nodes.len()).filter(|&n| kept[n]).collect();
        let len = kept.len();
        let (mut data, mut values) = (vec![0.0; columns * len], vec![0.0; columns]);
        for (a, &n) in kept.iter().enumerate() {
            plan.intensive(sums.at(n), cell, &mut values);
            for (c, value) in values.iter().enumerate() {
                data[c * len + a] = *value;
            }
        }
        let mut new = Particles::new(len);
        for part in &plan.parts {
            let components = part.field.spec().components;
            let values = data[part.first * len..(part.first + components) * len].to_vec();
            new.set(part.field, Column::from_vec(values, len));
        }
        if self.volume == NewVolume::Cell {
            new.set(Field::Volume, Column::from_vec(vec![cell; len], len));
        }
        let mass_column = plan.first_of(Field::Mass);
        let report = RemeshReport {
            particles: [particles.len(), len],
            mass: [total_mass(particles), total_mass(&new)],
            momentum: [momentum(particles), momentum(&new)],
            folded_mass: mass_column.map_or(0.0, |c| folded.moved[c]),
            dropped_mass: mass_column.map_or(0.0, |c| folded.dropped[c]),
        };
        let nodes: Vec<[i64; 3]> = kept.iter().map(|&n| nodes[n]).collect();
        let positions = nodes.iter().map(|n| self.lattice.position(*n)).collect();
        Ok(Remeshed { nodes, positions, particles: new, report })
    }
}

/// A field among the columns that are scattered.
#[derive(Clone, Copy, Debug)]
struct Part {
    field: Field,
    first: usize,
    /// The column it is divided by; `None`: by nothing, or by the volume of a cell.
    weight: Option<usize>,
}

/// Which columns are scattered, and under which weight.
#[derive(Clone, Debug)]
struct Plan {
    parts: Vec<Part>,
    /// Columns of the fields asked for; weights that were not asked for follow.
    transferred: usize,
    columns: usize,
    volume: NewVolume,
}

impl Plan {
    fn new(fields: &[Field], particles: &Particles, volume: NewVolume) -> Result<Self, RemeshError> {
        let given = volume == NewVolume::Cell;
        let present = |f: &&Field| particles.has(**f) && !(given && **f == Field::Volume);
        let mut plan = Self { parts: Vec::new(), transferred: 0, columns: 0, volume };
        for &field in fields.iter().filter(present) {
            plan.add(field);
        }
        plan.transferred = plan.columns;
        if !given && particles.has(Field::Volume) && plan.first_of(Field::Volume).is_none() {
            plan.add(Field::Volume);
        }
        let needs = |e: Extensive| plan.parts.iter().find(|p| p.field.spec().extensive == e);
        for (kind, weight) in [(Extensive::ByMass, Field::Mass), (Extensive::ByVolume, Field::Volume)] {
            if let Some(part) = needs(kind)
                && !particles.has(weight)
            {
                let (column, weight) = (part.field.spec().name, weight.spec().name);
                return Err(RemeshError::NoWeight { column, weight });
            }
        }
        if needs(Extensive::ByMass).is_some() && plan.first_of(Field::Mass).is_none() {
            plan.add(Field::Mass);
        }
        let (mass, conserved_volume) = (plan.first_of(Field::Mass), plan.first_of(Field::Volume));
        for part in &mut plan.parts {
            part.weight = match part.field.spec().extensive {
                Extensive::Itself => None,
                Extensive::ByMass => mass,
                Extensive::ByVolume => conserved_volume,
            };
        }
        Ok(plan)
    }

    fn add(&mut self, field: Field) {
        self.parts.push(Part { field, first: self.columns, weight: None });
        self.columns += field.spec().components;
    }

    fn first_of(&self, field: Field) -> Option<usize> {
        self.parts.iter().find(|p| p.field == field).map(|p| p.first)
    }

    /// What is scattered, particle by particle.
    fn extensive(&self, particles: &Particles) -> Vec<f64> {
        let n = particles.len();
        let mut values = vec![0.0; self.columns * n];
        for part in &self.parts {
            let spec = part.field.spec();
            let column = particles.column(part.field);
            let weight = match spec.extensive {
                Extensive::Itself => None,
                Extensive::ByMass => Some(particles.column(Field::Mass).values()),
                Extensive::ByVolume => Some(particles.column(Field::Volume).values()),
            };
            for c in 0..spec.components {
                for (a, q) in column.component(c).iter().enumerate() {
                    values[a * self.columns + part.first + c] = weight.map_or(*q, |w| q * w[a]);
                }
            }
        }
        values
    }

    /// The values of a new particle from the sums at its node.
    fn intensive(&self, sums: &[f64], cell: f64, out: &mut [f64]) {
        for part in &self.parts {
            let spec = part.field.spec();
            let by_cell = spec.extensive == Extensive::ByVolume && self.volume == NewVolume::Cell;
            let weight = if by_cell { cell } else { part.weight.map_or(1.0, |w| sums[w]) };
            for c in part.first..part.first + spec.components {
                // A node without mass or volume carries nothing.
                out[c] = if weight == 0.0 { 0.0 } else { sums[c] / weight };
            }
        }
    }
}

fn total_mass(particles: &Particles) -> f64 {
    particles.column(Field::Mass).values().iter().sum()
}

fn momentum(particles: &Particles) -> Vec3 {
    let (m, v) = (particles.column(Field::Mass), particles.column(Field::Velocity));
    if m.is_empty() || v.is_empty() {
        return Vec3::zeros();
    }
    (0..particles.len()).map(|a| m.values()[a] * v.vector(a)).sum()
}
