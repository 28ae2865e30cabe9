//! The exact motion of a body of Kelvin-Voigt material from rest under a load that stays: each mode of
//! K phi = w^2 M phi is a damped oscillator of its own.

use super::kelvin_voigt_bar::decay;
use faer::{Mat, Side};
use rsph_core::particles::Field;
use rsph_core::simulation::Simulation;

/// A motion as a sum of modes.
#[derive(Clone, Debug)]
pub(super) struct Modes {
    rest: Vec<f64>,
    relaxation_time: f64,
    /// Angular frequency of each mode, and its share of the displacement at rest.
    pairs: Vec<(f64, Vec<f64>)>,
}

impl Modes {
    /// The modes of `simulation`, whose displacement at rest is `rest` (component by component), with its own
    /// K as a dense matrix; what holds the body rests.
    pub fn new(simulation: &mut Simulation, rest: &[f64], relaxation_time: f64) -> Result<Self, String> {
        let size = rest.len();
        let n = size / 3;
        let mass = simulation.particles().column(Field::Mass).values().to_vec();
        let root: Vec<f64> = (0..size).map(|i| mass[i % n].sqrt()).collect();
        let mut scaled = Mat::<f64>::zeros(size, size);
        let mut unit = vec![0.0; size];
        for j in 0..size {
            unit[j] = 1.0;
            let column = simulation.stiffness(&unit).ok_or("the body has no stiffness")?;
            unit[j] = 0.0;
            for i in 0..size {
                scaled[(i, j)] = column[i] / (root[i] * root[j]);
            }
        }
        let eigen = scaled.self_adjoint_eigen(Side::Lower).map_err(|e| format!("no pairs: {e:?}"))?;
        let (squares, vectors) = (eigen.S().column_vector(), eigen.U());
        let pairs = (0..size)
            .map(|k| {
                let share: f64 = (0..size).map(|i| vectors[(i, k)] * root[i] * rest[i]).sum();
                (squares[k].max(0.0).sqrt(), (0..size).map(|i| share * vectors[(i, k)] / root[i]).collect())
            })
            .collect();
        Ok(Self { rest: rest.to_vec(), relaxation_time, pairs })
    }

    /// Displacement at time t: the rest less sum g_k(t) of each mode's share of it.
    pub fn displacement(&self, t: f64) -> Vec<f64> {
        let mut u = self.rest.clone();
        for (omega, share) in &self.pairs {
            let left = decay(t, *omega, self.relaxation_time);
            u.iter_mut().zip(share).for_each(|(u, s)| *u -= left * s);
        }
        u
    }
}
