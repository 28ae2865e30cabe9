//! Loads on the flat faces of a box in the scheme of the paper and of bodies in the plane: with the area vectors of the operator,
//! so that a uniform traction meets a uniform stress exactly.

use crate::grid::Bounds;
use crate::region::Region;
use crate::tensor::Vec3;

/// Depth below a face, in smoothing lengths, over which its area vectors spread on an undeformed lattice.
pub const DEPTH: f64 = 3.3;
/// Largest relative deviation of their sum from the face's area on an undeformed lattice.
pub const TOLERANCE: f64 = 0.01;

/// What the flat faces of a box are loaded by.
#[derive(Clone, Copy, Debug)]
pub struct Faces<'a> {
    /// Area vectors of the particles.
    pub area_vectors: &'a [Vec3],
    /// Depth below a face over which its area vectors spread.
    pub depth: f64,
    /// Largest relative deviation of their sum from the area of the face.
    pub tolerance: f64,
}

/// A face of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    axis: usize,
    upper: bool,
}

impl Face {
    /// The faces of `bounds` that lie wholly in `region`, or `None` if the region holds parts of faces.
    pub fn whole_faces(bounds: &Bounds, region: &Region, tolerance: f64) -> Option<Vec<Self>> {
        const SAMPLES: usize = 9;
        let mut faces = Vec::new();
        for axis in 0..3 {
            for upper in [false, true] {
                let face = Self { axis, upper };
                let normal = face.normal();
                let inside = (0..SAMPLES * SAMPLES)
                    .filter(|k| {
                        let share = |i: usize| i as f64 / (SAMPLES - 1) as f64;
                        let mut s = Vec3::zeros();
                        s[axis] = if upper { 1.0 } else { 0.0 };
                        // Strictly inside the face: its edges belong to two faces.
                        s[(axis + 1) % 3] = 0.001 + 0.998 * share(k % SAMPLES);
                        s[(axis + 2) % 3] = 0.001 + 0.998 * share(k / SAMPLES);
                        let x = bounds.min + s.component_mul(&bounds.size());
                        region.contains_on_surface(&x, &normal, tolerance)
                    })
                    .count();
                match inside {
                    0 => {}
                    k if k == SAMPLES * SAMPLES => faces.push(face),
                    _ => return None,
                }
            }
        }
        Some(faces)
    }

    /// Outward normal.
    pub fn normal(&self) -> Vec3 {
        let mut n = Vec3::zeros();
        n[self.axis] = if self.upper { 1.0 } else { -1.0 };
        n
    }

    /// Forces A_a.n / S on the particles for a unit traction times area along the normal, where
    /// S = sum A.n over the area is 1 but for the quality of the lattice; `None` when it is not: a body
    /// too thin for its spacing, whose other faces reach into this one's area vectors.
    pub fn shares(&self, bounds: &Bounds, positions: &[Vec3], faces: &Faces<'_>) -> Option<Vec<f64>> {
        let normal = self.normal();
        let at = if self.upper { bounds.max[self.axis] } else { bounds.min[self.axis] };
        let size = bounds.size();
        let area = size[(self.axis + 1) % 3] * size[(self.axis + 2) % 3];
        let near = |x: &Vec3| (x[self.axis] - at).abs() < faces.depth;
        let share = |(x, a): (&Vec3, &Vec3)| if near(x) { a.dot(&normal) } else { 0.0 };
        let shares: Vec<f64> = positions.iter().zip(faces.area_vectors).map(share).collect();
        let s = shares.iter().sum::<f64>() / area;
        ((s - 1.0).abs() < faces.tolerance).then(|| shares.iter().map(|f| f / s).collect())
    }
}
