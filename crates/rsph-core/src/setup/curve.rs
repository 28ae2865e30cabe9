//! A factor that depends on time: the course of a load or of a prescribed motion.

use crate::error::InvalidInput;
use std::sync::Arc;

/// Relaxation times after which nothing of a start is left.
const FORGOTTEN: f64 = 40.0;

/// Change of a curve that a time step should see, as a share of its peak.
const CHANGED: f64 = 0.01;
/// Most points of a curve that one time step passes over.
const POINTS_IN_A_STEP: usize = 1000;

/// How a curve goes from one of its points to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Between {
    /// Along a straight line.
    #[default]
    Linear,
    /// Not at all: it keeps the value of a point until the time of the next one.
    Step,
    /// By monotone cubics with a continuous rate, which is zero at a largest and at a smallest value and outside.
    Smooth,
}

/// A factor as a function of time, by points; constant before the first and after the last of them, or periodic.
///
/// ```
/// use rsph_core::setup::{Between, Curve};
/// let pulse = Curve::new(&[0.0, 1.0, 3.0], &[0.0, 2.0, 0.0], Between::Linear, false)?;
/// assert_eq!((pulse.at(0.5), pulse.at(2.0), pulse.rate(2.0)), (1.0, 1.0, -1.0));
/// assert_eq!(Curve::ramp(0.0, 2.0).at(1.0), 0.5);
/// # Ok::<(), rsph_core::error::InvalidInput>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The value before the first piece.
    before: f64,
    /// In the order of time; the last one has no end, or ends with the period.
    pieces: Arc<[Piece]>,
    period: Option<f64>,
}

/// A polynomial of t - start.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    start: f64,
    coefficients: [f64; 4],
}

impl Piece {
    /// Value and derivatives at `t`.
    fn derivatives(&self, t: f64) -> [f64; 4] {
        let [a, b, c, d] = self.coefficients;
        let x = t - self.start;
        [a + x * (b + x * (c + x * d)), b + x * (2.0 * c + x * 3.0 * d), 2.0 * c + 6.0 * d * x, 6.0 * d]
    }
}

impl Default for Curve {
    /// 1 from time 0 on.
    fn default() -> Self {
        Self::ramp(0.0, 0.0)
    }
}

impl Curve {
    /// Grows linearly from 0 at time `from` (s) to 1 at time `to`; a step if `to` is not later.
    pub fn ramp(from: f64, to: f64) -> Self {
        let end = Piece { start: to.max(from), coefficients: [1.0, 0.0, 0.0, 0.0] };
        let rise = Piece { start: from, coefficients: [0.0, 1.0 / (to - from), 0.0, 0.0] };
        let pieces: &[Piece] = if to > from { &[rise, end] } else { &[end] };
        Self { before: 0.0, pieces: pieces.into(), period: None }
    }

    /// Has these values at these times (s). If it is `periodic`, it repeats what it does between the first and the last of
    /// them for ever, before and after.
    ///
    /// # Errors
    /// `time` or `value`: fewer than two points, lists of different length, numbers that are not finite, times that do not
    /// ascend, or a period that ends at another value than it begins at.
    pub fn new(
        times: &[f64],
        values: &[f64],
        between: Between,
        periodic: bool,
    ) -> Result<Self, InvalidInput> {
        check(times, values, periodic)?;
        let n = times.len();
        let slopes = slopes(times, values, periodic);
        let piece = |i: usize| {
            let (start, h, rise) = (times[i], times[i + 1] - times[i], values[i + 1] - values[i]);
            let (mean, [left, right]) = (rise / h, [slopes[i], slopes[i + 1]]);
            let coefficients = match between {
                Between::Linear => [values[i], mean, 0.0, 0.0],
                Between::Step => [values[i], 0.0, 0.0, 0.0],
                Between::Smooth => {
                    let (c, d) = (3.0 * mean - 2.0 * left - right, left + right - 2.0 * mean);
                    [values[i], left, c / h, d / (h * h)]
                }
            };
            Piece { start, coefficients }
        };
        let end = Piece { start: times[n - 1], coefficients: [values[n - 1], 0.0, 0.0, 0.0] };
        let period = periodic.then(|| times[n - 1] - times[0]);
        let pieces = (0..n - 1).map(piece).chain((!periodic).then_some(end)).collect();
        Ok(Self { before: values[0], pieces, period })
    }

