//! Triangle meshes from and to files, one format a file; the format is chosen by the extension.

mod gltf_file;
mod obj;
mod parts;
mod ply;
mod polygon;
mod stl;
mod text;

pub use parts::MeshWithParts;

use crate::whole_file::{Kind, Unreadable};
use rsph_core::mesh::TriangleMesh;
use rsph_core::surface::SurfaceField;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Mesh files are in memory as a whole.
const FILE: Kind = Kind {
    what: "a mesh file",
    limit: 1_000_000_000,
    if_larger: "simplify the mesh: a tenth of the triangles is as good for a simulation",
    if_missing: "check the path; a relative one in a scenario starts beside its file",
    from_pipe: false,
};
/// Most vertices, and most triangles, of a mesh.
const MAX_ELEMENTS: usize = 20_000_000;

/// A mesh file that can not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The file can not be opened, read or written.
    #[error("{}: {problem}; {remedy}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        problem: String,
        /// What to do about it.
        remedy: String,
    },
    /// The extension names no format that is known.
    #[error("{}: {problem}; {remedy}", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The extension and those that are known.
        problem: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// The file is not what its extension says, broken, or holds no triangle.
    #[error("{}: {problem}; {remedy}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong, with the line where there is one.
        problem: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// The scale is not a positive number.
    #[error("{}: {problem}; {remedy}", path.display())]
    Scale {
        /// The file.
        path: PathBuf,
        /// The value and what is allowed.
        problem: String,
        /// What to do about it.
        remedy: &'static str,
    },
}

impl MeshError {
    /// The file it is about.
    pub fn path(&self) -> &Path {
        match self {
            Self::File { path, .. }
            | Self::UnknownFormat { path, .. }
            | Self::Malformed { path, .. }
            | Self::Scale { path, .. } => path,
        }
    }

    /// What is wrong.
    pub fn problem(&self) -> &str {
        match self {
            Self::File { problem, .. }
            | Self::UnknownFormat { problem, .. }
            | Self::Malformed { problem, .. }
            | Self::Scale { problem, .. } => problem,
        }
    }

    /// What to do about it.
    pub fn remedy(&self) -> &str {
        match self {
            Self::File { remedy, .. } => remedy,
            Self::UnknownFormat { remedy, .. }
            | Self::Malformed { remedy, .. }
            | Self::Scale { remedy, .. } => remedy,
        }
    }

    fn unreadable(path: &Path, Unreadable { problem, remedy }: Unreadable) -> Self {
        Self::File { path: path.into(), problem, remedy }
    }

    fn unwritable(path: &Path, error: &io::Error) -> Self {
        let problem = format!("cannot be written: {error}");
        Self::File {
            path: path.into(),
            problem,
            remedy: "check the folder, its permissions and the disk".into(),
        }
    }

    fn malformed(path: &Path, problem: impl Into<String>) -> Self {
        let remedy = "export the mesh again, or as another format (STL, OBJ, PLY, GLB)";
        Self::Malformed { path: path.into(), problem: problem.into(), remedy }
    }
}

/// The triangles of a mesh file, coordinates times `scale`. By extension: `stl` (ASCII and
/// binary), `obj`, `ply` (ASCII and binary), `glb` and `gltf` (all meshes of the scene where their
/// nodes put them). Polygons are divided into triangles; vertices stay as the file has them, so
/// that equal positions may occur more than once.
///
/// # Errors
/// A file that can not be read, is broken, holds no triangle, or whose extension is not known, and
/// a scale that is not positive.
pub fn read_mesh(path: &Path, scale: f64) -> Result<TriangleMesh, MeshError> {
    Ok(read_mesh_with_parts(path, scale)?.mesh)
}

/// As [`read_mesh`], with the parts that the file names: solids of ASCII STL; groups, objects and materials of OBJ; nodes, meshes and
/// materials of glTF; in PLY the colours of faces, or of two or more corners, as `#ff0000`, and whole numbers of faces as `label=3`.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_mesh_with_parts(path: &Path, scale: f64) -> Result<MeshWithParts, MeshError> {
    if !(scale.is_finite() && scale > 0.0) {
        return Err(MeshError::Scale {
            path: path.into(),
            problem: format!("`scale` = {scale} is not a positive, finite number"),
            remedy: "give the factor from the mesh's units to those of the scenario, 0.001 for mm to m",
        });
    }
    let parse = match extension(path).as_str() {
        "stl" => stl::parse,
        "obj" => obj::parse,
        "ply" => ply::parse,
        "glb" | "gltf" => gltf_file::parse,
        _ => return Err(unknown_format(path, "stl, obj, ply, glb, gltf")),
    };
    let bytes = FILE.read(path).map_err(|e| MeshError::unreadable(path, e))?;
    if bytes.is_empty() {
        return Err(MeshError::malformed(path, "the file is empty"));
    }
    let mut read = parse(path, &bytes)?;
    let mesh = &mut read.mesh;
    if mesh.triangles.is_empty() {
        return Err(MeshError::malformed(path, "the file holds no triangle"));
    }
    if let Some(t) = mesh.first_bad_triangle() {
        let problem =
            format!("triangle {t} names a vertex that is not there ({} vertices)", mesh.vertices.len());
        return Err(MeshError::malformed(path, problem));
    }
    for v in &mut mesh.vertices {
        *v *= scale;
    }
    Ok(read)
}

/// Writes a surface; the extension chooses the format: `stl` (binary), `obj`, `ply` (binary, with
/// the fields as vertex properties; the other two have no place for them).
///
/// # Errors
/// A file that can not be written or whose extension is not known.
pub fn write_mesh(path: &Path, mesh: &TriangleMesh, fields: &[SurfaceField]) -> Result<(), MeshError> {
    let bytes = match extension(path).as_str() {
        "stl" => stl::format(mesh),
        "obj" => obj::format(mesh),
        "ply" => ply::format(mesh, fields),
        _ => return Err(unknown_format(path, "stl, obj, ply")),
    };
    bytes.and_then(|b| fs::write(path, b)).map_err(|e| MeshError::unwritable(path, &e))
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn unknown_format(path: &Path, known: &str) -> MeshError {
    MeshError::UnknownFormat {
        path: path.into(),
        problem: format!("the extension \"{}\" names no mesh format; known are {known}", extension(path)),
        remedy: "rename or convert the file",
    }
}

/// A piece of a file for a message, on one line.
fn shown(text: &str) -> String {
    const LONGEST: usize = 60;
    text.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(LONGEST).collect()
}

/// The triangles of polygons, given as vertex numbers, as fans around their first vertices.
fn fan(polygon: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    polygon.windows(2).skip(1).map(|pair| [polygon[0], pair[0], pair[1]])
}
