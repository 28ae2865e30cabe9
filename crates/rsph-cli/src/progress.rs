//! How a run goes: a bar on a terminal, quiet lines elsewhere.

use crate::output::{number, rate};
use indicatif::{ProgressBar, ProgressStyle};
use rsph_core::simulation::Description;
use rsph_scenario::run::{Observer, Progress};
use rsph_scenario::sink::Outcome;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Wall time between two lines where there is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(5);
/// The bar counts thousandths of the simulated time.
const BAR_LENGTH: u64 = 1000;

/// Shows a run on stderr.
pub struct Display {
    bar: Option<ProgressBar>,
    begun: Instant,
    /// Simulated time at which this program took over.
    from: f64,
    last_line: Instant,
    quiet: bool,
}

impl Display {
    /// A display; `quiet` shows nothing but notes.
    pub fn new(quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(BAR_LENGTH);
            if let Ok(style) = ProgressStyle::with_template("{bar:20} {percent:>3} %  {msg}") {
                bar.set_style(style);
            }
            bar
        });
        Self { bar, begun: Instant::now(), from: 0.0, last_line: Instant::now(), quiet }
    }
}

impl Observer for Display {
    fn started(&mut self, d: &Description, notes: &[String]) {
        for note in notes {
            tracing::warn!("{note}");
        }
        let limit = if d.limited_by_viscosity { "viscosity" } else { "wave speed" };
        tracing::info!(
            "{} particles, spacing {}, volume {} (shape {}), {} with dt {} (limit of rk4 {}, set by {limit})",
            d.particles,
            number(d.spacing),
            number(d.volume),
            number(d.shape_volume),
            d.scheme.name(),
            number(d.dt),
            number(d.dt_limit),
        );
        if let Some(reason) = &d.scheme_reason {
            tracing::info!("integrator {}: {reason}", d.scheme.name());
        }
        self.begun = Instant::now();
        self.last_line = self.begun;
    }

    fn resumed(&mut self, time: f64, frames: u64) {
        tracing::info!("goes on from its checkpoint at t = {}, after frame {frames}", number(time));
        self.from = time;
    }

    fn progressed(&mut self, p: &Progress) {
        let part = (p.time / p.until).clamp(0.0, 1.0);
        let elapsed = self.begun.elapsed().as_secs_f64();
        // What was done before a resume took none of this time.
        let left = elapsed * (p.until - p.time) / (p.time - self.from);
        let line = format!(
            "t = {} of {}, {} steps/s, {} left",
            number(p.time),
            number(p.until),
            rate(p.steps_per_second),
            duration(left)
        );
        if let Some(bar) = &self.bar {
            bar.set_position((part * BAR_LENGTH as f64) as u64);
            bar.set_message(line);
        } else if !self.quiet && self.last_line.elapsed() >= LINE_INTERVAL {
            self.last_line = Instant::now();
            tracing::info!("{line}");
        }
    }

    fn solving(&mut self, iteration: usize, residual: f64) {
        let line = format!("iteration {iteration}, {residual:.1e} of the load out of balance");
        if let Some(bar) = &self.bar {
            bar.set_message(line);
        } else if !self.quiet && self.last_line.elapsed() >= LINE_INTERVAL {
            self.last_line = Instant::now();
            tracing::info!("{line}");
        }
    }

    fn finished(&mut self, outcome: &Outcome) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        for note in &outcome.notes {
            tracing::warn!("{note}");
        }
    }
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if !s.is_finite() => "?".into(),
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
