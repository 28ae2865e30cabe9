//! The parts of a surface: triangles that hang together by their edges, turned the same way.

use crate::mesh::TriangleMesh;

/// A surface in parts. Two triangles belong to one part if they, and no third, share an edge.
pub(in crate::shape) struct Parts {
    /// The surface, all triangles of a part turned the same way if that is possible.
    pub(in crate::shape) mesh: TriangleMesh,
    /// The part of each triangle, numbered from 0.
    pub(super) of: Vec<usize>,
    /// For each part: whether it has no open edge.
    pub(in crate::shape) closed: Vec<bool>,
    /// Number of triangles that were dropped because others have the same corners.
    pub(super) repeated: usize,
    /// Number of triangles that were dropped as walls between bodies.
    pub(super) walls: usize,
    /// Number of triangles that were turned to agree with the others of their part.
    pub(super) turned: usize,
}

/// A triangle on the other side of an edge, and whether it is turned the other way.
type Link = Option<(u32, bool)>;

impl Parts {
    /// The parts of a surface whose equal vertices are merged. The way that most of a part's area is turned stays.
    pub(super) fn of(surface: &TriangleMesh) -> Self {
        let Single { mesh, repeated, walls } = without_repeats(surface);
        let links = links(&mesh);
        let of = vec![usize::MAX; links.len()];
        let mut parts = Self { of, mesh, closed: Vec::new(), repeated, walls, turned: 0 };
        let mut turn = vec![false; links.len()];
        let mut members = Vec::new();
        for first in 0..links.len() {
            if parts.of[first] == usize::MAX {
                parts.gather(first, &links, &mut turn, &mut members);
            }
        }
        for (triangle, _) in parts.mesh.triangles.iter_mut().zip(&turn).filter(|(_, turn)| **turn) {
            triangle.swap(1, 2);
        }
        parts.turned = turn.iter().filter(|t| **t).count();
        parts
    }

    /// Gives the triangles that hang together with `first` the next number, and says which to turn.
    fn gather(&mut self, first: usize, links: &[[Link; 3]], turn: &mut [bool], members: &mut Vec<usize>) {
        let part = self.closed.len();
        members.clear();
        members.push(first);
        self.of[first] = part;
        let (mut next, mut closed) = (0, true);
        while let Some(&t) = members.get(next) {
            next += 1;
            for link in links[t] {
                let Some((other, against)) = link else {
                    closed = false;
                    continue;
                };
                let other = other as usize;
                if self.of[other] == usize::MAX {
                    self.of[other] = part;
                    turn[other] = turn[t] != against;
                    members.push(other);
                } else if turn[other] != (turn[t] != against) {
                    // A surface with one side only, such as a Moebius strip.
                    closed = false;
                }
            }
        }
        let area = |turned: bool| -> f64 {
            members.iter().filter(|&&t| turn[t] == turned).map(|&t| self.mesh.triangle_area(t)).sum()
        };
        if area(true) > area(false) {
            for &t in &*members {
                turn[t] = !turn[t];
            }
        }
        self.closed.push(closed);
    }

    /// Number of parts.
    pub(super) fn count(&self) -> usize {
        self.closed.len()
    }

    /// Turns round the parts that `which` names.
    pub(super) fn turn(&mut self, which: &[bool]) {
        for (triangle, part) in self.mesh.triangles.iter_mut().zip(&self.of) {
            if which[*part] {
                triangle.swap(1, 2);
            }
        }
    }
}

/// What is left of a surface where triangles have the same corners.
struct Single {
    mesh: TriangleMesh,
    /// Triangles that were dropped because another has the same corners.
    repeated: usize,
    /// Triangles that were dropped because another is their back.
    walls: usize,
}

