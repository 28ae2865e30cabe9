//! Named parts of a mesh.

use rsph_core::mesh::TriangleMesh;
use rsph_core::tensor::Vec3;
use std::collections::BTreeMap;

/// A triangle mesh with the parts that its file names. A triangle may belong to several of them, or to none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshWithParts {
    /// All triangles, with vertices as the file has them.
    pub mesh: TriangleMesh,
    /// Triangles of each part by its name, ascending.
    pub parts: BTreeMap<String, Vec<u32>>,
}

impl MeshWithParts {
    /// Names the triangle `t`, which comes after those named before.
    pub(super) fn name(&mut self, name: &str, t: usize) {
        let name = name.trim();
        if name.is_empty() {
            return;
        }
        let triangles = match self.parts.get_mut(name) {
            Some(triangles) => triangles,
            None => self.parts.entry(name.to_owned()).or_default(),
        };
        let t = t as u32;
        if triangles.last() != Some(&t) {
            triangles.push(t);
        }
    }

    /// Area of a part, and its centre of gravity; the area is zero where there is no such part.
    pub fn area_and_centre(&self, name: &str) -> (f64, Vec3) {
        let triangles = self.parts.get(name).map_or(&[][..], Vec::as_slice);
        let (area, moment) = triangles.iter().fold((0.0, Vec3::zeros()), |(area, moment), &t| {
            let own = self.mesh.triangle_area(t as usize);
            (area + own, moment + own * self.mesh.centroid(t as usize))
        });
        (area, if area > 0.0 { moment / area } else { moment })
    }
}
