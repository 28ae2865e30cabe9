//! A polygon in the plane: a plane body.

use super::slab::filled_slab;
use super::{Shape, check};
use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;

/// Most corners: every distance looks at all of them.
const MAX_CORNERS: usize = 10_000;

/// The inside of a closed outline in the plane z = 0, of thickness one.
#[derive(Clone, Debug)]
pub struct PolygonShape {
    /// Corners, counter-clockwise.
    corners: Vec<Vec3>,
    bounds: Bounds,
    surface: TriangleMesh,
}

impl PolygonShape {
    /// The polygon with these corners, in order around it either way.
    ///
    /// # Errors
    /// `body.shape.polygon.points[i]` when a coordinate is not finite, `body.shape.polygon.points` when there are fewer than
    /// three or too many, or the outline meets itself.
    pub fn new(points: &[[f64; 2]]) -> Result<Self, InvalidInput> {
        const KEY: &str = "body.shape.polygon.points";
        if !(3..=MAX_CORNERS).contains(&points.len()) {
            return Err(InvalidInput::new(
                KEY,
                format!("{} points", points.len()),
                format!("an outline has 3 to {MAX_CORNERS} corners"),
                "give the corners in order around the body, each once",
            ));
        }
        let mut corners: Vec<Vec3> = points.iter().map(|p| Vec3::new(p[0], p[1], 0.0)).collect();
        for (i, corner) in corners.iter().enumerate() {
            check::finite(&format!("{KEY}[{i}]"), corner)?;
        }
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        if edges.map(|(a, b)| (a - corners[0]).cross(&(b - corners[0])).z).sum::<f64>() < 0.0 {
            corners.reverse();
        }
        let surface = filled_slab(&corners).ok_or_else(|| {
            InvalidInput::new(
                KEY,
                format!("{} points", points.len()),
                "the outline meets itself, or encloses nothing",
                "give the corners in order around the body, each once",
            )
        })?;
        let bounds = surface.bounds().unwrap_or(Bounds { min: corners[0], max: corners[0] });
        Ok(Self { corners, bounds, surface })
    }
}

impl Shape for PolygonShape {
    fn name(&self) -> String {
        "polygon".into()
    }

    fn dimension(&self) -> usize {
        2
    }

    fn signed_distance(&self, x: &Vec3) -> f64 {
        let (mut square, mut inside) = (f64::INFINITY, false);
        for (a, b) in self.corners.iter().zip(self.corners.iter().cycle().skip(1)) {
            let (edge, to) = ((b - a).xy(), (x - a).xy());
            let along = (to.dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
            square = square.min((to - edge * along).norm_squared());
            // Edges that a ray along x crosses.
            if (a.y > x.y) != (b.y > x.y) && to.x < edge.x * to.y / edge.y {
                inside = !inside;
            }
        }
        if inside { -square.sqrt() } else { square.sqrt() }
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
    use approx::assert_relative_eq;

    /// An L, clockwise.
    const L: [[f64; 2]; 6] = [[0.0, 0.0], [0.0, 2.0], [1.0, 2.0], [1.0, 1.0], [3.0, 1.0], [3.0, 0.0]];

    #[test]
    fn the_slab_is_closed_and_has_the_volume() {
        let shape = PolygonShape::new(&L).unwrap();
        assert_eq!(shape.surface().genus(), Some(0));
        assert_relative_eq!(shape.volume(), 4.0, epsilon = 1e-12);
        assert_relative_eq!(shape.signed_distance(&Vec3::new(0.5, 0.4, 7.0)), -0.4, epsilon = 1e-12);
        assert_relative_eq!(shape.signed_distance(&Vec3::new(2.0, 1.5, 0.0)), 0.5, epsilon = 1e-12);
        assert_relative_eq!(shape.signed_distance(&Vec3::new(6.0, -4.0, 0.0)), 5.0, epsilon = 1e-12);
        // On the height of a corner.
        assert_relative_eq!(shape.signed_distance(&Vec3::new(-1.0, 1.0, 0.0)), 1.0, epsilon = 1e-12);
        assert_relative_eq!(shape.signed_distance(&Vec3::new(0.5, 1.0, 0.0)), -0.5, epsilon = 1e-12);
    }

    #[test]
    fn bad_outlines_name_their_key() {
        let key = |points: &[[f64; 2]]| PolygonShape::new(points).unwrap_err().key;
        assert_eq!(key(&L[..2]), "body.shape.polygon.points");
        assert_eq!(key(&[[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]]), "body.shape.polygon.points[1][1]");
        let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(key(&bow), "body.shape.polygon.points");
        assert_eq!(key(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]), "body.shape.polygon.points");
    }
}
