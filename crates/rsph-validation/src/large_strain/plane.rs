//! Benchmarks of plane strain that others have solved: Cook's membrane, and the elastic beam behind a cylinder of S. Turek and J. Hron
//! (2006) without the fluid, CSM1 to CSM3.

use super::{beyond, held, setup};
use crate::Row;
use rsph_core::material::{Material, NeoHookean, SaintVenantKirchhoff};
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{
    Curve, Integration, Load, LoadKind, Probe, Quantity, Scheme, Setup, SolidSetup, Solver, TimeStep,
};
use rsph_core::shape::PolygonShape;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// Displacement of the upper right corner of Cook's membrane by mixed finite elements (validation/large_strain/cook.csv, the finest mesh;
/// what two meshes differ by says that .001 to .004 are missing).
const COOK: [(f64, f64); 3] = [(0.3, 7.778294), (0.49, 6.984166), (0.4999, 6.923939)];

/// Cook's membrane by a dead shear of 100/16 at its end; bounds of our own.
pub(super) fn cook(quick: bool) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for (nu, exact) in COOK {
        for (spacing, percent) in [(2.0, 1.0), (1.0, 0.5), (0.5, 0.25)] {
            if quick && (spacing < 2.0 || nu > 0.49) {
                continue;
            }
            let corners = [[0.0, 0.0], [48.0, 44.0], [48.0, 60.0], [0.0, 44.0]];
            let material = NeoHookean::new(1.0, 240.565, nu, 0.0).map_err(|e| e.to_string())?;
            let mut membrane = body(&corners, spacing, Arc::new(material), Vec3::new(48.0, 60.0, 0.0))?;
            membrane.mechanics.boundaries.push(held(beyond(Axis::X, 0.0, Side::Below), None));
            let kind = LoadKind::Traction {
                region: beyond(Axis::X, 48.0, Side::Above),
                traction: Vec3::y() * (100.0 / 16.0),
            };
            membrane.mechanics.loads.push(Load { kind, curve: Curve::default() });
            let tip = at_rest(membrane)?;
            let name = format!("finite strain: Cook's membrane, nu = {nu}, {} across", 44.0 / spacing);
            rows.push(Row::within(name, tip.y, exact, percent, "m"));
        }
    }
    Ok(rows)
}

/// CSM1 and CSM2: Young's modulus (Pa) and the displacement of the tip (m).
const CSM: [(&str, f64, [f64; 2]); 2] =
    [("CSM1", 1.4e6, [-7.187e-3, -66.10e-3]), ("CSM2", 5.6e6, [-0.469e-3, -16.97e-3])];
/// CSM3: mean and amplitude of the displacement of the tip (m) along x and y, and the frequency (Hz).
const CSM3: ([[f64; 2]; 2], f64) = ([[-14.305e-3, 14.305e-3], [-63.607e-3, 65.160e-3]], 1.0995);
/// Time step of CSM3 (s).
const STEP: f64 = 0.005;
/// End of CSM3 (s), as in the reference; its last period counts.
const UNTIL: f64 = 10.0;

/// The beam under its own weight: at rest, and swinging from rest. Bounds of issue 16.
pub(super) fn beam(quick: bool) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for (across, percent) in [(10, 2.0), (20, 1.0)] {
        if quick && across > 10 {
            continue;
        }
        for (name, young_modulus, exact) in CSM {
            let tip = at_rest(beam_of(across, young_modulus)?)?;
            for (i, axis) in ["x", "y"].into_iter().enumerate() {
                let name = format!("finite strain: {name}, {across} across, u_{axis}");
                rows.push(Row::within(name, tip[i], exact[i], percent, "m"));
            }
        }
        if quick {
            continue;
        }
        let (found, frequency) = swing(beam_of(across, CSM[0].1)?)?;
        for (i, axis) in ["x", "y"].into_iter().enumerate() {
            for (k, which) in ["mean", "amplitude"].into_iter().enumerate() {
                let name = format!("finite strain: CSM3, {across} across, {which} of u_{axis}");
                rows.push(Row::within(name, found[i][k], CSM3.0[i][k], percent, "m"));
            }
        }
        let name = format!("finite strain: CSM3, {across} across, frequency");
        rows.push(Row::within(name, frequency, CSM3.1, percent, "Hz"));
    }
    Ok(rows)
}