/// The surface with at most one triangle for each three corners. Pairs that are each other's back are walls that two bodies share, and
/// both go, where the piece of the surface that they are in is the less open for it; else one of them stays.
fn without_repeats(surface: &TriangleMesh) -> Single {
    let mut order: Vec<([u32; 3], bool, usize)> = surface
        .triangles
        .iter()
        .enumerate()
        .map(|(t, &[a, b, c])| {
            let mut key = [a, b, c];
            key.sort_unstable();
            (key, [[a, b, c], [b, c, a], [c, a, b]].contains(&key), t)
        })
        .collect();
    order.sort_unstable();
    let groups = || order.chunk_by(|a, b| a.0 == b.0);
    if groups().all(|group| group.len() == 1) {
        return Single { mesh: surface.clone(), repeated: 0, walls: 0 };
    }
    let (mut once, mut cancelled) = (vec![false; order.len()], vec![false; order.len()]);
    for group in groups() {
        let first = group[0].2;
        once[first] = true;
        let fronts = group.iter().filter(|(_, front, _)| *front).count();
        cancelled[first] = 2 * fronts != group.len();
    }
    let pieces = Pieces::of(surface);
    let (open_once, open_cancelled) =
        (pieces.open_edges(surface, &once), pieces.open_edges(surface, &cancelled));
    let is_left = pieces.has_any(&cancelled);
    let keep = |t: usize| {
        let piece = pieces.of[t];
        let cancels = is_left[piece] && open_cancelled[piece] < open_once[piece];
        if cancels { cancelled[t] } else { once[t] }
    };
    let mesh = surface.retain(keep);
    let walls = 2 * (0..order.len()).filter(|&t| once[t] && !keep(t)).count();
    Single { repeated: order.len() - mesh.triangles.len() - walls, mesh, walls }
}

/// The pieces of a surface, which share no vertex.
struct Pieces {
    /// Of each triangle.
    of: Vec<usize>,
    count: usize,
}

impl Pieces {
    fn of(surface: &TriangleMesh) -> Self {
        let (of, count) = surface.component_of_triangles();
        Self { of, count }
    }

    /// Whether each has a triangle of those to `keep`.
    fn has_any(&self, keep: &[bool]) -> Vec<bool> {
        let mut any = vec![false; self.count];
        self.of.iter().zip(keep).for_each(|(&piece, &keep)| any[piece] |= keep);
        any
    }

    /// Edges of each that are not shared by two of the triangles to `keep`.
    fn open_edges(&self, surface: &TriangleMesh, keep: &[bool]) -> Vec<usize> {
        let mut edges: Vec<([u32; 2], usize)> = Vec::new();
        for (t, &[a, b, c]) in surface.triangles.iter().enumerate().filter(|(t, _)| keep[*t]) {
            edges.extend([(a, b), (b, c), (c, a)].map(|(v, w)| ([v.min(w), v.max(w)], self.of[t])));
        }
        edges.sort_unstable();
        let mut open = vec![0; self.count];
        edges.chunk_by(|a, b| a == b).filter(|uses| uses.len() != 2).for_each(|uses| open[uses[0].1] += 1);
        open
    }
}

