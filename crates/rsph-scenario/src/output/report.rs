//! `report.html`: one self-contained page about a run.

mod curves;
mod frames;
mod history;
mod packed;
mod tables;
mod thinned;

use super::html::{escape, fill};
use super::polydata::PolyData;
use super::summary::Summary;
use super::{ProbeColumn, RunInfo, VERSION, atomic, units};
use crate::sink::{Outcome, SinkError};
use frames::Frames;
use history::History;
use rsph_core::error::InvalidInput;
use rsph_core::simulation::{Conservation, Reading};
use rsph_core::state::State;
use serde::Serialize;
use std::path::Path;

const TEMPLATE: &str = include_str!("report/report.html");
const STYLE: &str = include_str!("report/report.css");
const SCRIPT: &str = include_str!("report/report.js");

/// Collects what the page shows while a run goes on.
#[derive(Debug, Default)]
pub struct Report {
    frames: Frames,
    history: History,
}

/// The labels and numbers that the page's script draws.
#[derive(Serialize)]
struct Data<'a> {
    up: &'static str,
    length_unit: String,
    time_unit: String,
    energy_unit: String,
    stress_unit: String,
    velocity_unit: String,
    probes: Vec<Probe<'a>>,
    force_displacement: Vec<ForceDisplacement<'a>>,
    force_unit: String,
    curves: history::Curves,
    view: frames::View<'a>,
}

#[derive(Serialize)]
struct Probe<'a> {
    name: &'a str,
    /// Probes of the same quantity share a plot.
    plot: &'a str,
    unit: String,
}

/// A component of the force of a boundary that moves, over that of its displacement.
#[derive(Serialize)]
struct ForceDisplacement<'a> {
    /// Name of the boundary and component.
    name: &'a str,
    /// Number of the probe that reads the force.
    force: usize,
    /// Number of the probe that reads the displacement.
    displacement: usize,
}

impl<'a> ForceDisplacement<'a> {
    /// Of all boundaries that move and have a name.
    fn all(info: &'a RunInfo) -> Vec<Self> {
        let of = |(displacement, column): (usize, &'a ProbeColumn)| {
            let name = column.quantity.strip_prefix("displacement of ")?;
            let is_force = |other: &ProbeColumn| other.quantity.strip_prefix("force of ") == Some(name);
            Some(Self { name, force: info.probes.iter().position(is_force)?, displacement })
        };
        info.probes.iter().enumerate().filter_map(of).collect()
    }
}

impl Report {
    /// Takes a frame.
    pub fn frame(&mut self, surface: &PolyData) {
        self.frames.push(surface);
    }

    /// Takes a sample.
    pub fn sample(&mut self, time: f64, readings: &[Reading], conservation: &Conservation) {
        self.history.push(time, readings, conservation);
    }

    /// The readings of the last sample; nothing if there was none.
    pub fn last_readings(&self) -> &[f64] {
        self.history.last_readings()
    }

    /// Puts the samples into `state`; the frames are in the results.
    pub fn save(&self, state: &mut State) {
        self.history.save(state);
    }

    /// Takes back the samples of `probes` probe columns.
    ///
    /// # Errors
    /// When they are not there or do not belong together.
    pub fn restore(&mut self, state: &State, probes: usize) -> Result<(), InvalidInput> {
        self.history.restore(state, probes)
    }

    /// Writes the page.
    ///
    /// # Errors
    /// When it can not be stored.
    pub fn write(
        &self,
        path: &Path,
        info: &RunInfo,
        summary: &Summary,
        outcome: &Outcome,
    ) -> Result<(), SinkError> {
        let page = self.page(info, summary, outcome).map_err(|e| SinkError::new(path, e))?;
        atomic::write(path, page.as_bytes())
    }

    fn page(&self, info: &RunInfo, summary: &Summary, outcome: &Outcome) -> serde_json::Result<String> {
        let data = serde_json::to_string(&self.data(info))?;
        let (in_page, all) = self.frames.counts();
        let view_note = self.frames.missing().unwrap_or_else(|| {
            if in_page as u64 == all {
                format!("All {all} frames.")
            } else {
                format!("{in_page} of {all} frames, evenly spaced; all of them are in surface.vtkhdf.")
            }
        });
        Ok(fill(TEMPLATE, &|name| match name {
            "title" => escape(&info.title),
            "style" => STYLE.to_owned(),
            "plotly" => plotly(),
            "script" => SCRIPT.to_owned(),
            // A `<` in a string must not look like the end of the script element.
            "data" => data.replace('<', "\\u003c"),
            "banner" => tables::banner(outcome, info),
            "lead" => tables::lead(info, summary),
            "cards" => tables::cards(info, summary),
            "parameters" => tables::parameters(info, summary),
            "courses" => curves::section(info),
            "notes" => tables::notes(summary),
            "view_note" => escape(&view_note),
            "scenario" => escape(&info.scenario),
            "sha256" => summary.scenario_sha256.clone(),
            "version" => VERSION.to_owned(),
            _ => String::new(),
        }))
    }

    fn data<'a>(&'a self, info: &'a RunInfo) -> Data<'a> {
        let unit = |si: &str| units::bracket(info.units, si);
        Data {
            up: ["x", "y", "z"][info.up as usize],
            length_unit: unit("m"),
            time_unit: unit("s"),
            energy_unit: unit("J"),
            stress_unit: unit("Pa"),
            velocity_unit: unit("m/s"),
            probes: info
                .probes
                .iter()
                .map(|p| Probe {
                    name: &p.name,
                    plot: p.quantity.rsplit_once('.').map_or(&*p.quantity, |(plot, _)| plot),
                    unit: unit(&p.unit),
                })
                .collect(),
            force_displacement: ForceDisplacement::all(info),
            force_unit: unit("N"),
            curves: self.history.curves(info.probes.len()),
            view: self.frames.view(),
        }
    }
}

/// The plotly.js library that the `plotly` crate carries, without the formula library behind it.
fn plotly() -> String {
    let sources = plotly::Plot::offline_js_sources();
    let end = "</script>";
    sources.find(end).map_or_else(String::new, |i| sources[..i + end.len()].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plot_library_is_whole_and_alone() {
        let js = plotly();
        assert!(js.starts_with("<script") && js.ends_with("</script>"));
        assert!(js.contains("plotly.js v"));
        assert_eq!(js.matches("</script>").count(), 1, "MathJax is in a script of its own");
        assert!((1_000_000..6_000_000).contains(&js.len()), "{}", js.len());
    }
}