    /// The factor at time `t`; where it jumps, that after the jump.
    pub fn at(&self, t: f64) -> f64 {
        self.derivatives(t)[0]
    }

    /// Its rate of change at time `t` (1/s); where that jumps, the one after the jump, and zero in a step.
    pub fn rate(&self, t: f64) -> f64 {
        self.derivatives(t)[1]
    }

    /// Value and derivatives at `t`.
    fn derivatives(&self, t: f64) -> [f64; 4] {
        let t = self.local(t);
        let number = self.pieces.partition_point(|piece| piece.start <= t);
        number.checked_sub(1).map_or([self.before, 0.0, 0.0, 0.0], |k| self.pieces[k].derivatives(t))
    }

    /// The time in the first period.
    fn local(&self, t: f64) -> f64 {
        let start = self.start();
        self.period.map_or(t, |period| start + (t - start).rem_euclid(period))
    }

    fn start(&self) -> f64 {
        self.pieces.first().map_or(0.0, |piece| piece.start)
    }

    /// The value of largest magnitude that it has at any time.
    pub fn peak(&self) -> f64 {
        // Between its points a curve is monotone.
        let values = self.pieces.iter().map(|piece| piece.coefficients[0]);
        values.fold(self.before, |peak, value| if value.abs() > peak.abs() { value } else { peak })
    }

    /// The first of its points after time `t`, where its rate or a derivative of it may jump; `None` if there is none.
    pub fn corner_after(&self, t: f64) -> Option<f64> {
        let local = self.local(t);
        let next =
            self.pieces.get(self.pieces.partition_point(|piece| piece.start <= local)).map(|p| p.start);
        let Some(period) = self.period else { return next };
        let corner = t + (next.unwrap_or(self.start() + period) - local);
        // Rounding must not lead back.
        Some(corner.max(t.next_up()))
    }

    /// The next moment after time `t` that a time step of about `dt` should not pass over: a point a quarter of a step
    /// away or more, or one at which it has changed; `None` if there is none.
    pub fn moment_after(&self, t: f64, dt: f64) -> Option<f64> {
        let (value, peak) = (self.at(t), self.peak().abs());
        let mut corner = t;
        for _ in 0..POINTS_IN_A_STEP {
            corner = self.corner_after(corner)?;
            if corner - t >= 0.25 * dt || (self.at(corner) - value).abs() > CHANGED * peak {
                break;
            }
        }
        Some(corner)
    }

    /// Whether it jumps anywhere.
    pub fn jumps(&self) -> bool {
        let ends =
            self.pieces.iter().skip(1).map(|piece| piece.start).chain(self.period.map(|p| self.start() + p));
        let values = self.pieces.iter().skip(1).chain(self.period.and(self.pieces.first()));
        let first = self.pieces.first().filter(|_| self.period.is_none());
        let begins = first.map_or(self.before, |piece| piece.coefficients[0]);
        let apart = |a: f64, b: f64| (a - b).abs() > 1e-9 * self.peak().abs();
        let mut meetings = self.pieces.iter().zip(ends).zip(values);
        apart(begins, self.before)
            || meetings.any(|((piece, end), next)| apart(piece.derivatives(end)[0], next.coefficients[0]))
    }

    /// s at time `to` with T ds/dt + s = the factor, T the `relaxation` time (s), from s = 0 at time `from`.
    pub fn relaxed(&self, from: f64, to: f64, relaxation: f64) -> f64 {
        // On a piece p the difference of s to p - T p' + T^2 p'' - T^3 p''' decays.
        let steady = |[p, p1, p2, p3]: [f64; 4]| p - relaxation * (p1 - relaxation * (p2 - relaxation * p3));
        let (mut t, mut s) = (from.max(to - FORGOTTEN * relaxation), 0.0);
        while t < to {
            let end = self.corner_after(t).map_or(to, |corner| corner.min(to));
            let [p, p1, p2, p3] = self.derivatives(t);
            let x = end - t;
            let there =
                [p + x * (p1 + x * (p2 / 2.0 + x * p3 / 6.0)), p1 + x * (p2 + x * p3 / 2.0), p2 + x * p3, p3];
            s = steady(there) + (s - steady([p, p1, p2, p3])) * (-x / relaxation).exp();
            t = end;
        }
        s
    }
}

