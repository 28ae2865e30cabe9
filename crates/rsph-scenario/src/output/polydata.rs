//! Points, cells and point data of one moment: what every writer takes and every reader gives.

use rsph_core::particles::{Column, ColumnSpec, Field};
use rsph_core::snapshot::Snapshot;
use rsph_core::surface::Surface;
use std::fmt::Debug;
use std::ops::Range;

/// Points, cells and point data of one moment, of which files take a piece at a time: a second copy of all
/// particles in the order of a file would be as large as the simulation.
pub trait Frame: Debug + Send {
    /// Simulated time (time unit of the scenario; s in SI).
    fn time(&self) -> f64;

    /// Number of points.
    fn point_count(&self) -> usize;

    /// Triangles of three point indices; `None`: one vertex a point.
    fn triangles(&self) -> Option<&[[u32; 3]]>;

    /// Names of the fields and their values a point.
    fn fields(&self) -> Vec<(&str, usize)>;

    /// Positions of those points, three values each, behind what is in `out`.
    fn put_points(&self, points: Range<usize>, out: &mut Vec<f64>);

    /// Values of a field, by its number, at those points, point by point behind what is in `out`.
    fn put_values(&self, field: usize, points: Range<usize>, out: &mut Vec<f64>);

    /// What is inconsistent, if anything.
    ///
    /// # Errors
    /// One sentence about the first inconsistency.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }
}

/// Cells on the points.
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
    /// Cells on the points.
    pub cells: Cells,
    /// Fields on them.
    pub fields: Vec<PointField>,
}

impl PolyData {
    /// The particles of a snapshot at their current places, with every column but the reference
    /// position.
    pub fn from_snapshot(snapshot: &Snapshot) -> Self {
        let all = 0..snapshot.len();
        let field = |(i, (name, components)): (usize, (&str, usize))| {
            let mut values = Vec::with_capacity(components * snapshot.len());
            snapshot.put_values(i, all.clone(), &mut values);
            PointField { name: name.to_owned(), components, values }
        };
        let mut points = Vec::with_capacity(3 * snapshot.len());
        snapshot.put_points(all.clone(), &mut points);
        Self {
            time: snapshot.time,
            points: points.as_chunks().0.to_vec(),
            cells: Cells::Vertices,
            fields: snapshot.fields().into_iter().enumerate().map(field).collect(),
        }
    }

    /// The surface at time `time` with all of its fields.
    pub fn from_surface(time: f64, surface: Surface) -> Self {
        let fields = surface
            .fields
            .into_iter()
            .map(|f| PointField { name: f.name.to_owned(), components: f.components, values: f.values })
            .collect();
        Self {
            time,
            points: surface.mesh.vertices.iter().map(|v| (*v).into()).collect(),
            cells: Cells::Triangles(surface.mesh.triangles),
            fields,
        }
    }

    /// The field of that name.
    pub fn field(&self, name: &str) -> Option<&PointField> {
        self.fields.iter().find(|f| f.name == name)
    }
}

impl Frame for PolyData {
    fn time(&self) -> f64 {
        self.time
    }

    fn point_count(&self) -> usize {
        self.points.len()
    }

    fn triangles(&self) -> Option<&[[u32; 3]]> {
        match &self.cells {
            Cells::Vertices => None,
            Cells::Triangles(t) => Some(t),
        }
    }

    fn fields(&self) -> Vec<(&str, usize)> {
        self.fields.iter().map(|f| (f.name.as_str(), f.components)).collect()
    }

    fn put_points(&self, points: Range<usize>, out: &mut Vec<f64>) {
        out.extend(self.points[points].as_flattened());
    }

    fn put_values(&self, field: usize, points: Range<usize>, out: &mut Vec<f64>) {
        let PointField { components, values, .. } = &self.fields[field];
        out.extend(&values[components * points.start..components * points.end]);
    }

    /// A field of the wrong length or a triangle that names a point that does not exist.
    fn check(&self) -> Result<(), String> {
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

/// The particles at their current places, with every column but the reference position.
impl Frame for Snapshot {
    fn time(&self) -> f64 {
        self.time
    }

    fn point_count(&self) -> usize {
        self.len()
    }

    fn triangles(&self) -> Option<&[[u32; 3]]> {
        None
    }

    fn fields(&self) -> Vec<(&str, usize)> {
        shown(self).map(|(spec, _)| (spec.name, spec.components)).collect()
    }

    fn put_points(&self, points: Range<usize>, out: &mut Vec<f64>) {
        let (x0, u) = (self.column(Field::Reference), self.column(Field::Displacement));
        for a in points {
            // A dynamics without displacement keeps its particles at their references.
            let x = if u.is_empty() { x0.vector(a) } else { x0.vector(a) + u.vector(a) };
            out.extend(x.iter());
        }
    }

    fn put_values(&self, field: usize, points: Range<usize>, out: &mut Vec<f64>) {
        let Some((_, column)) = shown(self).nth(field) else { return };
        let (n, values) = (column.len(), column.values());
        for a in points {
            out.extend((0..column.components()).map(|c| values[c * n + a]));
        }
    }
}

/// The columns of a snapshot that are fields of its points.
fn shown(snapshot: &Snapshot) -> impl Iterator<Item = (&'static ColumnSpec, &Column)> {
    snapshot.columns().filter(|(spec, _)| spec.field != Field::Reference)
}
