//! What is refused before a simulation starts, whatever the body, and what ends it on the way.

use super::Description;
use super::model::Moment;
use crate::error::{Failure, FailureKind, InvalidInput};
use crate::material::Material;
use crate::measures::{MEASURES, is_measure};
use crate::setup::{Formulation, Probe, Scheme, Setup, SolidSetup, Solver};
use crate::tensor::Vec3;
use std::sync::Arc;

/// Share of the first time step below which remeshing may not bring it: such a run does not get anywhere.
pub(super) const SHORTEST_STEP: f64 = 1e-3;
/// Share of the mass that one remeshing may lose or make.
const MASS_LOSS: f64 = 0.01;
/// How many times stiffer against compression than against shear a material may be before it counts as nearly
/// incompressible: a Poisson's ratio of 0.49.
const NEARLY_INCOMPRESSIBLE: f64 = 50.0;

/// Settings of the solver that are out of range.
///
/// # Errors
/// `solver.smoothing` or `solver.hourglass`.
pub(super) fn check_solver(solver: &Solver) -> Result<(), InvalidInput> {
    if !(0.75..=2.0).contains(&solver.smoothing) {
        return Err(InvalidInput::new(
            "solver.smoothing",
            solver.smoothing,
            "must lie between 0.75 and 2 spacings: below that a particle has too few neighbours for a \
             gradient, above it detail is lost and cost grows with the third power",
            "the paper uses 1.25 (122 neighbours); 0.8 (26 neighbours) is as accurate and faster",
        ));
    }
    if !(0.0..=10.0).contains(&solver.hourglass) {
        return Err(InvalidInput::new(
            "solver.hourglass",
            solver.hourglass,
            "must lie between 0 (off) and 10",
            "1 is the default",
        ));
    }
    Ok(())
}

/// Measures of deformation and stress of a body that has none, fields that are none, and gauges on what is no solid.
///
/// # Errors
/// `output.fields`, `gauge` or `probe[i].quantity`.
pub(super) fn check_fields(setup: &Setup) -> Result<(), InvalidInput> {
    let has_measures = setup.solid().is_some() && setup.solver.formulation == Formulation::Adjoint;
    for field in &setup.fields {
        let name = field.spec().name;
        if !is_measure(*field) {
            let names: Vec<&str> = MEASURES.iter().map(|f| f.spec().name).collect();
            return Err(InvalidInput::new(
                "output.fields",
                name,
                "is in every frame of a body that has it",
                format!("remove it; what can be asked for: {}", names.join(", ")),
            ));
        }
        if !has_measures {
            return Err(InvalidInput::new(
                "output.fields",
                name,
                "is a field of a solid in the formulation \"adjoint\" only",
                "remove it",
            ));
        }
    }
    if setup.solid().is_none() && !setup.gauges.is_empty() {
        return Err(InvalidInput::new("gauge", "", "is for a solid only", "remove it, or read a probe"));
    }
    setup.probes.iter().enumerate().try_for_each(|(i, probe)| check_quantity(setup, i, probe))
}

/// A probe, number `i`, of a measure that the scheme of the paper does not have.
///
/// # Errors
/// `probe[i].quantity`.
pub(super) fn check_quantity<M>(setup: &Setup<M>, i: usize, probe: &Probe) -> Result<(), InvalidInput> {
    let field = probe.quantity.field;
    if setup.solver.formulation == Formulation::Paper && is_measure(field) {
        return Err(InvalidInput::new(
            format!("probe[{i}].quantity"),
            field.spec().name,
            "is a field of the formulation \"adjoint\" only",
            "read the strain or the stress, or take `formulation = \"adjoint\"`",
        ));
    }
    Ok(())
}

/// (lambda + 2 mu) / mu of the material for which it is largest, if that is nearly incompressible.
pub(super) fn incompressibility(solid: &SolidSetup) -> Option<f64> {
    let of = |m: &Arc<dyn Material>| m.p_wave_modulus() / m.shear_modulus();
    let ratio = solid.materials().map(of).fold(0.0, f64::max);
    (ratio > NEARLY_INCOMPRESSIBLE).then_some(ratio)
}

