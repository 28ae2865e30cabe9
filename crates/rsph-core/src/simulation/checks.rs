//! What is refused before a simulation starts, whatever the body.

use crate::error::InvalidInput;
use crate::setup::Solver;

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
    if !(0.0..=1.0).contains(&solver.hourglass) {
        return Err(InvalidInput::new(
            "solver.hourglass",
            solver.hourglass,
            "must lie between 0 (off) and 1",
            "0.1 is a good value",
        ));
    }
    Ok(())
}
