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
    /// Number of triangles that were turned to agree with the others of their part.
    pub(super) turned: usize,
}

/// A triangle on the other side of an edge, and whether it is turned the other way.
type Link = Option<(u32, bool)>;

impl Parts {
    /// The parts of a surface whose equal vertices are merged. The way that most of a part's area is turned stays.
    pub(super) fn of(surface: &TriangleMesh) -> Self {
        let (mesh, repeated) = without_repeats(surface);
        let links = links(&mesh);
        let mut parts =
            Self { of: vec![usize::MAX; links.len()], mesh, closed: Vec::new(), repeated, turned: 0 };
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

/// The surface with one triangle for each three corners, and how many were dropped.
fn without_repeats(surface: &TriangleMesh) -> (TriangleMesh, usize) {
    let mut order: Vec<([u32; 3], usize)> = surface
        .triangles
        .iter()
        .enumerate()
        .map(|(t, &corners)| {
            let mut key = corners;
            key.sort_unstable();
            (key, t)
        })
        .collect();
    order.sort_unstable();
    let before = order.len();
    order.dedup_by_key(|(key, _)| *key);
    let repeated = before - order.len();
    if repeated == 0 {
        return (surface.clone(), 0);
    }
    let mut keep = vec![false; before];
    for (_, t) in order {
        keep[t] = true;
    }
    (surface.retain(|t| keep[t]), repeated)
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

    #[test]
    fn a_wall_across_a_body_cuts_it_in_parts() {
        // Two cubes with a common face: its edges are shared by three faces or more.
        let mut mesh = cube();
        let other = BoxShape::new(Vec3::repeat(1.0), Vec3::x()).unwrap().surface().clone();
        mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + 8)));
        mesh.vertices.extend(other.vertices);
        let parts = Parts::of(&mesh.merged());
        // The wall was there twice; what is left are two open cups and the wall.
        assert_eq!((parts.repeated, parts.count()), (2, 3));
        assert!(parts.closed.iter().all(|c| !c));
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
