//! How the time of a solid advances, from what the user asked for and what is stable.

use super::checks::{about_incompressibility, incompressibility};
use crate::error::InvalidInput;
use crate::setup::{Scheme, Setup, SolidSetup, TimeStep, Units};
use crate::stability::{SAFETY, StepLimit};

/// How many times dearer than the waves ask for the viscosity may make RK4 before another scheme is chosen.
const DEARER: f64 = 100.0;
/// First step of an implicit scheme that chooses its steps, as a share of the relaxation time.
const FIRST: f64 = 0.05;
/// Its shortest step, in stability limits of RK4.
const SHORTEST: f64 = 4.0;

/// How time advances.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    /// The scheme, never `Auto`.
    pub scheme: Scheme,
    /// Time step, or the first of them.
    pub dt: f64,
    /// The shortest step worth taking, of a scheme that chooses its steps.
    pub adaptive: Option<f64>,
    /// Why this scheme, if the user left the choice open and it is not the paper's.
    pub reason: Option<String>,
    /// What to tell the user.
    pub notes: Vec<String>,
}

/// The scheme, its time step, and what to tell the user about them. `solvable`: there is a stiffness
/// to solve with.
///
/// # Errors
/// `time.dt` when it is not positive, above the limit, or "auto" without a limit; `time.integrator` when
/// the formulation or the material has nothing for it.
pub(super) fn choose_pace<M>(
    setup: &Setup<M>,
    solid: &SolidSetup,
    limit: &StepLimit,
    solvable: bool,
) -> Result<Pace, InvalidInput> {
    let relaxation_time = solid.relaxation_time();
    let dearer = limit.wave / limit.dt;
    let asked = setup.integration.scheme;
    let mut reason = None;
    let scheme = match asked {
        Scheme::Auto if solvable && dearer > DEARER && !asks_for_less(setup, limit) => {
            reason = Some(format!(
                "viscosity would make the steps of rk4 {dearer:.0} times shorter than waves do"
            ));
            Scheme::Sdirk2
        }
        Scheme::Auto => Scheme::Rk4,
        other => other,
    };
    if scheme.is_implicit() && !solvable {
        return Err(InvalidInput::new(
            "time.integrator",
            scheme.name(),
            "needs the stiffness of the adjoint formulation, which this formulation does not have",
            "take `integrator = \"rk4\"`",
        ));
    }
    if scheme == Scheme::Rkc2 && !limit.viscous {
        return Err(InvalidInput::new(
            "time.integrator",
            scheme.name(),
            "is for bodies whose viscosity limits the time step; here it is the wave speed",
            "take `integrator = \"rk4\"` or \"sdirk2\"",
        ));
    }
    if scheme == Scheme::Rk4 {
        let (dt, notes) = choose_step(setup, limit, incompressibility(solid))?;
        return Ok(Pace { scheme, dt, adaptive: None, reason, notes });
    }
    let notes = Vec::new();
    let shortest = SHORTEST * limit.dt;
    match setup.time_step {
        TimeStep::Fixed(dt) if dt.is_finite() && dt > 0.0 => {
            Ok(Pace { scheme, dt, adaptive: None, reason, notes })
        }
        _ => {
            // Whatever is wrong for RK4 is wrong here.
            choose_step(setup, limit, incompressibility(solid))?;
            let dt = (FIRST * relaxation_time).max(shortest);
            let adaptive = (scheme == Scheme::Sdirk2).then_some(shortest);
            Ok(Pace { scheme, dt, adaptive, reason, notes })
        }
    }
}

/// Whether the user gave a time step that RK4 can take.
fn asks_for_less<M>(setup: &Setup<M>, limit: &StepLimit) -> bool {
    matches!(setup.time_step, TimeStep::Fixed(dt) if dt <= limit.dt || setup.allow_unstable)
}

/// Refuses every scheme but that of the paper for a body of that `kind`.
///
/// # Errors
/// `time.integrator`.
pub(super) fn only_rk4<M>(setup: &Setup<M>, kind: &str) -> Result<(), InvalidInput> {
    let scheme = setup.integration.scheme;
    if matches!(scheme, Scheme::Auto | Scheme::Rk4) {
        return Ok(());
    }
    Err(InvalidInput::new(
        "time.integrator",
        scheme.name(),
        format!("is for solids in space, not for {kind}"),
        "take `integrator = \"rk4\"` or leave it out",
    ))
}

/// The time step of RK4, and what to tell the user about it; `incompressible` is [`incompressibility`] of the material.
///
/// # Errors
/// `time.dt`.
pub(super) fn choose_step<M>(
    setup: &Setup<M>,
    limit: &StepLimit,
    incompressible: Option<f64>,
) -> Result<(f64, Vec<String>), InvalidInput> {
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
                let why = incompressible
                    .map_or_else(String::new, |ratio| format!("; {}", about_incompressibility(ratio)));
                Err(InvalidInput::new(
                    "time.dt",
                    dt,
                    format!(
                        "is above the stability limit {:.4e}{unit}, which is set by {cause}{why}",
                        limit.dt
                    ),
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

/// The time step after what is stable has become `limit`: a given one as long as it is stable.
pub(super) fn step_within<M>(setup: &Setup<M>, limit: &StepLimit) -> f64 {
    match setup.time_step {
        TimeStep::Fixed(dt) if dt <= limit.dt || setup.allow_unstable => dt,
        TimeStep::Fixed(_) | TimeStep::Auto => SAFETY * limit.dt,
    }
}
