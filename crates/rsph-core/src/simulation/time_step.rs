//! The time step of a solid, from what the user asked for and what is stable.

use crate::error::InvalidInput;
use crate::setup::{Setup, TimeStep, Units};
use crate::stability::{SAFETY, StepLimit};

/// The time step, and what to tell the user about it.
///
/// # Errors
/// `time.dt` when it is not positive, above the limit, or "auto" without a limit.
pub(super) fn choose_step(setup: &Setup, limit: &StepLimit) -> Result<(f64, Vec<String>), InvalidInput> {
    let cause = if limit.viscous { "viscosity (dt ~ dx^2 rho / (E T))" } else { "wave speed (dt ~ dx / c)" };
    let unit = if setup.units == Units::Si { " s" } else { "" };
    match setup.time_step {
        TimeStep::Auto => {
            if limit.dt.is_finite() && limit.dt > 0.0 {
                Ok((SAFETY * limit.dt, Vec::new()))
            } else {
                Err(InvalidInput::new(
                    "time.dt",
                    "auto",
                    "the body has no stiffness from which a time step follows (every particle is held, \
                     or there is only one)",
                    "give `time.dt` a number, or choose a smaller spacing",
                ))
            }
        }
        TimeStep::Fixed(dt) if !(dt.is_finite() && dt > 0.0) => Err(InvalidInput::new(
            "time.dt",
            dt,
            "must be a positive number",
            "`dt = \"auto\"` takes 0.9 of the stability limit",
        )),
        TimeStep::Fixed(dt) if dt > limit.dt => {
            if setup.allow_unstable {
                Ok((
                    dt,
                    vec![format!(
                        "dt = {dt:.3e}{unit} is above the stability limit {:.3e}{unit}, set by {cause}; \
                         the run will blow up",
                        limit.dt
                    )],
                ))
            } else {
                Err(InvalidInput::new(
                    "time.dt",
                    dt,
                    format!("is above the stability limit {:.4e}{unit}, which is set by {cause}", limit.dt),
                    format!(
                        "take `dt = \"auto\"` or at most {:.4e}{unit}; `time.allow_unstable = true` lets \
                         you try",
                        limit.dt
                    ),
                ))
            }
        }
        TimeStep::Fixed(dt) => Ok((dt, Vec::new())),
    }
}
