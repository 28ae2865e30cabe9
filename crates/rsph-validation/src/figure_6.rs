//! Fig. 6: the surface that a liver was given by, beside the zero level set that 144 particles carry.

use super::Row;
use super::case::{LIVER_LOAD_144, LIVER_VISIBLE_HUMAN, simulation};
use super::liver;
use super::picture::Picture;
use super::render::{View, render, shaded};
use rsph_core::mesh::TriangleMesh;
use rsph_core::shape::{MeshShape, Shape};
use rsph_core::tensor::Vec3;
use std::path::Path;

/// Particles of the paper.
const PARTICLES: usize = 144;
/// Size of a panel.
const PANEL: [usize; 2] = [420, 320];

/// How far apart two closed surfaces are.
struct Gap {
    /// Mean distance from a vertex of one to the other surface, the larger of both ways.
    mean: f64,
    largest: f64,
}

impl Gap {
    fn between(a: &TriangleMesh, b: &TriangleMesh) -> Result<Self, String> {
        let shape =
            |m: &TriangleMesh| MeshShape::new(m, "surface").map(|(s, _)| s).map_err(|e| e.to_string());
        let mut gap = Self { mean: 0.0, largest: 0.0 };
        for (from, to) in [(a, shape(b)?), (b, shape(a)?)] {
            let distances: Vec<f64> = from.vertices.iter().map(|x| to.signed_distance(x).abs()).collect();
            gap.mean = gap.mean.max(distances.iter().sum::<f64>() / distances.len() as f64);
            gap.largest = distances.into_iter().fold(gap.largest, f64::max);
        }
        Ok(gap)
    }
}

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let mut picture = Picture::new(2, PANEL, false);
    let count = |n: usize| format!("body.particles={n}");
    organ("built-in liver", LIVER_LOAD_144, &[count(PARTICLES)], 1.0, &mut rows, Some(&mut picture))?;
    if liver::is_there() {
        let edits = liver::edits(PARTICLES);
        organ("real liver", LIVER_VISIBLE_HUMAN, &edits, 1.0, &mut rows, Some(&mut picture))?;
    }
    if !quick {
        // Finer particles come nearer by as much as they are finer.
        organ("built-in liver", LIVER_LOAD_144, &[count(5000)], 0.5, &mut rows, None)?;
        if liver::is_there() {
            organ("real liver", LIVER_VISIBLE_HUMAN, &liver::edits(5000), 0.5, &mut rows, None)?;
        }
    }
    picture.save(&folder.join("figure_6.svg"))?;
    Ok(rows)
}

/// The rows of one organ; its panels where there is a picture. `coarse` scales the bounds.
fn organ(
    what: &str,
    scenario: (&str, &str),
    edits: &[String],
    coarse: f64,
    rows: &mut Vec<Row>,
    picture: Option<&mut Picture>,
) -> Result<(), String> {
    // The whole organ: a clamp would cut it.
    let edits = [edits, &["boundary=[]".into()]].concat();
    let (mut sim, _) = simulation(scenario, &edits)?;
    let original = sim.setup().shape.surface().clone();
    let snapshot = sim.snapshot();
    let surface = sim.surface(&snapshot).mesh;
    let about = sim.description();
    let (n, dx) = (about.particles, about.spacing);
    let name = |of: &str| format!("figure_6: {what}, {n} particles, {of}");
    if coarse >= 1.0 {
        rows.push(Row::within(name("number"), n as f64, PARTICLES as f64, 3.0, "1").paper("144"));
    }
    rows.push(Row::within(name("volume"), about.volume, original.volume(), 3.0 * coarse, "m^3"));
    let inside = name("volume inside the zero level set");
    rows.push(Row::within(inside, surface.volume(), original.volume(), 12.0 * coarse, "m^3"));
    let (Some(has), Some(should)) = (surface.bounds(), original.bounds()) else {
        return Err(format!("{what}: a surface without triangles"));
    };
    let off = (has.size() - should.size()).abs().component_div(&should.size()).max();
    rows.push(Row::at_most(name("extent, worst axis off by"), 100.0 * off, 5.0 * coarse, "%"));
    let gap = Gap::between(&surface, &original)?;
    rows.push(Row::at_most(name("mean distance of the surfaces"), gap.mean / dx, 0.2, "of the spacing"));
    rows.push(Row::at_most(
        name("largest distance of the surfaces"),
        gap.largest / dx,
        1.0,
        "of the spacing",
    ));
    rows.push(Row::near(name("pieces of the surface"), surface.components() as f64, 1.0, 0.0, "1"));
    if let Some(picture) = picture {
        let view = view(&original, PANEL);
        let of = format!("{what}: {} triangles", original.triangles.len());
        picture.pixels(&of, &render(&original, &view, &shaded))?;
        picture.pixels(&format!("{n} particles, zero level set"), &render(&surface, &view, &shaded))?;
    }
    Ok(())
}

/// The body as the paper shows it: its right end on the left, up upwards, a little from above.
pub(super) fn view(surface: &TriangleMesh, panel: [usize; 2]) -> View {
    let bounds = surface.bounds();
    let (centre, size) =
        bounds.map_or((Vec3::zeros(), Vec3::repeat(1.0)), |b| (0.5 * (b.min + b.max), b.size()));
    let scale = (0.9 * panel[0] as f64 / size.x).min(0.9 * panel[1] as f64 / size.yz().norm());
    View::new(Vec3::new(0.0, 0.35, 1.0), centre, scale, panel)
}