/// What is wrong with the points of a curve.
fn check(times: &[f64], values: &[f64], periodic: bool) -> Result<(), InvalidInput> {
    let refuse = |key: &str, value: String, problem: String, remedy: &str| {
        Err(InvalidInput::new(key, value, problem, remedy))
    };
    let count = |list: &[f64]| format!("{} numbers", list.len());
    if times.len() < 2 {
        let remedy = "for example time = [0.0, 1.0] with value = [0.0, 1.0]";
        return refuse("time", count(times), "a curve has at least two points".into(), remedy);
    }
    if values.len() != times.len() {
        let problem = format!("there are {} times: every point has a time and a value", times.len());
        return refuse("value", count(values), problem, "give as many values as times");
    }
    for (key, list) in [("time", times), ("value", values)] {
        if let Some(x) = list.iter().find(|x| !x.is_finite()) {
            return refuse(key, x.to_string(), "must be finite numbers".into(), "check that number");
        }
    }
    if let Some(pair) = times.windows(2).find(|pair| pair[1] <= pair[0]) {
        let problem = format!("times must ascend: {} does not follow {}", pair[1], pair[0]);
        return refuse(
            "time",
            pair[1].to_string(),
            problem,
            "sort the points; for a jump take kind = \"step\"",
        );
    }
    let (first, last) = (values[0], values[values.len() - 1]);
    if periodic && (first - last).abs() > 1e-9 * values.iter().fold(0.0_f64, |m, v| m.max(v.abs())) {
        let problem = format!("a period must end as it begins, and this one goes from {first} to {last}");
        return refuse(
            "value",
            last.to_string(),
            problem,
            "make first and last value equal, or remove `periodic`",
        );
    }
    Ok(())
}

