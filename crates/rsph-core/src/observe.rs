//! Probes: named readings at points, on surfaces and in regions, as weighted sums over particles.

mod gauge;

pub use gauge::TaggedGauge;

use crate::boundary::surface_load::quadrature;
use crate::boundary::tag::no_particle;
use crate::error::InvalidInput;
use crate::mesh::TriangleMesh;
use crate::mls::PointWeights;
use crate::particles::{Evolution, Field, Particles};
use crate::region::Region;
use crate::setup::{Probe, Quantity};
use crate::shape::Shape;
use crate::tensor::Vec3;
use std::ops::Range;

/// One value of a probe.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Column header: the probe's name, with `_x` etc. for a vector.
    pub name: String,
    /// Value.
    pub value: f64,
}

/// A probe with the weights of its particles, which sum to 1.
#[derive(Clone, Debug)]
pub struct TaggedProbe {
    names: Vec<String>,
    quantity: Quantity,
    weights: Weights,
    /// Points of the undeformed body that it reads, with their weights.
    points: Vec<(Vec3, f64)>,
}

/// Particles with a weight each; those of a region come in stretches of consecutive ones.
#[derive(Clone, Debug, Default)]
struct Weights {
    runs: Vec<Range<u32>>,
    weights: Vec<f64>,
}

impl FromIterator<(u32, f64)> for Weights {
    fn from_iter<I: IntoIterator<Item = (u32, f64)>>(rows: I) -> Self {
        let mut all = Self::default();
        for (a, weight) in rows {
            match all.runs.last_mut() {
                Some(run) if run.end == a => run.end += 1,
                _ => all.runs.push(a..a + 1),
            }
            all.weights.push(weight);
        }
        all
    }
}

impl Weights {
    /// The weighted sum; not a number when there is nothing to read.
    fn sum(&self, values: &[f64]) -> f64 {
        if self.weights.is_empty() {
            return f64::NAN;
        }
        let particles = self.runs.iter().cloned().flatten();
        particles.zip(&self.weights).map(|(a, w)| w * values[a as usize]).sum()
    }
}

impl TaggedProbe {
    /// Finds what `probe` (number `index` in the list) reads of a body with that surface: the particles in its region, weighted by
    /// volume; if there are none, the particles around the surface or the point in it, by moving least
    /// squares.
    ///
    /// # Errors
    /// `probe[i].region` when there is nothing in it.
    pub fn new(
        index: usize,
        probe: &Probe,
        (shape, surface): (&dyn Shape, &TriangleMesh),
        positions: &[Vec3],
        volume: &[f64],
        spacing: f64,
        weights: impl Fn(&[Vec3]) -> PointWeights,
    ) -> Result<Self, InvalidInput> {
        let tolerance = 1e-3 * spacing;
        let nothing = || Err(no_particle(&format!("probe[{index}].region"), &probe.region, positions));
        let mut tagged = Self {
            names: names(probe),
            quantity: probe.quantity,
            weights: Weights::default(),
            points: Vec::new(),
        };
        let inside: Vec<usize> =
            (0..positions.len()).filter(|&a| probe.region.contains(&positions[a], 0.0)).collect();
        if let Region::Point(x) = &probe.region {
            if shape.signed_distance(x) > spacing {
                return nothing();
            }
            tagged.points = vec![(*x, 1.0)];
        } else if inside.is_empty() {
            tagged.points = quadrature(surface, 0.5 * spacing)
                .into_iter()
                .filter(|p| probe.region.contains_on_surface(&p.x, &p.normal, tolerance))
                .map(|p| (p.x, p.area))
                .collect();
            if tagged.points.is_empty() {
                return nothing();
            }
        } else {
            let total: f64 = inside.iter().map(|&a| volume[a]).sum();
            tagged.weights = inside.iter().map(|&a| (a as u32, volume[a] / total)).collect();
            tagged.points = inside.iter().map(|&a| (positions[a], volume[a])).collect();
            return Ok(tagged);
        }
        tagged.find(positions.len(), weights);
        Ok(tagged)
    }

    /// Finds the particles that read the same points of the undeformed body after a remesh; `weights`
    /// gives their weights at a list of points.
    pub fn find(&mut self, particles: usize, weights: impl Fn(&[Vec3]) -> PointWeights) {
        let (x, share): (Vec<Vec3>, Vec<f64>) = self.points.iter().copied().unzip();
        self.weights = weights(&x).mean(&share, particles).into_iter().collect();
    }

    /// The same probe of a body that is never remeshed: what it reads is found for good.
    #[must_use]
    pub fn settled(self) -> Self {
        Self { points: Vec::new(), ..self }
    }

    /// A probe that reads the particles which are in its region now, weighted by volume.
    pub fn of_particles(probe: &Probe, positions: &[Vec3], volume: &[f64]) -> Self {
        let inside = || (0..positions.len()).filter(|&a| probe.region.contains(&positions[a], 0.0));
        let total: f64 = inside().map(|a| volume[a]).sum();
        let weights = inside().map(|a| (a as u32, volume[a] / total)).collect();
        Self { names: names(probe), quantity: probe.quantity, weights, points: Vec::new() }
    }

    /// The column that the probe reads.
    pub fn field(&self) -> Field {
        self.quantity.field
    }

    /// Whether that is part of the state of every dynamics.
    pub fn reads_state(&self) -> bool {
        let field = self.field();
        let derived_of_some = matches!(field, Field::Strain | Field::Density | Field::Pressure);
        field.spec().evolution == Evolution::State && !derived_of_some
    }

    /// The readings, one for each component; not a number when there is nothing to read.
    pub fn read(&self, particles: &Particles, out: &mut Vec<Reading>) {
        let column = particles.column(self.quantity.field);
        let first = self.quantity.component.unwrap_or(0);
        for (i, name) in self.names.iter().enumerate() {
            let values = column.component(first + i);
            let value = self.weights.sum(values);
            out.push(Reading { name: name.clone(), value });
        }
    }
}

/// Column headers: the probe's name, with `_x` etc. for a vector.
fn names(probe: &Probe) -> Vec<String> {
    let suffixes = probe.quantity.field.spec().suffixes;
    if probe.quantity.component.is_some() || suffixes.is_empty() {
        return vec![probe.name.clone()];
    }
    suffixes.iter().map(|s| format!("{}_{s}", probe.name)).collect()
}
