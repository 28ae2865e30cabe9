//! Where to start a system from those solved before: the projection onto their solutions (P. F. Fischer,
//! Comput. Methods Appl. Mech. Eng. 163, 1998). It costs inner products, no application of the operator.

use super::cg::ConjugateGradients;
use super::sums::{Sums, combine};

/// Solutions d of earlier systems with A d, orthonormal in the inner product of A.
#[derive(Clone, Debug, Default)]
pub struct Recall {
    count: usize,
    known: Vec<[Vec<f64>; 2]>,
    /// b - A x where the last system started.
    rest: Vec<f64>,
}

impl Recall {
    /// Of the last `count` systems.
    pub fn new(count: usize) -> Self {
        Self { count, ..Self::default() }
    }

    /// Whether there is something to start from.
    pub fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// Solutions and their products, oldest first.
    pub fn known(&self) -> &[[Vec<f64>; 2]] {
        &self.known
    }

    /// Goes on from what [`Recall::known`] gave.
    pub fn restore(&mut self, known: Vec<[Vec<f64>; 2]>) {
        self.known = known;
    }

    /// Forgets everything: the matrix is another one.
    pub fn forget(&mut self) {
        self.known.clear();
    }

    /// Sets x to the best combination of known solutions and [`Recall::rest`] to b - A x.
    pub fn start(&mut self, b: &[f64], x: &mut [f64], sums: &mut Sums) {
        self.rest.resize(b.len(), 0.0);
        self.rest.copy_from_slice(b);
        x.fill(0.0);
        for [solution, product] in &self.known {
            let share = sums.dot(solution, &self.rest);
            combine(share, solution, 1.0, x);
            combine(-share, product, 1.0, &mut self.rest);
        }
    }

    /// b - A x where the last system started.
    pub fn rest(&self) -> &[f64] {
        &self.rest
    }

    /// Remembers a solution x of A x = b, found by `gradients` from any start.
    pub fn keep(&mut self, x: &[f64], b: &[f64], gradients: &mut ConjugateGradients) {
        self.rest.resize(b.len(), 0.0);
        self.rest.copy_from_slice(b);
        self.keep_step(x, gradients);
    }

    /// Remembers what `gradients` added to the start.
    pub fn keep_step(&mut self, step: &[f64], gradients: &mut ConjugateGradients) {
        if self.count == 0 {
            return;
        }
        let mut slot = if self.known.len() < self.count {
            [vec![0.0; step.len()], vec![0.0; step.len()]]
        } else {
            self.known.remove(0)
        };
        let [solution, product] = &mut slot;
        solution.copy_from_slice(step);
        product.copy_from_slice(&self.rest);
        combine(-1.0, gradients.residual(), 1.0, product);
        let energy = gradients.sums().dot(solution, product);
        if energy > 0.0 && energy.is_finite() {
            let scale = 1.0 / energy.sqrt();
            slot.iter_mut().flatten().for_each(|v| *v *= scale);
            self.known.push(slot);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::operator::{Operator, Preconditioner};
    use super::*;
    use crate::solve::cg::Goal;
    use crate::solve::sums::noise;

    /// Second differences on a line, plus one.
    struct Line;

    impl Operator for Line {
        fn len(&self) -> usize {
            50
        }

        fn apply(&mut self, x: &[f64], y: &mut [f64]) {
            for i in 0..x.len() {
                let beside = |j: usize| x.get(j).copied().unwrap_or(0.0);
                y[i] = 3.0 * x[i] - beside(i.wrapping_sub(1)) - beside(i + 1);
            }
        }
    }

    struct Nothing;

    impl Preconditioner for Nothing {
        fn apply(&mut self, _: &mut dyn Operator, r: &[f64], z: &mut [f64]) {
            z.copy_from_slice(r);
        }
    }

    #[test]
    fn a_system_in_the_span_of_those_before_needs_no_iteration() {
        let (mut gradients, mut recall) = (ConjugateGradients::new(50), Recall::new(3));
        let goal = Goal { residual: 1e-13, iterations: 100 };
        let mut values = vec![0.0; 150];
        noise(&mut values);
        let right: Vec<&[f64]> = values.chunks(50).collect();
        let mut x = vec![0.0; 50];
        for (k, b) in right.iter().enumerate() {
            let mut step = vec![0.0; 50];
            recall.start(b, &mut x, gradients.sums());
            let rest = recall.rest().to_vec();
            let found = gradients.solve(&mut Line, &mut Nothing, &rest, &mut step, goal, &mut |_, _| true);
            assert!(found.iterations > 0);
            recall.keep_step(&step, &mut gradients);
            assert_eq!(recall.known().len(), k + 1);
        }
        let b: Vec<f64> = (0..50).map(|i| right[0][i] - 2.0 * right[1][i] + 0.5 * right[2][i]).collect();
        recall.start(&b, &mut x, gradients.sums());
        assert!(gradients.sums().norm(recall.rest()) < 1e-11);
        let mut product = vec![0.0; 50];
        Line.apply(&x, &mut product);
        assert!(product.iter().zip(&b).all(|(p, b)| (p - b).abs() < 1e-11));
    }
}
