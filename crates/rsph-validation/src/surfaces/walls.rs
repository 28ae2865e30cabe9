//! Walls that are curved: thick rings and spheres under pressure, a plate with a hole and an elliptic membrane.

use super::case::{Case, YOUNG, beyond, hold, read, symmetry};
use super::meshes::{ellipse, hollow, shape_of, tube};
use crate::Row;
use rsph_core::mesh::TriangleMesh;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::setup::{Fix, LoadKind};
use rsph_core::simulation::{Equilibrium, Simulation};
use rsph_core::tensor::{SymTensor, Vec3};

/// Sides of a polygon that stands for a curve; of a square, corners among them.
pub const SIDES: u32 = 404;
/// Peak stress at the hole of a plate over the load, its half-width over the radius, and mean displacement of its end
/// (`validation/references/plate_with_hole.py`).
const HOLE: (f64, f64, f64) = (3.58322, 4.0, 4.28549);
/// Stress at the end of the long axis of the inner ellipse over the load (NAFEMS LE1, `validation/references/le1.py`).
const MEMBRANE: f64 = 9.2658;

/// Thick walls under pressure from inside, radii 1 and 2 (G. Lame, 1852): a quarter of a ring in plane strain and an eighth of
/// a hollow sphere.
pub fn lame(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let (nu, a, b) = (0.3, 1.0_f64, 2.0_f64);
    let sizes: &[(f64, f64, f64)] =
        if quick { &[(8.0, 2.0, 15.0)] } else { &[(8.0, 2.0, 15.0), (16.0, 0.5, 6.0), (32.0, 0.2, 3.0)] };
    for (across, of_displacement, of_stress) in sizes {
        for is_sphere in [false, true] {
            if is_sphere && *across > 20.0 {
                continue;
            }
            let spacing = (b - a) / across;
            let mesh = if is_sphere {
                hollow(a, b, 5)
            } else {
                tube(ellipse([a; 2], SIDES), ellipse([b; 2], SIDES), 4.0 * spacing, SIDES)
            };
            let mesh = shape_of(&mesh).map_err(|e| e.to_string())?;
            let mut boundaries = vec![symmetry(Axis::X), symmetry(Axis::Y), symmetry(Axis::Z)];
            if !is_sphere {
                let top = Region::Plane { axis: Axis::Z, at: 4.0 * spacing, side: Side::Above };
                boundaries.push(hold(top, Fix::Normal));
            }
            // The inner wall faces the axis.
            let inner = Region::Ball { centre: Vec3::zeros(), radius: 0.5 * (a + b) };
            let inside = if is_sphere { inner } else { inner_wall(a, b, spacing) };
            let loads = vec![LoadKind::Pressure { region: inside, pressure: 1.0 }];
            let (mut body, found) = Case { shape: mesh, spacing, nu, boundaries, loads }.solve()?;
            let (u_inner, hoop) = exact_lame(is_sphere, nu, a, b);
            // Work of the pressure over the area of the wall: the mean displacement.
            let area = if is_sphere {
                0.5 * std::f64::consts::PI * a * a
            } else {
                0.5 * std::f64::consts::PI * a * 4.0 * spacing
            };
            let what = if is_sphere { "hollow sphere" } else { "thick ring" };
            let name =
                |of: &str| format!("surfaces: {what} under pressure, nu = {nu}, {across} cells across, {of}");
            rows.push(Row::within(
                name("displacement of the inner wall"),
                found.compliance / area,
                u_inner,
                *of_displacement,
                "1",
            ));
            let (mut worst_hoop, mut worst_radial) = (0.0_f64, 0.0_f64);
            for vertex in read(&mut body, YOUNG) {
                let flat = if is_sphere { vertex.x } else { Vec3::new(vertex.x.x, vertex.x.y, 0.0) };
                let (r, n) = (flat.norm(), flat.normalize());
                let margin = 1.5 * spacing;
                let near_cut =
                    vertex.x.x < margin || vertex.x.y < margin || (is_sphere && vertex.x.z < margin);
                let wall = if (r - a).abs() < 0.1 * spacing {
                    0
                } else if (r - b).abs() < 0.1 * spacing {
                    1
                } else {
                    continue;
                };
                if near_cut {
                    continue;
                }
                let along = Vec3::z().cross(&n).normalize();
                let (h, radial) = (along.dot(&vertex.stress.dot(&along)), n.dot(&vertex.stress.dot(&n)));
                let exact_radial = if wall == 0 { -1.0 } else { 0.0 };
                worst_hoop = worst_hoop.max((h / hoop[wall] - 1.0).abs());
                worst_radial = worst_radial.max((radial - exact_radial).abs());
            }
            rows.push(Row::at_most(
                name("hoop stress at the walls off at most"),
                100.0 * worst_hoop,
                *of_stress,
                "%",
            ));
            rows.push(Row::at_most(
                name("radial stress at the walls off at most"),
                100.0 * worst_radial,
                *of_stress,
                "% of p",
            ));
        }
    }
    Ok(())
}

/// A slice in plane strain, four cells thick, with its quarter between two planes of symmetry.
fn slice(
    mesh: impl Fn(f64) -> TriangleMesh,
    spacing: f64,
    loads: Vec<LoadKind>,
) -> Result<(Simulation, Equilibrium), String> {
    let thick = 4.0 * spacing;
    let shape = shape_of(&mesh(thick)).map_err(|e| e.to_string())?;
    let mut boundaries = [Axis::X, Axis::Y, Axis::Z].map(symmetry).to_vec();
    boundaries.push(hold(Region::Plane { axis: Axis::Z, at: thick, side: Side::Above }, Fix::Normal));
    Case { shape, spacing, nu: 0.3, boundaries, loads }.solve()
}

