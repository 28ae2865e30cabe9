//! Surfaces that are no surfaces of solids: open, overlapping, inside out.

use super::Row;
use super::liver::PARTS_MESH;
use rsph_core::mesh::TriangleMesh;
use rsph_core::sample::{Resolution, sample};
use rsph_core::shape::{BoxShape, MeshShape, Shape, SphereShape, winding_field};
use rsph_core::tensor::Vec3;
use rsph_core::winding::WindingField;
use rsph_scenario::mesh_io::read_mesh;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

/// Volume of the wrapped surface of the same liver (m^3), and that inside of its own capsule and bare area.
const WRAP: f64 = 2.245e-3;
const CAPSULE: f64 = 2.1382e-3;
/// Cells of the picture along x.
const PIXELS: usize = 220;

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    cup(&mut rows)?;
    balls(&mut rows)?;
    if Path::new(PARTS_MESH).is_file() {
        liver(quick, &mut rows, folder)?;
    }
    Ok(rows)
}

/// A unit cube without a face, which a plane closes.
fn cup(rows: &mut Vec<Row>) -> Result<(), String> {
    let cube = BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).map_err(|e| e.to_string())?;
    let mut mesh = cube.surface().clone();
    mesh.triangles.retain(|t| t.iter().any(|&v| mesh.vertices[v as usize].z == 0.0));
    let shape = body(&mesh)?;
    rows.push(Row::within("imperfect: cube without a face, volume", shape.volume(), 1.0, 0.2, "1"));
    let made_up = shape.repair().map_or(f64::NAN, |r| r.made_up);
    rows.push(Row::near(
        "imperfect: cube without a face, share of the surface made up",
        made_up,
        1.0 / 6.0,
        0.01,
        "1",
    ));
    Ok(())
}

/// Two unit balls whose centres are 1 apart; the second has a hole, is inside out, and lies in part on itself.
fn balls(rows: &mut Vec<Row>) -> Result<(), String> {
    let ball = |x: f64| SphereShape::new(1.0, Vec3::new(x, 0.0, 0.0)).map_err(|e| e.to_string());
    let (mut mesh, mut other) = (ball(0.0)?.surface().clone(), ball(1.0)?.surface().flipped());
    other.triangles.retain(|t| t.iter().any(|&v| other.vertices[v as usize].z < 0.98));
    other.triangles.extend_from_within(..other.triangles.len() / 4);
    let first = mesh.vertices.len() as u32;
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    mesh.vertices.extend(&other.vertices);
    let exact = 8.0 / 3.0 * PI - 5.0 / 12.0 * PI;
    let volume = body(&mesh)?.volume();
    rows.push(Row::within(
        "imperfect: two balls, one inside out and open, volume of the union",
        volume,
        exact,
        0.5,
        "1",
    ));
    Ok(())
}

fn liver(quick: bool, rows: &mut Vec<Row>, folder: &Path) -> Result<(), String> {
    let mesh = read_mesh(Path::new(PARTS_MESH), 1.0).map_err(|e| e.to_string())?.merged();
    let shape = body(&mesh)?;
    let name = |what: &str| format!("imperfect: liver of 26 open parts, {what}");
    let particles = sample(&shape, Resolution::Particles(5_000), &[]).map_err(|e| e.to_string())?;
    rows.push(Row::within(name("5,000 particles, volume (wrap)"), particles.volume(), WRAP, 5.0, "m^3"));
    rows.push(Row::within(name("volume (its capsule and bare area)"), shape.volume(), CAPSULE, 0.5, "m^3"));
    let pieces = particles.surface.components().max(shape.surface().components());
    rows.push(Row::near(name("pieces"), pieces as f64, 1.0, 0.0, "1"));
    if let Some(repair) = shape.repair() {
        rows.push(Row::at_most(name("uncertain share"), repair.uncertain, 0.01, "1"));
        rows.push(Row::at_most(name("widest gap"), repair.gap, 0.002, "m"));
    }
    let field = winding_field(&mesh).ok_or("the liver has no triangles")?;
    let plain = WindingField::new(&mesh, &vec![1.0; mesh.triangles.len()]);
    let bounds = shape.bounds();
    let points = (0..if quick { 200 } else { 1_000 }).map(|n| {
        let at = |ratio: f64| (f64::from(n) * ratio).fract();
        bounds.min
            + bounds.size().component_mul(&Vec3::new(at(0.819_172_5), at(0.671_043_6), at(0.549_700_5)))
    });
    let error = points.map(|x| (plain.at(&x) - plain.at_by_all(&x)).abs()).fold(0.0, f64::max);
    rows.push(Row::at_most(name("tree against the sum, largest difference"), error, 0.03, "1"));
    if quick {
        return Ok(());
    }
    section(&bounds, &plain, &field, &folder.join("imperfect_liver.csv")).map_err(|e| e.to_string())
}

fn body(mesh: &TriangleMesh) -> Result<MeshShape, String> {
    MeshShape::new(mesh, "mesh").map(|found| found.0).map_err(|e| e.to_string())
}

/// Both winding numbers on a plane through the middle, for the picture.
fn section(
    bounds: &rsph_core::grid::Bounds,
    plain: &WindingField,
    field: &WindingField,
    file: &Path,
) -> std::io::Result<()> {
    let (low, size) = (bounds.min - 0.04 * bounds.size(), 1.08 * bounds.size());
    let step = size.x / PIXELS as f64;
    let mut text = String::from("x,y,winding_of_all_triangles,winding_after_repair\n");
    for j in 0..(size.y / step) as usize {
        for i in 0..PIXELS {
            let x = low + Vec3::new((i as f64 + 0.5) * step, (j as f64 + 0.5) * step, 0.5 * size.z);
            let _ = writeln!(text, "{:.5},{:.5},{:.4},{:.4}", x.x, x.y, plain.at(&x), field.at(&x));
        }
    }
    std::fs::write(file, text)
}