/// That a material is nearly incompressible, and what this means for the time step.
pub(super) fn about_incompressibility(ratio: f64) -> String {
    format!(
        "Poisson's ratio so near 0.5 makes the material {ratio:.0} times stiffer against compression than against \
         shear, and stable steps that much shorter"
    )
}

/// The failure with what has likely caused it, where the settings tell.
pub(super) fn with_cause(mut failure: Failure, setup: &Setup, d: &Description, dt: f64) -> Failure {
    if d.scheme == Scheme::Rk4 && dt > d.dt_limit * (1.0 + 1e-9) {
        let cause = if d.limited_by_viscosity { "viscosity" } else { "wave speed" };
        failure.what = format!(
            "{}; the time step {dt:.3e} is {:.1} times the stability limit {:.3e}, set by {cause}",
            failure.what,
            dt / d.dt_limit,
            d.dt_limit
        );
        if let Some(ratio) = setup.solid().and_then(incompressibility) {
            failure.what = format!("{}: {}", failure.what, about_incompressibility(ratio));
        }
        failure.remedy = "take `time.dt = \"auto\"`, and no `time.allow_unstable`".into();
    }
    failure
}

/// A particle, undeformed at `place`, that is turned inside out.
pub(super) fn inverted(place: Vec3, moment: Moment) -> Failure {
    Failure {
        kind: FailureKind::Inverted,
        time: moment.time,
        step: moment.step,
        what: "a particle was turned inside out (det F <= 0)".into(),
        place: Some(place),
        remedy:
            "load or move the body more slowly or less far, take a smaller `time.dt`, or a smaller spacing"
                .into(),
    }
}

/// A remeshing that has changed the mass.
pub(super) fn mass_lost(before: f64, after: f64, moment: Moment) -> Option<Failure> {
    let change = after / before - 1.0;
    (change.is_nan() || change.abs() > MASS_LOSS).then(|| Failure {
        kind: FailureKind::MassLost,
        time: moment.time,
        step: moment.step,
        what: format!(
            "remeshing has changed the mass from {before:.6e} to {after:.6e}: particles are too far apart"
        ),
        place: None,
        remedy: "remesh more often (`remesh.every`), or take a smaller spacing".into(),
    })
}

/// A time step that has become shorter than `shortest`.
pub(super) fn step_too_short(dt: f64, shortest: f64, moment: Moment) -> Option<Failure> {
    (dt.is_nan() || dt < shortest).then(|| Failure {
        kind: FailureKind::StepTooShort,
        time: moment.time,
        step: moment.step,
        what: format!(
            "the stable time step has fallen to {dt:.3e}: a part of the body is squeezed to nothing"
        ),
        place: None,
        remedy: "lower the loads, take a stiffer material or a larger spacing".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::KelvinVoigt;

    #[test]
    fn a_poisson_ratio_near_one_half_is_noticed() {
        let of = |nu: f64| {
            let material = Arc::new(KelvinVoigt::new(1.0, 100.0, nu, 0.1).unwrap());
            incompressibility(&SolidSetup::new(material))
        };
        assert!(of(0.3).is_none() && of(0.48).is_none());
        // (lambda + 2 mu) / mu = 2 (1 - nu) / (1 - 2 nu)
        assert!((of(0.4999).unwrap() / 5001.0 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn lost_mass_and_tiny_steps_end_a_run() {
        let moment = Moment { time: 1.0, step: 10 };
        assert!(mass_lost(2.0, 1.999, moment).is_none());
        assert_eq!(mass_lost(2.0, 1.9, moment).unwrap().kind, FailureKind::MassLost);
        assert_eq!(mass_lost(2.0, f64::NAN, moment).unwrap().kind, FailureKind::MassLost);
        assert!(step_too_short(1e-3, 1e-4, moment).is_none());
        assert_eq!(step_too_short(1e-5, 1e-4, moment).unwrap().kind, FailureKind::StepTooShort);
    }
}
