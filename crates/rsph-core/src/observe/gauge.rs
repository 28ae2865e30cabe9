//! Strain gauges: the distance between two points of a body.

use super::{Reading, TaggedProbe};
use crate::error::InvalidInput;
use crate::mesh::TriangleMesh;
use crate::mls::PointWeights;
use crate::particles::{Field, Particles};
use crate::region::Region;
use crate::setup::{Gauge, Probe, Quantity};
use crate::shape::Shape;
use crate::tensor::Vec3;

/// A strain gauge with the particles around its ends.
#[derive(Clone, Debug)]
pub struct TaggedGauge {
    name: String,
    /// From one end to the other in the undeformed body.
    apart: Vec3,
    /// What reads the displacement of the ends.
    ends: [TaggedProbe; 2],
}

impl TaggedGauge {
    /// Finds what `gauge` (number `index` in the list) reads of a body, as [`TaggedProbe::new`] does.
    ///
    /// # Errors
    /// `gauge[i].from` or `gauge[i].to` when a point lies more than a spacing outside of the body, or both are the same.
    pub fn new(
        index: usize,
        gauge: &Gauge,
        (shape, surface): (&dyn Shape, &TriangleMesh),
        positions: &[Vec3],
        volume: &[f64],
        spacing: f64,
        weights: impl Fn(&[Vec3]) -> PointWeights,
    ) -> Result<Self, InvalidInput> {
        let written = |x: &Vec3| format!("[{}, {}, {}]", x.x, x.y, x.z);
        if gauge.from == gauge.to {
            return Err(InvalidInput::new(
                format!("gauge[{index}].to"),
                written(&gauge.to),
                "is the point that the gauge is from",
                "give two points of the body",
            ));
        }
        let end = |key: &str, x: &Vec3| {
            let outside = shape.signed_distance(x);
            if outside > spacing {
                return Err(InvalidInput::new(
                    format!("gauge[{index}].{key}"),
                    written(x),
                    format!("lies {outside:.4} outside of the body; a gauge is on the body or in it"),
                    "move the point, and check its units",
                ));
            }
            let quantity = Quantity { field: Field::Displacement, component: None };
            let probe = Probe { name: gauge.name.clone(), quantity, region: Region::Point(*x) };
            TaggedProbe::new(index, &probe, (shape, surface), positions, volume, spacing, &weights)
        };
        let ends = [end("from", &gauge.from)?, end("to", &gauge.to)?];
        Ok(Self { name: gauge.name.clone(), apart: gauge.to - gauge.from, ends })
    }

    /// Finds the particles around the ends after a remesh.
    pub fn find(&mut self, particles: usize, weights: impl Fn(&[Vec3]) -> PointWeights) {
        for end in &mut self.ends {
            end.find(particles, &weights);
        }
    }

    /// Reads the strain, change of length over undeformed length, and the length.
    pub fn read(&self, particles: &Particles, out: &mut Vec<Reading>) {
        let mut displacements = Vec::with_capacity(6);
        for end in &self.ends {
            end.read(particles, &mut displacements);
        }
        let u: Vec<f64> = displacements.iter().map(|reading| reading.value).collect();
        let moved = Vec3::from_fn(|i, _| u[3 + i] - u[i]);
        let length = self.apart.norm();
        // |d + v| - |d| without the cancellation.
        let now = (self.apart + moved).norm();
        let change = moved.dot(&(2.0 * self.apart + moved)) / (now + length);
        let reading = |what: &str, value: f64| Reading { name: format!("{}_{what}", self.name), value };
        out.push(reading("strain", change / length));
        out.push(reading("length", now));
    }
}
