//! The method that the paper compares with: finite differences on a mesh that moves with the interface
//! (arbitrary Lagrangian-Eulerian, ALE). For comparison only.

use super::reference::Profile;
use std::f64::consts::TAU;

/// How the fluid's convection, (3/2 u - w) u_x with the mesh velocity w, is differenced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Convection {
    /// (3/2 u - w) times the central difference of u.
    Central,
    /// Central difference of the flux 3/4 u^2, less w times that of u.
    Conservative,
    /// (3/2 u - w) times the difference against the stream.
    Upwind,
}

/// Viscosity of the fluid and elasticity of the solid, as in the paper.
const VISCOSITY: f64 = 0.001;
const ELASTICITY: f64 = 1.0;

/// Fluid on [-0.5, interface] and solid on [0, 0.5] with `n` elements each.
#[derive(Clone, Debug)]
pub(super) struct Ale {
    n: usize,
    convection: Convection,
    /// Interface position, then u at the fluid's nodes, v and d at the solid's.
    state: Vec<f64>,
}

impl Ale {
    /// The initial state, Eq. (20).
    pub fn new(n: usize, convection: Convection) -> Self {
        let u0 = |x: f64| -0.1 * ((TAU * x).cos() + 1.0);
        let at = |i: usize| 0.5 * i as f64 / n as f64;
        let mut state = vec![0.0];
        state.extend((0..=n).map(|i| if i == 0 { 0.0 } else { u0(at(i) - 0.5) }));
        state.extend((0..=n).map(|i| if i == n { 0.0 } else { u0(at(i)) }));
        state.extend(vec![0.0; n + 1]);
        Self { n, convection, state }
    }

    /// Advances by `steps` steps of RK4 to a time `duration` later.
    pub fn advance(&mut self, duration: f64, steps: usize) {
        let dt = duration / steps as f64;
        for _ in 0..steps {
            let start = self.state.clone();
            let mut end = start.clone();
            let mut stage = start.clone();
            for (weight, next) in [(1.0 / 6.0, 0.5), (1.0 / 3.0, 0.5), (1.0 / 3.0, 1.0), (1.0 / 6.0, 0.0)] {
                let rates = self.rates(&stage);
                for i in 0..rates.len() {
                    end[i] += weight * dt * rates[i];
                    stage[i] = start[i] + next * dt * rates[i];
                }
            }
            self.state = end;
        }
    }

    fn rates(&self, state: &[f64]) -> Vec<f64> {
        let n = self.n;
        let (u, solid) = state[1..].split_at(n + 1);
        let (v, d) = solid.split_at(n + 1);
        let (h, dxi) = ((state[0] + 0.5) / n as f64, 0.5 / n as f64);
        let mut fluid_rate = vec![0.0; n + 1];
        for i in 1..n {
            let w = u[n] * i as f64 / n as f64;
            let central = (u[i + 1] - u[i - 1]) / (2.0 * h);
            let speed = 1.5 * u[i] - w;
            let convection = match self.convection {
                Convection::Central => speed * central,
                Convection::Conservative => {
                    0.75 * (u[i + 1].powi(2) - u[i - 1].powi(2)) / (2.0 * h) - w * central
                }
                Convection::Upwind if speed > 0.0 => speed * (u[i] - u[i - 1]) / h,
                Convection::Upwind => speed * (u[i + 1] - u[i]) / h,
            };
            fluid_rate[i] = VISCOSITY * (u[i + 1] - 2.0 * u[i] + u[i - 1]) / (h * h) - convection;
        }
        let mut solid_rate = vec![0.0; n + 1];
        for j in 1..n {
            solid_rate[j] = ELASTICITY * (d[j + 1] - 2.0 * d[j] + d[j - 1]) / (dxi * dxi);
        }
        // The interface: half an element of each.
        let u_x = (u[n] - u[n - 1]) / h;
        let force = ELASTICITY * (d[1] - d[0]) / dxi - VISCOSITY * u_x - 0.25 * h * u[n] * u_x;
        let a = force / (0.5 * (h + dxi));
        (fluid_rate[n], solid_rate[0]) = (a, a);
        let mut rates = vec![u[n]];
        rates.extend(fluid_rate);
        rates.extend(solid_rate);
        rates.extend_from_slice(v);
        rates
    }

    /// The velocity profile of this moment.
    pub fn profile(&self) -> Profile {
        let n = self.n;
        let (u, v, d) = (&self.state[1..n + 2], &self.state[n + 2..2 * n + 3], &self.state[2 * n + 3..]);
        let part = |i: usize| i as f64 / n as f64;
        let mut profile = Profile { x: Vec::new(), u: u.to_vec(), interface: n };
        profile.x.extend((0..=n).map(|i| -0.5 + part(i) * (self.state[0] + 0.5)));
        profile.x.extend((1..=n).map(|j| 0.5 * part(j) + d[j]));
        profile.u.extend_from_slice(&v[1..]);
        profile
    }
}
