//! A body bounded by a triangle surface.

use super::repair::{self, Found, Repair};
use super::{Shape, check, columns::Columns};
use crate::error::InvalidInput;
use crate::grid::{Bounds, Grid};
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;
use rayon::prelude::*;
use std::fmt;

/// A closed surface that winds around more than this share of its inside twice is no surface of a solid.
const LEAST_OVERLAP: f64 = 1e-3;

/// A body bounded by a closed triangle surface.
#[derive(Clone)]
pub struct MeshShape {
    name: String,
    surface: TriangleMesh,
    bounds: Bounds,
    volume: f64,
    /// Tells inside from outside.
    columns: Columns,
    /// Finds the nearest point of the surface.
    nearest: TriMesh,
    repair: Option<Repair>,
}

impl MeshShape {
    /// The body inside of `mesh`, and what was changed about the mesh, one sentence each. Vertices at equal positions
    /// are merged, triangles that occur twice count once, and what is turned inside out is turned round. A surface that
    /// is still not closed becomes a body by its winding number ([`Shape::repair`]). `name` is what messages
    /// and summaries call it, e.g. `mesh liver.stl`.
    ///
    /// # Errors
    /// `body.shape.mesh.path` when the mesh has no triangle, a vertex that is not finite, a triangle without vertices, no
    /// volume, or holes that leave too much of the inside uncertain.
    pub fn new(mesh: &TriangleMesh, name: &str) -> Result<(Self, Vec<String>), InvalidInput> {
        Self::build(mesh, name, true)
    }

    /// As [`MeshShape::new`], but a surface that is not closed is refused.
    ///
    /// # Errors
    /// As [`MeshShape::new`], and when the surface has open edges.
    pub fn new_closed(mesh: &TriangleMesh, name: &str) -> Result<(Self, Vec<String>), InvalidInput> {
        Self::build(mesh, name, false)
    }

    fn build(mesh: &TriangleMesh, name: &str, may_repair: bool) -> Result<(Self, Vec<String>), InvalidInput> {
        let refuse = |problem: String, remedy: &str| {
            Err(InvalidInput::new("body.shape.mesh.path", name, problem, remedy))
        };
        if let Some(t) = mesh.first_bad_triangle() {
            return refuse(
                format!("triangle {t} names a vertex that is not there ({} vertices)", mesh.vertices.len()),
                "export the mesh again",
            );
        }
        if let Some(v) = mesh.first_not_finite() {
            let [x, y, z] = mesh.vertices[v].into();
            return refuse(
                format!("vertex {v} is ({x}, {y}, {z}); coordinates must be finite"),
                "repair the mesh, or export it again",
            );
        }
        let merged = mesh.merged();
        if let Some(bounds) = merged.bounds() {
            check::extent("body.shape.mesh.path", &bounds, 3)?;
        }
        let (parts, mut notes) = repair::outward(&merged, name);
        let Some(bounds) = parts.mesh.bounds() else {
            return refuse("the mesh has no triangles".into(), "give a closed surface");
        };
        let is_closed = parts.closed.iter().all(|closed| *closed);
        if is_closed {
            let volume = parts.mesh.volume();
            if !volume.is_finite() || volume <= 1e-9 * bounds.size().norm().powi(3) {
                return refuse(
                    format!("the surface encloses no volume that can be computed with ({volume:e})"),
                    "give the surface of a solid body; check `scale`",
                );
            }
            let overlap = Columns::new(&parts.mesh).overlap();
            if overlap > LEAST_OVERLAP && !may_repair {
                notes.push(format!(
                    "{name} overlaps itself: {:.2} % of what it encloses count more than once",
                    100.0 * overlap
                ));
            }
            if overlap <= LEAST_OVERLAP || !may_repair {
                return match Self::from_closed(parts.mesh, name) {
                    Some(shape) => Ok((shape, notes)),
                    None => refuse("the mesh has no triangles".into(), "give a closed surface"),
                };
            }
        }
        let open = if is_closed {
            "the surface overlaps itself".into()
        } else {
            format!(
                "the surface is not closed: {} open edges (not shared by exactly two triangles that turn the same way) \
                 of {} triangles",
                parts.mesh.open_edges().len(),
                parts.mesh.triangles.len()
            )
        };
        if !may_repair {
            return refuse(
                open,
                "allow `repair = true`, or close the holes in a mesh editor (MeshLab, Blender, Meshmixer)",
            );
        }
        let remedy =
            "close the holes in a mesh editor (MeshLab, Blender, Meshmixer), or give the rest of the surface";
        let (surface, repair) = match repair::repaired(&parts) {
            Found::Body(surface, repair) => (surface, repair),
            Found::Nothing => {
                return refuse(
                    format!(
                        "{open}; it encloses nothing: nowhere does it wind around more than half of the directions"
                    ),
                    remedy,
                );
            }
            Found::Doubtful(share) => {
                return refuse(
                    format!(
                        "{open}; its holes are too wide to tell the inside: {:.0} % of it are uncertain, winding number \
                         below 3/4",
                        100.0 * share
                    ),
                    remedy,
                );
            }
        };
        notes.extend(repair.notes(name));
        match Self::from_closed(surface, name) {
            Some(shape) => Ok((Self { repair: Some(repair), ..shape }, notes)),
            None => refuse(open, remedy),
        }
    }

