//! An estimate of the memory that a run needs, against what is free.

use rsph_core::sample::Resolution;
use rsph_core::setup::{Formulation, Mechanics, RemeshTrigger, Setup};
use sysinfo::{MemoryRefreshKind, RefreshKind, System};

/// A body with more particles than the memory holds.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{particles:.2e} particles need about {:.1} GB of memory; {:.1} GB are free, for about {fits:.2e} particles",
    needed / 1e9, available / 1e9
)]
pub struct MemoryError {
    /// Particles asked for, about.
    pub particles: f64,
    /// Memory that they need (bytes).
    pub needed: f64,
    /// Memory that is free (bytes).
    pub available: f64,
    /// Particles that it holds.
    pub fits: f64,
}

impl MemoryError {
    /// What to do about it.
    pub fn remedy(&self) -> String {
        format!(
            "set `body.particles` to {:.0} or fewer (or a larger `body.spacing`), or free some memory",
            0.9 * self.fits
        )
    }
}

/// More particles than this are refused by the sampling, which says how many cells it can have.
const LEFT_TO_SAMPLING: f64 = 5e7;

/// Bytes a particle needs in a run, measured by the largest memory of runs of 1e4 to 1e6 particles, and rounded up:
/// remeshing takes more than steps do.
fn bytes_a_particle(setup: &Setup) -> f64 {
    let stays =
        setup.remesh.trigger == RemeshTrigger::Never && setup.solver.formulation == Formulation::Adjoint;
    match &setup.mechanics {
        Mechanics::Prescribed(_) | Mechanics::Interaction(_) => 4e3,
        Mechanics::Solid(_) if stays => 4e3,
        Mechanics::Solid(_) if setup.shape.is_box() => 9e3,
        Mechanics::Solid(_) => 17e3,
    }
}

/// Refuses a body that the free memory does not hold.
///
/// # Errors
/// How many particles it holds.
pub(super) fn check(setup: &Setup) -> Result<(), MemoryError> {
    let only = RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram());
    let available = System::new_with_specifics(only).available_memory() as f64;
    // 0: the system does not say.
    if available == 0.0 {
        return Ok(());
    }
    fits(setup, available)
}

fn fits(setup: &Setup, available: f64) -> Result<(), MemoryError> {
    let dimension = setup.shape.dimension() as i32;
    let particles = match setup.resolution {
        Resolution::Particles(n) => n as f64,
        Resolution::Spacing(dx) => setup.shape.volume() / dx.powi(dimension),
    };
    let each = bytes_a_particle(setup);
    let needed = particles * each;
    // What is not a number is refused elsewhere.
    if needed > available && particles < LEFT_TO_SAMPLING {
        return Err(MemoryError { particles, needed, available, fits: available / each });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::LoadedScenario;

    #[test]
    fn a_body_that_memory_does_not_hold_is_refused_with_the_number_that_fits() {
        let text = include_str!("../../../../scenarios/tensile_liver.toml");
        let sets = ["body.particles=1000000".to_owned()];
        let scenario = LoadedScenario::from_text("f.toml", text.into(), "".into(), &sets).unwrap();
        let setup = scenario.lower().unwrap().setup;
        assert!(fits(&setup, 4.1e9).is_ok());
        let error = fits(&setup, 1e9).unwrap_err();
        assert!((error.fits - 1e9 / 4e3).abs() < 1.0, "{error:?}");
        let message = format!("{error}; {}", error.remedy());
        assert!(
            message.contains("1.00e6 particles need about 4.0 GB") && message.contains("225000"),
            "{message}"
        );
    }
}
