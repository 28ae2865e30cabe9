//! Curved, cut and oblique surfaces, loaded and held, for Poisson's ratios up to 0.499: static solves against exact
//! solutions and finite elements (`validation/surfaces/`).

mod meshes;

use super::Row;
use super::equilibrium::Placed;
use super::figure::{Curve, Figure};
use meshes::{ball, hollow, ring, shape_of, turned};
use rsph_core::material::KelvinVoigt;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Boundary, Fix, Initial, Integration, Load, LoadKind, Mechanics, Ramp, Remesh, Setup, Solver, TimeStep,
    Units,
};
use rsph_core::shape::{BoxShape, CylinderShape, Shape};
use rsph_core::simulation::{Equilibrium, Simulation};
use rsph_core::surface::Surface;
use rsph_core::tensor::{SymTensor, Vec3};
use std::path::Path;
use std::sync::Arc;

/// E u of the clamped cube by Poisson's ratio (`validation/references/cube.py`).
const CUBE: [(f64, f64); 4] = [(0.3, 0.970546), (0.45, 0.927758), (0.49, 0.911656), (0.499, 0.907685)];
/// E times the compliance of the cantilever under shear at its end (`validation/references/cantilever.py`).
const CANTILEVER: [(f64, f64); 4] = [(0.3, 264.130), (0.45, 259.685), (0.49, 257.921), (0.499, 257.482)];
/// Work of the pressure on a disc, over p^2 / E (`validation/references/disc_on_cylinder.py`).
const DISC: f64 = 0.0624235;
/// Turns of bodies against their lattice: axis (none: by a shift alone) and name.
const TURNS: [(Option<[f64; 3]>, &str); 3] = [
    (None, "cut anywhere"),
    (Some([0.0, 1.0, 0.0]), "about y"),
    (Some([1.0, 2.0, 0.5]), "about (1, 2, 0.5)"),
];
/// Positions of the lattice, in spacings.
const POSITIONS: [[f64; 3]; 4] =
    [[0.13, 0.71, 0.37], [0.61, 0.24, 0.82], [0.4, 0.9, 0.05], [0.77, 0.5, 0.56]];

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    pulled_box(&mut rows)?;
    sphere(quick, &mut rows)?;
    cubes(quick, &mut rows, folder)?;
    cantilever(quick, &mut rows)?;
    disc(quick, &mut rows)?;
    lame(quick, &mut rows)?;
    Ok(rows)
}

/// Young's modulus of all bodies: displacements stay small against them. Results are for E = 1.
const YOUNG: f64 = 1e6;

/// A body at rest.
struct Case {
    shape: Arc<dyn Shape>,
    spacing: f64,
    /// Poisson's ratio.
    nu: f64,
    boundaries: Vec<Boundary>,
    loads: Vec<LoadKind>,
}

impl Case {
    /// Its equilibrium, with the compliance for E = 1.
    fn solve(self) -> Result<(Simulation, Equilibrium), String> {
        let Self { shape, spacing, nu, boundaries, loads } = self;
        let load = |kind| Load { kind, ramp: Ramp::default() };
        let mut body = Simulation::new(Setup {
            units: Units::Normalised,
            shape,
            resolution: Resolution::Spacing(spacing),
            material: Arc::new(KelvinVoigt::new(1.0, YOUNG, nu, 0.0).map_err(|e| e.to_string())?),
            initial: Initial::default(),
            boundaries,
            loads: loads.into_iter().map(load).collect(),
            mechanics: Mechanics::Solid,
            remesh: Remesh::default(),
            solver: Solver::ACCURATE,
            time_step: TimeStep::Auto,
            integration: Integration::default(),
            allow_unstable: false,
            probes: Vec::new(),
        })
        .map_err(|e| e.to_string())?;
        let found = body.solve_static(0.0, &mut |_, _| true).map_err(|e| e.to_string())?;
        Ok((body, Equilibrium { compliance: YOUNG * found.compliance, ..found }))
    }
}

/// The half-space beyond the plane through `point` with the outward normal `out`.
fn beyond(point: Vec3, out: Vec3) -> Region {
    Region::HalfSpace { point, normal: -out }
}

fn hold(region: Region, fix: Fix) -> Boundary {
    Boundary { region, fix, motion: None }
}

/// A box from the origin, turned by 30 degrees about an axis and shifted by some spacings against its lattice: its shape and
/// where its axes point.
fn placed(
    size: Vec3,
    axis: Option<[f64; 3]>,
    shift: Vec3,
    spacing: f64,
) -> Result<(Arc<dyn Shape>, [Vec3; 3]), String> {
    let whole = BoxShape::new(size, Vec3::zeros()).map_err(|e| e.to_string())?;
    let (mesh, axes) = turned(whole.surface(), axis);
    let shape = shape_of(&mesh).map_err(|e| e.to_string())?;
    let more = 2.0 * spacing * shift;
    Ok((Arc::new(Placed { shape, more }), axes))
}

