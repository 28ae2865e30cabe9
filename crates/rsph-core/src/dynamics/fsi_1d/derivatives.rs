//! First and second derivatives along a line of particles by kernel sums that are exact for
//! quadratic functions.

use crate::kernel::QuarticSpline;

/// Fluid particles from a wall to the interface, in order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<'a> {
    /// Positions; the first particle is at the wall, the last at the interface.
    pub x: &'a [f64],
    /// Volumes; the first and the last particle have half cells.
    pub volume: &'a [f64],
    /// Smoothing length in spacings.
    pub smoothing: f64,
}

/// A field on the line with what a wall makes of it: -1 for an odd field (velocity), 1 for an even one
/// (pressure).
pub(crate) type Mirrored<'a> = (&'a [f64], f64);

impl Line<'_> {
    /// (q_x, q_xx) of each field at particle `i`. Beyond the wall are mirror images; at the interface
    /// the sums are one-sided.
    ///
    /// With w = -W'(r)/r and sums over the neighbours b at r = x_b - x_a, q_x and q_xx solve
    /// `q_x m_2 + q_xx/2 m_3 = sum V w r dq` and `q_x m_3 + q_xx/2 m_4 = sum V w r^2 dq`, where
    /// `m_k = sum V w r^k`: the gradient sum of Eq. (10) corrected by its own moments.
    pub fn derivatives<const F: usize>(&self, i: usize, fields: [Mirrored<'_>; F]) -> [[f64; 2]; F] {
        let (x, last) = (self.x, self.x.len() - 1);
        let support = self.support(i);
        let kernel = QuarticSpline::<1>::new(support / QuarticSpline::<1>::SUPPORT);
        let (mut m, mut g) = ([0.0; 3], [[0.0; 2]; F]);
        let mut add = |r: f64, b: usize, mirrored: bool| {
            // The wall particle has its whole cell here, its mirror image included.
            let volume = if b == 0 { 2.0 * self.volume[0] } else { self.volume[b] };
            let w = volume * kernel.gradient_weight(r.abs());
            for (k, m) in m.iter_mut().enumerate() {
                *m += w * r.powi(k as i32 + 2);
            }
            for ((q, parity), g) in fields.iter().zip(&mut g) {
                let dq = if mirrored { parity * q[b] } else { q[b] } - q[i];
                g[0] += w * r * dq;
                g[1] += w * r * r * dq;
            }
        };
        for b in i + 1..=last {
            let r = x[b] - x[i];
            if r >= support {
                break;
            }
            add(r, b, false);
        }
        for b in (0..i).rev() {
            let r = x[b] - x[i];
            if -r >= support {
                break;
            }
            add(r, b, false);
        }
        for b in 1..=last {
            let r = 2.0 * x[0] - x[b] - x[i];
            if -r >= support {
                break;
            }
            add(r, b, true);
        }
        let determinant = m[0] * m[2] - m[1] * m[1];
        g.map(|[g1, g2]| [(g1 * m[2] - g2 * m[1]) / determinant, 2.0 * (g2 * m[0] - g1 * m[1]) / determinant])
    }

    /// How far the sums of particle `i` reach: from a smoothing length of 0.85 on, as far as both
    /// neighbours, or at the interface the nearest two.
    fn support(&self, i: usize) -> f64 {
        let (x, last) = (self.x, self.x.len() - 1);
        let spacing = match i {
            0 => x[1] - x[0],
            _ if i == last => 0.5 * (x[i] - x[i - 2]),
            _ => 0.5 * (x[i + 1] - x[i - 1]),
        };
        QuarticSpline::<1>::SUPPORT * self.smoothing * spacing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Particles at uneven places, and their volumes.
    fn uneven(jitter: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let n = jitter.len();
        let x: Vec<f64> = (0..n).map(|i| (i as f64 + if i == 0 { 0.0 } else { jitter[i] }) * 0.1).collect();
        let v = (0..n).map(|i| 0.5 * (x[(i + 1).min(n - 1)] - x[i.saturating_sub(1)])).collect();
        (x, v)
    }

    proptest! {
        #[test]
        fn quadratics_are_exact_away_from_the_wall(
            jitter in prop::collection::vec(-0.45..0.45f64, 12),
            a in -2.0..2.0f64, b in -2.0..2.0f64, c in -2.0..2.0f64, smoothing in 0.85..2.0f64,
        ) {
            let (x, volume) = uneven(&jitter);
            let q: Vec<f64> = x.iter().map(|x| a + b * x + c * x * x).collect();
            let line = Line { x: &x, volume: &volume, smoothing };
            // Nearer to the wall the mirror images are of another function.
            for i in 8..12 {
                let [[first, second]] = line.derivatives(i, [(&q, 1.0)]);
                prop_assert!((first - b - 2.0 * c * x[i]).abs() < 1e-9, "{i}: {first}");
                prop_assert!((second - 2.0 * c).abs() < 1e-7, "{i}: {second}");
            }
        }

        #[test]
        fn odd_and_even_functions_are_exact_at_the_wall(jitter in prop::collection::vec(-0.45..0.45f64, 12)) {
            let (x, volume) = uneven(&jitter);
            let line = Line { x: &x, volume: &volume, smoothing: 1.25 };
            let odd: Vec<f64> = x.iter().map(|x| 3.0 * x).collect();
            let even: Vec<f64> = x.iter().map(|x| 1.0 - 2.0 * x * x).collect();
            for i in 0..12 {
                let [o, e] = line.derivatives(i, [(&odd, -1.0), (&even, 1.0)]);
                prop_assert!((o[0] - 3.0).abs() < 1e-9 && o[1].abs() < 1e-7, "{i}: {o:?}");
                prop_assert!((e[0] + 4.0 * x[i]).abs() < 1e-9 && (e[1] + 4.0).abs() < 1e-7, "{i}: {e:?}");
            }
        }
    }
}
