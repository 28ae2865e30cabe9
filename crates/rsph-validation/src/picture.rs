//! Pictures of particles and surfaces in panels, as a small SVG: particles as dots, surfaces as pixels.

use super::render::{Pixels, View, data_address};
use rsph_core::tensor::Vec3;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

/// Height of the line above a panel.
const TITLE: usize = 24;
/// Height of a scale below one.
const SCALE: usize = 44;

/// A scale of colours: from the lowest value to the highest.
pub(super) type Scale<'a> = &'a dyn Fn(f64) -> [u8; 3];

/// Panels in rows.
pub(super) struct Picture {
    columns: usize,
    panel: [usize; 2],
    scales: bool,
    panels: Vec<(String, String)>,
}

impl Picture {
    /// An empty picture with that many panels in a row, each of that many pixels; `scales` leaves room for
    /// a scale below each.
    pub fn new(columns: usize, panel: [usize; 2], scales: bool) -> Self {
        Self { columns, panel, scales, panels: Vec::new() }
    }

    /// Adds a panel with points as dots.
    pub fn dots(&mut self, title: &str, view: &View, points: impl Iterator<Item = Vec3>) {
        let dots: BTreeSet<(i32, i32)> =
            points.map(|x| view.seen(&x)).map(|p| (p.y.round() as i32, p.x.round() as i32)).collect();
        // Dots are lines of no length with round ends; dots side by side are one line.
        let mut path = String::new();
        for &(y, x) in dots.iter().filter(|(y, x)| !dots.contains(&(*y, x - 1))) {
            let length = (0..self.panel[0] as i32).take_while(|i| dots.contains(&(y, x + i + 1))).count();
            let _ = write!(path, "M{x} {y}h{length}");
        }
        let drawn = format!(
            "<path d=\"{path}\" fill=\"none\" stroke=\"#0b487a\" stroke-width=\"2\" stroke-linecap=\"round\" \
             stroke-opacity=\"0.55\"/>"
        );
        self.panels.push((title.into(), drawn));
    }

    /// Adds a panel with pixels.
    pub fn pixels(&mut self, title: &str, pixels: &Pixels) -> Result<(), String> {
        let [width, height] = self.panel;
        let address = data_address(pixels, self.panel).map_err(|e| format!("cannot draw {title}: {e}"))?;
        let drawn = format!("<image width=\"{width}\" height=\"{height}\" href=\"{address}\"/>");
        self.panels.push((title.into(), drawn));
        Ok(())
    }

    /// Draws a scale below the last panel, with numbers at its ends and at zero if that is between them.
    pub fn scale(&mut self, low: f64, high: f64, scale: Scale) {
        const STEPS: usize = 60;
        let [width, height] = self.panel;
        let Some((_, drawn)) = self.panels.last_mut() else { return };
        let (left, length) = (0.15 * width as f64, 0.7 * width as f64);
        let step = length / STEPS as f64;
        for i in 0..STEPS {
            let share = (i as f64 + 0.5) / STEPS as f64;
            let [r, g, b] = scale(low + share * (high - low));
            let x = left + i as f64 * step;
            let _ = write!(
                drawn,
                "<rect x=\"{x:.1}\" y=\"{height}\" width=\"{:.1}\" height=\"10\" fill=\"rgb({r},{g},{b})\"/>",
                step + 0.5
            );
        }
        let _ = write!(
            drawn,
            "<rect x=\"{left:.1}\" y=\"{height}\" width=\"{length:.1}\" height=\"10\" fill=\"none\" stroke=\"#555\"/>"
        );
        let mut ticks = vec![low, high];
        if low < 0.0 && high > 0.0 && (0.25..0.75).contains(&(-low / (high - low))) {
            ticks.push(0.0);
        }
        for value in ticks {
            let x = left + length * (value - low) / (high - low);
            let _ = write!(
                drawn,
                "<text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\" font-size=\"12\">{}</text>",
                height + 24,
                number(value)
            );
        }
    }

    /// Writes the picture.
    pub fn save(&self, path: &Path) -> Result<(), String> {
        std::fs::write(path, self.svg()).map_err(|e| format!("cannot write {}: {e}", path.display()))
    }

    fn svg(&self) -> String {
        let [panel_width, panel_height] = self.panel;
        let each = TITLE + panel_height + if self.scales { SCALE } else { 0 };
        let rows = self.panels.len().div_ceil(self.columns);
        let (width, height) = (self.columns * panel_width, rows * each);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\" font-family=\"sans-serif\" font-size=\"14\">\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        for (i, (title, drawn)) in self.panels.iter().enumerate() {
            let (x, y) = (i % self.columns * panel_width, i / self.columns * each);
            let _ = writeln!(
                svg,
                "<g transform=\"translate({x} {y})\"><text x=\"{}\" y=\"17\" text-anchor=\"middle\">{title}</text>\
                 <g transform=\"translate(0 {TITLE})\">{drawn}</g></g>",
                panel_width / 2
            );
        }
        svg + "</svg>\n"
    }
}

/// A value for a scale: two digits, as a power of ten where it is small.
fn number(value: f64) -> String {
    if value == 0.0 || (0.01..1000.0).contains(&value.abs()) {
        format!("{value:.2}")
    } else {
        format!("{value:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{render, shaded};
    use rsph_core::shape::{Shape, SphereShape};

    #[test]
    fn panels_have_titles_scales_and_small_files() {
        let sphere = SphereShape::new(0.15, Vec3::repeat(0.35)).unwrap();
        let view = View::new(Vec3::new(0.5, 0.3, 0.7), Vec3::repeat(0.35), 600.0, [260, 200]);
        let mut picture = Picture::new(2, view.size(), true);
        picture.dots("dots", &view, sphere.surface().vertices.iter().copied());
        picture.pixels("a ball", &render(sphere.surface(), &view, &shaded)).unwrap();
        picture.scale(-0.001, 0.001, &|_| [1, 2, 3]);
        let svg = picture.svg();
        assert!(svg.len() < 150_000, "{}", svg.len());
        assert!(svg.contains("a ball") && svg.contains("rgb(1,2,3)") && svg.contains(">-1.0e-3<"));
        assert!(svg.contains(">0.00<"), "zero is marked");
        assert!(svg.contains("width=\"520\" height=\"268\""), "two panels side by side");
    }
}
