//! A picture of particles and surfaces seen from one side, as a small SVG: particles as dots, surfaces
//! shaded by the direction of their normals.

use rsph_core::mesh::TriangleMesh;
use rsph_core::particles::Field;
use rsph_core::snapshot::Snapshot;
use rsph_core::tensor::{Mat3, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

/// Edge of a panel in pixels.
const PANEL: usize = 260;
/// Height of the line above it.
const TITLE: usize = 24;
/// Particles with less colour are not drawn: a remeshed body has a halo of them.
const SEEN: f64 = 0.25;
/// Shades of grey of a surface.
const SHADES: f64 = 12.0;

/// Panels in rows.
pub(super) struct Picture {
    columns: usize,
    panels: Vec<(String, String)>,
}

impl Picture {
    /// An empty picture with that many panels in a row.
    pub fn new(columns: usize) -> Self {
        Self { columns, panels: Vec::new() }
    }

    /// Adds a panel with the particles of a moment that have colour.
    pub fn particles(&mut self, title: &str, snapshot: &Snapshot) {
        let colour = snapshot.column(Field::Colour).values();
        let drawn = snapshot.positions().into_iter().zip(colour).filter(|(_, c)| **c >= SEEN);
        let dots: BTreeSet<(i32, i32)> = drawn
            .map(|(x, _)| seen(&Vec3::from(x)))
            .map(|p| (p.y.round() as i32, p.x.round() as i32))
            .collect();
        // Dots are lines of no length with round ends; dots side by side are one line.
        let mut path = String::new();
        for &(y, x) in dots.iter().filter(|(y, x)| !dots.contains(&(*y, x - 1))) {
            let length = (0..PANEL as i32).take_while(|i| dots.contains(&(y, x + i + 1))).count();
            let _ = write!(path, "M{x} {y}h{length}");
        }
        let drawn = format!(
            "<path d=\"{path}\" fill=\"none\" stroke=\"#0b487a\" stroke-width=\"2\" stroke-linecap=\"round\" \
             stroke-opacity=\"0.55\"/>"
        );
        self.panels.push((title.into(), drawn));
    }

    /// Adds a panel with a surface.
    pub fn surface(&mut self, title: &str, mesh: &TriangleMesh) {
        let shade = shaded(mesh);
        // Runs of pixels with the same shade, as horizontal lines.
        let mut paths: BTreeMap<u8, String> = BTreeMap::new();
        for (y, row) in shade.chunks(PANEL).enumerate() {
            let mut x = 0;
            while x < PANEL {
                let run = row[x..].iter().take_while(|s| **s == row[x]).count();
                if let Some(grey) = row[x] {
                    let _ = write!(paths.entry(grey).or_default(), "M{x} {y}h{run}");
                }
                x += run;
            }
        }
        let mut drawn = String::new();
        for (grey, path) in paths {
            let _ = write!(
                drawn,
                "<path transform=\"translate(0 .5)\" d=\"{path}\" stroke=\"rgb({grey},{grey},{grey})\"/>"
            );
        }
        self.panels.push((title.into(), drawn));
    }

    /// Writes the picture.
    pub fn save(&self, path: &Path) -> Result<(), String> {
        std::fs::write(path, self.svg()).map_err(|e| format!("cannot write {}: {e}", path.display()))
    }

    fn svg(&self) -> String {
        let rows = self.panels.len().div_ceil(self.columns);
        let (width, height) = (self.columns * PANEL, rows * (PANEL + TITLE));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             font-family=\"sans-serif\" font-size=\"14\"><rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        for (i, (title, drawn)) in self.panels.iter().enumerate() {
            let (x, y) = (i % self.columns * PANEL, i / self.columns * (PANEL + TITLE));
            let _ = writeln!(
                svg,
                "<g transform=\"translate({x} {y})\"><text x=\"{}\" y=\"17\" text-anchor=\"middle\">{title}</text>\
                 <g transform=\"translate(0 {TITLE})\">{drawn}</g></g>",
                PANEL / 2
            );
        }
        svg + "</svg>\n"
    }
}

/// A point of the unit cube in pixels, with its nearness to the eye as z.
fn seen(x: &Vec3) -> Vec3 {
    let p = view() * (x - Vec3::new(0.46, 0.42, 0.45));
    let (half, scale) = (0.5 * PANEL as f64, 1.1 * PANEL as f64);
    Vec3::new(half + scale * p.x, half - scale * p.y, p.z)
}

/// Rows: right, up, towards the eye.
fn view() -> Mat3 {
    let eye = Vec3::new(0.55, 0.35, 0.75).normalize();
    let right = Vec3::y().cross(&eye).normalize();
    Mat3::from_rows(&[right.transpose(), eye.cross(&right).transpose(), eye.transpose()])
}

/// Shade of each pixel of a panel, row by row; `None`: nothing there.
fn shaded(mesh: &TriangleMesh) -> Vec<Option<u8>> {
    let mut nearest = vec![f64::NEG_INFINITY; PANEL * PANEL];
    let mut shade = vec![None; PANEL * PANEL];
    let view = view();
    for t in 0..mesh.triangles.len() {
        let corners = mesh.triangles[t].map(|v| mesh.vertices[v as usize]);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let towards = (view * normal.try_normalize(0.0).unwrap_or_else(Vec3::zeros)).z.abs();
        let grey = (((40.0 + 200.0 * towards) / 240.0 * SHADES).round() * 240.0 / SHADES) as u8;
        let [a, b, c] = corners.map(|x| seen(&x));
        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        let pixels =
            |low: f64, high: f64| low.max(0.0) as usize..(high.max(-1.0) + 1.0).min(PANEL as f64) as usize;
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        for y in pixels(low.y, high.y) {
            for x in pixels(low.x, high.x) {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let side = |p: &Vec3, q: &Vec3| ((q.x - p.x) * (py - p.y) - (q.y - p.y) * (px - p.x)) / area;
                let (wc, wa) = (side(&a, &b), side(&b, &c));
                let wb = 1.0 - wa - wc;
                let depth = wa * a.z + wb * b.z + wc * c.z;
                let n = y * PANEL + x;
                if wa >= 0.0 && wb >= 0.0 && wc >= 0.0 && depth > nearest[n] {
                    nearest[n] = depth;
                    shade[n] = Some(grey);
                }
            }
        }
    }
    shade
}

#[cfg(test)]
mod tests {
    use super::*;
    use rsph_core::shape::{Shape, SphereShape};

    #[test]
    fn a_sphere_is_a_shaded_disc() {
        let sphere = SphereShape::new(0.15, Vec3::repeat(0.35)).unwrap();
        let shade = shaded(sphere.surface());
        let covered = shade.iter().flatten().count() as f64;
        let disc = std::f64::consts::PI * (0.15 * 1.1 * PANEL as f64).powi(2);
        assert!((covered / disc - 1.0).abs() < 0.03, "{covered} {disc}");
        assert!(shade.iter().flatten().any(|g| *g < 80) && shade.iter().flatten().any(|g| *g > 220));
        let mut picture = Picture::new(1);
        picture.surface("a ball", sphere.surface());
        assert!(picture.svg().len() < 60_000);
    }
}
