//! Curved, cut and oblique surfaces, loaded and held, for Poisson's ratios up to 0.499: static solves against exact
//! solutions and finite elements (`validation/surfaces/`).

pub(super) mod case;
mod hourglass;
pub(super) mod livers;
mod local_load;
pub(super) mod meshes;
pub(super) mod walls;

use super::Row;
use super::equilibrium::Placed;
use super::figure::{Curve, Figure};
use super::liver;
use case::{Case, YOUNG, beyond, hold, read, symmetry};
use meshes::{ball, shape_of, turned};
use rsph_core::particles::Field;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::setup::{Fix, LoadKind, Solver};
use rsph_core::shape::{BoxShape, CylinderShape, Shape};
use rsph_core::tensor::Vec3;
use std::path::Path;
use std::sync::Arc;

/// E u of the clamped cube by Poisson's ratio (`validation/references/cube.py`).
const CUBE: [(f64, f64); 4] = [(0.3, 0.970546), (0.45, 0.927758), (0.49, 0.911656), (0.499, 0.907685)];
/// E times the compliance of the cantilever under shear at its end (`validation/references/cantilever.py`).
const CANTILEVER: [(f64, f64); 4] = [(0.3, 264.130), (0.45, 259.685), (0.49, 257.921), (0.499, 257.482)];
/// E times the compliance of the cantilever under its own weight, nu = 0.3.
const CANTILEVER_WEIGHT: f64 = 663.792;
/// Work of the pressure on a disc, over p^2 / E (`validation/references/disc_on_cylinder.py`).
const DISC: f64 = 0.0624235;
/// Turns of bodies against their lattice: axis (none: by a shift alone) and name.
pub(super) const TURNS: [(Option<[f64; 3]>, &str); 3] = [
    (None, "cut anywhere"),
    (Some([0.0, 1.0, 0.0]), "about y"),
    (Some([1.0, 2.0, 0.5]), "about (1, 2, 0.5)"),
];
/// Positions of the lattice, in spacings.
pub(super) const POSITIONS: [[f64; 3]; 4] =
    [[0.13, 0.71, 0.37], [0.61, 0.24, 0.82], [0.4, 0.9, 0.05], [0.77, 0.5, 0.56]];

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    pulled_box(&mut rows)?;
    sphere(quick, &mut rows)?;
    cubes(quick, &mut rows, folder)?;
    cantilever(quick, &mut rows)?;
    disc(quick, &mut rows)?;
    thin_bodies(&mut rows)?;
    local_load::sphere(quick, &mut rows)?;
    walls::lame(quick, &mut rows)?;
    walls::plate(quick, &mut rows)?;
    walls::membrane(quick, &mut rows)?;
    hourglass::study(quick, &mut rows, folder)?;
    if liver::is_there() {
        livers::run(quick, &mut rows)?;
    }
    Ok(rows)
}

