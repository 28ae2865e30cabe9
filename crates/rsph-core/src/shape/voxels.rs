//! The body that voxels of a segmented image show, as a smooth surface of the same volume.

use super::MeshShape;
use crate::error::InvalidInput;
use crate::grid::Grid;
use crate::marching_cubes::zero_level_set;
use crate::mesh::TriangleMesh;
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;

/// More cells than this in the box around the body are made fewer by joining voxels.
const MOST_CELLS: usize = 2_000_000;
/// Standard deviations of the Gaussian that rounds the steps between voxels, in cells: the less, the thinner a wall may be.
const BLURS: [f64; 3] = [1.0, 0.6, 0.35];
/// Empty cells around the body, more than the blur reaches.
const MARGIN: usize = 5;
/// Error of the enclosed volume.
const VOLUME_TOLERANCE: f64 = 1e-4;
/// Deviation of the volume at which the user is told that the body is too thin for its voxels.
const VOLUME_NOTE: f64 = 0.01;
/// Deviation at which such a body is refused.
const MOST_DEVIATION: f64 = 0.05;

/// Cells of a cavity that is not blurred away.
const LEAST_CAVITY: usize = 27;

/// Voxels of the body that follow each other along the first axis of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Indices of the first one.
    pub start: [usize; 3],
    /// Their number.
    pub length: usize,
}

/// Where an image is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// From the indices of a voxel to the position of its centre, less `origin`.
    pub axes: Mat3,
    /// The centre of the voxel (0, 0, 0).
    pub origin: Vec3,
}

/// The body of the voxels in `runs`, of an image of `size` voxels; and what the user should know, one sentence
/// each. `name` is what messages and summaries call it.
///
/// # Errors
/// `body.labelmap` when there is no voxel, too few to have a surface, or the placement is none.
pub fn voxel_shape(
    runs: &[Run],
    size: [usize; 3],
    placement: &Placement,
    name: &str,
) -> Result<(MeshShape, Vec<String>), InvalidInput> {
    let refuse = |problem: &str, remedy: &str| Err(InvalidInput::new("body.labelmap", name, problem, remedy));
    let Placement { axes, origin } = placement;
    let voxel = axes.determinant();
    let edges: f64 = (0..3).map(|i| axes.column(i).norm()).product();
    if !(voxel.abs() > 1e-6 * edges && edges.is_finite() && origin.iter().all(|c| c.is_finite())) {
        return refuse(
            "the image says not where its voxels are: their axes lie in a plane, or are not finite",
            "correct the header, for example with ITK-SNAP or nibabel",
        );
    }
    let Some((low, high)) = extent(runs) else {
        return refuse("no voxel is inside", "choose another label");
    };
    let cells = Cells::new(runs, low, high, axes);
    let remedy = "take a finer image: a body needs a few voxels across";
    let Some((mesh, deviation)) = cells.surface() else {
        return refuse("the body has too few voxels for a surface", remedy);
    };
    let share = 100.0 * (1.0 + deviation);
    if deviation.abs() > MOST_DEVIATION {
        let what =
            format!("the body is too thin for its voxels: a surface encloses {share:.0} % of their volume");
        return refuse(&what, remedy);
    }
    let mut notes = Vec::new();
    if deviation.abs() > VOLUME_NOTE {
        notes.push(format!(
            "{name} is thin for its voxels: its surface encloses {share:.1} % of their volume"
        ));
    }
    if (0..3).any(|i| low[i] == 0 || high[i] + 1 >= size[i]) {
        notes.push(format!("{name} reaches the edge of the image and is cut off there"));
    }
    let (_, volumes) = mesh.component_volumes();
    let pieces = volumes.iter().filter(|volume| **volume > 0.0).count();
    if pieces > 1 {
        notes.push(format!("{name} has {pieces} separate pieces: each needs a hold of its own"));
    }
    let cavities = volumes.len() - pieces;
    match cavities {
        0 => {}
        1 => notes.push(format!("{name} has a cavity within")),
        several => notes.push(format!("{name} has {several} cavities within")),
    }
    if cells.cavities() > cavities {
        notes.push(format!(
            "the wall around a cavity of {name} is too thin for its voxels: there are holes in it"
        ));
    }
    let place = |x: &Vec3| axes * cells.voxel_at(x) + origin;
    let mesh = TriangleMesh { vertices: mesh.vertices.iter().map(place).collect(), ..mesh };
    let mesh = if voxel < 0.0 { mesh.flipped() } else { mesh };
    MeshShape::from_closed(mesh, name)
        .map(|shape| (shape, notes))
        .map_or_else(|| refuse("the body has too few voxels for a surface", "take a finer image"), Ok)
}

