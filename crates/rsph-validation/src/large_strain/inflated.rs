//! Thick walls inflated by a pressure that follows them, against the exact radial solution.

use super::setup;
use crate::Row;
use crate::surfaces::case::{hold, read, symmetry};
use crate::surfaces::meshes::{ellipse, hollow, shape_of, tube};
use crate::surfaces::walls::{SIDES, inner_wall};
use rsph_core::material::NeoHookean;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Curve, Fix, Load, LoadKind, SolidSetup, Solver};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// Radii of the walls.
const RADII: [f64; 2] = [1.0, 2.0];
/// Displacement of the inner wall: a hoop stretch of 1.2.
const INNER: f64 = 0.2;
/// Particles across the wall.
const ACROSS: f64 = 8.0;
/// Poisson's ratio, pressure, displacement of the outer wall and Cauchy hoop stress at both walls
/// (validation/references/inflated_walls.py).
type Exact = (f64, f64, f64, [f64; 2]);
const SPHERE: [Exact; 4] = [
    (0.3, 1.71265, 0.0826385, [1.78985, 0.561162]),
    (0.45, 1.627256, 0.0644691, [1.64625, 0.562706]),
    (0.49, 1.605813, 0.0600057, [1.60309, 0.564254]),
    (0.499, 1.601059, 0.0590229, [1.593077, 0.564681]),
];
const TUBE: [Exact; 4] = [
    (0.3, 0.8243895, 0.13199, [1.806388, 0.706624]),
    (0.45, 0.7875327, 0.1136528, [1.729974, 0.696755]),
    (0.49, 0.7797367, 0.1084502, [1.711774, 0.696811]),
    (0.499, 0.7780811, 0.107263, [1.707734, 0.696975]),
];

/// An eighth of a hollow sphere and a quarter of a tube in plane strain; bounds of issue 17.
pub(super) fn walls(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    for (name, cases) in [("hollow sphere", SPHERE), ("tube", TUBE)] {
        for exact in cases {
            if !quick || exact.0 == 0.45 {
                wall(name, &exact, rows)?;
            }
        }
    }
    Ok(())
}

fn wall(what: &str, (nu, pressure, outer, hoops): &Exact, rows: &mut Vec<Row>) -> Result<(), String> {
    let ([a, b], spacing) = (RADII, (RADII[1] - RADII[0]) / ACROSS);
    let thick = 4.0 * spacing;
    let is_sphere = what == "hollow sphere";
    let mut boundaries = [Axis::X, Axis::Y, Axis::Z].map(symmetry).to_vec();
    let (mesh, region) = if is_sphere {
        // The inner wall is nearer to the centre than the middle of the wall.
        (hollow(a, b, 5), Region::Ball { centre: Vec3::zeros(), radius: 0.5 * (a + b) })
    } else {
        boundaries.push(hold(Region::Plane { axis: Axis::Z, at: thick, side: Side::Above }, Fix::Normal));
        (tube(ellipse([a; 2], SIDES), ellipse([b; 2], SIDES), thick, SIDES), inner_wall(a, b, spacing))
    };
    let cube =
        rsph_core::shape::BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).map_err(|e| e.to_string())?;
    let mut setup = setup(cube, 1);
    setup.shape = shape_of(&mesh).map_err(|e| e.to_string())?;
    setup.resolution = Resolution::Spacing(spacing);
    setup.solver = Solver::ACCURATE;
    setup.mechanics = SolidSetup {
        foundations: Vec::new(),
        material: Arc::new(NeoHookean::new(1.0, 10.0, *nu, 0.0).map_err(|e| e.to_string())?),
        boundaries,
        loads: vec![Load {
            kind: LoadKind::FollowerPressure { region, pressure: *pressure },
            curve: Curve::default(),
        }],
    };
    let name = |of: &str| format!("finite strain: inflated {what}, nu = {nu}, {of}");
    let mut body = Simulation::new(setup).map_err(|e| e.to_string())?;
    body.solve_static(0.0, &mut |_, _| true).map_err(|e| format!("{}: {e}", name("rest")))?;
    let (mut moved, mut worst_hoop, mut worst_radial) = ([(0.0, 0.0); 2], [0.0_f64; 2], 0.0_f64);
    for vertex in read(&mut body, 1.0) {
        let x = if is_sphere { vertex.x } else { Vec3::new(vertex.x.x, vertex.x.y, 0.0) };
        let (r, n) = (x.norm(), x.normalize());
        let wall = usize::from(r > 0.5 * (a + b));
        let margin = 1.5 * spacing;
        let near_cut = x.x < margin || x.y < margin || (is_sphere && x.z < margin);
        if near_cut || (r - RADII[wall]).abs() > 0.1 * spacing {
            continue;
        }
        let along = Vec3::z().cross(&n).normalize();
        let hoop = along.dot(&vertex.stress.dot(&along));
        let radial = n.dot(&vertex.stress.dot(&n));
        let exact = [-pressure, 0.0][wall];
        moved[wall] = (moved[wall].0 + vertex.area * vertex.u.dot(&n), moved[wall].1 + vertex.area);
        worst_hoop[wall] = worst_hoop[wall].max((hoop / hoops[wall] - 1.0).abs());
        worst_radial = worst_radial.max((radial - exact).abs() / pressure);
    }
    for (wall, (which, exact)) in [("inner", INNER), ("outer", *outer)].into_iter().enumerate() {
        let mean = moved[wall].0 / moved[wall].1;
        rows.push(Row::within(
            name(&format!("mean displacement of the {which} wall")),
            mean,
            exact,
            2.0,
            "1",
        ));
        let of = format!("hoop stress at the {which} wall off at most");
        rows.push(Row::at_most(name(&of), 100.0 * worst_hoop[wall], 5.0, "%"));
    }
    rows.push(Row::at_most(
        name("radial stress at the walls off at most"),
        100.0 * worst_radial,
        5.0,
        "% of p",
    ));
    Ok(())
}
