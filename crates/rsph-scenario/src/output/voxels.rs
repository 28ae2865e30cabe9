//! A field of stored particles on the voxels of an image, in the undeformed body, for overlay on it.

use super::nifti::{Meaning, VoxelField};
use super::polydata::{Cells, PolyData};
use crate::label_map::{Axes, ImageGrid};
use crate::scenario::{LabelMapValue, LoadedScenario, ScenarioError};
use rayon::prelude::*;
use rsph_core::error::InvalidInput;
use rsph_core::mls::{Cloud, PointWeights};
use rsph_core::neighbors::CellList;
use rsph_core::particles::{Column, ColumnSpec, Field, MATRIX, TENSOR, VECTOR};
use rsph_core::shape::Placement;
use rsph_core::tensor::{Mat3, SymTensor, Vec3};
use std::path::Path;

/// How far particles are looked for that say of a place that it lies in the body, in spacings.
const REACH: f64 = 4.0;
/// By how much a place may be farther from a particle than the surface is, in spacings: flat faces are met on average.
const SLACK: f64 = 0.1;
/// Where the components of a symmetric matrix of NIfTI stand in VTK's order.
const LOWER_TRIANGLE: [usize; 6] = [0, 3, 1, 5, 4, 2];

/// How an image and a body fit together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Registration {
    /// Factor from the units of the image to those of the body; `None`: to metres, as the header of the image says.
    pub scale: Option<f64>,
    /// Axes of the body.
    pub axes: Axes,
}

/// How the body of the run in `folder` fits to its images: as its scenario reads its label map, if it has one.
///
/// # Errors
/// A scenario that can not be understood.
pub fn registration(folder: &Path) -> Result<Registration, ScenarioError> {
    let path = folder.join("scenario.toml");
    if !path.is_file() {
        return Ok(Registration::default());
    }
    let scenario = LoadedScenario::from_file(&path, &[])?;
    let image = scenario.tables().body.labelmap.as_ref();
    Ok(image.map_or_else(Registration::default, |LabelMapValue(image)| Registration {
        scale: image.scale,
        axes: image.axes.axes(),
    }))
}

/// The field `quantity` of `particles`, such as `displacement` or `stress.zz`, at the centres of those voxels that lie in the
/// undeformed body. Lengths are in the units of the image; vectors and tensors that are whole go along its axes.
///
/// # Errors
/// `field` when the particles do not have it, `particles` when they are no body in space, `like` when it is not on the image.
pub fn on_voxels(
    particles: &PolyData,
    quantity: &str,
    grid: &ImageGrid,
    registration: Registration,
) -> Result<VoxelField, InvalidInput> {
    let (spec, component) = chosen(particles, quantity)?;
    let body = Undeformed::new(particles)?;
    let cloud = Cloud::new(&body.positions, &body.volume, body.spacing);
    let placement = grid.placement(registration.scale, registration.axes);
    let [along_x, along_y, along_z] = body.indices(grid, &placement)?;
    let values = column(particles, spec)?;
    let shown = Shown::new(spec, component, grid, registration);
    let place =
        |[i, j, k]: [usize; 3]| placement.axes * Vec3::new(i as f64, j as f64, k as f64) + placement.origin;
    let (mut voxels, mut stored) = (Vec::new(), Vec::new());
    for k in along_z {
        let rows: Vec<Vec<[usize; 3]>> = along_y
            .clone()
            .into_par_iter()
            .map(|j| {
                let row = along_x.clone().map(|i| [i, j, k]);
                row.filter(|at| body.holds(&place(*at))).collect()
            })
            .collect();
        let inside = rows.concat();
        let places: Vec<Vec3> = inside.iter().map(|at| place(*at)).collect();
        let weights = PointWeights::new(&cloud, &places);
        for (p, [i, j, k]) in inside.into_iter().enumerate() {
            voxels.push((i + grid.size[0] * (j + grid.size[1] * k)) as u64);
            let all: Vec<f64> = (0..spec.components).map(|c| weights.value(&values, c, p)).collect();
            shown.put(&all, &mut stored);
        }
    }
    if voxels.is_empty() {
        return Err(body.elsewhere());
    }
    Ok(VoxelField { name: quantity.to_owned(), meaning: shown.meaning, voxels, values: stored })
}

