//! Thick walls inflated by a pressure that follows them, against the exact radial solution.

use super::setup;
use crate::Row;
use crate::surfaces::case::{hold, read, symmetry};
use crate::surfaces::meshes::{ellipse, hollow, shape_of, tube};
use crate::surfaces::walls::{SIDES, inner_wall};
use rsph_core::error::InvalidInput;
use rsph_core::material::{self, Material, NeoHookean};
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Curve, Fix, Load, LoadKind, SolidSetup, Solver, VectorField};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// Radii of the walls.
const RADII: [f64; 2] = [1.0, 2.0];
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

/// The tube with fibres wound around its axis, of the material of `fibres`, at a hoop stretch of 1.1.
const WOUND: [Exact; 3] = [
    (0.3, 1.75032, 0.08416921, [3.778209, 1.184686]),
    (0.45, 1.989811, 0.06122572, [4.393423, 1.384438]),
    (0.49, 2.071537, 0.05379741, [4.635297, 1.449043]),
];

/// An eighth of a hollow sphere and a quarter of a tube in plane strain; bounds of issue 17.
pub(super) fn walls(quick: bool, rows: &mut Vec<Row>) -> Result<(), String> {
    let exact: [(Wall, f64, &[Exact]); 3] =
        [(Wall::Sphere, 0.2, &SPHERE), (Wall::Tube, 0.2, &TUBE), (Wall::WoundTube, 0.1, &WOUND)];
    for (wall, inner, cases) in exact {
        for case in cases {
            if !quick || case.0.to_bits() == 0.45_f64.to_bits() {
                inflate(wall, inner, case, rows)?;
            }
        }
    }
    Ok(())
}

/// What is inflated.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wall {
    Sphere,
    Tube,
    WoundTube,
}

/// A neo-Hookean ground of mu = 3.5 with two families of fibres along one direction.
fn fibres(nu: f64) -> Result<Arc<dyn Material>, InvalidInput> {
    let model = material::model("holzapfel-gasser-ogden").expect("one of the models");
    model.make(|key| match key {
        "density" | "k2" => Some(vec![1.0]),
        "shear_modulus" => Some(vec![3.5]),
        "k1" => Some(vec![10.0]),
        "dispersion" => Some(vec![0.1]),
        "fibre" => Some(vec![1.0, 0.0, 0.0]),
        "poisson_ratio" => Some(vec![nu]),
        _ => None,
    })
}

/// Rows of a wall at an exact displacement of its inner side.
fn inflate(
    what: Wall,
    inner: f64,
    (nu, pressure, outer, hoops): &Exact,
    rows: &mut Vec<Row>,
) -> Result<(), String> {
    let ([a, b], spacing) = (RADII, (RADII[1] - RADII[0]) / ACROSS);
    let thick = 4.0 * spacing;
    let is_sphere = what == Wall::Sphere;
    let mut boundaries = [Axis::X, Axis::Y, Axis::Z].map(symmetry).to_vec();
    let (mesh, region) = if is_sphere {
        // The inner wall is nearer to the centre than the middle of the wall.
        (hollow(a, b, 6), Region::Ball { centre: Vec3::zeros(), radius: 0.5 * (a + b) })
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
    let (name, material, fibres) = match what {
        Wall::Sphere | Wall::Tube => {
            let law = NeoHookean::new(1.0, 10.0, *nu, 0.0).map(|law| Arc::new(law) as Arc<dyn Material>);
            (if is_sphere { "hollow sphere" } else { "tube" }, law, None)
        }
        Wall::WoundTube => {
            let around = VectorField::Rotation { rate: Vec3::z(), centre: Vec3::zeros() };
            ("tube of wound fibres", fibres(*nu), Some(around))
        }
    };
    setup.mechanics = SolidSetup {
        fibres,
        boundaries,
        loads: vec![Load {
            kind: LoadKind::FollowerPressure { region, pressure: *pressure },
            curve: Curve::default(),
        }],
        ..SolidSetup::new(material.map_err(|e| e.to_string())?)
    };
    let name_of = |of: &str| format!("finite strain: inflated {name}, nu = {nu}, {of}");
    let mut body = Simulation::new(setup).map_err(|e| e.to_string())?;
    body.solve_static(0.0, &mut |_, _| true).map_err(|e| format!("{}: {e}", name_of("rest")))?;
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
    for (wall, (which, exact)) in [("inner", inner), ("outer", *outer)].into_iter().enumerate() {
        let mean = moved[wall].0 / moved[wall].1;
        rows.push(Row::within(
            name_of(&format!("mean displacement of the {which} wall")),
            mean,
            exact,
            2.0,
            "1",
        ));
        let of = format!("hoop stress at the {which} wall off at most");
        rows.push(Row::at_most(name_of(&of), 100.0 * worst_hoop[wall], 5.0, "%"));
    }
    rows.push(Row::at_most(
        name_of("radial stress at the walls off at most"),
        100.0 * worst_radial,
        5.0,
        "% of p",
    ));
    Ok(())
}