    /// From a surface known to be closed, finite and outward; `None` if it is empty.
    pub(super) fn from_closed(surface: TriangleMesh, name: &str) -> Option<Self> {
        let vertices = surface.vertices.iter().map(|v| Vector::new(v.x, v.y, v.z)).collect();
        Some(Self {
            name: name.into(),
            bounds: surface.bounds()?,
            volume: surface.volume(),
            columns: Columns::new(&surface),
            nearest: TriMesh::new(vertices, surface.triangles.clone()).ok()?,
            surface,
            repair: None,
        })
    }
}

impl fmt::Debug for MeshShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MeshShape")
            .field("name", &self.name)
            .field("triangles", &self.surface.triangles.len())
            .field("bounds", &self.bounds)
            .field("volume", &self.volume)
            .finish_non_exhaustive()
    }
}

impl Shape for MeshShape {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn signed_distance(&self, x: &Vec3) -> f64 {
        let p = Vector::new(x.x, x.y, x.z);
        let distance = (self.nearest.project_local_point(p, false).point - p).length();
        if self.columns.contains(x) { -distance } else { distance }
    }

    fn signed_distances(&self, grid: &Grid, reach: f64) -> Vec<f64> {
        let [nx, ny, _] = grid.cells;
        let mut values = vec![0.0; grid.len()];
        values.par_chunks_mut(nx.max(1)).enumerate().for_each_init(Vec::new, |passages, (row, along_x)| {
            let first = grid.centre([0, row % ny, row / ny]);
            self.columns.passages(first.y, first.z, passages);
            let mut passed = passages.iter().peekable();
            let mut winding = 0;
            // The nearest point of the surface is near that of the cell before, and no farther than it.
            let mut before: Option<(Vector, usize, f64)> = None;
            for (i, value) in along_x.iter_mut().enumerate() {
                let x = grid.centre([i, row % ny, row / ny]);
                while let Some((_, change)) = passed.next_if(|p| p.0 < x.x) {
                    winding += change;
                }
                if let Some((_, at, distance)) = before {
                    let least = distance - (i - at) as f64 * grid.spacing;
                    if winding <= 0 && least > reach {
                        *value = least;
                        continue;
                    }
                }
                let p = Vector::new(x.x, x.y, x.z);
                let found = before.and_then(|(point, _, _)| {
                    let most = (point - p).length() * (1.0 + 1e-9);
                    self.nearest.project_local_point_with_max_dist(p, false, most)
                });
                let nearest = found.unwrap_or_else(|| self.nearest.project_local_point(p, false)).point;
                let distance = (nearest - p).length();
                before = Some((nearest, i, distance));
                *value = if winding > 0 { -distance } else { distance };
            }
        });
        values
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    fn surface(&self) -> &TriangleMesh {
        &self.surface
    }

    fn repair(&self) -> Option<&Repair> {
        self.repair.as_ref()
    }

    fn fill(&self, grid: &Grid) -> Vec<f64> {
        self.columns.fill(grid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::Axis;
    use crate::shape::{BoxShape, CylinderShape};
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn cube() -> TriangleMesh {
        BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap().surface().clone()
    }

    #[test]
    fn a_flipped_mesh_is_turned_round_and_says_so() {
        let (shape, notes) = MeshShape::new(&cube().flipped(), "mesh cube.stl").unwrap();
        assert_relative_eq!(shape.volume(), 1.0, epsilon = 1e-12);
        assert!(notes[0].contains("inside out"));
        assert!(MeshShape::new(&cube(), "mesh cube.stl").unwrap().1.is_empty());
    }

    #[test]
    fn bad_meshes_are_refused_with_the_reason() {
        let problem = |m: &TriangleMesh| MeshShape::new(m, "mesh x.stl").unwrap_err().problem;
        assert!(problem(&TriangleMesh::default()).contains("no triangles"));
        let mut m = cube();
        m.triangles.truncate(8);
        assert!(problem(&m).contains("8 open edges") && problem(&m).contains("too wide"), "{}", problem(&m));
        m.triangles.truncate(2);
        assert!(problem(&m).contains("its size is 0.000e0"), "{}", problem(&m));
        m = cube();
        m.triangles.pop();
        let refused = MeshShape::new_closed(&m, "mesh x.stl").unwrap_err();
        assert!(refused.problem.contains("3 open edges") && refused.remedy.contains("repair"), "{refused}");
        m = cube();
        m.vertices[2].x = f64::NAN;
        assert!(problem(&m).contains("vertex 2"));
        m = cube();
        m.triangles[1][2] = 8;
        assert!(problem(&m).contains("triangle 1"));
        m = cube();
        for v in &mut m.vertices {
            v.z *= 1e-14;
        }
        assert!(problem(&m).contains("no volume"), "{}", problem(&m));
    }

    proptest! {
        /// Triangles give the same distance as the formula.
        #[test]
        fn distances_agree_with_the_formula(x in -1.0..2.0_f64, y in -1.0..2.0_f64, z in -1.0..2.0_f64) {
            let exact = BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap();
            let shape = MeshShape::new(exact.surface(), "mesh cube").unwrap().0;
            let p = Vec3::new(x, y, z);
            prop_assert!((shape.signed_distance(&p) - exact.signed_distance(&p)).abs() < 1e-12);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// No triangles, however broken, make the constructor panic.
        #[test]
        fn broken_references_are_met_at_the_door(
            points in prop::collection::vec(prop::array::uniform3(-1e3..1e3_f64), 0..8),
            triangles in prop::collection::vec(prop::array::uniform3(0..9_u32), 0..12),
        ) {
            let mesh = TriangleMesh { vertices: points.into_iter().map(Vec3::from).collect(), triangles };
            let _ = MeshShape::new(&mesh, "mesh soup");
        }
    }

    #[test]
    fn filling_a_mesh_agrees_with_filling_the_formula() {
        let exact = CylinderShape::new(Axis::Y, 0.4, 0.9, Vec3::new(0.0, -0.45, 0.0)).unwrap();
        let shape = MeshShape::new(exact.surface(), "mesh cylinder").unwrap().0;
        let grid = Grid { origin: Vec3::repeat(-0.5), spacing: 0.1, cells: [10, 10, 10] };
        for (a, b) in shape.fill(&grid).iter().zip(exact.fill(&grid)) {
            assert!((a - b).abs() < 0.08, "{a} {b}");
        }
    }

    #[test]
    fn distances_on_a_grid_are_those_of_its_points() {
        let shape = crate::shape::organ("kidney").unwrap();
        let dx = 0.004;
        let origin = shape.bounds().min - Vec3::repeat(5.3 * dx);
        let size = shape.bounds().size() / dx;
        let grid = Grid { origin, spacing: dx, cells: [size.x, size.y, size.z].map(|n| n as usize + 11) };
        let reach = 2.0 * dx;
        for (q, value) in shape.signed_distances(&grid, reach).iter().enumerate() {
            let [nx, ny, _] = grid.cells;
            let exact = shape.signed_distance(&grid.centre([q % nx, q / nx % ny, q / nx / ny]));
            if exact <= reach {
                assert!((value - exact).abs() < 1e-12, "{value} {exact}");
            } else {
                assert!(*value >= reach && *value < exact + 1e-12, "{value} {exact}");
            }
        }
    }
}
