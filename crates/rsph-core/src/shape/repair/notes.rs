//! What the user should know about a surface that was repaired, in sentences.

use super::{DOUBT, Repair, parts::Parts};
use crate::tensor::Vec3;

/// More of the body than this uncertain, or its surface made up: a sentence says so first.
const MUCH: f64 = 0.1;

/// What was done to the triangles, `wrong` being the parts that were turned round.
pub(super) fn of_parts(parts: &Parts, wrong: &[bool], name: &str) -> Vec<String> {
    let mut notes = Vec::new();
    if parts.repeated > 0 {
        notes.push(format!("{name} has {} triangles more than once; they count once", parts.repeated));
    }
    if parts.walls > 0 {
        notes.push(format!(
            "parts of {name} share walls: {} triangles between them, which face each other, were left out",
            parts.walls
        ));
    }
    if parts.turned > 0 {
        notes.push(format!(
            "{} triangles of {name} were turned the other way than those beside them: they were turned round",
            parts.turned
        ));
    }
    let turned = wrong.iter().filter(|w| **w).count();
    if turned > 0 && turned == wrong.len() {
        notes.push(format!("{name} was turned inside out: its triangles were turned round"));
    } else if turned > 0 {
        let of_wrong = || (0..parts.of.len()).filter(|&t| wrong[parts.of[t]]);
        let area = |t: usize| parts.mesh.triangle_area(t);
        let share = of_wrong().map(area).sum::<f64>() / parts.mesh.area();
        let largest = of_wrong().max_by(|&a, &b| area(a).total_cmp(&area(b)));
        let at = largest.map_or_else(Vec3::zeros, |t| parts.mesh.corners(t)[0]);
        notes.push(format!(
            "{turned} of {} parts of {name}, {} of its area, were turned inside out: they were turned round, \
             one of them at {}",
            wrong.len(),
            percent(share),
            point(&at)
        ));
    }
    notes
}

impl Repair {
    /// What the user should know, one sentence each; `name` is what messages call the surface.
    pub fn notes(&self, name: &str) -> Vec<String> {
        let mut notes = Vec::new();
        if self.uncertain.max(self.made_up) > MUCH {
            notes.push(format!("much of {name} is a guess: its holes are wide"));
        }
        let fault = match self.open_edges {
            0 => format!("overlaps itself ({} parts)", self.parts),
            open => format!("is not closed ({open} open edges, {} parts)", self.parts),
        };
        notes.push(format!(
            "{name} {fault}: its body is where the winding number of its triangles is above 1/2, found on cells of {}",
            short(self.spacing)
        ));
        notes.push(format!(
            "{} of the body are uncertain: its volume is {}, and {} where the winding number is above {}, {} where it is \
             above {DOUBT}",
            percent(self.uncertain),
            short(self.volume),
            short(self.between[0]),
            1.0 - DOUBT,
            short(self.between[1]),
        ));
        notes.push(format!(
            "{} of the body's surface are made up, with no triangle within {}; the middle of the widest gap is {} from the \
             next triangle, at {}",
            percent(self.made_up),
            short(self.spacing),
            short(self.gap),
            point(&self.gap_at)
        ));
        if self.layered > 0.0 || self.overlapping > 0.0 {
            notes.push(format!(
                "{} of the area of {name} lie on another part of it and count once; in {} of the body solids overlap",
                percent(self.layered),
                percent(self.overlapping)
            ));
        }
        if self.dropped.0 > 0 {
            notes.push(format!(
                "{} small pieces and voids of {name} were left out, of the volume {} together",
                self.dropped.0,
                short(self.dropped.1)
            ));
        }
        notes
    }
}

fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}

fn point(x: &Vec3) -> String {
    format!("({}, {}, {})", short(x.x), short(x.y), short(x.z))
}

/// A number of four digits.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    if rounded != 0.0 && !(1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        rounded.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_repair_says_how_sure_it_is_and_where_it_is_not() {
        let mut repair = Repair {
            open_edges: 7,
            parts: 2,
            spacing: 0.002,
            volume: 2.1537e-3,
            between: [2.1466e-3, 2.1657e-3],
            uncertain: 0.004,
            overlapping: 0.0014,
            layered: 0.95,
            made_up: 0.0058,
            gap_at: Vec3::new(-0.02182, 0.3139, -0.056),
            gap: 0.0084,
            dropped: (13, 6.3e-9),
        };
        let text = repair.notes("mesh a.stl").join("\n");
        for part in [
            "7 open edges, 2 parts",
            "0.4 % of the body",
            "0.002147",
            "(-0.02182, 0.3139, -0.056)",
            "13 small",
            "6.3e-9",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
        assert!(!text.contains("guess"));
        repair.made_up = 0.2;
        assert!(repair.notes("mesh a.stl")[0].contains("guess"));
    }
}