/// Largest hoop stress of a free wall within three spacings of a point on it, in the middle half of a slice: the trace in the
/// plane, since no traction acts.
fn hoop_near(body: &mut Simulation, spacing: f64, point: Vec3, on_wall: impl Fn(&Vec3) -> bool) -> f64 {
    let is_near = |x: &Vec3| {
        (x - point).xy().norm() < 3.0 * spacing && x.z > spacing && x.z < 3.0 * spacing && on_wall(x)
    };
    let hoop = |s: &SymTensor| s.0[0] + s.0[1];
    let found = read(body, YOUNG);
    found.iter().filter(|v| is_near(&v.x)).map(|v| hoop(&v.stress)).fold(f64::NEG_INFINITY, f64::max)
}

/// A square plate with a hole of radius 1, pulled along x.
pub fn plate(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let (peak, half, moved) = HOLE;
    let sizes: &[(f64, f64)] = if quick { &[(8.0, 6.0)] } else { &[(8.0, 6.0), (16.0, 3.0)] };
    for (per_radius, bound) in sizes {
        let spacing = 1.0 / per_radius;
        let square = |angle: f64| {
            let (c, s) = (angle.cos(), angle.sin());
            [c, s].map(|x| half * x / c.abs().max(s.abs()))
        };
        let mesh = |thick| tube(ellipse([1.0; 2], SIDES), square, thick, SIDES);
        let end = beyond(half * Vec3::x(), Vec3::x());
        let loads = vec![LoadKind::Traction { region: end, traction: Vec3::x() }];
        let (mut body, found) = slice(mesh, spacing, loads)?;
        let thick = 4.0 * spacing;
        let name =
            |of: &str| format!("surfaces: plate with a hole, nu = 0.3, {per_radius} cells a radius, {of}");
        let on_wall = |x: &Vec3| (x.xy().norm() - 1.0).abs() < 0.1 * spacing;
        let stress = hoop_near(&mut body, spacing, Vec3::y(), on_wall);
        rows.push(Row::within(name("peak stress over the load"), stress, peak, *bound, "1"));
        let mean = found.compliance / (half * thick);
        rows.push(Row::within(name("mean displacement of the end"), mean, moved, *bound, "S a/E"));
    }
    Ok(())
}

/// The elliptic membrane NAFEMS LE1 in plane strain, pulled outward at its outer edge.
pub fn membrane(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let sizes: &[(f64, f64)] = if quick { &[(16.0, 5.0)] } else { &[(16.0, 5.0), (32.0, 2.0)] };
    for (across, bound) in sizes {
        // Across the wall at the point where the stress is known.
        let spacing = 1.25 / across;
        let mesh = |thick| tube(ellipse([2.0, 1.0], SIDES), ellipse([3.25, 2.75], SIDES), thick, SIDES);
        // All but the inner wall; the other faces are held along their normal.
        let inner: Vec<Region> = (0..=90)
            .map(|k| f64::from(k).to_radians())
            .map(|t| Vec3::new(2.0 * t.cos(), t.sin(), 2.0 * spacing))
            .map(|centre| Region::Ball { centre, radius: 4.0 * spacing })
            .collect();
        let region = Region::Not(Box::new(Region::Or(inner)));
        let loads = vec![LoadKind::Pressure { region, pressure: -1.0 }];
        let (mut body, _) = slice(mesh, spacing, loads)?;
        let on_wall = |x: &Vec3| (Vec3::new(0.5 * x.x, x.y, 0.0).norm() - 1.0).abs() < 0.1 * spacing;
        let stress = hoop_near(&mut body, spacing, 2.0 * Vec3::x(), on_wall);
        let name = format!(
            "surfaces: elliptic membrane (LE1), nu = 0.3, {across} cells across, stress at D over the load"
        );
        rows.push(Row::within(name, stress, MEMBRANE, *bound, "1"));
    }
    Ok(())
}

/// The inner wall of a ring: all that is nearer to the axis than the middle of the wall, in slices that balls cover.
pub fn inner_wall(a: f64, b: f64, spacing: f64) -> Region {
    let slices = (0..=4)
        .map(|k| Region::Ball { centre: Vec3::new(0.0, 0.0, f64::from(k) * spacing), radius: 0.5 * (a + b) });
    let faces = [0.0, 4.0 * spacing].map(|z| Region::Box {
        min: Vec3::new(-3.0 * b, -3.0 * b, z - 1e-3 * spacing),
        max: Vec3::new(3.0 * b, 3.0 * b, z + 1e-3 * spacing),
    });
    Region::And(vec![Region::Or(slices.collect()), Region::Not(Box::new(Region::Or(faces.to_vec())))])
}

/// Displacement of the inner wall and hoop stress at both, E = p = 1.
fn exact_lame(is_sphere: bool, nu: f64, a: f64, b: f64) -> (f64, [f64; 2]) {
    if is_sphere {
        let d = b.powi(3) - a.powi(3);
        let u = a / d * ((1.0 - 2.0 * nu) * a.powi(3) + 0.5 * (1.0 + nu) * b.powi(3));
        (u, [(a.powi(3) + 0.5 * b.powi(3)) / d, 1.5 * a.powi(3) / d])
    } else {
        let d = b * b - a * a;
        let u = (1.0 + nu) * a / d * ((1.0 - 2.0 * nu) * a * a + b * b);
        (u, [(a * a + b * b) / d, 2.0 * a * a / d])
    }
}
