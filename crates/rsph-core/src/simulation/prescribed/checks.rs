//! What is refused before a prescribed motion starts, and its time step.

use crate::error::InvalidInput;
use crate::particles::Field;
use crate::setup::{Prescription, Setup, TimeStep};

/// A time step that is allowed turns or strains a particle by at most this much ...
pub const LARGEST_STRAIN: f64 = 1.0;
/// ... and one that the program chooses by this much.
const CHOSEN_STRAIN: f64 = 0.125;

/// Fields that the particles of a prescribed motion have.
const FIELDS: [Field; 6] =
    [Field::Displacement, Field::Velocity, Field::Mass, Field::Volume, Field::Colour, Field::Reference];

/// What a prescribed motion has no use for, and values out of range.
///
/// # Errors
/// The first of them.
pub fn check(setup: &Setup, p: &Prescription) -> Result<(), InvalidInput> {
    if setup.shape.dimension() == 2 {
        return Err(InvalidInput::new(
            "body.shape",
            setup.shape.name(),
            "is a plane body, and a prescribed motion has bodies in space only",
            "take a body in space such as a box",
        ));
    }
    if !(p.density.is_finite() && p.density > 0.0) {
        return Err(InvalidInput::new(
            "material.density",
            p.density,
            "must be a positive number",
            "1 is the default",
        ));
    }
    if !(p.iso > 0.0 && p.iso < 1.0) {
        return Err(InvalidInput::new(
            "dynamics.iso",
            p.iso,
            "the colour that makes the surface must lie between 0 and 1",
            "0.5 keeps the volume of a smooth body; thin sheets that the spacing hardly resolves need less",
        ));
    }
    if !(0.0..=8.0).contains(&p.band) {
        return Err(InvalidInput::new(
            "dynamics.band",
            p.band,
            "the half width of the colour's band must lie between 0 (a jump) and 8 spacings",
            "0 is good for thin sheets, 2 for a body that stays thick",
        ));
    }
    if let Some(period) = p.flow.reversal
        && !(period.is_finite() && period > 0.0)
    {
        return Err(InvalidInput::new(
            "dynamics.reversal",
            period,
            "the time after which everything is back in its place must be positive",
            "for example 1.257, or remove the key for a steady flow",
        ));
    }
    let strange = setup.probes.iter().position(|probe| !FIELDS.contains(&probe.quantity.field));
    if let Some(i) = strange {
        let field = setup.probes[i].quantity.field.spec().name;
        return Err(InvalidInput::new(
            format!("probe[{i}].quantity"),
            field,
            "the particles of a prescribed motion do not have this field",
            format!("choose one of {}", FIELDS.map(|f| f.spec().name).join(", ")),
        ));
    }
    Ok(())
}

/// The time step, at most `limit`.
///
/// # Errors
/// `time.dt` when it is above the limit, or "auto" and nothing limits it.
pub fn time_step(setup: &Setup, limit: f64) -> Result<f64, InvalidInput> {
    let refuse = |value: String, problem: String, remedy: &str| {
        Err(InvalidInput::new("time.dt", value, problem, remedy))
    };
    match setup.time_step {
        TimeStep::Auto if limit.is_finite() => Ok(CHOSEN_STRAIN * limit),
        TimeStep::Auto => refuse(
            "auto".into(),
            "the velocity is the same everywhere, so that no time step follows from it".into(),
            "give `time.dt` a number",
        ),
        TimeStep::Fixed(dt) if !(dt.is_finite() && dt > 0.0) => {
            refuse(dt.to_string(), "must be a positive number".into(), "`dt = \"auto\"` chooses one")
        }
        TimeStep::Fixed(dt) if dt > limit && !setup.allow_unstable => refuse(
            dt.to_string(),
            format!(
                "strains the body by more than {LARGEST_STRAIN} in one step; at most {limit:.4e} is allowed"
            ),
            "take `dt = \"auto\"`; `time.allow_unstable = true` lets you try",
        ),
        TimeStep::Fixed(dt) => Ok(dt),
    }
}