/// The column and the component that a quantity names.
fn chosen(
    particles: &PolyData,
    quantity: &str,
) -> Result<(&'static ColumnSpec, Option<usize>), InvalidInput> {
    let (name, suffix) = quantity.split_once('.').map_or((quantity, None), |(n, s)| (n, Some(s)));
    let there = || particles.fields.iter().map(|f| f.name.as_str()).collect::<Vec<_>>().join(", ");
    let field = Field::from_name(name).filter(|_| particles.field(name).is_some());
    let spec = field.map(Field::spec).ok_or_else(|| {
        let remedy =
            format!("the particles have {}; others are asked for by `output.fields` before a run", there());
        InvalidInput::new("field", quantity, "is not among the fields of the particles", remedy)
    })?;
    let Some(suffix) = suffix else { return Ok((spec, None)) };
    let component = spec.suffixes.iter().position(|s| *s == suffix).ok_or_else(|| {
        let remedy = if spec.suffixes.is_empty() {
            format!("{name} is a single number: write \"{name}\"")
        } else {
            format!("{name} has the components {}", spec.suffixes.join(", "))
        };
        InvalidInput::new("field", quantity, "names a component that is not there", remedy)
    })?;
    Ok((spec, Some(component)))
}

/// The values of a field, component by component.
fn column(particles: &PolyData, spec: &ColumnSpec) -> Result<Column, InvalidInput> {
    let n = particles.points.len();
    let field = particles.field(spec.name).filter(|f| f.components == spec.components);
    let field = field.filter(|f| f.values.len() == spec.components * n).ok_or_else(|| {
        let remedy = "take the particles of a solid, as `rsph run` stores them";
        InvalidInput::new("particles", spec.name, "is a field that they lack", remedy)
    })?;
    let c = spec.components;
    Ok(Column::from_vec((0..c * n).map(|k| field.values[k % n * c + k / n]).collect(), n))
}

/// The particles of a body where they were before it was deformed.
struct Undeformed {
    positions: Vec<Vec3>,
    volume: Vec<f64>,
    /// Signed distance of each particle to the surface, negative inside.
    level_set: Vec<f64>,
    cells: CellList,
    spacing: f64,
}

impl Undeformed {
    fn new(particles: &PolyData) -> Result<Self, InvalidInput> {
        let refused = |problem: &str| {
            let remedy = "take the particles of a solid in space, as `rsph run` stores them";
            Err(InvalidInput::new("particles", "", problem, remedy))
        };
        if particles.cells != Cells::Vertices || particles.points.is_empty() {
            return refused("are none: this is a surface, or empty");
        }
        let u = column(particles, Field::Displacement.spec())?;
        let volume = column(particles, Field::Volume.spec())?.values().to_vec();
        let level_set = column(particles, Field::LevelSet.spec())?.values().to_vec();
        let place = |(a, x): (usize, &[f64; 3])| Vec3::from(*x) - u.vector(a);
        let positions: Vec<Vec3> = particles.points.iter().enumerate().map(place).collect();
        if !positions.iter().all(|x| x.iter().all(|c| c.is_finite())) {
            return refused("have positions that are not finite");
        }
        let spread = |axis: usize| {
            let along = positions.iter().map(|x| x[axis]);
            along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
        };
        if (0..3).any(|axis| spread(axis) == 0.0) {
            return refused("lie in a plane or on a line");
        }
        // Most particles have a cell of their own.
        let mut volumes = volume.clone();
        let middle = volumes.len() / 2;
        let (_, median, _) = volumes.select_nth_unstable_by(middle, f64::total_cmp);
        let spacing = median.cbrt();
        if !(spacing.is_finite() && spacing > 0.0) {
            return refused("have volumes that are not positive");
        }
        let cells = CellList::new(&positions, spacing);
        Ok(Self { positions, volume, level_set, cells, spacing })
    }

    /// Whether a place lies in the body: it does if it is nearer to a particle than the surface is. Nothing counts that lies farther
    /// outside than the slack, and of edges less than 0.3 spacings are missed.
    fn holds(&self, x: &Vec3) -> bool {
        let covers = |a: usize| (x - self.positions[a]).norm() <= SLACK * self.spacing - self.level_set[a];
        let reach = REACH * self.spacing;
        let Some((nearest, _)) = self.cells.nearest(&self.positions, x, 1.5 * self.spacing) else {
            return false;
        };
        let mut found = covers(nearest);
        if !found {
            self.cells.visit_near(x, reach, |a| found = found || covers(a as usize));
        }
        found
    }

