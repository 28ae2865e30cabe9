//! Where lines along x pass through a closed triangle surface: inside or outside, exactly.

use crate::grid::Grid;
use crate::mesh::TriangleMesh;
use crate::tensor::Vec3;
use rayon::prelude::*;

/// Lines along each of the two edges of a cell that they cross.
const LINES: usize = 6;
/// Lines along y and along z that look for overlaps.
const OVERLAP_LINES: usize = 64;

/// A passage through the surface: the coordinate x, and the change of the winding number there
/// (+1 in, -1 out).
pub(super) type Passage = (f64, i32);

/// The triangles of a closed surface, found by where they lie in the y-z plane.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    triangles: Vec<[Vec3; 3]>,
    /// Lower corner and width of the bins in y and z.
    low: [f64; 2],
    width: [f64; 2],
    bins: [usize; 2],
    /// Triangles of bin b: `items[start[b]..start[b + 1]]`.
    start: Vec<u32>,
    items: Vec<u32>,
}

impl Columns {
    /// Sorts the triangles of a closed surface into bins.
    pub(super) fn new(mesh: &TriangleMesh) -> Self {
        let triangles: Vec<_> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        let mut columns = Self {
            triangles,
            low: [0.0; 2],
            width: [1.0; 2],
            bins: [1; 2],
            start: Vec::new(),
            items: Vec::new(),
        };
        if let Some(bounds) = mesh.bounds() {
            for d in 0..2 {
                // Bins of twice the root mean square extent keep the number of entries to a few
                // times the number of triangles whatever their shapes.
                let square = |t: &[Vec3; 3]| {
                    let (low, high) = extent(t, d + 1);
                    (high - low).powi(2)
                };
                let sum: f64 = columns.triangles.iter().map(square).sum();
                let rms = (sum / columns.triangles.len() as f64).sqrt();
                let size = bounds.size()[d + 1];
                columns.low[d] = bounds.min[d + 1];
                columns.bins[d] = ((0.5 * size / rms) as usize).clamp(1, 1024);
                columns.width[d] = (size / columns.bins[d] as f64).max(f64::MIN_POSITIVE);
            }
        }
        columns.sort();
        columns
    }

    fn sort(&mut self) {
        let mut entries = Vec::with_capacity(2 * self.triangles.len());
        for (t, corners) in self.triangles.iter().enumerate() {
            let [j, k] = [0, 1].map(|d| {
                let (low, high) = extent(corners, d + 1);
                self.bin(d, low)..=self.bin(d, high)
            });
            for k in k {
                entries.extend(j.clone().map(|j| ((k * self.bins[0] + j) as u32, t as u32)));
            }
        }
        entries.sort_unstable();
        let mut start = vec![0; self.bins[0] * self.bins[1] + 1];
        for &(bin, _) in &entries {
            start[bin as usize + 1] += 1;
        }
        for b in 1..start.len() {
            start[b] += start[b - 1];
        }
        self.start = start;
        self.items = entries.into_iter().map(|(_, t)| t).collect();
    }

    fn bin(&self, d: usize, at: f64) -> usize {
        (((at - self.low[d]) / self.width[d]) as usize).min(self.bins[d] - 1)
    }

