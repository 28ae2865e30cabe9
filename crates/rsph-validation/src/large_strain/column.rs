//! A column that twists and one that bends from an initial velocity, beside finite elements in time.

use super::plane::tip;
use super::{beyond, held, setup};
use crate::Row;
use rsph_core::material::NeoHookean;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Probe, Quantity, Setup, Solver, VectorField};
use rsph_core::shape::BoxShape;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

const HEIGHT: f64 = 6.0;
/// Angular velocity (1/s) at the top of the twisted column, and velocity (m/s) there of the bent one.
const TWIST: f64 = 105.0;
const BEND: f64 = 10.0;

/// A column, where its displacement is compared, and with what.
struct Column {
    name: &'static str,
    /// At the start.
    velocity: fn(&Vec3) -> Vec3,
    place: Vec3,
    reference: &'static str,
}

/// Displacement of the column's top in time, against column_twist.csv and column_bend.csv; bounds of our own.
pub(super) fn column(quick: bool) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for (across, percent) in [(6, 5.0), (12, 2.0)] {
        if quick && across > 6 {
            continue;
        }
        let twisted = Column {
            name: "twisted",
            velocity: |x| (TWIST * (FRAC_PI_2 * x.z / HEIGHT).sin()) * Vec3::new(x.y, -x.x, 0.0),
            place: Vec3::new(0.25, 0.0, HEIGHT),
            reference: include_str!("../../../../validation/large_strain/column_twist.csv"),
        };
        let bending = Column {
            name: "bending",
            velocity: |x| (BEND * x.z / HEIGHT) * Vec3::x(),
            place: Vec3::new(0.0, 0.0, HEIGHT),
            reference: include_str!("../../../../validation/large_strain/column_bend.csv"),
        };
        for Column { name, velocity, place, reference } in [twisted, bending] {
            let name = format!("finite strain: {name} column, {across} across, displacement in time");
            let mut body = body(across, velocity, place).map_err(|e| format!("{name}: {e}"))?;
            let (mut off, mut size) = (0.0, 0.0);
            for [t, x, y, z] in rows_of(reference)? {
                let exact = Vec3::new(x, y, z);
                body.advance_to(t, &mut |_| true).map_err(|e| format!("{name}: {e}"))?;
                off += (tip(&mut body) - exact).norm_squared();
                size += exact.norm_squared();
            }
            rows.push(Row::at_most(name, 100.0 * (off / size).sqrt(), percent, "% in L2"));
        }
    }
    Ok(rows)
}

/// The column with its initial velocity and a probe at `place`.
fn body(across: usize, velocity: fn(&Vec3) -> Vec3, place: Vec3) -> Result<Simulation, String> {
    let size = Vec3::new(1.0, 1.0, HEIGHT);
    let shape = BoxShape::new(size, Vec3::new(-0.5, -0.5, 0.0)).map_err(|e| e.to_string())?;
    let quantity = Quantity::parse("displacement").ok_or("no such quantity")?;
    let mut column = Setup {
        resolution: Resolution::Spacing(1.0 / across as f64),
        solver: Solver::ACCURATE,
        probes: vec![Probe { name: "tip".into(), quantity, region: Region::Point(place) }],
        ..setup(shape, across)
    };
    column.mechanics.material =
        Arc::new(NeoHookean::new(1100.0, 17e6, 0.45, 0.0).map_err(|e| e.to_string())?);
    column.mechanics.boundaries.push(held(beyond(Axis::Z, 0.0, Side::Below), None));
    let of_all = move |x: &[Vec3]| x.iter().map(velocity).collect();
    column.initial.velocity = VectorField::Function(Arc::new(of_all));
    Simulation::new(column).map_err(|e| e.to_string())
}

/// Rows t, u_x, u_y, u_z.
fn rows_of(table: &str) -> Result<Vec<[f64; 4]>, String> {
    let rows: Result<_, _> = csv::Reader::from_reader(table.as_bytes()).deserialize().collect();
    rows.map_err(|e| e.to_string())
}
