//! (m M + k K + c C) x = b of a body: conjugate gradients with the multigrid hierarchy of its lattice, which is
//! made once and serves as long as the lattice stands.

use super::cg::{ConjugateGradients, Goal, Outcome};
use super::initial_guess::{SolutionHistory, WINDOW};
use super::multigrid::Multigrid;
use super::operator::{Operator, Shifted};
use super::sums::combine;
use crate::dynamics::Scales;
use crate::dynamics::solid::Solid;
use crate::error::InvalidInput;
use crate::state::{State, Stateful, damaged};

/// Change of the scales that counts as rounding: steps to moments like k / 30 differ in their last digits, and
/// the hierarchy and what is remembered are worth keeping.
const ROUNDING: f64 = 1e-12;

/// Whether two numbers differ by rounding only.
fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= ROUNDING * a.abs()
}

/// Whether two scales differ by rounding only.
fn alike(a: Scales, b: Scales) -> bool {
    close(a.mass, b.mass) && close(a.stiffness, b.stiffness) && close(a.damping, b.damping)
}

/// A solver for one body on one lattice.
#[derive(Clone, Debug)]
pub struct LinearSolver {
    multigrid: Multigrid,
    gradients: ConjugateGradients,
    history: SolutionHistory,
    step: Vec<f64>,
    scales: Scales,
    /// T.
    relaxation_time: f64,
    /// By how much the body was stiffer than its laws.
    stiffening: f64,
    applications: u64,
}

/// Counts what an operator is asked.
struct Counted<'a, 'b>(&'a mut Shifted<'b>, &'a mut u64);

impl Operator for Counted<'_, '_> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        *self.1 += 1;
        self.0.apply(x, y);
    }
}

impl LinearSolver {
    /// Sets up the hierarchy of `solid`.
    pub fn new(solid: &mut Solid) -> Self {
        let len = 3 * solid.len();
        Self {
            multigrid: solid.fully_relaxed(Multigrid::new),
            gradients: ConjugateGradients::new(len),
            history: SolutionHistory::default(),
            step: vec![0.0; len],
            scales: Scales::STATIC,
            relaxation_time: solid.relaxation_time(),
            stiffening: 1.0,
            applications: 0,
        }
    }

    /// Remembers the last solutions, from which the next systems of the same scales start: what a body
    /// does in one time step resembles what it did in those before.
    #[must_use]
    pub fn with_history(mut self) -> Self {
        self.history = SolutionHistory::new(self.step.len());
        self
    }

    /// Improves x until |b - (m M + k K + c C) x| meets `goal`. `watch` as in
    /// [`ConjugateGradients::solve`].
    pub fn solve(
        &mut self,
        solid: &mut Solid,
        scales: Scales,
        b: &[f64],
        x: &mut [f64],
        goal: Goal,
        watch: &mut dyn FnMut(usize, f64) -> bool,
    ) -> Outcome {
        let stiffening = solid.stiffening();
        if !alike(self.scales, scales) || !close(self.stiffening, stiffening) {
            self.stiffening = stiffening;
            self.set_scales(scales);
            self.history.forget();
        }
        let mut shifted = Shifted { solid, scales: self.scales };
        let mut operator = Counted(&mut shifted, &mut self.applications);
        let Self { multigrid, gradients, history, step, .. } = self;
        let outcome = if history.is_empty() {
            gradients.solve(&mut operator, multigrid, b, x, goal, watch)
        } else {
            history.start(b, x);
            step.fill(0.0);
            let outcome = gradients.solve(&mut operator, multigrid, history.rest(), step, goal, watch);
            combine(1.0, step, 1.0, x);
            outcome
        };
        history.keep(x, b, gradients);
        outcome
    }

    /// Smooths from now on by the positive tangent about the present state of `solid`: a body that has turned or stretched far is
    /// smoothed badly, or not at all, by that of the undeformed one.
    /// Returns the hierarchy of before.
    pub fn refresh(&mut self, solid: &mut Solid) -> Multigrid {
        let before = self.multigrid.clone();
        solid.make_tangent_positive(true);
        solid.fully_relaxed(|solid| self.multigrid.refresh(solid));
        solid.make_tangent_positive(false);
        self.set_scales(self.scales);
        before
    }

    /// Takes back a hierarchy that [`refresh`](Self::refresh) has replaced.
    pub fn put_back(&mut self, multigrid: Multigrid) {
        self.multigrid = multigrid;
    }

    fn set_scales(&mut self, scales: Scales) {
        let stiffness = self.stiffening * scales.of_stiffness(self.relaxation_time);
        self.multigrid.set_scales(scales.mass, stiffness);
        self.scales = scales;
    }

    /// |x|, summed in a fixed order.
    pub fn norm(&mut self, x: &[f64]) -> f64 {
        self.gradients.sums().norm(x)
    }

    /// Applications of the operator so far.
    pub fn applications(&self) -> u64 {
        self.applications
    }

    /// Number of unknowns of every level, the particles first.
    pub fn sizes(&self) -> Vec<usize> {
        self.multigrid.sizes()
    }
}

/// Remembered solutions with their products, one after the other.
const KNOWN: &str = "solver/known";

impl Stateful for LinearSolver {
    fn save(&self, state: &mut State) {
        state.put("solver/scales", [self.scales.mass, self.scales.stiffness, self.scales.damping]);
        state.put("solver/stiffening", [self.stiffening]);
        state.put(KNOWN, self.history.known().iter().flatten().flatten().copied().collect::<Vec<_>>());
    }

    fn restore(&mut self, state: &State) -> Result<(), InvalidInput> {
        let [mass, stiffness, damping] = state.numbers("solver/scales")?;
        let scales = Scales { mass, stiffness, damping };
        let [stiffening] = state.numbers("solver/stiffening")?;
        let (values, len) = (state.real(KNOWN)?, self.step.len());
        let pair = 2 * len.max(1);
        if !values.len().is_multiple_of(pair) || values.len() > WINDOW * pair {
            return Err(damaged(KNOWN, &format!("must hold pairs of {len} values, {WINDOW} at most")));
        }
        if self.scales != scales || self.stiffening.to_bits() != stiffening.to_bits() {
            self.stiffening = stiffening;
            self.set_scales(scales);
        }
        let split = |pair: &[f64]| [pair[..len].to_vec(), pair[len..].to_vec()];
        self.history.restore(values.chunks(pair).map(split).collect());
        Ok(())
    }
}
