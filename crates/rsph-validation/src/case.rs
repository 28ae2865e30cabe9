//! Shipped scenarios as validations run them: with edits, and one probe's history.

use rsph_core::error::Failure;
use rsph_core::setup::Setup;
use rsph_core::simulation::{Conservation, Simulation};
use rsph_scenario::scenario::LoadedScenario;
use std::path::PathBuf;
use std::time::Instant;

/// The scenario files that validations start from.
pub(super) const TENSILE_LIVER: (&str, &str) =
    ("tensile_liver.toml", include_str!("../../../scenarios/tensile_liver.toml"));
pub(super) const TENSILE_KIDNEY: (&str, &str) =
    ("tensile_kidney.toml", include_str!("../../../scenarios/tensile_kidney.toml"));
pub(super) const LIVER_LOAD: (&str, &str) =
    ("liver_load.toml", include_str!("../../../scenarios/liver_load.toml"));
pub(super) const LIVER_LOAD_144: (&str, &str) =
    ("liver_load_144.toml", include_str!("../../../scenarios/liver_load_144.toml"));
pub(super) const LIVER_LOAD_TRANSIENT: (&str, &str) =
    ("liver_load_transient.toml", include_str!("../../../scenarios/liver_load_transient.toml"));
pub(super) const LIVER_VISIBLE_HUMAN: (&str, &str) =
    ("liver_visible_human.toml", include_str!("../../../scenarios/liver_visible_human.toml"));
pub(super) const HANGING_COLUMN: (&str, &str) =
    ("hanging_column.toml", include_str!("../../../scenarios/hanging_column.toml"));
pub(super) const OSCILLATING_BAR: (&str, &str) =
    ("oscillating_bar.toml", include_str!("../../../scenarios/oscillating_bar.toml"));
pub(super) const OSCILLATING_BEAM: (&str, &str) =
    ("oscillating_beam.toml", include_str!("../../../scenarios/oscillating_beam.toml"));

pub(super) const DEFORMATION: (&str, &str) =
    ("deformation.toml", include_str!("../../../scenarios/deformation.toml"));
pub(super) const DEFORMATION_REMESHED: (&str, &str) =
    ("deformation_remeshed.toml", include_str!("../../../scenarios/deformation_remeshed.toml"));

pub(super) const FSI_1D: (&str, &str) = ("fsi_1d.toml", include_str!("../../../scenarios/fsi_1d.toml"));

/// The history of a run's first probe.
#[derive(Debug)]
pub(super) struct History {
    /// Times.
    pub time: Vec<f64>,
    /// Readings.
    pub value: Vec<f64>,
    /// Conserved sums at the end.
    pub end: Conservation,
    /// Time steps a second of wall time.
    pub steps_per_second: f64,
    /// How the run failed, if it did.
    pub failure: Option<Failure>,
}

impl History {
    /// The last reading.
    pub fn last(&self) -> f64 {
        self.value.last().copied().unwrap_or(f64::NAN)
    }

    /// The largest reading.
    pub fn largest(&self) -> f64 {
        self.value.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// When the reading first reaches `level`, between samples by a straight line.
    pub fn first_reaches(&self, level: f64) -> f64 {
        let Some(i) = self.value.iter().position(|v| *v >= level) else { return f64::NAN };
        if i == 0 {
            return self.time[0];
        }
        let share = (level - self.value[i - 1]) / (self.value[i] - self.value[i - 1]);
        self.time[i - 1] + share * (self.time[i] - self.time[i - 1])
    }
}

/// Builds a shipped scenario with edits (`key.path=value`); returns it with its end time.
pub(super) fn simulation(scenario: (&str, &str), sets: &[String]) -> Result<(Simulation, f64), String> {
    let (setup, until) = setup(scenario, sets)?;
    Ok((Simulation::new(setup).map_err(|e| format!("{}: {e}", scenario.0))?, until))
}

/// What a shipped scenario with edits is made from, and its end time.
pub(super) fn setup((name, text): (&str, &str), sets: &[String]) -> Result<(Setup, f64), String> {
    let scenario = LoadedScenario::from_text(name, text.to_owned(), PathBuf::new(), sets)
        .map_err(|e| format!("{name}: {e}"))?;
    let job = scenario.lower().map_err(|e| format!("{name}: {e}"))?;
    Ok((job.setup, job.until))
}

/// Runs a shipped scenario to its end, with about 2,000 samples of its first probe.
pub(super) fn history(scenario: (&str, &str), sets: &[String]) -> Result<History, String> {
    let (mut simulation, until) = simulation(scenario, sets)?;
    let samples = 2000;
    let mut time = vec![0.0];
    let mut value = vec![simulation.readings()[0].value];
    let mut failure = None;
    let start = Instant::now();
    for k in 1..=samples {
        let t = until * f64::from(k) / f64::from(samples);
        if let Err(e) = simulation.advance_to(t, &mut |_| true) {
            failure = Some(e);
            break;
        }
        time.push(simulation.time());
        value.push(simulation.readings()[0].value);
    }
    let steps_per_second = simulation.step_count() as f64 / start.elapsed().as_secs_f64();
    Ok(History { time, value, end: simulation.conservation(), steps_per_second, failure })
}
