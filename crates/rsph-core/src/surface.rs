//! The body's surface: the zero level set as triangles, with the fields sampled on it.

use crate::measures::{LocalState, is_measure};
use crate::mesh::TriangleMesh;
use crate::mls::PointWeights;
use crate::particles::Field;
use crate::snapshot::Snapshot;
use crate::tensor::{SymTensor, Vec3};

/// A field on the vertices of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceField {
    /// Name in files.
    pub name: &'static str,
    /// 1, 3 or 6 components.
    pub components: usize,
    /// Values, vertex by vertex (`components` values each).
    pub values: Vec<f64>,
}

/// The deformed surface of one moment.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Triangles at their current place.
    pub mesh: TriangleMesh,
    /// Fields on its vertices: those of the snapshot, `normal_strain` and `shear_strain`.
    pub fields: Vec<SurfaceField>,
}

impl Surface {
    /// The zero level set `reference` of the undeformed body, moved with the displacement of
    /// `snapshot`; `weights` are those of the particles at its vertices.
    pub fn new(reference: &TriangleMesh, weights: &PointWeights, snapshot: &Snapshot) -> Self {
        let mut mesh = reference.clone();
        let mut fields: Vec<SurfaceField> = snapshot
            .columns()
            .filter(|(spec, _)| spec.field != Field::Reference)
            .map(|(spec, column)| SurfaceField {
                name: spec.name,
                components: spec.components,
                values: weights.interpolate(column),
            })
            .collect();
        if let Some(u) = fields.iter().find(|f| f.name == Field::Displacement.spec().name) {
            for (x, u) in mesh.vertices.iter_mut().zip(u.values.chunks_exact(3)) {
                *x += Vec3::from_column_slice(u);
            }
        }
        if let Some(strain) = fields.iter().find(|f| f.name == Field::Strain.spec().name) {
            let (normal, shear) = strain
                .values
                .chunks_exact(6)
                .zip(vertex_normals(&mesh))
                .map(|(e, n)| normal_and_shear(SymTensor(std::array::from_fn(|i| e[i])), &n))
                .unzip();
            fields.push(SurfaceField { name: "normal_strain", components: 1, values: normal });
            fields.push(SurfaceField { name: "shear_strain", components: 1, values: shear });
        }
        Self { mesh, fields }
    }

    /// Replaces the strain, the stress and the material of every vertex, and what follows from them, by these.
    pub fn set_strain_and_stress(&mut self, read: &[VertexStrain]) {
        let (normal, shear): (Vec<f64>, Vec<f64>) =
            read.iter().map(|v| normal_and_shear(v.local.strain, &v.normal)).unzip();
        let new = [
            ("strain", read.iter().flat_map(|v| v.local.strain.0).collect()),
            ("stress", read.iter().flat_map(|v| v.local.stress.0).collect()),
            ("von_mises", read.iter().map(|v| v.local.stress.von_mises()).collect()),
            ("normal_strain", normal),
            ("shear_strain", shear),
            ("material", read.iter().map(|v| v.material as f64).collect()),
        ];
        for (name, values) in new {
            if let Some(field) = self.fields.iter_mut().find(|f| f.name == name) {
                field.values = values;
            }
        }
        for field in &mut self.fields {
            if let Some(measure) = Field::from_name(field.name).filter(|f| is_measure(*f)) {
                field.values.clear();
                for v in read {
                    v.local.put(measure, &mut field.values);
                }
            }
        }
    }

    /// The field of that name.
    pub fn field(&self, name: &str) -> Option<&SurfaceField> {
        self.fields.iter().find(|f| f.name == name)
    }
}

/// Strain and stress at a vertex of the surface, read with the traction there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexStrain {
    /// Outward normal that normal and shear strain belong to: of the undeformed surface, of the deformed one where strain is ln V.
    pub normal: Vec3,
    /// Deformation, strain and stress.
    pub local: LocalState,
    /// Number of the material.
    pub material: usize,
}

/// Normal strain n.e.n and shear strain |e n - (n.e.n) n| on a surface with unit normal n, Fig. 7.
fn normal_and_shear(strain: SymTensor, n: &Vec3) -> (f64, f64) {
    let e_n = strain.dot(n);
    let normal = n.dot(&e_n);
    (normal, (e_n - normal * n).norm())
}

/// Unit normals of the vertices: means over their triangles, weighted by area.
fn vertex_normals(mesh: &TriangleMesh) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); mesh.vertices.len()];
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
        let twice_area = (b - a).cross(&(c - a));
        for i in t {
            normals[*i as usize] += twice_area;
        }
    }
    normals.iter().map(|n| n.try_normalize(0.0).unwrap_or_else(Vec3::zeros)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strain_splits_into_normal_and_shear() {
        // Uniaxial strain 2 along z with a shear e_xz = 1.
        let e = SymTensor([0.0, 0.0, 2.0, 0.0, 0.0, 1.0]);
        assert_eq!(normal_and_shear(e, &Vec3::z()), (2.0, 1.0));
        assert_eq!(normal_and_shear(e, &Vec3::x()), (0.0, 1.0));
        assert_eq!(normal_and_shear(e, &Vec3::y()), (0.0, 0.0));
    }
}