/// A box on rollers, pulled at its end: a uniform strain, exact to what the correction is solved to.
fn pulled_box(rows: &mut Vec<Row>) -> Result<(), String> {
    let (nu, n) = (0.3, 7.0);
    for (axis, name) in TURNS {
        let mut worst = 0.0_f64;
        for position in POSITIONS {
            let (shape, [x, y, z]) = placed(Vec3::repeat(1.0), axis, Vec3::from(position), 1.0 / n)?;
            let boundaries = [x, y, z].map(|a| hold(beyond(Vec3::zeros(), -a), Fix::Normal)).to_vec();
            let loads = vec![LoadKind::Traction { region: beyond(z, z), traction: z }];
            let (_, found) = Case { shape, spacing: 1.0 / n, nu, boundaries, loads }.solve()?;
            worst = worst.max((found.compliance - 1.0).abs());
        }
        let name = format!("surfaces: pulled box, nu = {nu}, {n} across, {name}, extension off at most");
        rows.push(Row::at_most(name, worst, 1e-5, "1"));
    }
    Ok(())
}

/// A sphere under uniform pressure: the same stress everywhere, e = -p (1 - 2 nu) / E.
fn sphere(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let nu = 0.3;
    let strain = -(1.0 - 2.0 * nu);
    for per_radius in if quick { vec![6.0] } else { vec![6.0, 10.0, 20.0] } {
        // An eighth of it, on three planes of symmetry.
        let shape: Arc<dyn Shape> = shape_of(&ball(1.0, 5)).map_err(|e| e.to_string())?;
        let boundaries = [Axis::X, Axis::Y, Axis::Z].map(symmetry).to_vec();
        let loads = vec![LoadKind::Pressure { region: Region::All, pressure: 1.0 }];
        let case = Case { shape, spacing: 1.0 / per_radius, nu, boundaries, loads };
        let (mut body, _) = case.solve()?;
        let surface = at_rest(&mut body);
        let (mut moved, mut strained) = (0.0_f64, 0.0_f64);
        for vertex in vertices(&surface) {
            if vertex.x.norm() < 1.0 - 1e-2 {
                continue;
            }
            let off = vertex.u - strain * vertex.x;
            moved = moved.max(off.norm() / strain.abs());
            strained = strained.max((vertex.strain.dot(&vertex.x) - strain * vertex.x).norm() / strain.abs());
        }
        let name =
            |of: &str| format!("surfaces: sphere under pressure, nu = {nu}, dx = R/{per_radius}, {of}");
        rows.push(Row::at_most(name("displacement off at most"), moved, 1e-4, "1"));
        rows.push(Row::at_most(name("strain on the surface off at most"), strained, 1e-4, "1"));
    }
    Ok(())
}

/// A plane of symmetry through the origin, with the body on its upper side.
fn symmetry(axis: Axis) -> Boundary {
    hold(Region::Plane { axis, at: 0.0, side: Side::Below }, Fix::Normal)
}

/// The clamped cube of section 5.2, aligned with its lattice, shifted and turned against it.
fn cubes(quick: bool, rows: &mut Vec<Row>, folder: &Path) -> Result<(), String> {
    let sizes: &[(f64, f64)] = if quick { &[(7.0, 0.5)] } else { &[(7.0, 0.5), (13.0, 0.25)] };
    let mut figure =
        Figure::new("Clamped cube against finite elements, worst position", "Poisson's ratio", "error (%)");
    for (n, bound) in sizes {
        for (axis, name) in [(None, "aligned")].into_iter().chain(TURNS) {
            let positions: &[[f64; 3]] = match name {
                "aligned" => &[[0.0; 3]],
                _ if quick => &POSITIONS[..1],
                _ => &POSITIONS,
            };
            let mut errors = Vec::new();
            for (nu, exact) in CUBE {
                let mut worst = 0.0_f64;
                for position in positions {
                    let spacing = 1.0 / n;
                    let (shape, [_, _, z]) = if name == "aligned" {
                        let cube =
                            BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).map_err(|e| e.to_string())?;
                        (Arc::new(cube) as Arc<dyn Shape>, [Vec3::x(), Vec3::y(), Vec3::z()])
                    } else {
                        placed(Vec3::repeat(1.0), axis, Vec3::from(*position), spacing)?
                    };
                    let boundaries = vec![hold(beyond(Vec3::zeros(), -z), Fix::ALL)];
                    let loads = vec![LoadKind::Traction { region: beyond(z, z), traction: z }];
                    let (_, found) = Case { shape, spacing, nu, boundaries, loads }.solve()?;
                    let off = 100.0 * (found.compliance / exact - 1.0);
                    worst = if off.abs() > worst.abs() { off } else { worst };
                }
                let name = format!("surfaces: clamped cube, nu = {nu}, {n} across, {name}, E u off at most");
                rows.push(Row::near(name, worst, 0.0, *bound, "%"));
                errors.push(worst);
            }
            let ratios: Vec<f64> = CUBE.iter().map(|c| c.0).collect();
            figure.add(Curve::marked(&format!("{name}, {n} across"), &ratios, &errors));
        }
    }
    figure.save(folder, "surfaces")
}

