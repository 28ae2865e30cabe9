//! Shapes of bodies.

use crate::arrays;
use crate::errors;
use crate::pool::detach;
use numpy::{PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;
use rsph_core::error::InvalidInput;
use rsph_core::mesh::TriangleMesh;
use rsph_core::region::Axis;
use rsph_core::shape::{
    self as core, BoxShape, CylinderShape, DiscShape, MeshShape, Placement, PolygonShape, RectangleShape,
    Run, SphereShape,
};
use rsph_core::tensor::{Mat3, Vec3};
use rsph_scenario::label_map::{Axes, read_label};
use rsph_scenario::mesh_io::{read_mesh, write_mesh};
use rsph_scenario::output::summary::RepairSummary;
use std::path::PathBuf;
use std::sync::Arc;

/// A body's shape in its undeformed state.
#[pyclass(frozen, module = "rsph._rsph")]
pub struct Shape {
    pub(crate) shape: Arc<dyn core::Shape>,
    notes: Vec<String>,
}

impl Shape {
    fn analytic<S: core::Shape + 'static>(shape: Result<S, InvalidInput>) -> PyResult<Self> {
        let shape = shape.map_err(|e| errors::invalid_input(&e))?;
        Ok(Self { shape: Arc::new(shape), notes: Vec::new() })
    }

    fn from_mesh(mesh: &TriangleMesh, name: &str, repair: bool) -> PyResult<Self> {
        let build = if repair { MeshShape::new } else { MeshShape::new_closed };
        let (shape, notes) = build(mesh, name).map_err(|e| errors::invalid_input(&e))?;
        Ok(Self { shape: Arc::new(shape), notes })
    }

    fn from_voxels(runs: &[Run], size: [usize; 3], placement: &Placement, name: &str) -> PyResult<Self> {
        let (shape, notes) =
            core::voxel_shape(runs, size, placement, name).map_err(|e| errors::invalid_input(&e))?;
        Ok(Self { shape: Arc::new(shape), notes })
    }
}

#[pymethods]
impl Shape {
    /// An axis-aligned box.
    #[staticmethod]
    #[pyo3(name = "box")]
    fn cuboid(size: [f64; 3], corner: [f64; 3]) -> PyResult<Self> {
        Self::analytic(BoxShape::new(size.into(), corner.into()))
    }

    /// A sphere.
    #[staticmethod]
    fn sphere(radius: f64, centre: [f64; 3]) -> PyResult<Self> {
        Self::analytic(SphereShape::new(radius, centre.into()))
    }

    /// A cylinder along the axis "x", "y" or "z".
    #[staticmethod]
    fn cylinder(radius: f64, height: f64, axis: &str, centre: [f64; 3]) -> PyResult<Self> {
        let axis = match axis {
            "x" => Axis::X,
            "y" => Axis::Y,
            "z" => Axis::Z,
            other => {
                return Err(errors::invalid_input(&InvalidInput::new(
                    "body.shape.cylinder.axis",
                    format!("\"{other}\""),
                    "there is no such axis",
                    "choose \"x\", \"y\" or \"z\"",
                )));
            }
        };
        Self::analytic(CylinderShape::new(axis, radius, height, centre.into()))
    }

    /// A rectangle in the plane.
    #[staticmethod]
    fn rectangle(size: [f64; 2], corner: [f64; 2]) -> PyResult<Self> {
        Self::analytic(RectangleShape::new(size, corner))
    }

    /// A disc in the plane.
    #[staticmethod]
    fn disc(radius: f64, centre: [f64; 2]) -> PyResult<Self> {
        Self::analytic(DiscShape::new(radius, centre))
    }

    /// A polygon in the plane.
    #[staticmethod]
    fn polygon(points: Vec<[f64; 2]>) -> PyResult<Self> {
        Self::analytic(PolygonShape::new(&points))
    }

    /// An organ that the program builds itself.
    #[staticmethod]
    fn organ(py: Python<'_>, name: &str) -> PyResult<Self> {
        detach(py, || Self::analytic(core::organ(name)))
    }

