//! Particles on a line, shown as a bar: a ring of four corners at every particle.

use crate::grid::Bounds;
use crate::mesh::TriangleMesh;
use crate::particles::{Column, Field};
use crate::snapshot::Snapshot;
use crate::surface::{Surface, SurfaceField};
use crate::tensor::Vec3;

/// Corners of a ring.
const CORNERS: usize = 4;

/// The cross-section of the bar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bar {
    bounds: Bounds,
}

impl Bar {
    /// A bar along x with the cross-section of a box.
    pub fn new(bounds: Bounds) -> Self {
        Self { bounds }
    }

    /// The bar through the particles of `snapshot`, with their fields and `velocity_x`. Displacements are left
    /// out: those of the fluid count from its last remeshing.
    pub fn surface(&self, snapshot: &Snapshot) -> Surface {
        let (low, high) = (self.bounds.min, self.bounds.max);
        let ring = [(low.y, low.z), (high.y, low.z), (high.y, high.z), (low.y, high.z)];
        let vertices = snapshot
            .positions()
            .into_iter()
            .flat_map(|[x, _, _]| ring.map(|(y, z)| Vec3::new(x, y, z)))
            .collect();
        let mut fields: Vec<SurfaceField> = snapshot
            .columns()
            .filter(|(spec, _)| !matches!(spec.field, Field::Reference | Field::Displacement))
            .map(|(spec, column)| SurfaceField {
                name: spec.name,
                components: spec.components,
                values: at_corners(column),
            })
            .collect();
        let u = snapshot.column(Field::Velocity);
        if !u.is_empty() {
            let along: Vec<f64> = u.component(0).iter().flat_map(|u| [*u; CORNERS]).collect();
            fields.push(SurfaceField { name: "velocity_x", components: 1, values: along });
        }
        Surface { mesh: TriangleMesh { vertices, triangles: triangles(snapshot.len()) }, fields }
    }
}

/// Each particle's values four times, vertex by vertex.
fn at_corners(column: &Column) -> Vec<f64> {
    let of = |a: usize| (0..column.components()).map(move |c| column.component(c)[a]);
    (0..column.len()).flat_map(|a| (0..CORNERS).flat_map(move |_| of(a))).collect()
}

/// Sides and end faces, turned outward.
fn triangles(rings: usize) -> Vec<[u32; 3]> {
    let corner = |ring: usize, c: usize| (ring * CORNERS + c % CORNERS) as u32;
    let mut triangles = Vec::with_capacity(8 * rings);
    let last = rings - 1;
    triangles.push([corner(0, 0), corner(0, 2), corner(0, 1)]);
    triangles.push([corner(0, 0), corner(0, 3), corner(0, 2)]);
    for r in 0..last {
        for c in 0..CORNERS {
            triangles.push([corner(r, c), corner(r, c + 1), corner(r + 1, c)]);
            triangles.push([corner(r, c + 1), corner(r + 1, c + 1), corner(r + 1, c)]);
        }
    }
    triangles.push([corner(last, 0), corner(last, 1), corner(last, 2)]);
    triangles.push([corner(last, 0), corner(last, 2), corner(last, 3)]);
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::Particles;

    #[test]
    fn the_bar_is_closed_and_has_its_volume() {
        let bounds = Bounds { min: Vec3::new(0.0, -1.0, 2.0), max: Vec3::new(3.0, 1.0, 5.0) };
        let mut particles = Particles::new(4);
        let x: Vec<Vec3> = [0.0, 0.5, 2.0, 3.0].map(|x| Vec3::new(x, 0.0, 0.0)).to_vec();
        particles.set(Field::Reference, Column::from_vectors(&x));
        particles.set(Field::Displacement, Column::zeros(3, 4));
        particles.set(Field::Volume, Column::from_vec(vec![1.0, 2.0, 3.0, 4.0], 4));
        let surface = Bar::new(bounds).surface(&Snapshot { time: 0.0, step: 0, particles });
        assert!((surface.mesh.volume() - 18.0).abs() < 1e-12, "{}", surface.mesh.volume());
        assert_eq!(surface.mesh.euler_characteristic(), 2);
        let volume = surface.fields.iter().find(|f| f.name == "volume").unwrap();
        assert_eq!(volume.values[4..9], [2.0, 2.0, 2.0, 2.0, 3.0]);
    }
}
