//! Points, cells and point data of one moment: what every writer takes and every reader gives.

use rsph_core::particles::{Column, Field};
use rsph_core::snapshot::Snapshot;
use rsph_core::surface::Surface;

/// What the points are tied into.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// One vertex a point: particles.
    Vertices,
    /// Triangles of three point indices: a surface.
    Triangles(Vec<[u32; 3]>),
}

/// A field on the points.
#[derive(Clone, Debug, PartialEq)]
pub struct PointField {
    /// Name in files.
    pub name: String,
    /// Values a point; 6 is a symmetric tensor XX YY ZZ XY YZ XZ.
    pub components: usize,
    /// `components x points` values, point by point.
    pub values: Vec<f64>,
}

/// Points, cells and point data of one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct PolyData {
    /// Simulated time (time unit of the scenario; s in SI).
    pub time: f64,
    /// Positions (length unit of the scenario; m in SI).
    pub points: Vec<[f64; 3]>,
    /// What they are tied into.
    pub cells: Cells,
    /// Fields on them.
    pub fields: Vec<PointField>,
}

impl PolyData {
    /// The particles of a snapshot at their current places, with every column but the reference
    /// position.
    pub fn from_snapshot(snapshot: &Snapshot) -> Self {
        let fields = snapshot
            .columns()
            .filter(|(spec, _)| spec.field != Field::Reference)
            .map(|(spec, column)| PointField {
                name: spec.name.to_owned(),
                components: spec.components,
                values: point_by_point(column),
            })
            .collect();
        Self { time: snapshot.time, points: positions(snapshot), cells: Cells::Vertices, fields }
    }

    /// The surface at time `time` with all of its fields.
    pub fn from_surface(time: f64, surface: &Surface) -> Self {
        let fields = surface
            .fields
            .iter()
            .map(|f| PointField {
                name: f.name.to_owned(),
                components: f.components,
                values: f.values.clone(),
            })
            .collect();
        Self {
            time,
            points: surface.mesh.vertices.iter().map(|v| (*v).into()).collect(),
            cells: Cells::Triangles(surface.mesh.triangles.clone()),
            fields,
        }
    }

    /// The field of that name.
    pub fn field(&self, name: &str) -> Option<&PointField> {
        self.fields.iter().find(|f| f.name == name)
    }

    /// What is inconsistent, if anything: a field of the wrong length or a triangle that names a
    /// point that does not exist.
    ///
    /// # Errors
    /// One sentence about the first inconsistency.
    pub fn check(&self) -> Result<(), String> {
        let points = self.points.len();
        for f in &self.fields {
            if f.components == 0 || f.components.checked_mul(points) != Some(f.values.len()) {
                return Err(format!(
                    "field `{}` holds {} values, expected {} for each of {points} points",
                    f.name,
                    f.values.len(),
                    f.components
                ));
            }
        }
        if let Cells::Triangles(triangles) = &self.cells
            && let Some(bad) = triangles.iter().flatten().find(|&&i| i as usize >= points)
        {
            return Err(format!("a triangle names point {bad}, but there are only {points} points"));
        }
        Ok(())
    }
}

/// Current positions; a dynamics without displacement keeps its particles at their references.
fn positions(snapshot: &Snapshot) -> Vec<[f64; 3]> {
    if snapshot.particles.has(Field::Displacement) {
        return snapshot.positions();
    }
    let reference = snapshot.column(Field::Reference);
    (0..reference.len()).map(|a| reference.vector(a).into()).collect()
}

fn point_by_point(column: &Column) -> Vec<f64> {
    let (n, values) = (column.len(), column.values());
    let components = column.components();
    let mut out = Vec::with_capacity(values.len());
    for a in 0..n {
        out.extend((0..components).map(|c| values[c * n + a]));
    }
    out
}