/// Lowest and highest indices.
fn extent(runs: &[Run]) -> Option<([usize; 3], [usize; 3])> {
    let ends = |r: &Run| [r.start[0] + r.length - 1, r.start[1], r.start[2]];
    runs.iter().filter(|r| r.length > 0).fold(None, |found, run| {
        let (low, high) = found.unwrap_or((run.start, run.start));
        let end = ends(run);
        Some((
            std::array::from_fn(|i| low[i].min(run.start[i])),
            std::array::from_fn(|i| high[i].max(end[i])),
        ))
    })
}

/// Cells of one or more voxels, with the share of each that is inside.
struct Cells {
    /// The first voxel of the cell (0, 0, 0).
    first: [f64; 3],
    /// Voxels along the edges of a cell.
    joined: [usize; 3],
    grid: Grid,
    share: Vec<f64>,
}

impl Cells {
    fn new(runs: &[Run], low: [usize; 3], high: [usize; 3], axes: &Mat3) -> Self {
        let mut joined = [1_usize; 3];
        let count =
            |j: [usize; 3]| -> [usize; 3] { std::array::from_fn(|i| (high[i] - low[i] + 1).div_ceil(j[i])) };
        while count(joined).iter().product::<usize>() > MOST_CELLS {
            // Along the axis where cells are shortest.
            let edge = |i: usize| axes.column(i).norm() * joined[i] as f64;
            let shortest = (0..3).min_by(|&i, &j| edge(i).total_cmp(&edge(j))).unwrap_or(0);
            joined[shortest] += 1;
        }
        let grid = Grid { origin: Vec3::zeros(), spacing: 1.0, cells: count(joined).map(|n| n + 2 * MARGIN) };
        let mut share = vec![0.0; grid.len()];
        let each = 1.0 / joined.iter().product::<usize>() as f64;
        for run in runs {
            let [y, z] = [1, 2].map(|i| (run.start[i] - low[i]) / joined[i] + MARGIN);
            for x in run.start[0]..run.start[0] + run.length {
                share[grid.index([(x - low[0]) / joined[0] + MARGIN, y, z])] += each;
            }
        }
        let first = std::array::from_fn(|i| low[i] as f64 - (MARGIN * joined[i]) as f64);
        Self { first, joined, grid, share }
    }

    /// Indices of the voxel, as real numbers, at a point of the grid.
    fn voxel_at(&self, x: &Vec3) -> Vec3 {
        // Voxels have their centres at whole numbers, cells at halves.
        Vec3::from_fn(|i, _| self.first[i] + x[i] * self.joined[i] as f64 - 0.5)
    }

    /// The surface in coordinates of the grid, as round as walls that are thin let it be without being torn, and how much more volume it
    /// encloses than the voxels have, as a share of that.
    fn surface(&self) -> Option<(TriangleMesh, f64)> {
        let volume: f64 = self.share.iter().sum();
        let pieces = |mesh: &TriangleMesh| mesh.component_volumes().1.iter().filter(|v| **v > 0.0).count();
        let mut best: Option<(TriangleMesh, f64)> = None;
        for blur in BLURS {
            let Some(mesh) = self.surface_by(blur, volume) else { continue };
            let deviation = mesh.volume() / volume - 1.0;
            let is_better = |(so_far, off): &(TriangleMesh, f64)| {
                deviation.abs() < off.abs() && pieces(&mesh) <= pieces(so_far)
            };
            if best.as_ref().is_none_or(is_better) {
                best = Some((mesh, deviation));
            }
            if best.as_ref().is_some_and(|(_, off)| off.abs() <= VOLUME_NOTE) {
                break;
            }
        }
        best
    }

    /// Number of cavities, of [`LEAST_CAVITY`] cells or more.
    fn cavities(&self) -> usize {
        let [nx, ny, nz] = self.grid.cells;
        let mut is_seen: Vec<bool> = self.share.iter().map(|share| *share > 0.0).collect();
        let mut waiting = Vec::new();
        let mut count = 0;
        for first in 0..is_seen.len() {
            if is_seen[first] {
                continue;
            }
            is_seen[first] = true;
            waiting.push(first);
            let mut size = 0;
            while let Some(cell) = waiting.pop() {
                size += 1;
                let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
                for (axis, (n, stride)) in [(nx, 1), (ny, nx), (nz, nx * ny)].into_iter().enumerate() {
                    let before = (at[axis] > 0).then(|| cell - stride);
                    let after = (at[axis] + 1 < n).then_some(cell + stride);
                    for next in [before, after].into_iter().flatten() {
                        if !std::mem::replace(&mut is_seen[next], true) {
                            waiting.push(next);
                        }
                    }
                }
            }
            // The first is what lies around the body.
            count += usize::from(first > 0 && size >= LEAST_CAVITY);
        }
        count
    }