/// The beam of length 0.35 and thickness 0.02 on a cylinder of radius 0.05 around (0.2, 0.2), which holds it.
fn beam_of(across: usize, young_modulus: f64) -> Result<Setup<SolidSetup>, String> {
    let pieces = 8;
    let on_cylinder = |k: usize| {
        let y = 0.21 - 0.02 * k as f64 / f64::from(pieces);
        [0.2 + (0.05_f64.powi(2) - (y - 0.2).powi(2)).sqrt(), y]
    };
    let mut corners: Vec<[f64; 2]> = (0..=pieces as usize).map(on_cylinder).collect();
    corners.extend([[0.6, 0.19], [0.6, 0.21]]);
    let material = SaintVenantKirchhoff::new(1000.0, young_modulus, 0.4, 0.0).map_err(|e| e.to_string())?;
    let mut beam = body(&corners, 0.02 / across as f64, Arc::new(material), Vec3::new(0.6, 0.2, 0.0))?;
    let end =
        Region::SurfacePatch { centre: Vec3::new(0.2495, 0.2, 0.0), radius: 0.0105, facing: -Vec3::x() };
    beam.mechanics.boundaries.push(held(end, None));
    let kind = LoadKind::BodyForce { region: Region::All, acceleration: -2.0 * Vec3::y() };
    beam.mechanics.loads.push(Load { kind, curve: Curve::default() });
    Ok(beam)
}

/// A polygon with a probe of the displacement at a point.
fn body(
    corners: &[[f64; 2]],
    spacing: f64,
    material: Arc<dyn Material>,
    at: Vec3,
) -> Result<Setup<SolidSetup>, String> {
    let quantity = Quantity::parse("displacement").ok_or("no such quantity")?;
    let shape = PolygonShape::new(corners).map_err(|e| e.to_string())?;
    Ok(Setup {
        resolution: Resolution::Spacing(spacing),
        mechanics: SolidSetup::new(material),
        solver: Solver::ACCURATE,
        probes: vec![Probe { name: "tip".into(), quantity, region: Region::Point(at) }],
        ..setup(shape, 1)
    })
}

/// What the probe reads.
pub(super) fn tip(body: &mut Simulation) -> Vec3 {
    Vec3::from_iterator(body.readings().iter().map(|r| r.value))
}

fn at_rest(setup: Setup<SolidSetup>) -> Result<Vec3, String> {
    let mut body = Simulation::new(setup).map_err(|e| e.to_string())?;
    body.solve_static(0.0, &mut |_, _| true).map_err(|e| e.to_string())?;
    Ok(tip(&mut body))
}

/// Mean and amplitude of the tip along x and y in the last period, by parabolas through the turns, and the frequency.
fn swing(setup: Setup<SolidSetup>) -> Result<([[f64; 2]; 2], f64), String> {
    let integration = Integration { scheme: Scheme::Sdirk2, ..setup.integration };
    let setup = Setup { integration, time_step: TimeStep::Fixed(STEP), ..setup };
    let mut body = Simulation::new(setup).map_err(|e| e.to_string())?;
    let mut path = vec![tip(&mut body)];
    let steps = (UNTIL / STEP).round() as usize;
    for k in 1..=steps {
        body.advance_to(k as f64 * STEP, &mut |_| true).map_err(|e| e.to_string())?;
        path.push(tip(&mut body));
    }
    // Time and value of the vertex of the parabola through three readings around each turn.
    let turns = |axis: usize, sign: f64| -> Vec<(f64, f64)> {
        let at = |k: usize| sign * path[k][axis];
        (1..steps)
            .filter(|&k| at(k) >= at(k - 1) && at(k) > at(k + 1))
            .map(|k| {
                let (slope, bend) = (0.5 * (at(k + 1) - at(k - 1)), at(k + 1) - 2.0 * at(k) + at(k - 1));
                let shift = -slope / bend;
                (STEP * (k as f64 + shift), sign * (at(k) + 0.5 * slope * shift))
            })
            .collect()
    };
    let lows = turns(1, -1.0);
    let (Some(first), Some(last)) = (lows.first(), lows.last()) else { return Err("no swing".into()) };
    let period = (last.0 - first.0) / (lows.len() - 1) as f64;
    let extreme = |axis: usize, sign: f64| {
        let values = turns(axis, sign).into_iter().filter(|turn| turn.0 > UNTIL - 1.05 * period);
        sign * values.map(|turn| sign * turn.1).fold(f64::NEG_INFINITY, f64::max)
    };
    let of = |axis: usize| {
        let (low, high) = (extreme(axis, -1.0), extreme(axis, 1.0));
        [0.5 * (high + low), 0.5 * (high - low)]
    };
    Ok(([of(0), of(1)], 1.0 / period))
}