/// A cantilever of 1 x 1 x 4 under shear at its end.
fn cantilever(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let sizes: &[(f64, f64)] = if quick { &[(6.0, 4.5)] } else { &[(6.0, 4.5), (12.0, 1.2)] };
    for (across, bound) in sizes {
        for (axis, name) in TURNS {
            for (nu, exact) in CANTILEVER {
                if axis.is_some() && nu > 0.3 && nu < 0.499 {
                    continue;
                }
                let spacing = 1.0 / across;
                let size = Vec3::new(1.0, 1.0, 4.0);
                let (shape, [x, _, z]) = placed(size, axis, Vec3::from(POSITIONS[0]), spacing)?;
                let boundaries = vec![hold(beyond(Vec3::zeros(), -z), Fix::ALL)];
                let loads = vec![LoadKind::Traction { region: beyond(4.0 * z, z), traction: x }];
                let (_, found) = Case { shape, spacing, nu, boundaries, loads }.solve()?;
                let name = format!("surfaces: cantilever, nu = {nu}, {across} across, {name}, compliance");
                rows.push(Row::within(name, found.compliance, exact, *bound, "1/E"));
            }
        }
    }
    Ok(())
}

/// A disc of pressure on the end of a clamped cylinder.
fn disc(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    const RADIUS: f64 = 0.25;
    let sizes: &[(f64, f64)] = if quick { &[(3.0, 9.0)] } else { &[(3.0, 9.0), (4.0, 6.0), (6.0, 3.0)] };
    for (per_radius, bound) in sizes {
        let cylinder = CylinderShape::new(Axis::Z, 1.0, 1.0, Vec3::zeros()).map_err(|e| e.to_string())?;
        let below = cylinder.bounds().min.z;
        let top = cylinder.bounds().max.z;
        let centre = Vec3::new(0.0, 0.0, top);
        let boundaries = vec![hold(Region::Plane { axis: Axis::Z, at: below, side: Side::Below }, Fix::ALL)];
        let region = Region::SurfacePatch { centre, radius: RADIUS, facing: Vec3::z() };
        let loads = vec![LoadKind::Pressure { region, pressure: 1.0 }];
        let case =
            Case { shape: Arc::new(cylinder), spacing: RADIUS / per_radius, nu: 0.3, boundaries, loads };
        let (_, found) = case.solve()?;
        let name = format!("surfaces: disc of pressure on a cylinder, nu = 0.3, a/dx = {per_radius}, work");
        rows.push(Row::within(name, found.compliance, DISC, *bound, "p^2/E"));
    }
    Ok(())
}

/// Thick walls under pressure from inside, radii 1 and 2 (G. Lame, 1852): a quarter of a ring in plane strain and an eighth of
/// a hollow sphere.
fn lame(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let (nu, a, b) = (0.3, 1.0_f64, 2.0_f64);
    let sizes: &[(f64, f64, f64)] =
        if quick { &[(8.0, 2.0, 15.0)] } else { &[(8.0, 2.0, 15.0), (16.0, 0.5, 6.0), (32.0, 0.2, 3.0)] };
    for (across, of_displacement, of_stress) in sizes {
        for is_sphere in [false, true] {
            if is_sphere && *across > 20.0 {
                continue;
            }
            let spacing = (b - a) / across;
            let mesh = if is_sphere { hollow(a, b, 5) } else { ring(a, b, 4.0 * spacing, 400) };
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
            let surface = at_rest(&mut body);
            let (mut worst_hoop, mut worst_radial) = (0.0_f64, 0.0_f64);
            for vertex in vertices(&surface) {
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

/// The inner wall of a ring: all that is nearer to the axis than the middle of the wall, in slices that balls cover.
fn inner_wall(a: f64, b: f64, spacing: f64) -> Region {
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

/// The surface of the body as it is now.
fn at_rest(body: &mut Simulation) -> Surface {
    let snapshot = body.snapshot();
    body.surface(&snapshot)
}

/// What is read at a vertex of the surface: its undeformed place and the fields, displacement and strain for E = 1.
struct VertexFields {
    x: Vec3,
    u: Vec3,
    strain: SymTensor,
    stress: SymTensor,
}

fn vertices(surface: &Surface) -> impl Iterator<Item = VertexFields> + '_ {
    let field = |name: &str| surface.field(name).map_or(&[][..], |f| &f.values);
    let (u, strain, stress) = (field("displacement"), field("strain"), field("stress"));
    let tensor = |values: &[f64], i: usize| SymTensor(std::array::from_fn(|c| values[6 * i + c]));
    surface.mesh.vertices.iter().enumerate().map(move |(i, x)| {
        let u = Vec3::from_column_slice(&u[3 * i..3 * i + 3]);
        VertexFields { x: x - u, u: u * YOUNG, strain: tensor(strain, i) * YOUNG, stress: tensor(stress, i) }
    })
}
