//! Sheets that lie on each other count as one.
//!
//! Segmentations have the same surface several times: a capsule, and over it the segments or the faces
//! of the organ. Where they end, a sum of winding numbers would see the edge of a sheet. Each triangle is given one
//! over the number of parts that cover it, so that together they wind once.

use super::parts::Parts;
use crate::tensor::Vec3;
use crate::winding::TriangleTree;
use rayon::prelude::*;

/// Looks at nodes and triangles for all triangles together, and for one at least.
const EFFORT: usize = 1_000_000_000;
const LEAST_EFFORT: usize = 200;
/// Cosine of the angle within which normals agree.
const AGREE: f64 = 0.5;

/// Weights of all triangles: the mean of 1/(1 + other parts within `reach` in front or behind that face the
/// same way) over four points of each.
pub(super) fn weights(parts: &Parts, tree: &TriangleTree, reach: f64) -> Vec<f64> {
    let mesh = &parts.mesh;
    let normals: Vec<Vec3> = (0..mesh.triangles.len()).map(|t| mesh.normal(t)).collect();
    let effort = (EFFORT / (4 * normals.len().max(1))).max(LEAST_EFFORT);
    let weight = |covering: &mut Vec<usize>, t: usize| {
        let corners = mesh.corners(t);
        let middle = corners.iter().sum::<Vec3>() / 3.0;
        let points =
            [middle, 0.5 * (middle + corners[0]), 0.5 * (middle + corners[1]), 0.5 * (middle + corners[2])];
        let step = reach * normals[t];
        let at = |covering: &mut Vec<usize>, x: &Vec3| {
            covering.clear();
            tree.passages(&(x - step), &(2.0 * step), effort, |other, _| {
                let part = parts.of[other];
                if part != parts.of[t] && normals[other].dot(&normals[t]) > AGREE && !covering.contains(&part)
                {
                    covering.push(part);
                }
            });
            1.0 / (1.0 + covering.len() as f64)
        };
        points.iter().map(|x| at(covering, x)).sum::<f64>() / points.len() as f64
    };
    (0..normals.len()).into_par_iter().map_init(Vec::new, weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;

    fn sheet(z: f64, up: bool) -> TriangleMesh {
        let vertices = [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]].map(Vec3::from).to_vec();
        TriangleMesh { vertices, triangles: vec![if up { [0, 1, 2] } else { [0, 2, 1] }] }
    }

    fn weights_of(sheets: &[TriangleMesh]) -> Vec<f64> {
        let mut mesh = TriangleMesh::default();
        for sheet in sheets {
            let first = mesh.vertices.len() as u32;
            mesh.triangles.extend(sheet.triangles.iter().map(|t| t.map(|v| v + first)));
            mesh.vertices.extend(&sheet.vertices);
        }
        weights(&Parts::of(&mesh), &TriangleTree::new(&mesh), 0.1)
    }

    #[test]
    fn layers_share_and_opposite_faces_do_not() {
        assert_eq!(weights_of(&[sheet(0.0, true)]), [1.0]);
        assert_eq!(weights_of(&[sheet(0.0, true), sheet(0.05, true)]), [0.5, 0.5]);
        assert_eq!(weights_of(&[sheet(0.0, true), sheet(0.05, false)]), [1.0, 1.0]);
        assert_eq!(weights_of(&[sheet(0.0, true), sheet(0.2, true)]), [1.0, 1.0]);
        assert_eq!(
            weights_of(&[sheet(0.0, true), sheet(0.06, true), sheet(-0.06, true)]),
            [1.0 / 3.0, 0.5, 0.5]
        );
    }
}
