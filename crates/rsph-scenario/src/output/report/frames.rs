//! The frames of the 3D view: as many as fit into the page, evenly spaced in time.

use super::packed::{Packed, indices};
use super::thinned::Thinned;
use crate::output::polydata::{Cells, PolyData};
use rsph_core::particles::PRINCIPAL;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Most frames in a page.
const MAX_FRAMES: usize = 40;
/// Most bytes of frames in a page.
const MAX_BYTES: usize = 9_000_000;
/// A surface with more vertices than this is left to ParaView.
const MAX_VERTICES: usize = 80_000;
/// What the view can show, if the surface has it: a scalar field, or a field with one of its principal values.
const SCALARS: [(&str, Option<&str>); 14] = [
    ("normal_strain", None),
    ("shear_strain", None),
    ("von_mises", None),
    ("material", None),
    ("velocity_x", None),
    ("volume_ratio", None),
    ("principal_stretch", Some("1")),
    ("principal_strain", Some("1")),
    ("principal_strain", Some("3")),
    ("max_shear_strain", None),
    ("principal_stress", Some("1")),
    ("principal_stress", Some("3")),
    ("max_shear_stress", None),
    ("pressure", None),
];

/// An undeformed surface, shared by all frames until the next remesh.
#[derive(Debug, Serialize)]
struct Mesh {
    x: [Packed; 3],
    triangles: String,
}

/// The newest mesh as it came, to compare the next one with.
#[derive(Debug)]
struct Newest {
    mesh: Arc<Mesh>,
    reference: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

#[derive(Debug)]
struct Frame {
    time: f64,
    mesh: Arc<Mesh>,
    u: Option<[Packed; 3]>,
    scalars: BTreeMap<String, Packed>,
}

/// Collects frames while a run goes on.
#[derive(Debug, Default)]
pub struct Frames {
    series: Thinned<Frame>,
    newest: Option<Newest>,
    too_large: Option<usize>,
}

/// The frames as they stand in the page.
#[derive(Debug, Serialize)]
pub struct View<'a> {
    meshes: Vec<&'a Mesh>,
    frames: Vec<FrameView<'a>>,
}

#[derive(Debug, Serialize)]
struct FrameView<'a> {
    time: f64,
    mesh: usize,
    u: Option<&'a [Packed; 3]>,
    scalars: &'a BTreeMap<String, Packed>,
}

impl Frames {
    /// Takes a surface.
    pub fn push(&mut self, surface: &PolyData) {
        let n = surface.points.len();
        if n > MAX_VERTICES {
            self.too_large = Some(n);
        }
        let Cells::Triangles(triangles) = &surface.cells else { return };
        if n == 0 || self.too_large.is_some() {
            return;
        }
        let field = |name: &str, components: usize| {
            let found = surface.field(name).filter(|f| f.components == components)?;
            (found.values.len() == components * n).then_some(&found.values)
        };
        let u = field("displacement", 3).map(|v| v.as_chunks::<3>().0);
        let reference: Vec<[f64; 3]> = surface
            .points
            .iter()
            .enumerate()
            .map(|(i, x)| std::array::from_fn(|c| x[c] - u.map_or(0.0, |u| u[i][c])))
            .collect();
        let frame = Frame {
            time: surface.time,
            mesh: self.mesh(reference, triangles),
            u: u.map(pack),
            scalars: SCALARS
                .into_iter()
                .filter_map(|(of, value)| {
                    let components = if value.is_some() { PRINCIPAL.len() } else { 1 };
                    let component = PRINCIPAL.iter().position(|p| Some(*p) == value).unwrap_or(0);
                    let name = value.map_or_else(|| of.to_owned(), |value| format!("{of}_{value}"));
                    let values = field(of, components)?.iter().skip(component).step_by(components);
                    Some((name, Packed::new(values.copied())))
                })
                .collect(),
        };
        self.series.push(frame, |frames| frames.len() <= MAX_FRAMES && size(frames) <= MAX_BYTES);
    }

    /// The newest mesh if it is this one, else a new one.
    fn mesh(&mut self, reference: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Arc<Mesh> {
        if let Some(newest) = &self.newest
            && newest.triangles == triangles
            && same(&newest.reference, &reference)
        {
            return Arc::clone(&newest.mesh);
        }
        let mesh =
            Arc::new(Mesh { x: pack(&reference), triangles: indices(triangles.iter().flatten().copied()) });
        let newest = Newest { mesh: Arc::clone(&mesh), reference, triangles: triangles.to_vec() };
        self.newest = Some(newest);
        mesh
    }

    /// Why there is nothing to see, if so.
    pub fn missing(&self) -> Option<String> {
        match self.too_large {
            Some(n) => Some(format!(
                "The surface has {n} vertices, more than the {MAX_VERTICES} that this page can hold. \
                 Open surface.vtkhdf in ParaView or pyvista."
            )),
            None if self.series.seen() == 0 => Some("The run has no surface.".to_owned()),
            None => None,
        }
    }

    /// How many of how many frames are in the page.
    pub fn counts(&self) -> (usize, u64) {
        (self.series.entries().len(), self.series.seen())
    }

    /// The frames for the page.
    pub fn view(&self) -> View<'_> {
        let mut view = View { meshes: Vec::new(), frames: Vec::new() };
        if self.too_large.is_some() {
            return view;
        }
        for f in self.series.entries() {
            if !view.meshes.last().is_some_and(|m| std::ptr::eq(*m, &raw const *f.mesh)) {
                view.meshes.push(&f.mesh);
            }
            let mesh = view.meshes.len() - 1;
            view.frames.push(FrameView { time: f.time, mesh, u: f.u.as_ref(), scalars: &f.scalars });
        }
        view
    }
}

fn pack(vectors: &[[f64; 3]]) -> [Packed; 3] {
    std::array::from_fn(|c| Packed::new(vectors.iter().map(move |v| v[c])))
}

/// Whether two sets of points differ by no more than rounding.
fn same(a: &[[f64; 3]], b: &[[f64; 3]]) -> bool {
    let size = a.iter().flatten().fold(0.0_f64, |s, x| s.max(x.abs()));
    a.len() == b.len()
        && a.iter().flatten().zip(b.iter().flatten()).all(|(x, y)| (x - y).abs() <= 1e-6 * size)
}

/// Bytes in the page.
fn size(frames: &[&Frame]) -> usize {
    let mut total = 0;
    let mut mesh: Option<&Arc<Mesh>> = None;
    for f in frames {
        if !mesh.is_some_and(|m| Arc::ptr_eq(m, &f.mesh)) {
            total += f.mesh.triangles.len() + f.mesh.x.iter().map(Packed::size).sum::<usize>();
        }
        mesh = Some(&f.mesh);
        total += f.u.iter().flatten().chain(f.scalars.values()).map(Packed::size).sum::<usize>();
    }
    total
}