/// Slopes of a monotone cubic at its points, by the harmonic mean of Fritsch and Butland (1984).
fn slopes(times: &[f64], values: &[f64], periodic: bool) -> Vec<f64> {
    let n = times.len();
    let interval =
        |i: usize| (times[i + 1] - times[i], (values[i + 1] - values[i]) / (times[i + 1] - times[i]));
    let between = |(h, left): (f64, f64), (k, right): (f64, f64)| {
        if left * right <= 0.0 {
            return 0.0;
        }
        let weights = [2.0 * k + h, k + 2.0 * h];
        (weights[0] + weights[1]) / (weights[0] / left + weights[1] / right)
    };
    let mut slopes = vec![0.0; n];
    for i in 1..n - 1 {
        slopes[i] = between(interval(i - 1), interval(i));
    }
    if periodic {
        let ends = between(interval(n - 2), interval(0));
        (slopes[0], slopes[n - 1]) = (ends, ends);
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(between: Between, periodic: bool) -> Curve {
        Curve::new(&[0.5, 1.0, 2.0, 2.5], &[0.2, 1.0, -0.5, 0.2], between, periodic).unwrap()
    }

    #[test]
    fn it_passes_through_its_points_and_rests_or_repeats_outside() {
        for between in [Between::Linear, Between::Step, Between::Smooth] {
            for periodic in [false, true] {
                let curve = curve(between, periodic);
                for (t, value) in [(0.5, 0.2), (1.0, 1.0), (2.0, -0.5), (2.5, 0.2)] {
                    assert!(
                        (curve.at(t) - value).abs() < 1e-12,
                        "{between:?} {periodic} {t}: {}",
                        curve.at(t)
                    );
                }
                let far = if periodic { curve.at(1.3) } else { 0.2 };
                assert!(
                    (curve.at(1.3 + 14.0) - far).abs() < 1e-12 && (curve.at(1.3 - 6.0) - far).abs() < 1e-12
                );
                assert_eq!(curve.peak(), 1.0);
                assert_eq!(curve.jumps(), between == Between::Step, "{between:?} {periodic}");
            }
        }
        // A period of 2 s: corners at 0.5, 1 and 2, and the same before.
        let periodic = curve(Between::Linear, true);
        let mut t = -9.2;
        for wanted in [-9.0, -8.0, -7.5, -7.0] {
            t = periodic.corner_after(t).unwrap();
            assert!((t - wanted).abs() < 1e-12, "{t} {wanted}");
        }
        assert_eq!(curve(Between::Step, false).corner_after(2.5), None);
    }

    #[test]
    fn a_ramp_is_zero_then_linear_then_one_and_a_step_where_it_takes_no_time() {
        let ramp = Curve::ramp(1.0, 3.0);
        assert_eq!([0.0, 1.0, 1.5, 3.0, 9.0].map(|t| ramp.at(t)), [0.0, 0.0, 0.25, 1.0, 1.0]);
        assert_eq!([0.9, 1.0, 2.9, 3.0].map(|t| ramp.rate(t)), [0.0, 0.5, 0.5, 0.0]);
        let step = Curve::ramp(1.0, 1.0);
        assert_eq!([0.999, 1.0].map(|t| (step.at(t), step.rate(t))), [(0.0, 0.0), (1.0, 0.0)]);
        assert!(step.jumps() && !ramp.jumps());
        assert_eq!(Curve::default().at(0.0), 1.0);
    }

    #[test]
    fn a_smooth_curve_has_a_continuous_rate_and_stays_between_its_values() {
        for periodic in [false, true] {
            let curve = curve(Between::Smooth, periodic);
            let mut before = curve.at(-4.0);
            for k in 1..80_000 {
                let t = -4.0 + f64::from(k) * 1e-4;
                let (value, rate) = (curve.at(t), curve.rate(t));
                assert!((-0.5 - 1e-12..=1.0 + 1e-12).contains(&value));
                assert!((value - before - 1e-4 * curve.rate(t - 5e-5)).abs() < 1e-7, "{t}");
                assert!((rate - curve.rate(t - 1e-7)).abs() < 1e-4, "{t}");
                before = value;
            }
        }
        // Two points make the smoothstep 3 x^2 - 2 x^3.
        let step = Curve::new(&[0.0, 2.0], &[0.0, 1.0], Between::Smooth, false).unwrap();
        assert!((step.at(0.5) - (3.0 / 16.0 - 2.0 / 64.0)).abs() < 1e-15);
    }

    #[test]
    fn a_relaxed_curve_solves_its_equation() {
        let relaxation = 0.2;
        let mut curves = vec![Curve::ramp(0.1, 0.4), Curve::ramp(0.3, 0.3), Curve::ramp(-0.2, 0.1)];
        for between in [Between::Linear, Between::Step, Between::Smooth] {
            let points = ([0.1, 0.15, 0.3, 0.45], [0.5, 1.0, -1.0, 0.5]);
            curves.extend([false, true].map(|p| Curve::new(&points.0, &points.1, between, p).unwrap()));
        }
        for curve in curves {
            let (steps, end) = (100_000, 0.9);
            let dt = end / f64::from(steps);
            let mut s = 0.0;
            for k in 0..steps {
                s += dt / relaxation * (curve.at((f64::from(k) + 0.5) * dt) - s);
            }
            let found = curve.relaxed(0.0, end, relaxation);
            assert!((found - s).abs() < 1e-4, "{curve:?}: {found} {s}");
            // In two pieces, the first of which decays.
            let first = curve.relaxed(0.0, 0.25, relaxation) * (-(end - 0.25) / relaxation).exp();
            assert!((found - first - curve.relaxed(0.25, end, relaxation)).abs() < 1e-12);
        }
    }

    #[test]
    fn points_that_make_no_curve_are_refused() {
        let key = |times: &[f64], values: &[f64], periodic: bool| {
            Curve::new(times, values, Between::Linear, periodic).unwrap_err().key
        };
        assert_eq!(key(&[0.0], &[1.0], false), "time");
        assert_eq!(key(&[0.0, 1.0], &[1.0], false), "value");
        assert_eq!(key(&[0.0, 0.0], &[1.0, 2.0], false), "time");
        assert_eq!(key(&[0.0, f64::NAN], &[1.0, 2.0], false), "time");
        assert_eq!(key(&[0.0, 1.0], &[1.0, 2.0], true), "value");
    }
}
