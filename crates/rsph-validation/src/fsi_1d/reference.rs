//! The reference of the fluid beside a solid, and velocity profiles compared with it or with each other.

use rsph_core::particles::Field;
use rsph_core::snapshot::Snapshot;

/// Profiles of a fine finite-difference solution (3200 + 3200 elements), checked by Chebyshev collocation;
/// their source is told in the folder's README.
const FILES: [(f64, &str); 5] = [
    (0.0, include_str!("../../../../validation/fsi_1d/reference/ref_t0.csv")),
    (0.5, include_str!("../../../../validation/fsi_1d/reference/ref_t0.5.csv")),
    (1.0, include_str!("../../../../validation/fsi_1d/reference/ref_t1.0.csv")),
    (1.5, include_str!("../../../../validation/fsi_1d/reference/ref_t1.5.csv")),
    (2.0, include_str!("../../../../validation/fsi_1d/reference/ref_t2.0.csv")),
];

/// Position and velocity of the interface at some times, with more digits than the profiles have.
pub(super) const INTERFACE: [(f64, f64, f64); 4] = [
    (0.5, -0.051978, -0.003607),
    (1.0, -0.006015, 0.190929),
    (1.5, 0.048727, 0.013716),
    (2.0, 0.012484, -0.166839),
];

/// Velocity over position: fluid up to the interface, solid from there on.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    pub x: Vec<f64>,
    pub u: Vec<f64>,
    /// Number of the interface.
    pub interface: usize,
}

impl Profile {
    /// The reference at a time that has one.
    pub fn reference(time: f64) -> Result<Self, String> {
        let broken = || format!("no reference at t = {time}");
        let (_, text) = FILES.iter().find(|(t, _)| (t - time).abs() < 1e-9).ok_or_else(broken)?;
        let (mut x, mut u, mut fluid) = (Vec::new(), Vec::new(), 0_usize);
        for row in csv::Reader::from_reader(text.as_bytes()).records() {
            let row = row.map_err(|e| e.to_string())?;
            let number = |i: usize| row.get(i).and_then(|v| v.parse::<f64>().ok()).ok_or_else(broken);
            x.push(number(0)?);
            u.push(number(1)?);
            fluid += usize::from(number(2)? > 0.5);
        }
        Ok(Self { x, u, interface: fluid - 1 })
    }

    /// The particles of a snapshot.
    pub fn of(snapshot: &Snapshot) -> Self {
        let colour = snapshot.column(Field::Colour).values();
        Self {
            x: snapshot.positions().iter().map(|x| x[0]).collect(),
            u: snapshot.column(Field::Velocity).component(0).to_vec(),
            interface: colour.iter().filter(|c| **c > 0.0).count() - 1,
        }
    }

    /// The fluid's or the solid's part.
    pub fn part(&self, fluid: bool) -> (&[f64], &[f64]) {
        let i = self.interface;
        if fluid { (&self.x[..=i], &self.u[..=i]) } else { (&self.x[i..], &self.u[i..]) }
    }

    /// The velocity at `x` by a cubic through the four nodes around it, all of one material.
    fn at(&self, x: f64) -> f64 {
        let i = self.x.partition_point(|p| *p < x);
        let (first, last) =
            if i <= self.interface { (0, self.interface) } else { (self.interface, self.x.len() - 1) };
        let start = i.saturating_sub(2).clamp(first, last - 3);
        let nodes = start..start + 4;
        let weight = |a: usize| -> f64 {
            let others = nodes.clone().filter(|b| *b != a);
            others.map(|b| (x - self.x[b]) / (self.x[a] - self.x[b])).product()
        };
        nodes.clone().map(|a| self.u[a] * weight(a)).sum()
    }

    /// Relative L2 error of the velocity against `exact`, over the whole line and over the fluid: sums over
    /// the nodes of this profile with the trapezoidal rule.
    pub fn errors(&self, exact: &Self) -> (f64, f64) {
        let last = self.x.len() - 1;
        let (mut all, mut fluid) = ([0.0; 2], [0.0; 2]);
        for (i, (x, u)) in self.x.iter().zip(&self.u).enumerate() {
            let width = 0.5 * (self.x[(i + 1).min(last)] - self.x[i.saturating_sub(1)]);
            let q = exact.at(*x);
            let terms = [width * (u - q).powi(2), width * q * q];
            for (k, term) in terms.into_iter().enumerate() {
                all[k] += term;
                fluid[k] += if i <= self.interface { term } else { 0.0 };
            }
        }
        ((all[0] / all[1]).sqrt(), (fluid[0] / fluid[1]).sqrt())
    }
}