    /// All passages of the line (y, z), in order of x.
    ///
    /// The rule for edges lets a line that meets an edge or a vertex pass exactly one of the
    /// triangles there, as if it were moved aside by an infinitely small amount. What rounding may
    /// still spoil shows as a winding number that does not return to zero: then the line is moved.
    pub(super) fn passages(&self, y: f64, z: f64, found: &mut Vec<Passage>) {
        for attempt in 0..8 {
            let aside = f64::from(attempt) * 1e-9;
            let (y, z) = (y + aside * self.width[0], z + 0.7 * aside * self.width[1]);
            self.passages_once(y, z, found);
            if found.iter().map(|p| p.1).sum::<i32>() == 0 {
                break;
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    }

    fn passages_once(&self, y: f64, z: f64, found: &mut Vec<Passage>) {
        found.clear();
        let outside = |d: usize, at: f64| {
            !(at >= self.low[d] && at <= self.low[d] + self.width[d] * self.bins[d] as f64)
        };
        if outside(0, y) || outside(1, z) {
            return;
        }
        let bin = self.bin(1, z) * self.bins[0] + self.bin(0, y);
        for &t in &self.items[self.start[bin] as usize..self.start[bin + 1] as usize] {
            let [a, b, c] = &self.triangles[t as usize];
            let side = left_of(a, b, y, z);
            if side == left_of(b, c, y, z) && side == left_of(c, a, y, z) {
                let n = (b - a).cross(&(c - a));
                let x = a.x - (n.y * (y - a.y) + n.z * (z - a.z)) / n.x;
                let (low, high) = extent(&self.triangles[t as usize], 0);
                // Seen along x, a triangle that turns left faces on: the line leaves there.
                found.push((if x.is_finite() { x.clamp(low, high) } else { low }, if side { -1 } else { 1 }));
            }
        }
    }

    /// Whether the surface winds around the point.
    pub(super) fn contains(&self, x: &Vec3) -> bool {
        let mut found = Vec::new();
        self.passages(x.y, x.z, &mut found);
        found.iter().filter(|p| p.0 < x.x).map(|p| p.1).sum::<i32>() > 0
    }

    /// Share of the inside where the surface winds twice or more, and of what it winds around the wrong way, by a few
    /// thousand lines.
    pub(super) fn overlap(&self) -> f64 {
        let at = |d: usize, line: usize| {
            self.low[d] + (line as f64 + 0.5) / OVERLAP_LINES as f64 * self.width[d] * self.bins[d] as f64
        };
        let (mut once, mut more) = (0.0, 0.0);
        let mut found = Vec::new();
        for line in 0..OVERLAP_LINES * OVERLAP_LINES {
            self.passages(at(0, line % OVERLAP_LINES), at(1, line / OVERLAP_LINES), &mut found);
            let mut winding = 0;
            for pair in found.windows(2) {
                winding += pair[0].1;
                let length = pair[1].0 - pair[0].0;
                match winding {
                    0 => {}
                    1 => once += length,
                    _ => more += length,
                }
            }
        }
        if once + more > 0.0 { more / (once + more) } else { 0.0 }
    }

    /// Inside fractions of all cells of `grid`, x fastest: the lengths of 6 x 6 lines through each
    /// cell, exact along x.
    pub(super) fn fill(&self, grid: &Grid) -> Vec<f64> {
        let [nx, ny, _] = grid.cells;
        let mut fraction = vec![0.0; grid.len()];
        fraction.par_chunks_mut(nx.max(1)).enumerate().for_each_init(Vec::new, |found, (row, cells)| {
            let at = |axis: usize, cell: usize, line: usize| {
                grid.origin[axis] + (cell as f64 + (line as f64 + 0.5) / LINES as f64) * grid.spacing
            };
            for line in 0..LINES * LINES {
                let (y, z) = (at(1, row % ny, line % LINES), at(2, row / ny, line / LINES));
                self.passages(y, z, found);
                add_inside_lengths(found, grid, cells);
            }
            for theta in cells {
                *theta /= (LINES * LINES) as f64;
                if *theta > 1.0 - 1e-9 {
                    *theta = 1.0;
                }
            }
        });
        fraction
    }
}

/// Adds to each cell of a row the length, in spacings, of the line that is inside.
fn add_inside_lengths(passages: &[Passage], grid: &Grid, cells: &mut [f64]) {
    let mut winding = 0;
    for pair in passages.windows(2) {
        winding += pair[0].1;
        if winding <= 0 {
            continue;
        }
        let last = cells.len() as f64;
        let from = ((pair[0].0 - grid.origin.x) / grid.spacing).clamp(0.0, last);
        let to = ((pair[1].0 - grid.origin.x) / grid.spacing).clamp(0.0, last);
        for (i, length) in cells.iter_mut().enumerate().take(to.ceil() as usize).skip(from as usize) {
            *length += (to.min(i as f64 + 1.0) - from.max(i as f64)).max(0.0);
        }
    }
}

/// Smallest and largest coordinate of a triangle on an axis.
fn extent(t: &[Vec3; 3], axis: usize) -> (f64, f64) {
    let [a, b, c] = [t[0][axis], t[1][axis], t[2][axis]];
    (a.min(b).min(c), a.max(b).max(c))
}

/// Whether (y, z) lies to the left of the line from `a` to `b` in the y-z plane. A point on the
/// line counts as left of the edge in its lexicographic direction, so that the two triangles of an
/// edge always disagree.
fn left_of(a: &Vec3, b: &Vec3, y: f64, z: f64) -> bool {
    let forward = (a.y, a.z) <= (b.y, b.z);
    let (p, q) = if forward { (a, b) } else { (b, a) };
    let left = (q.y - p.y) * (z - p.z) - (q.z - p.z) * (y - p.y) >= 0.0;
    left == forward
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{BoxShape, Shape, SphereShape};
    use proptest::prelude::*;

    fn grid() -> Grid {
        Grid { origin: Vec3::repeat(-1.25), spacing: 0.25, cells: [10, 10, 10] }
    }

    #[test]
    fn lines_through_edges_and_vertices_count_once() {
        let mesh = SphereShape::new(1.0, Vec3::zeros()).unwrap().surface().clone();
        let columns = Columns::new(&mesh);
        let mut found = Vec::new();
        for v in mesh.vertices.iter().step_by(7) {
            columns.passages(v.y, v.z, &mut found);
            assert_eq!(found.iter().map(|p| p.1).sum::<i32>(), 0);
            assert!(found.len() <= 2, "{found:?} at {v:?}");
        }
        assert!(columns.contains(&Vec3::zeros()) && !columns.contains(&Vec3::new(0.0, 0.0, 1.5)));
    }

    #[test]
    fn an_aligned_box_fills_its_cells_exactly() {
        let shape = BoxShape::new(Vec3::new(1.0, 1.5, 2.0), Vec3::repeat(-1.0)).unwrap();
        let exact = shape.fill(&grid());
        for (a, b) in Columns::new(shape.surface()).fill(&grid()).iter().zip(exact) {
            assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn overlapping_pieces_are_inside_once() {
        let mut mesh = BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap().surface().clone();
        let other = BoxShape::new(Vec3::repeat(1.0), Vec3::new(0.5, 0.0, 0.0)).unwrap();
        mesh.triangles.extend(other.surface().triangles.iter().map(|t| t.map(|v| v + 8)));
        mesh.vertices.extend(&other.surface().vertices);
        let cells = Grid { origin: Vec3::zeros(), spacing: 0.5, cells: [4, 2, 2] };
        let fraction = Columns::new(&mesh).fill(&cells);
        assert_eq!(&fraction[..4], &[1.0, 1.0, 1.0, 0.0]);
    }

    proptest! {
        #[test]
        fn inside_a_ball_is_inside(x in -1.2..1.2_f64, y in -1.2..1.2_f64, z in -1.2..1.2_f64) {
            let mesh = SphereShape::new(1.0, Vec3::zeros()).unwrap().surface().clone();
            let p = Vec3::new(x, y, z);
            prop_assume!((p.norm() - 1.0).abs() > 1e-3);
            prop_assert_eq!(Columns::new(&mesh).contains(&p), p.norm() < 1.0);
        }
    }
}