    /// The level of the shares after a blur that encloses this volume.
    fn surface_by(&self, blur: f64, volume: f64) -> Option<TriangleMesh> {
        let blurred = self.blurred(blur);
        let most = blurred.iter().copied().fold(0.0, f64::max);
        let at = |level: f64| {
            let phi: Vec<f64> = blurred.par_iter().map(|share| level - share).collect();
            zero_level_set(&self.grid, &phi)
        };
        let mut level = 0.5_f64.min(0.5 * most);
        let mut mesh = at(level);
        for _ in 0..8 {
            let error = mesh.volume() - volume;
            if error.abs() <= VOLUME_TOLERANCE * volume || mesh.triangles.is_empty() {
                break;
            }
            // At a flat face the blurred share has this slope, so that a level moves the surface as much.
            let slope = 1.0 / (blur * (2.0 * std::f64::consts::PI).sqrt());
            let next = (level + error * slope / mesh.area()).clamp(0.05 * most, 0.95 * most);
            if next.to_bits() == level.to_bits() {
                break;
            }
            level = next;
            mesh = at(level);
        }
        (!mesh.triangles.is_empty()).then_some(mesh)
    }

    /// The shares after a Gaussian along each axis.
    fn blurred(&self, blur: f64) -> Vec<f64> {
        let reach = MARGIN - 1;
        let raw: Vec<f64> = (0..=reach).map(|d| (-0.5 * (d as f64 / blur).powi(2)).exp()).collect();
        let total: f64 = raw[0] + 2.0 * raw[1..].iter().sum::<f64>();
        let weight: Vec<f64> = raw.iter().map(|w| w / total).collect();
        let [nx, ny, nz] = self.grid.cells;
        let along = |from: &[f64], n: usize, stride: usize| -> Vec<f64> {
            let blur = |index: usize| {
                let i = index / stride % n;
                let mut sum = weight[0] * from[index];
                for (d, w) in weight.iter().enumerate().skip(1) {
                    if i >= d {
                        sum += w * from[index - d * stride];
                    }
                    if i + d < n {
                        sum += w * from[index + d * stride];
                    }
                }
                sum
            };
            (0..from.len()).into_par_iter().map(blur).collect()
        };
        along(&along(&along(&self.share, nx, 1), ny, nx), nz, nx * ny)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Shape, organ};
    use proptest::prelude::*;

    fn runs_of(size: [usize; 3], inside: impl Fn([usize; 3]) -> bool) -> Vec<Run> {
        let mut runs = Vec::new();
        for k in 0..size[2] {
            for j in 0..size[1] {
                runs.extend(
                    (0..size[0]).filter(|&i| inside([i, j, k])).map(|i| Run { start: [i, j, k], length: 1 }),
                );
            }
        }
        runs
    }

    fn ball(axes: Mat3, size: [usize; 3]) -> (MeshShape, Vec<String>) {
        let middle = axes * Vec3::from_fn(|i, _| size[i] as f64 / 2.0 + 0.2 * i as f64);
        let placement = Placement { axes, origin: -middle };
        let runs = runs_of(size, |c| (axes * Vec3::from_fn(|i, _| c[i] as f64) - middle).norm() < 1.0);
        voxel_shape(&runs, size, &placement, "ball").unwrap()
    }

    #[test]
    fn a_ball_of_long_voxels_is_round_and_where_it_was() {
        // Rotated, sheared by nothing, 0.05 x 0.05 x 0.1, and once mirrored.
        let turn = *nalgebra::Rotation3::from_euler_angles(0.3, -0.5, 0.7).matrix();
        for mirror in [1.0, -1.0] {
            let axes = turn * Mat3::from_diagonal(&Vec3::new(0.05 * mirror, 0.05, 0.1));
            let (shape, notes) = ball(axes, [60, 60, 30]);
            assert!(notes.is_empty(), "{notes:?}");
            let exact = 4.0 / 3.0 * std::f64::consts::PI;
            assert!((shape.volume() / exact - 1.0).abs() < 0.01, "{}", shape.volume() / exact);
            // Within half of the long edge of a voxel: no more is known of where the surface passes between two.
            let worst = shape.surface().vertices.iter().map(|v| (v.norm() - 1.0).abs()).fold(0.0, f64::max);
            assert!(worst < 0.05, "{worst}");
            assert_eq!(shape.surface().genus(), Some(0));
        }
    }