/// A box from the origin, turned by 30 degrees about an axis and shifted by some spacings against its lattice: its shape and
/// where its axes point.
pub(super) fn placed(
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
        let (mut moved, mut strained) = (0.0_f64, 0.0_f64);
        for vertex in read(&mut body, YOUNG) {
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

/// The clamped cube of section 5.2, aligned with its lattice, shifted and turned against it.
fn cubes(quick: bool, rows: &mut Vec<Row>, folder: &Path) -> Result<(), String> {
    let sizes: &[(f64, f64)] = if quick { &[(7.0, 0.5)] } else { &[(7.0, 0.5), (13.0, 0.25), (25.0, 0.12)] };
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
                    let size = Vec3::repeat(1.0);
                    let placed = if name == "aligned" {
                        let cube = BoxShape::new(size, Vec3::zeros()).map_err(|e| e.to_string())?;
                        (Arc::new(cube) as Arc<dyn Shape>, [Vec3::x(), Vec3::y(), Vec3::z()])
                    } else {
                        placed(size, axis, Vec3::from(*position), 1.0 / n)?
                    };
                    let (_, found) = clamped_cube(placed, *n, nu).solve()?;
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

/// The cube, so many cells across, clamped at its foot and pulled at its head.
fn clamped_cube((shape, [_, _, z]): (Arc<dyn Shape>, [Vec3; 3]), across: f64, nu: f64) -> Case {
    let boundaries = vec![hold(beyond(Vec3::zeros(), -z), Fix::ALL)];
    let loads = vec![LoadKind::Traction { region: beyond(z, z), traction: z }];
    Case { shape, spacing: 1.0 / across, nu, boundaries, loads }
}

/// A cantilever of 1 x 1 x 4, so many cells across, turned about an axis, under what `load` makes of its axes.
fn clamped_beam(
    across: f64,
    axis: Option<[f64; 3]>,
    nu: f64,
    load: impl Fn([Vec3; 3]) -> LoadKind,
) -> Result<Case, String> {
    let (spacing, size) = (1.0 / across, Vec3::new(1.0, 1.0, 4.0));
    let (shape, axes) = placed(size, axis, Vec3::from(POSITIONS[0]), spacing)?;
    let boundaries = vec![hold(beyond(Vec3::zeros(), -axes[2]), Fix::ALL)];
    Ok(Case { shape, spacing, nu, boundaries, loads: vec![load(axes)] })
}

/// Shear at the end of the beam.
fn end_shear([x, _, z]: [Vec3; 3]) -> LoadKind {
    LoadKind::Traction { region: beyond(4.0 * z, z), traction: x }
}

/// The weight of the beam, across it.
fn own_weight([x, _, _]: [Vec3; 3]) -> LoadKind {
    LoadKind::BodyForce { region: Region::All, acceleration: x }
}

/// A cantilever under shear at its end and under its own weight.
fn cantilever(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let sizes: &[(f64, f64)] = if quick { &[(6.0, 4.5)] } else { &[(6.0, 4.5), (12.0, 1.2)] };
    for (across, bound) in sizes {
        for (axis, name) in TURNS {
            let mut solve = |what: &str, nu: f64, exact: f64, load: fn([Vec3; 3]) -> LoadKind| {
                let (_, found) = clamped_beam(*across, axis, nu, load)?.solve()?;
                let name =
                    format!("surfaces: cantilever{what}, nu = {nu}, {across} across, {name}, compliance");
                rows.push(Row::within(name, found.compliance, exact, *bound, "1/E"));
                Ok::<(), String>(())
            };
            for (nu, exact) in CANTILEVER {
                if axis.is_some() && nu > 0.3 && nu < 0.499 {
                    continue;
                }
                solve("", nu, exact, end_shear)?;
            }
            solve(" under its own weight", 0.3, CANTILEVER_WEIGHT, own_weight)?;
        }
    }
    Ok(())
}

/// Flat ellipsoids of half axes 1, 1 and 3, 1.2 and 0.6 cells under uniform pressure, turned against the lattice: a quarter
/// between two planes of symmetry, with one component of a particle in the middle held so that it does not drift. The strain
/// is that of the sphere.
fn thin_bodies(rows: &mut Vec<Row>) -> Result<(), String> {
    let (nu, spacing) = (0.3, 0.1);
    let exact = std::f64::consts::PI * (1.0 - 2.0 * nu);
    for cells in [3.0, 1.2, 0.6] {
        let mut ellipsoid = ball(1.0, 5);
        ellipsoid.vertices.iter_mut().for_each(|x| x.z *= cells * spacing);
        let (mesh, [x, y, _]) = turned(&ellipsoid, Some([1.0, 2.0, 0.5]));
        let shape = shape_of(&mesh).map_err(|e| e.to_string())?;
        let boundaries = [x, y].map(|a| hold(beyond(Vec3::zeros(), -a), Fix::Normal)).to_vec();
        let loads = vec![LoadKind::Pressure { region: Region::All, pressure: 1.0 }];
        let mut case = Case { shape, spacing, nu, boundaries, loads };
        // One particle: two would hold the strain between them.
        let drifting = case.clone().body(Solver::ACCURATE)?;
        let places = drifting.particles().column(Field::Reference);
        let places = (0..places.len()).map(|a| places.vector(a));
        let centre = places.min_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
        let middle = Region::Ball { centre, radius: 0.1 * spacing };
        case.boundaries.push(hold(middle, Fix::Components([false, false, true])));
        let (_, found) = case.solve()?;
        let off = 100.0 * (found.compliance / (exact * cells * spacing) - 1.0);
        let name = format!(
            "surfaces: flat ellipsoid under pressure, nu = {nu}, {cells} cells half thickness, compliance off by"
        );
        rows.push(Row::near(name, off, 0.0, 0.5, "%"));
    }
    Ok(())
}

/// A disc of pressure on the end of a clamped cylinder, whose last layer of cells is full or filled in part.
fn disc(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let sizes: &[(f64, f64)] = if quick { &[(3.0, 9.0)] } else { &[(3.0, 9.0), (4.0, 6.0), (6.0, 3.0)] };
    for (per_radius, bound) in sizes {
        let work = disc_of_pressure(*per_radius, 1.0)?;
        let name = |of: &str| {
            format!("surfaces: disc of pressure on a cylinder, nu = 0.3, a/dx = {per_radius}, {of}")
        };
        rows.push(Row::within(name("work"), work, DISC, *bound, "p^2/E"));
        let mut worst = work;
        for fill in [0.1, 0.3, 0.49, 0.7, 0.9] {
            let work = disc_of_pressure(*per_radius, fill)?;
            let off = |work: f64| (work / DISC - 1.0).abs();
            worst = if off(work) > off(worst) { work } else { worst };
        }
        let of = "last layer filled to 0.1 to 0.9, worst";
        rows.push(Row::within(name(of), worst, DISC, bound + 5.0, "p^2/E"));
    }
    Ok(())
}

/// Work of the pressure, with the last layer of cells below it filled to that part.
fn disc_of_pressure(per_radius: f64, fill: f64) -> Result<f64, String> {
    const RADIUS: f64 = 0.25;
    let spacing = RADIUS / per_radius;
    let cylinder = CylinderShape::new(Axis::Z, 1.0, 1.0, Vec3::zeros()).map_err(|e| e.to_string())?;
    let ends = [(cylinder.bounds().min.z, Side::Below), (cylinder.bounds().max.z, Side::Above)];
    // The lattice has whole layers in the cylinder alone. Where that gets longer below by 2 s spacings, the lattice moves down
    // by s, with one more layer for each half: s of the last layer above are filled (s > 1/2), 1/2 - s of that below (s < 1/2).
    let above = fill > 0.5;
    let more = if above { fill.fract() } else { 0.5 - fill };
    let shape = Placed { shape: Arc::new(cylinder), more: 2.0 * spacing * more * Vec3::z() };
    let ((held, side), (loaded, _)) = if above { (ends[0], ends[1]) } else { (ends[1], ends[0]) };
    let boundaries = vec![hold(Region::Plane { axis: Axis::Z, at: held, side }, Fix::ALL)];
    let (centre, facing) = (Vec3::new(0.0, 0.0, loaded), (loaded - held).signum() * Vec3::z());
    let region = Region::SurfacePatch { centre, radius: RADIUS, facing };
    let loads = vec![LoadKind::Pressure { region, pressure: 1.0 }];
    let (_, found) = Case { shape: Arc::new(shape), spacing, nu: 0.3, boundaries, loads }.solve()?;
    Ok(found.compliance)
}
