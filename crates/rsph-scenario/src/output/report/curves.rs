//! The courses of loads and motions in time, as small plots that need no script.

use crate::output::html::escape;
use crate::output::info::{Course, RunInfo};
use crate::output::units::{bracket, number};
use std::fmt::Write;

/// Size of a plot in its own units, and the margin of the line in it.
const SIZE: (f64, f64, f64) = (320.0, 90.0, 4.0);

/// A section with a plot for each course; nothing where all loads act from the start and nothing moves.
pub fn section(info: &RunInfo) -> String {
    if info.courses.is_empty() {
        return String::new();
    }
    let plots: String = info.courses.iter().map(|course| plot(info, course)).collect();
    format!("<section>\n<h2>Loads and motions in time</h2>\n<div class=\"grid\">{plots}</div>\n</section>")
}

/// The factor of one course over time, with its extremes in words.
fn plot(info: &RunInfo, course: &Course) -> String {
    let range = |k: usize| {
        let values = course.points.iter().map(|point| point[k]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let [(start, end), (least, most)] = [range(0), range(1)];
    let (width, height, margin) = SIZE;
    let share = |x: f64, (low, high): (f64, f64)| if high > low { (x - low) / (high - low) } else { 0.5 };
    let line = course.points.iter().fold(String::new(), |mut line, [t, factor]| {
        let x = share(*t, (start, end)) * width;
        let y = margin + (1.0 - share(*factor, (least, most))) * (height - 2.0 * margin);
        let _ = write!(line, "{x:.1},{y:.1} ");
        line
    });
    format!(
        "<figure class=\"course\"><figcaption>{name}</figcaption><svg viewBox=\"0 0 {width} {height}\" role=\"img\" \
         aria-label=\"{name}\" preserveAspectRatio=\"none\"><polyline points=\"{}\"/></svg>\
         <p class=\"small\">factor from {} to {}; time{} from {} to {}</p></figure>",
        line.trim_end(),
        number(least),
        number(most),
        bracket(info.units, "s"),
        number(start),
        number(end),
        name = escape(&course.name),
    )
}