    /// Lower and upper corner of the body.
    fn bounds(&self) -> (Vec3, Vec3) {
        let margin = Vec3::repeat(self.spacing);
        let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        let (low, high) = self.positions.iter().fold(start, |(low, high), x| (low.inf(x), high.sup(x)));
        (low - margin, high + margin)
    }

    /// The indices of the voxels around the body.
    fn indices(
        &self,
        grid: &ImageGrid,
        placement: &Placement,
    ) -> Result<[std::ops::Range<usize>; 3], InvalidInput> {
        let inverse = placement.axes.try_inverse().ok_or_else(|| self.elsewhere())?;
        let (low, high) = self.bounds();
        let mut ends = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for corner in 0..8 {
            let x = Vec3::from_fn(|i, _| if corner >> i & 1 == 1 { high[i] } else { low[i] });
            let index = inverse * (x - placement.origin);
            ends = (ends.0.inf(&index), ends.1.sup(&index));
        }
        let along = |i: usize| {
            let first = ends.0[i].ceil().max(0.0) as usize;
            first..(ends.1[i].floor() + 1.0).clamp(first as f64, grid.size[i].max(first) as f64) as usize
        };
        let ranges = [along(0), along(1), along(2)];
        let is_empty = (0..3).any(|i| ranges[i].is_empty() || ranges[i].end > grid.size[i]);
        if is_empty { Err(self.elsewhere()) } else { Ok(ranges) }
    }

    /// That no voxel lies in the body.
    fn elsewhere(&self) -> InvalidInput {
        let (low, high) = self.bounds();
        let problem = format!(
            "has no voxel in the body, which lies between ({:.4}, {:.4}, {:.4}) and ({:.4}, {:.4}, {:.4})",
            low.x, low.y, low.z, high.x, high.y, high.z
        );
        let remedy =
            "take the image that the body is from; `scale` and `axes` say how positions follow from it";
        InvalidInput::new("like", "", problem, remedy)
    }
}

/// How the values of a field are shown in an image.
struct Shown {
    meaning: Meaning,
    component: Option<usize>,
    /// From the axes of the body to those of the image.
    turn: Mat3,
    /// Factor to the units of the image.
    factor: f64,
}

impl Shown {
    fn new(
        spec: &ColumnSpec,
        component: Option<usize>,
        grid: &ImageGrid,
        registration: Registration,
    ) -> Self {
        let meaning = match spec.suffixes {
            _ if component.is_some() || spec.components == 1 => Meaning::Scalar,
            names if *names == VECTOR && spec.field == Field::Displacement => Meaning::Displacement,
            names if *names == TENSOR => Meaning::Symmetric,
            names if *names == MATRIX => Meaning::Matrix,
            _ => Meaning::Vector,
        };
        let is_length = matches!(spec.field, Field::Displacement | Field::Velocity | Field::LevelSet);
        let factor = if is_length { 1.0 / registration.scale.unwrap_or(grid.metres) } else { 1.0 };
        let is_vector = *spec.suffixes == VECTOR || spec.components > 3;
        let turn = if is_vector { registration.axes.turn().transpose() } else { Mat3::identity() };
        Self { meaning, component, turn, factor }
    }

    /// Puts the values of a voxel behind what is in `out`.
    fn put(&self, values: &[f64], out: &mut Vec<f32>) {
        let turned = |matrix: Mat3| self.turn * matrix * self.turn.transpose();
        let single = |x: &f64| (x * self.factor) as f32;
        match (self.component, self.meaning) {
            (Some(c), _) => out.extend(values.get(c).map(single)),
            (None, Meaning::Scalar) => out.extend(values.iter().map(single)),
            (None, Meaning::Displacement | Meaning::Vector) => {
                out.extend((self.turn * Vec3::from_row_slice(values)).iter().map(single));
            }
            (None, Meaning::Symmetric) => {
                let tensor = SymTensor(std::array::from_fn(|c| values[c])).to_matrix();
                let tensor = SymTensor::symmetric_part(&turned(tensor)).0;
                out.extend(LOWER_TRIANGLE.map(|c| single(&tensor[c])));
            }
            (None, Meaning::Matrix) => {
                out.extend(turned(Mat3::from_row_slice(values)).transpose().iter().map(single));
            }
        }
    }
}
