//! The clamped cube of section 5.2 turned against its lattice, its lower face held by a half-space with an oblique plane.

use super::super::Row;
use super::super::case::{TENSILE_LIVER, setup};
use super::CUBE;
use super::phases::Placed;
use rsph_core::region::Region;
use rsph_core::sample::Resolution;
use rsph_core::setup::{LoadKind, Quantity};
use rsph_core::shape::{BoxShape, MeshShape, Shape};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// Particles along an edge of the cube, and the bounds (%).
const SIZES: [(usize, f64); 2] = [(7, 0.5), (13, 0.25)];
/// Positions of the lattice, in spacings.
const PHASES: [[f64; 3]; 4] = [[0.0; 3], [0.05, 0.14, 0.26], [0.1, 0.27, 0.53], [0.14, 0.41, 0.79]];
/// Axes of the turn by 30 degrees, and what they are called.
const AXES: [([f64; 3], &str); 2] = [([0.0, 1.0, 0.0], "y"), ([1.0, 2.0, 0.5], "(1, 2, 0.5)")];

pub(super) fn run() -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for (axis, name) in AXES {
        for (n, bound) in SIZES {
            let mut worst = 0.0_f64;
            for phase in PHASES {
                let off = turned(&Vec3::from(axis), n, &Vec3::from(phase))? / CUBE - 1.0;
                worst = if off.abs() > worst.abs() { off } else { worst };
            }
            let name = format!("equilibrium: cube {n}^3 turned by 30 degrees about {name}, E u off at most");
            rows.push(Row::near(name, 100.0 * worst, 0.0, bound, "%"));
        }
    }
    Ok(rows)
}

/// E u of the cube turned by 30 degrees about `axis`.
fn turned(axis: &Vec3, n: usize, phase: &Vec3) -> Result<f64, String> {
    let (a, angle) = (axis.normalize(), 30.0_f64.to_radians());
    let turn = Mat3::identity() * angle.cos()
        + a.cross_matrix() * angle.sin()
        + a * a.transpose() * (1.0 - angle.cos());
    let spacing = 1.0 / n as f64;
    let mut surface =
        BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).map_err(|e| e.to_string())?.surface().clone();
    surface.vertices.iter_mut().for_each(|x| *x = turn * *x);
    let (shape, _) = MeshShape::new(&surface, "turned box").map_err(|e| e.to_string())?;

    let (mut setup, until) = setup(TENSILE_LIVER, &["solver.smoothing=0.8".into()])?;
    setup.shape = Arc::new(Placed { shape: Arc::new(shape), more: 2.0 * spacing * phase });
    setup.resolution = Resolution::Spacing(spacing);
    let up = turn * Vec3::z();
    let top = Region::HalfSpace { point: up, normal: -up };
    let solid = setup.solid_mut().ok_or("no solid")?;
    solid.boundaries[0].region = Region::HalfSpace { point: Vec3::zeros(), normal: up };
    solid.loads[0].kind = LoadKind::Traction { region: top.clone(), traction: up };
    // The mean over the face: particles above a plane through their centres would be another mean.
    let facing = Region::SurfacePatch { centre: up, radius: 2.0, facing: up };
    setup.probes[0].region = Region::And(vec![facing, top]);
    setup.probes[0].quantity = Quantity::parse("displacement").ok_or("no displacement")?;
    setup.time_step = rsph_core::setup::TimeStep::Auto;
    let mut cube = Simulation::new(setup).map_err(|e| e.to_string())?;
    cube.solve_static(until, &mut |_, _| true).map_err(|e| e.to_string())?;
    let u: Vec<f64> = cube.readings().iter().map(|r| r.value).collect();
    Ok(100.0 * Vec3::from_column_slice(&u).dot(&up))
}
