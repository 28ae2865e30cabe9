//! Figures of a validation: line plots as SVG that read in black and white, with the curves as CSV
//! beside them.

use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::Color;
use std::path::Path;

/// Picture size in units of the SVG. Plotters rounds to whole ones, so that there are two to a pixel.
const SIZE: (u32, u32) = (1520, 880);
/// Most points of a curve.
const POINTS: usize = 800;
/// Most markers on a curve.
const MARKERS: usize = 24;

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Line {
    Solid,
    Dashed,
    Dotted,
    Marked,
}

impl Line {
    fn style(self) -> ShapeStyle {
        match self {
            Self::Solid => RGBColor(0x0b, 0x48, 0x7a).stroke_width(4),
            Self::Dashed => RGBColor(0xb0, 0x3a, 0x0c).stroke_width(4),
            Self::Dotted => RGBColor(0x20, 0x20, 0x20).stroke_width(2),
            Self::Marked => RGBColor(0x2c, 0x6e, 0x2c).stroke_width(3),
        }
    }

    /// Length of the dashes and of the gaps between them.
    fn dashes(self) -> Option<(u32, u32)> {
        match self {
            Self::Solid | Self::Marked => None,
            Self::Dashed => Some((18, 10)),
            Self::Dotted => Some((4, 8)),
        }
    }
}

/// One curve.
#[derive(Debug)]
pub(super) struct Curve {
    label: String,
    line: Line,
    points: Vec<(f64, f64)>,
}

impl Curve {
    fn new(label: &str, line: Line, x: &[f64], y: &[f64]) -> Self {
        Self { label: label.into(), line, points: x.iter().copied().zip(y.iter().copied()).collect() }
    }

    /// A solid curve; without a label it stays out of the legend.
    pub fn solid(label: &str, x: &[f64], y: &[f64]) -> Self {
        Self::new(label, Line::Solid, x, y)
    }

    /// A dashed curve.
    pub fn dashed(label: &str, x: &[f64], y: &[f64]) -> Self {
        Self::new(label, Line::Dashed, x, y)
    }

    /// A thin curve with circles on it.
    pub fn marked(label: &str, x: &[f64], y: &[f64]) -> Self {
        Self::new(label, Line::Marked, x, y)
    }

    /// A thin dotted curve, for references.
    pub fn dotted(label: &str, x: &[f64], y: &[f64]) -> Self {
        Self::new(label, Line::Dotted, x, y)
    }
}

/// A line plot.
#[derive(Debug)]
pub(super) struct Figure {
    title: &'static str,
    x: &'static str,
    y: &'static str,
    limit: Option<(f64, f64)>,
    curves: Vec<Curve>,
}

impl Figure {
    /// An empty plot with axis labels.
    pub fn new(title: &'static str, x: &'static str, y: &'static str) -> Self {
        Self { title, x, y, limit: None, curves: Vec::new() }
    }

    /// Fixes the range of y.
    pub fn limit(&mut self, low: f64, high: f64) {
        self.limit = Some((low, high));
    }

    /// Adds a curve.
    pub fn add(&mut self, curve: Curve) {
        self.curves.push(curve);
    }

    /// Writes `<name>.svg` and `<name>.csv` into `folder`.
    pub fn save(&self, folder: &Path, name: &str) -> Result<(), String> {
        let csv = folder.join(format!("{name}.csv"));
        self.write_csv(&csv).map_err(|e| format!("cannot write {}: {e}", csv.display()))?;
        let svg = folder.join(format!("{name}.svg"));
        self.draw(&svg).map_err(|e| format!("cannot write {}: {e}", svg.display()))
    }

    fn write_csv(&self, path: &Path) -> Result<(), csv::Error> {
        let mut writer = csv::Writer::from_path(path)?;
        writer.write_record(["curve", self.x, self.y])?;
        for curve in &self.curves {
            for (x, y) in &curve.points {
                writer.write_record([&curve.label, &x.to_string(), &y.to_string()])?;
            }
        }
        writer.flush()?;
        Ok(())
    }

    fn draw(&self, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
        let area = SVGBackend::new(path, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let points = || self.curves.iter().flat_map(|c| &c.points);
        let (x_min, x_max) =
            points().map(|p| p.0).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let (low, high) = self.limit.unwrap_or_else(|| {
            let low = points().map(|p| p.1).fold(0.0, f64::min);
            let high = points().map(|p| p.1).fold(0.0, f64::max);
            (1.05 * low, 1.08 * high)
        });
        let mut chart = ChartBuilder::on(&area)
            .caption(self.title, ("sans-serif", 36))
            .margin(24)
            .x_label_area_size(84)
            .y_label_area_size(140)
            .build_cartesian_2d(0.0_f64.min(x_min)..x_max, low..high)?;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .light_line_style(WHITE)
            .bold_line_style(BLACK.mix(0.12).stroke_width(2))
            .axis_style(BLACK.stroke_width(2))
            .label_style(("sans-serif", 26))
            .draw()?;
        for curve in &self.curves {
            // Not more points than pixels, and none outside of the frame.
            let stride = (curve.points.len() / POINTS).max(1);
            let shown: Vec<(f64, f64)> = curve
                .points
                .iter()
                .enumerate()
                .filter(|(i, p)| (i % stride == 0 || i + 1 == curve.points.len()) && p.1.is_finite())
                .map(|(_, p)| (p.0, p.1.clamp(low, high)))
                .collect();
            let line = curve.line;
            let style = line.style();
            let every = shown.len().div_ceil(MARKERS).max(1);
            let circles: Vec<_> = match line {
                Line::Marked => shown.iter().step_by(every).map(|p| Circle::new(*p, 8, style)).collect(),
                _ => Vec::new(),
            };
            let annotation = match line.dashes() {
                None => chart.draw_series(LineSeries::new(shown, style))?,
                Some((length, gap)) => chart.draw_series(DashedLineSeries::new(shown, length, gap, style))?,
            };
            if !curve.label.is_empty() {
                annotation.label(curve.label.clone()).legend(move |(x, y)| {
                    let (length, gap) = line.dashes().unwrap_or((56, 1));
                    let radius = if line == Line::Marked { 8 } else { 0 };
                    EmptyElement::at((x, y))
                        + DashedPathElement::new([(0, 0), (56, 0)], length, gap, style)
                        + Circle::new((28, 0), radius, style)
                });
            }
            chart.draw_series(circles)?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerRight)
            .legend_area_size(70)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .label_font(("sans-serif", 26))
            .draw()?;
        area.present()?;
        Ok(())
    }
}
