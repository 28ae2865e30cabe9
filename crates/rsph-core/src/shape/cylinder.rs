//! A circular cylinder along a coordinate axis.

use super::{Shape, check};
use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::mesh::TriangleMesh;
use crate::region::Axis;
use crate::tensor::Vec3;
use std::f64::consts::{PI, TAU};

/// Sides of the polygon that stands for the circle: area and circumference hold to 0.04 %.
const SIDES: u32 = 128;

/// A circular cylinder along a coordinate axis.
#[derive(Clone, Debug)]
pub struct CylinderShape {
    axis: usize,
    radius: f64,
    height: f64,
    centre: Vec3,
    surface: TriangleMesh,
}

impl CylinderShape {
    /// A cylinder along `axis`.
    ///
    /// # Errors
    /// `body.shape.cylinder.radius`, `.height` when they are not positive and finite,
    /// `.centre[i]` when a coordinate is not finite.
    pub fn new(axis: Axis, radius: f64, height: f64, centre: Vec3) -> Result<Self, InvalidInput> {
        check::positive("body.shape.cylinder.radius", radius)?;
        check::positive("body.shape.cylinder.height", height)?;
        check::finite("body.shape.cylinder.centre", &centre)?;
        let axis = axis as usize;
        Ok(Self { axis, radius, height, centre, surface: polygonal(axis, radius, height, &centre) })
    }
}

/// A prism over a regular polygon. Vertices 2i and 2i + 1 are the lower and upper end of edge i,
/// the last two the middles of the caps.
fn polygonal(axis: usize, radius: f64, height: f64, centre: &Vec3) -> TriangleMesh {
    let point = |u: f64, v: f64, w: f64| {
        let mut x = *centre;
        x[(axis + 1) % 3] += u;
        x[(axis + 2) % 3] += v;
        x[axis] += w;
        x
    };
    let mut mesh = TriangleMesh::default();
    let (low, high) = (2 * SIDES, 2 * SIDES + 1);
    for i in 0..SIDES {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(SIDES)).sin_cos();
        for w in [-0.5 * height, 0.5 * height] {
            mesh.vertices.push(point(radius * cos, radius * sin, w));
        }
        let (a, b) = (2 * i, 2 * ((i + 1) % SIDES));
        mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1], [low, b, a], [high, a + 1, b + 1]]);
    }
    mesh.vertices.extend([point(0.0, 0.0, -0.5 * height), point(0.0, 0.0, 0.5 * height)]);
    mesh
}

impl Shape for CylinderShape {
    fn name(&self) -> String {
        "cylinder".into()
    }

    fn signed_distance(&self, x: &Vec3) -> f64 {
        let d = x - self.centre;
        let around = d[(self.axis + 1) % 3].hypot(d[(self.axis + 2) % 3]) - self.radius;
        let along = d[self.axis].abs() - 0.5 * self.height;
        around.max(0.0).hypot(along.max(0.0)) + around.max(along).min(0.0)
    }

    fn bounds(&self) -> Bounds {
        let mut half = Vec3::repeat(self.radius);
        half[self.axis] = 0.5 * self.height;
        Bounds { min: self.centre - half, max: self.centre + half }
    }

    fn volume(&self) -> f64 {
        PI * self.radius.powi(2) * self.height
    }

    fn surface(&self) -> &TriangleMesh {
        &self.surface
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_surface_holds_volume_and_area_along_every_axis() {
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let c = CylinderShape::new(axis, 0.5, 3.0, Vec3::new(1.0, 2.0, 3.0)).unwrap();
            assert_eq!(c.surface().genus(), Some(0));
            assert_relative_eq!(c.surface().volume(), c.volume(), max_relative = 1e-3);
            assert_relative_eq!(c.surface().area(), PI * (0.5 + 3.0), max_relative = 1e-3);
            assert_relative_eq!(c.bounds().size()[axis as usize], 3.0, epsilon = 1e-12);
        }
    }

    #[test]
    fn distance_to_side_cap_and_rim() {
        let c = CylinderShape::new(Axis::Z, 1.0, 2.0, Vec3::zeros()).unwrap();
        assert_relative_eq!(c.signed_distance(&Vec3::new(0.0, 0.9, 0.0)), -0.1, epsilon = 1e-12);
        assert_relative_eq!(c.signed_distance(&Vec3::new(0.0, 0.0, 1.5)), 0.5);
        assert_relative_eq!(c.signed_distance(&Vec3::new(4.0, 0.0, 5.0)), 5.0);
    }

    #[test]
    fn bad_numbers_name_their_key() {
        let e = CylinderShape::new(Axis::X, 0.0, 1.0, Vec3::zeros()).unwrap_err();
        assert_eq!(e.key, "body.shape.cylinder.radius");
        let e = CylinderShape::new(Axis::X, 1.0, f64::NAN, Vec3::zeros()).unwrap_err();
        assert_eq!(e.key, "body.shape.cylinder.height");
    }
}
