//! What can go wrong: wrong input (met before anything is computed) and a simulation that fails.

use crate::tensor::Vec3;

/// An input that can not be simulated. The `key` is the dotted key of a scenario file
/// (`material.poisson_ratio`, `boundary[0].region`), so that a front end can point at its line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}` = {value}: {problem}")]
pub struct InvalidInput {
    /// Dotted key in the words of the scenario file; list entries as `load[1].region`.
    pub key: String,
    /// The offending value as the user would write it.
    pub value: String,
    /// What is wrong and what is allowed, with units.
    pub problem: String,
    /// What to do about it.
    pub remedy: String,
}

impl InvalidInput {
    /// A new error for `key`.
    #[allow(clippy::needless_pass_by_value)] // an error is handed over
    pub fn new(
        key: impl Into<String>,
        value: impl ToString,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { key: key.into(), value: value.to_string(), problem: problem.into(), remedy: remedy.into() }
    }
}

/// What a running simulation tripped over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FailureKind {
    /// A column holds a NaN or an infinite value.
    NotFinite,
    /// The energy grew beyond the work done on the body, or the strain beyond any meaning.
    Unstable,
    /// A particle was turned inside out, det F <= 0, or the body can not be remeshed.
    Inverted,
    /// A linear system was not solved: the body hangs by a thin piece or not at all.
    NotConverged,
    /// The particles have flown so far apart that no lattice holds them.
    Scattered,
    /// Remeshing has lost mass, or made some.
    MassLost,
    /// The stable time step has become too short to get anywhere.
    StepTooShort,
    /// Two particles on a line have passed each other.
    Crossed,
}

/// A simulation that stopped by itself. The state of the last good step is kept.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("simulation failed at t = {time:.6} (step {step}): {what}")]
pub struct Failure {
    /// The class of failure.
    pub kind: FailureKind,
    /// Simulated time of the last good state.
    pub time: f64,
    /// Number of the step that failed.
    pub step: u64,
    /// Which quantity, how much, compared with what.
    pub what: String,
    /// Reference position of the particle where it shows most.
    pub place: Option<Vec3>,
    /// What to change.
    pub remedy: String,
}