    #[test]
    fn an_organ_keeps_its_volume_and_its_surface() {
        let liver = organ("liver").unwrap();
        let (bounds, edge) = (liver.bounds(), 0.002);
        let size: [usize; 3] = std::array::from_fn(|i| (bounds.size()[i] / edge) as usize + 5);
        let origin = bounds.min - Vec3::repeat(1.7 * edge);
        let at = |c: [usize; 3]| origin + Vec3::from_fn(|i, _| c[i] as f64) * edge;
        let runs = runs_of(size, |c| liver.signed_distance(&at(c)) < 0.0);
        let placement = Placement { axes: Mat3::identity() * edge, origin };
        let (shape, _) = voxel_shape(&runs, size, &placement, "liver").unwrap();
        assert!((shape.volume() / liver.volume() - 1.0).abs() < 5e-3, "{}", shape.volume() / liver.volume());
        let surface = shape.surface();
        let distance: f64 = surface.vertices.iter().map(|v| liver.signed_distance(v).abs()).sum::<f64>();
        assert!(distance / (surface.vertices.len() as f64) < 0.1 * edge);
    }

    #[test]
    fn what_shows_no_body_is_refused() {
        let placement = Placement { axes: Mat3::identity(), origin: Vec3::zeros() };
        let problem = |runs: &[Run], p: &Placement| voxel_shape(runs, [9; 3], p, "x").unwrap_err().problem;
        assert!(problem(&[], &placement).contains("no voxel"));
        let one = [Run { start: [4; 3], length: 1 }];
        let flat = Placement { axes: Mat3::zeros(), origin: Vec3::zeros() };
        assert!(problem(&one, &flat).contains("plane"));
        let lost = Placement { axes: Mat3::identity(), origin: Vec3::repeat(f64::NAN) };
        assert!(problem(&one, &lost).contains("not finite"));
    }

    #[test]
    fn a_wall_of_one_voxel_keeps_its_volume_and_its_cavity() {
        let placement = Placement { axes: Mat3::identity(), origin: Vec3::zeros() };
        let size = [36; 3];
        let cube = |c: [usize; 3], edge: usize| c.iter().all(|i| (18 - edge..18 + edge).contains(i));
        let box_runs = runs_of(size, |c| cube(c, 10) && !cube(c, 9));
        let (shape, notes) = voxel_shape(&box_runs, size, &placement, "box").unwrap();
        assert!((shape.volume() / (8000.0 - 5832.0) - 1.0).abs() < 0.01, "{}", shape.volume());
        assert!(notes.iter().any(|n| n.contains("a cavity")), "{notes:?}");
        let r = |c: [usize; 3]| Vec3::from_fn(|i, _| c[i] as f64 - 18.0).norm();
        for (inner, outer) in [(14.5, 15.5), (10.5, 11.3), (8.5, 9.5), (12.0, 14.0)] {
            let runs = runs_of(size, |c| r(c) >= inner && r(c) < outer);
            let voxels = runs.len() as f64;
            match voxel_shape(&runs, size, &placement, "shell") {
                Ok((shape, notes)) => {
                    assert!((shape.volume() / voxels - 1.0).abs() <= MOST_DEVIATION, "{}", shape.volume());
                    assert!(notes.iter().any(|n| n.contains("cavit")), "{inner} {notes:?}");
                }
                Err(e) => assert!(e.problem.contains("too thin"), "{e}"),
            }
        }
    }

    #[test]
    fn pieces_and_cuts_are_told() {
        let placement = Placement { axes: Mat3::identity(), origin: Vec3::zeros() };
        let runs = runs_of([30, 10, 10], |c| c[0] < 10 || c[0] > 20);
        let (shape, notes) = voxel_shape(&runs, [30, 10, 10], &placement, "x").unwrap();
        assert!(notes.iter().any(|n| n.contains("2 separate")), "{notes:?}");
        assert!(notes.iter().any(|n| n.contains("edge of the image")), "{notes:?}");
        assert!((shape.volume() / 1900.0 - 1.0).abs() < 1e-3);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        /// Any voxels give a closed surface outward, or an error.
        #[test]
        fn any_voxels_are_a_body_or_refused(inside in prop::collection::vec(any::<bool>(), 64)) {
            let placement = Placement { axes: Mat3::identity(), origin: Vec3::zeros() };
            let runs = runs_of([4; 3], |c| inside[(c[2] * 4 + c[1]) * 4 + c[0]]);
            if let Ok((shape, _)) = voxel_shape(&runs, [4; 3], &placement, "x") {
                prop_assert!(shape.surface().is_closed());
                prop_assert!(shape.volume() > 0.0);
            }
        }
    }
}
