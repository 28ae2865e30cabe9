//! The words of the page: everything that is readable without its script.

use crate::output::html::escape;
use crate::output::info::{Parameter, RunInfo};
use crate::output::summary::{Remeshing, Summary};
use crate::output::units::{bracket, label, name, number};
use crate::sink::{Outcome, Status};
use std::fmt::Write;

/// A number with its unit.
fn quantity(info: &RunInfo, x: f64, si: &str) -> String {
    match label(info.units, si).as_str() {
        "1" => number(x),
        unit => format!("{} {unit}", number(x)),
    }
}

/// What to know first: that the run did not reach its end, or that its results can not be trusted.
pub fn banner(outcome: &Outcome, info: &RunInfo) -> String {
    let doubt = |note: &String| {
        format!("<div class=\"banner\"><strong>Do not trust this far:</strong> {}</div>", escape(note))
    };
    let doubts: String = outcome.notes.iter().map(doubt).collect();
    let end = match &outcome.status {
        Status::Finished => String::new(),
        Status::Interrupted => format!(
            "<div class=\"banner\"><strong>The run was interrupted</strong> at t = {} (step {}). \
             Everything up to there is complete.</div>",
            quantity(info, outcome.time, "s"),
            outcome.steps
        ),
        Status::Failed(f) => {
            let place = f.place.map_or_else(String::new, |p| {
                let at = p.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", ");
                format!("<br>It shows most at ({at}){} of the undeformed body.", bracket(info.units, "m"))
            });
            format!(
                "<div class=\"banner\"><strong>The simulation failed</strong> at t = {} (step {}): \
                 {}{place}<br><strong>What to do:</strong> {}<br>The results below end at the last good \
                 state.</div>",
                quantity(info, f.time, "s"),
                f.step,
                escape(&f.what),
                escape(&f.remedy)
            )
        }
    };
    end + &doubts
}

/// One line under the title.
pub fn lead(info: &RunInfo, s: &Summary) -> String {
    let units = match name(info.units) {
        "SI" => "SI units",
        _ => "normalised units: every quantity is divided by its characteristic value",
    };
    format!(
        "{} particles, {} steps to t = {}; {units}.",
        thousands(s.particles as u64),
        thousands(s.steps),
        quantity(info, s.time, "s")
    )
}

/// The summary's numbers.
pub fn cards(info: &RunInfo, s: &Summary) -> String {
    let force = |f: &[f64; 3]| quantity(info, f.iter().map(|x| x * x).sum::<f64>().sqrt(), "N");
    let cards = [
        ("status", s.status.to_owned()),
        ("particles", thousands(s.particles as u64)),
        ("steps", thousands(s.steps)),
        ("simulated time", quantity(info, s.time, "s")),
        ("wall time", format!("{} s", number(s.wall_seconds))),
        ("particle updates per second", number(s.particle_updates_per_second)),
        ("mass error", number(s.mass_error)),
        ("momentum error", number(s.momentum_error)),
        ("total load", force(&s.load)),
        ("reaction of the clamps", force(&s.reaction)),
    ];
    cards.iter().fold(String::new(), |mut out, (name, value)| {
        let _ = write!(out, "<div class=\"card\"><b>{}</b><span>{name}</span></div>", powers(value));
        out
    })
}

/// The tables of parameters.
pub fn parameters(info: &RunInfo, s: &Summary) -> String {
    let d = &info.description;
    let count = |name: &str, n: u64| Parameter::new(name, thousands(n), "");
    let limit = if d.limited_by_viscosity { "set by viscosity" } else { "set by the wave speed" };
    let mut run = vec![Parameter::new("units", name(info.units), "")];
    run.extend(info.parameters.iter().cloned());
    let discretisation = [
        count("particles", s.particles as u64),
        Parameter::number("spacing", d.spacing, "m"),
        Parameter::number("smoothing length", d.smoothing_length, "m"),
        count("neighbours", d.neighbours as u64),
        Parameter::number("volume of the particles", d.volume, "m^3"),
        Parameter::number("volume of the shape", d.shape_volume, "m^3"),
        Parameter::number("time step", d.dt, "s"),
        Parameter::number(&format!("largest stable step, {limit}"), d.dt_limit, "s"),
    ];
    let machine = [
        Parameter::new("threads", s.threads.to_string(), ""),
        Parameter::number("steps per second", s.steps_per_second, "1/s"),
        Parameter::new("simulated per wall time", number(s.real_time_factor), ""),
        count("right-hand sides", s.rhs_evaluations),
        count("frames stored", s.frames as u64),
        Parameter::new("version", s.version, ""),
    ];
    [
        table(info, "Scenario", &run),
        table(info, "Material", &info.material),
        table(info, "Discretisation", &discretisation),
        table(info, "Remeshing", &s.remesh.as_ref().map_or_else(Vec::new, remeshing)),
        table(info, "Computation", &machine),
    ]
    .concat()
}

/// What remeshing did.
fn remeshing(r: &Remeshing) -> Vec<Parameter> {
    vec![
        Parameter::new("remeshings", thousands(r.count), ""),
        Parameter::new(
            "particles before and after",
            format!("{}, {}", thousands(r.particles_before as u64), thousands(r.particles_after as u64)),
            "",
        ),
        Parameter::number("largest relative change of mass in one", r.largest_mass_jump, "1"),
        Parameter::number("largest change of momentum in one", r.largest_momentum_jump, "kg m/s"),
        Parameter::number("largest momentum given back in one", r.largest_momentum_correction, "kg m/s"),
        Parameter::number("change of energy in all", r.energy_change, "J"),
        Parameter::number("mass that went to a nearest node, sum", r.folded_mass, "kg"),
        Parameter::number("mass lost", r.dropped_mass, "kg"),
    ]
}

fn table(info: &RunInfo, caption: &str, rows: &[Parameter]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let mut out = format!("<table><caption>{caption}</caption><tbody>");
    for p in rows {
        // Rates of the machine are seconds in any unit system.
        let unit = if p.unit == "1/s" { "1/s".to_owned() } else { label(info.units, &p.unit) };
        let unit = if p.unit.is_empty() || unit == "1" { String::new() } else { unit };
        let value = powers(&p.value);
        let _ = write!(
            out,
            "<tr><th scope=\"row\">{}</th><td>{value}</td><td>{}</td></tr>",
            escape(&p.name),
            escape(&unit)
        );
    }
    out + "</tbody></table>"
}

/// The notes as a list.
pub fn notes(s: &Summary) -> String {
    if s.notes.is_empty() {
        return "<p>None.</p>".to_owned();
    }
    let items: Vec<_> = s.notes.iter().map(|n| escape(n)).collect();
    format!("<ul><li>{}</li></ul>", items.join("</li><li>"))
}

/// Escaped, and `10^-3` as a power. Only numbers of this program have that form.
fn powers(value: &str) -> String {
    let value = escape(value);
    match value.split_once("·10^") {
        Some((mantissa, rest)) => {
            let end = rest.find(|c: char| c != '-' && !c.is_ascii_digit()).unwrap_or(rest.len());
            format!("{mantissa}·10<sup>{}</sup>{}", &rest[..end], &rest[end..])
        }
        None => value,
    }
}

/// A count with thin spaces between groups of three digits.
fn thousands(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) && digits.len() > 4 {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_powers_read_well() {
        assert_eq!(thousands(343), "343");
        assert_eq!(thousands(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(powers("3·10^-15 kg"), "3·10<sup>-15</sup> kg");
        assert_eq!(powers("a < b"), "a &lt; b");
    }
}
