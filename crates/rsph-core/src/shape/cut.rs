//! A body cut by a plane: what is beyond it is not there.

use super::{BoxShape, MeshShape, RectangleShape, Shape};
use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use std::sync::Arc;

/// The part of `shape` before the plane through `point` whose unit `normal` points out of it. A vertex within
/// `tolerance` of the plane lies on it; a body that does not reach beyond stays as it is.
///
/// # Errors
/// `body.shape` when nothing is left.
pub fn cut(
    shape: &Arc<dyn Shape>,
    point: &Vec3,
    normal: &Vec3,
    tolerance: f64,
) -> Result<Arc<dyn Shape>, InvalidInput> {
    let surface = shape.surface();
    let beyond = |x: &Vec3| (x - point).dot(normal);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for x in &surface.vertices {
        (least, most) = (least.min(beyond(x)), most.max(beyond(x)));
    }
    if most <= tolerance {
        return Ok(Arc::clone(shape));
    }
    if least >= -tolerance {
        return Err(InvalidInput::new(
            "body.shape",
            shape.name(),
            "lies wholly beyond a plane that holds all of it",
            "check the place of the plane, its side and the units",
        ));
    }
    let axis = normal.iamax();
    if shape.is_box() && normal[axis].abs() >= 1.0 {
        let mut bounds = shape.bounds();
        let corner = if normal[axis] > 0.0 { &mut bounds.max } else { &mut bounds.min };
        corner[axis] = point[axis];
        let (size, min) = (bounds.size(), bounds.min);
        return Ok(match shape.dimension() {
            2 => Arc::new(RectangleShape::new([size.x, size.y], [min.x, min.y])?),
            _ => Arc::new(BoxShape::new(size, min)?),
        });
    }
    let left = surface.cut(point, &-normal, tolerance);
    if shape.dimension() == 2 {
        let bounds = left.mesh.bounds().unwrap_or_else(|| shape.bounds());
        let (whole, surface) = (Arc::clone(shape), left.mesh);
        return Ok(Arc::new(PlanePart { whole, point: *point, normal: *normal, bounds, surface }));
    }
    Ok(Arc::new(MeshShape::new(&left.mesh, &shape.name())?.0))
}

/// A body in the plane before a line.
#[derive(Debug)]
struct PlanePart {
    whole: Arc<dyn Shape>,
    point: Vec3,
    normal: Vec3,
    bounds: Bounds,
    surface: TriangleMesh,
}

impl Shape for PlanePart {
    fn name(&self) -> String {
        self.whole.name()
    }

    fn dimension(&self) -> usize {
        2
    }

    /// Inside exact; outside beside a corner the distance from a line through it, which is less.
    fn signed_distance(&self, x: &Vec3) -> f64 {
        self.whole.signed_distance(x).max((x - self.point).dot(&self.normal))
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn surface(&self) -> &TriangleMesh {
        &self.surface
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::SphereShape;

    fn sphere() -> Arc<dyn Shape> {
        Arc::new(SphereShape::new(1.0, Vec3::zeros()).unwrap())
    }

    #[test]
    fn half_a_sphere_has_half_its_volume_and_a_flat_face() {
        let normal = Vec3::new(1.0, 2.0, -0.5).normalize();
        let half = cut(&sphere(), &Vec3::zeros(), &normal, 1e-6).unwrap();
        assert!((half.volume() / sphere().surface().volume() - 0.5).abs() < 1e-3);
        assert!(half.signed_distance(&(0.1 * normal)) > 0.09);
        assert!(half.signed_distance(&(-0.1 * normal)) < -0.09);
    }

    #[test]
    fn a_box_stays_a_box_and_what_is_whole_stays_as_it_is() {
        let cube: Arc<dyn Shape> = Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap());
        let left = cut(&cube, &Vec3::new(0.25, 0.0, 0.0), &-Vec3::x(), 1e-6).unwrap();
        assert!(left.is_box());
        assert_eq!(left.bounds().min.x, 0.25);
        let whole = cut(&cube, &Vec3::zeros(), &-Vec3::x(), 1e-6).unwrap();
        assert!(Arc::ptr_eq(&whole, &cube));
        assert!(cut(&cube, &Vec3::new(2.0, 0.0, 0.0), &-Vec3::x(), 1e-6).is_err());
    }
}
