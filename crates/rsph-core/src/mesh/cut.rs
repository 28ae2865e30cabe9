//! A closed surface cut by a plane.

mod cap;
mod fill;
mod part;

use super::TriangleMesh;
use crate::tensor::Vec3;
pub(crate) use fill::filled;
use part::Part;

/// Error of a height above the plane, and the distance under which cut points count as one, as a
/// part of the largest coordinate.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// The part of a closed surface on one side of a plane, closed by a cap.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutMesh {
    /// The surface of the part: what is left of the triangles, in their order, then the cap.
    pub mesh: TriangleMesh,
    /// Whether each triangle lies on the plane: the cap, and what lay there from the start.
    pub on_plane: Vec<bool>,
}

impl TriangleMesh {
    /// What is left of the closed surface where (x - `point`) . `normal` >= 0, closed by a cap.
    ///
    /// The cap faces along -`normal`, leaves holes and hollows open, and uses the vertices of the cut
    /// as they are, so that the result is closed by indices. Vertices within `tolerance` (a length;
    /// never less than rounding) of the plane are moved onto it. Triangles that then lie on it stay if
    /// they face along -`normal` (the body only touches the plane there) and go otherwise; a piece that
    /// reaches nowhere above it goes as a whole. Pieces that overlap are capped each for itself. Where
    /// the surface was open, the ends of a cut are joined by a straight edge. Triangles with missing
    /// vertices are left out; a `normal` without a direction cuts nothing.
    #[must_use]
    pub fn cut(&self, point: &Vec3, normal: &Vec3, tolerance: f64) -> CutMesh {
        let there = |t: &&[u32; 3]| t.iter().all(|&v| (v as usize) < self.vertices.len());
        let mut source = Self {
            vertices: self.vertices.clone(),
            triangles: self.triangles.iter().filter(there).copied().collect(),
        };
        let Some(plane) = Plane::new(point, normal) else {
            let on_plane = vec![false; source.triangles.len()];
            return CutMesh { mesh: source, on_plane };
        };
        let sizes = source.vertices.iter().chain([point]).map(Vec3::amax);
        let rounding = ROUNDING * sizes.filter(|s| s.is_finite()).fold(0.0, f64::max);
        let tolerance = tolerance.max(rounding);
        let heights: Vec<_> = source.vertices.iter().map(|v| plane.height(v)).collect();
        let sides: Vec<_> = heights.iter().map(|&h| Side::of(h, tolerance)).collect();
        for (v, _) in source.vertices.iter_mut().zip(&sides).filter(|(_, side)| **side == Side::On) {
            *v = plane.foot(v);
        }

        let (piece, pieces) = source.component_of_triangles();
        let mut reaches = vec![false; pieces];
        for (t, &p) in source.triangles.iter().zip(&piece) {
            reaches[p] |= t.iter().any(|&v| sides[v as usize] == Side::Kept);
        }
        let mut part = Part::new(source.vertices.clone(), sides.iter().map(|&s| s == Side::On).collect());
        for (t, &triangle) in source.triangles.iter().enumerate().filter(|&(t, _)| reaches[piece[t]]) {
            let corner_sides = triangle.map(|v| sides[v as usize]);
            if corner_sides == [Side::On; 3] {
                if source.area_vector(t).dot(&plane.normal) < 0.0 {
                    part.push(triangle, true);
                }
            } else if !corner_sides.contains(&Side::Beyond) {
                part.push(triangle, false);
            } else if corner_sides.contains(&Side::Kept) {
                part.push_cut(triangle, corner_sides, &plane, &heights);
            }
        }
        part.collapse(rounding);
        for triangle in cap::triangles(&part.cut.mesh.vertices, &plane, &part.rim()) {
            part.push(triangle, true);
        }
        part.cut.mesh.drop_unused_vertices();
        part.cut
    }

    /// Drops the vertices that no triangle uses; the others stay in their order.
    fn drop_unused_vertices(&mut self) {
        let mut used = vec![false; self.vertices.len()];
        self.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let new_index: Vec<_> = used
            .iter()
            .scan(0, |count, &u| {
                *count += u32::from(u);
                Some(*count)
            })
            .collect();
        self.triangles.iter_mut().flatten().for_each(|v| *v = new_index[*v as usize] - 1);
        let mut used = used.into_iter();
        self.vertices.retain(|_| used.next() == Some(true));
    }
}

/// Where a vertex lies, seen from the plane.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Kept,
    On,
    Beyond,
}

impl Side {
    fn of(height: f64, tolerance: f64) -> Self {
        if height < -tolerance {
            Self::Beyond
        } else if height <= tolerance {
            Self::On
        } else {
            Self::Kept
        }
    }
}

/// A plane; what lies above it, along its unit normal, is kept.
struct Plane {
    point: Vec3,
    normal: Vec3,
}

impl Plane {
    /// The plane through `point`; `None` if `normal` has no direction.
    fn new(point: &Vec3, normal: &Vec3) -> Option<Self> {
        // Divided first, so that the square of a long or short normal stays in the range of numbers.
        let normal = (normal / normal.amax()).normalize();
        normal.iter().all(|c| c.is_finite()).then_some(Self { point: *point, normal })
    }

    fn height(&self, x: &Vec3) -> f64 {
        (x - self.point).dot(&self.normal)
    }

    /// The point of the plane nearest to `x`.
    fn foot(&self, x: &Vec3) -> Vec3 {
        x - self.normal * self.height(x)
    }
}