    /// The inside of a triangle mesh from a file.
    #[staticmethod]
    fn mesh_file(py: Python<'_>, path: PathBuf, scale: f64, repair: bool) -> PyResult<Self> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        detach(py, || {
            let mesh = read_mesh(&path, scale).map_err(|e| errors::mesh(&e))?;
            Self::from_mesh(&mesh, &format!("mesh {name}"), repair)
        })
    }

    /// The inside of a triangle mesh from arrays (V, 3) and (T, 3).
    #[staticmethod]
    fn mesh_arrays(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f64>,
        triangles: PyReadonlyArray2<'_, u32>,
        repair: bool,
    ) -> PyResult<Self> {
        let vertices: Vec<Vec3> = arrays::vectors(&vertices, "vertices")?;
        let triangles = triangles.as_array();
        if triangles.ncols() != 3 {
            return Err(arrays::shape_error("triangles", triangles.shape()));
        }
        let triangles = triangles.rows().into_iter().map(|r| [r[0], r[1], r[2]]).collect();
        let mesh = TriangleMesh { vertices, triangles };
        detach(py, || Self::from_mesh(&mesh, "mesh from arrays", repair))
    }

    /// The body of the voxels (NX, NY, NZ) that are true; `affine` (4, 4) goes from indices to positions.
    #[staticmethod]
    fn mask(
        py: Python<'_>,
        voxels: PyReadonlyArray3<'_, bool>,
        affine: [[f64; 4]; 4],
        name: String,
    ) -> PyResult<Self> {
        let voxels = voxels.as_array();
        let size = [voxels.shape()[0], voxels.shape()[1], voxels.shape()[2]];
        let mut runs = Vec::new();
        for ((i, j, k), inside) in voxels.indexed_iter() {
            if *inside {
                runs.push(Run { start: [i, j, k], length: 1 });
            }
        }
        let placement = Placement {
            axes: Mat3::from_fn(|i, j| affine[i][j]),
            origin: Vec3::from_fn(|i, _| affine[i][3]),
        };
        detach(py, || Self::from_voxels(&runs, size, &placement, &name))
    }

    /// The body of a label in a NIfTI file; `scale` absent: to metres by its header.
    #[staticmethod]
    #[pyo3(signature = (path, label, scale, axes))]
    fn label_map(
        py: Python<'_>,
        path: PathBuf,
        label: u32,
        scale: Option<f64>,
        axes: &str,
    ) -> PyResult<Self> {
        let axes = match axes {
            "image" => Axes::Image,
            "organ" => Axes::Organ,
            other => {
                return Err(errors::invalid_input(&InvalidInput::new(
                    "body.labelmap.axes",
                    format!("\"{other}\""),
                    "there are no such axes",
                    "choose \"image\" or \"organ\"",
                )));
            }
        };
        if scale.is_some_and(|s| !(s.is_finite() && s > 0.0)) {
            return Err(errors::invalid_input(&InvalidInput::new(
                "body.labelmap.scale",
                scale.unwrap_or_default(),
                "the scale of an image must be greater than 0",
                "leave it out to go by the header of the image; 0.001 makes metres of mm",
            )));
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        detach(py, || {
            let read = read_label(&path, label).map_err(|e| errors::label_map(&e))?;
            let placement = read.placement(scale, axes);
            Self::from_voxels(&read.runs, read.size, &placement, &format!("label {label} of {name}"))
        })
    }

    /// What it is.
    #[getter]
    fn name(&self) -> String {
        self.shape.name()
    }

    /// Volume enclosed by the surface.
    #[getter]
    fn volume(&self) -> f64 {
        self.shape.volume()
    }

    /// Lower and upper corner of the bounding box.
    #[getter]
    fn bounds(&self) -> ((f64, f64, f64), (f64, f64, f64)) {
        let b = self.shape.bounds();
        ((b.min.x, b.min.y, b.min.z), (b.max.x, b.max.y, b.max.z))
    }

    /// What was changed about a mesh, one sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// How the surface was made whole, as the text of `repair` in `summary.json`; `None` if it was closed.
    #[getter]
    fn repair(&self) -> Option<String> {
        self.shape.repair().map(|r| RepairSummary::from(r).to_json().unwrap_or_default())
    }

    /// Vertices (V, 3) and triangles (T, 3) of the surface.
    fn surface<'py>(&self, py: Python<'py>) -> (Bound<'py, PyAny>, Bound<'py, PyAny>) {
        let mesh = self.shape.surface();
        let vertices = arrays::positions(py, mesh.vertices.iter().map(|v| (*v).into()));
        (vertices, arrays::triangles(py, &mesh.triangles))
    }

    /// Writes the surface as an STL, OBJ or PLY file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        detach(py, || write_mesh(&path, self.shape.surface(), &[])).map_err(|e| errors::mesh(&e))
    }

    /// Signed distances (N,) of points (N, 3) to the surface, negative inside.
    fn signed_distance<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let points = arrays::vectors(&points, "points")?;
        let distances = detach(py, || points.iter().map(|p| self.shape.signed_distance(p)).collect());
        arrays::point_by_point(py, distances, 1)
    }

    fn __repr__(&self) -> String {
        let (size, volume) = (self.shape.bounds().size(), self.shape.volume());
        format!(
            "<rsph shape: {}, extent {:.4} x {:.4} x {:.4}, volume {volume:.4e}>",
            self.shape.name(),
            size.x,
            size.y,
            size.z
        )
    }
}

/// Names of the organs that the program builds itself.
#[pyfunction]
pub fn organ_names() -> Vec<&'static str> {
    core::organ_names().collect()
}