/// What is across each edge of each triangle: nothing unless exactly two triangles share it.
fn links(mesh: &TriangleMesh) -> Vec<[Link; 3]> {
    let mut edges = Vec::with_capacity(3 * mesh.triangles.len());
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        for (e, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
            edges.push(([from.min(to), from.max(to)], t as u32, e as u8, from < to));
        }
    }
    edges.sort_unstable();
    let mut links = vec![[None; 3]; mesh.triangles.len()];
    for shared in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, s, e, forward), (_, t, f, backward)] = *shared {
            let against = forward == backward;
            links[s as usize][e as usize] = Some((t, against));
            links[t as usize][f as usize] = Some((s, against));
        }
    }
    links
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{BoxShape, Shape};
    use crate::tensor::Vec3;
    use proptest::prelude::*;

    fn cube() -> TriangleMesh {
        BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap().surface().clone()
    }

    proptest! {
        /// Whichever triangles of a cube are turned, they come out as one closed part.
        #[test]
        fn turned_triangles_are_turned_back(which in prop::array::uniform12(any::<bool>())) {
            let mut mesh = cube();
            for (t, _) in which.iter().enumerate().filter(|(_, w)| **w) {
                mesh.triangles[t].swap(0, 1);
            }
            let parts = Parts::of(&mesh);
            prop_assert!(parts.mesh.is_closed());
            prop_assert_eq!((parts.count(), &parts.closed[..]), (1, &[true][..]));
            let turned = which.iter().filter(|w| **w).count();
            prop_assert_eq!(parts.turned, turned.min(12 - turned));
        }
    }

    #[test]
    fn repeated_triangles_count_once_however_they_are_turned() {
        let mut mesh = cube();
        mesh.triangles.push(mesh.triangles[3]);
        let [a, b, c] = mesh.triangles[5];
        mesh.triangles.push([c, b, a]);
        let parts = Parts::of(&mesh);
        assert_eq!((parts.repeated, parts.turned, parts.mesh.triangles.len()), (2, 0, 12));
        assert!(parts.mesh.is_closed());
    }

    /// Cubes of edge 1 with these corners.
    fn cubes(corners: &[Vec3]) -> TriangleMesh {
        let mut mesh = TriangleMesh::default();
        for corner in corners {
            let first = mesh.vertices.len() as u32;
            let cube = BoxShape::new(Vec3::repeat(1.0), *corner).unwrap().surface().clone();
            mesh.triangles.extend(cube.triangles.iter().map(|t| t.map(|v| v + first)));
            mesh.vertices.extend(cube.vertices);
        }
        mesh.merged()
    }

    #[test]
    fn a_wall_across_a_body_cuts_it_in_parts() {
        let mut mesh = cubes(&[Vec3::zeros(), Vec3::x()]);
        // One of its two copies alone: two open cups and the wall.
        let is_wall = |t: usize| mesh.corners(t).iter().all(|v| v.x == 1.0);
        let one = (0..mesh.triangles.len()).filter(|&t| !is_wall(t) || t < 12).collect::<Vec<_>>();
        mesh.triangles = one.iter().map(|&t| mesh.triangles[t]).collect();
        let parts = Parts::of(&mesh);
        assert_eq!((parts.repeated, parts.walls, parts.count()), (0, 0, 3));
        assert!(parts.closed.iter().all(|c| !c));
    }

    #[test]
    fn walls_that_bodies_share_cancel() {
        let block: Vec<Vec3> =
            (0..27).map(|q| Vec3::new(f64::from(q % 3), f64::from(q / 3 % 3), f64::from(q / 9))).collect();
        for (corners, walls) in [(&block[..2], 4), (&block[..3], 8), (&block, 216)] {
            let parts = Parts::of(&cubes(corners));
            assert_eq!((parts.repeated, parts.walls, &parts.closed[..]), (0, walls, &[true][..]));
            assert!(parts.mesh.is_closed());
            assert!((parts.mesh.volume() - corners.len() as f64).abs() < 1e-12);
        }
        // A surface that has a back everywhere is one surface, open or not.
        let mut sheet = cube();
        sheet.triangles.truncate(10);
        sheet.triangles.extend(sheet.flipped().triangles);
        let parts = Parts::of(&sheet);
        assert_eq!((parts.repeated, parts.walls, parts.mesh.triangles.len()), (10, 0, 10));
    }

    #[test]
    fn a_moebius_strip_is_not_closed() {
        // Five triangles around, each sharing edges with the next two.
        let mesh = TriangleMesh {
            vertices: (0..5)
                .map(|i| Vec3::new(f64::from(i).cos(), f64::from(i).sin(), f64::from(i % 2)))
                .collect(),
            triangles: (0..5).map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect(),
        };
        let parts = Parts::of(&mesh);
        assert_eq!((parts.count(), parts.closed[0]), (1, false));
    }
}
