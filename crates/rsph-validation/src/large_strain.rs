//! Solids at finite strain, with and without remeshing: a cube, a plane block and a liver at rest against finite
//! elements, inflated walls against exact solutions, columns that twist and bend, a disc and a ball that spin freely.

mod column;
mod inflated;
mod liver;
mod plane;
mod rest;
mod spin;

use super::Row;
use super::case::history;
use rsph_core::material::NeoHookean;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Boundary, Curve, Fix, Motion, Setup, SolidSetup, Units};
use rsph_core::shape::Shape;
use rsph_core::tensor::Vec3;
use std::path::Path;
use std::sync::Arc;

const BLOCK: (&str, &str) =
    ("block_large_strain.toml", include_str!("../../../scenarios/block_large_strain.toml"));

/// Extension of the block under the load of the scenario: finite elements (validation/large_strain).
const BLOCK_EXTENSION: f64 = 0.405546;

pub(super) fn run(quick: bool, _folder: &Path) -> Result<Vec<Row>, String> {
    let mut rows = rest::cube(quick)?;
    rows.extend(rest::block(quick)?);
    if super::liver::is_there() {
        liver::rows(quick, &mut rows)?;
    }
    inflated::walls(quick, &mut rows)?;
    rows.extend(plane::cook(quick)?);
    rows.extend(plane::beam(quick)?);
    rows.extend(column::column(quick)?);
    rows.extend(spin::disc(quick)?);
    rows.extend(spin::ball(quick)?);
    if !quick {
        let block = history(BLOCK, &[])?;
        let name = "finite strain: block_large_strain.toml at rest";
        rows.push(Row::within(name, block.last(), BLOCK_EXTENSION, 0.5, "extension"));
    }
    Ok(rows)
}

/// A body of E = 10, nu = 0.3, rho = 1 without damping, at 1/`n` of a unit of length.
fn setup(shape: impl Shape + 'static, n: usize) -> Setup<SolidSetup> {
    Setup {
        units: Units::Normalised,
        ..Setup::new(
            Arc::new(shape),
            Resolution::Spacing(1.0 / n as f64),
            SolidSetup::new(Arc::new(NeoHookean::new(1.0, 10.0, 0.3, 0.0).expect("parameters in range"))),
        )
    }
}

/// The part of space beyond the plane at `at` across an axis.
fn beyond(axis: Axis, at: f64, side: Side) -> Region {
    Region::Plane { axis, at, side }
}

/// A face that is held, or moved by `displacement` from time 0 to 1.
fn held(region: Region, displacement: Option<Vec3>) -> Boundary {
    let curve = Curve::ramp(0.0, 1.0);
    let motion = displacement.map(|displacement| Motion::Curve { displacement, curve });
    Boundary { name: None, region, fix: Fix::ALL, motion }
}
