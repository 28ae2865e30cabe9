//! A ball.

use super::{Shape, check};
use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use std::collections::HashMap;
use std::f64::consts::PI;

/// How often the faces of the octahedron are divided by four: 32,768 triangles.
const SUBDIVISIONS: usize = 6;

/// A ball.
#[derive(Clone, Debug)]
pub struct SphereShape {
    radius: f64,
    centre: Vec3,
    surface: TriangleMesh,
}

impl SphereShape {
    /// A ball of that radius around `centre`.
    ///
    /// # Errors
    /// `body.shape.sphere.radius` when it is not positive and finite,
    /// `body.shape.sphere.centre[i]` when a coordinate is not finite.
    pub fn new(radius: f64, centre: Vec3) -> Result<Self, InvalidInput> {
        check::positive("body.shape.sphere.radius", radius)?;
        check::finite("body.shape.sphere.centre", &centre)?;
        let mut surface = unit_sphere();
        for v in &mut surface.vertices {
            *v = centre + radius * *v;
        }
        Ok(Self { radius, centre, surface })
    }
}

/// The unit sphere from an octahedron, so that its extent along the axes is exact.
fn unit_sphere() -> TriangleMesh {
    let vertices = (0..6).map(|i| Vec3::ith(i / 2, if i % 2 == 0 { 1.0 } else { -1.0 })).collect();
    let triangles =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let mut mesh = TriangleMesh { vertices, triangles };
    for _ in 0..SUBDIVISIONS {
        let mut middle_of = HashMap::new();
        let vertices = &mut mesh.vertices;
        let mut middle = |a: u32, b: u32| {
            *middle_of.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        mesh.triangles = mesh
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    mesh
}

impl Shape for SphereShape {
    fn name(&self) -> String {
        "sphere".into()
    }

    fn signed_distance(&self, x: &Vec3) -> f64 {
        (x - self.centre).norm() - self.radius
    }

    fn bounds(&self) -> Bounds {
        let r = Vec3::repeat(self.radius);
        Bounds { min: self.centre - r, max: self.centre + r }
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius.powi(3)
    }

    fn surface(&self) -> &TriangleMesh {
        &self.surface
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use approx::assert_relative_eq;

    #[test]
    fn the_surface_holds_volume_and_area_to_a_thousandth() {
        let s = SphereShape::new(2.0, Vec3::new(1.0, 0.0, -1.0)).unwrap();
        assert_eq!(s.surface().genus(), Some(0));
        assert_relative_eq!(s.surface().volume(), s.volume(), max_relative = 1e-3);
        assert_relative_eq!(s.surface().area(), 16.0 * PI, max_relative = 1e-3);
        assert_eq!(s.surface().bounds().unwrap(), s.bounds());
    }

    #[test]
    fn filled_cells_add_up_to_the_volume() {
        let s = SphereShape::new(1.0, Vec3::zeros()).unwrap();
        let grid = Grid { origin: Vec3::repeat(-1.0), spacing: 0.125, cells: [16, 16, 16] };
        let volume = s.fill(&grid).iter().sum::<f64>() * grid.spacing.powi(3);
        assert_relative_eq!(volume, s.volume(), max_relative = 1e-3);
    }

    #[test]
    fn bad_radii_and_centres_are_refused() {
        assert_eq!(SphereShape::new(-1.0, Vec3::zeros()).unwrap_err().key, "body.shape.sphere.radius");
        let centre = Vec3::new(0.0, f64::INFINITY, 0.0);
        assert_eq!(SphereShape::new(1.0, centre).unwrap_err().key, "body.shape.sphere.centre[1]");
    }
}
