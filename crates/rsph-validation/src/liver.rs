//! The liver of the Visible Human as validations load it, its finite-element reference, and measures of livers.

use rsph_core::mesh::TriangleMesh;
use rsph_core::tensor::Vec3;
use std::path::Path;

/// Where the mesh is looked for, beside the repository.
const MESH: &str = "../shared/data/meshes/visible_human_liver_female.stl";
/// The liver of the Visible Human as it was published: 26 open, overlapping parts.
pub(super) const PARTS_MESH: &str = "../shared/data/meshes/VH_F_Liver.glb";
/// Height of the clamp: 15 % of the mesh.
const CLAMP: f64 = -0.060_008_288_9;
/// Centre of the load and its radius (m).
pub(super) const CENTRE: [f64; 3] = [0.078748, 0.051970, -0.003656];
pub(super) const RADIUS: f64 = 0.037132;
/// Peak pressure of the load (Pa).
pub(super) const PRESSURE: f64 = 270.0;

/// Compliance (J), displacement at the centre of the load (m) and total load along y (N), by quadratic
/// tetrahedra on the body cut at the clamp, good to 0.3 % (validation/references/liver.py).
pub(super) const COMPLIANCE: f64 = 7.39e-4;
pub(super) const DISPLACEMENT: [f64; 3] = [0.469e-3, -1.436e-3, -1.352e-3];
pub(super) const LOAD: f64 = -0.7052;

/// Whether the mesh is there.
pub(super) fn is_there() -> bool {
    Path::new(MESH).is_file()
}

/// Edits that make `liver_visible_human.toml` the problem of the reference, with so many particles; the first
/// probes are the displacement at the centre of the load.
pub(super) fn edits(particles: usize) -> Vec<String> {
    let [x, y, z] = CENTRE;
    vec![
        format!("body.shape.mesh.path=\"{MESH}\""),
        format!("body.particles={particles}"),
        format!("boundary.0.region.plane.at={CLAMP}"),
        format!("load.0.centre=[{x}, {y}, {z}]"),
        format!("load.0.radius={RADIUS}"),
        format!(
            "probe=[{{ name = \"c\", quantity = \"displacement\", region = {{ point = [{x}, {y}, {z}] }} }}]"
        ),
    ]
}

/// |u - reference| / |reference| of the displacement at the centre of the load.
pub(super) fn off(u: &[f64], share: f64) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    let reference = DISPLACEMENT.map(|e| share * e);
    norm(&mut u.iter().zip(reference).map(|(u, e)| u - e)) / norm(&mut reference.into_iter())
}

/// Centre and radius of a patch load "upper-right" on this surface, as the paper's figure shows it: the topmost
/// vertex of the right two fifths, 0.15 of the extent in x.
pub(super) fn upper_right(surface: &TriangleMesh) -> (Vec3, f64) {
    let x = || surface.vertices.iter().map(|v| v.x);
    let low = x().fold(f64::INFINITY, f64::min);
    let extent = x().fold(f64::NEG_INFINITY, f64::max) - low;
    let right = surface.vertices.iter().filter(|v| v.x > low + 0.6 * extent);
    let centre = right.max_by(|a, b| a.y.total_cmp(&b.y)).copied().unwrap_or_else(Vec3::zeros);
    (centre, 0.15 * extent)
}
