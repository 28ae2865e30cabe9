//! Iterations of the static solver from zero to a residual of 1e-6 of the load, over numbers of particles,
//! smoothing lengths and Poisson's ratios.

use super::super::Row;
use super::super::case::LIVER_LOAD;
use super::solved;

/// Smoothing lengths, in spacings.
const SMOOTHING: [f64; 3] = [0.8, 1.0, 1.25];

pub(super) fn run(quick: bool) -> Result<Vec<Row>, String> {
    let counts: &[usize] = if quick { &[5_000] } else { &[5_000, 60_000, 500_000] };
    let mut rows = Vec::new();
    for particles in counts {
        for h in SMOOTHING {
            // The largest body takes its time: of Poisson's ratios the dearest that has a bound, and 0.49.
            let ratios: &[f64] = if *particles > 100_000 { &[0.45, 0.49] } else { &[0.0, 0.3, 0.45, 0.49] };
            for nu in ratios {
                let sets = [
                    format!("body.particles={particles}"),
                    format!("solver.smoothing={h}"),
                    format!("material.poisson_ratio={nu}"),
                    "probe=[]".into(),
                ];
                let (_, found) = solved(LIVER_LOAD, &sets)?;
                let most = if *nu > 0.45 { 40.0 } else { 20.0 };
                rows.push(Row::at_most(
                    format!("equilibrium: iterations, {particles} particles, h = {h} dx, nu = {nu}"),
                    found.iterations as f64,
                    most,
                    "1",
                ));
            }
        }
    }
    Ok(rows)
}
