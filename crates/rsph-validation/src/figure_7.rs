//! Fig. 7: normal and shear strain on the surface of a liver soon after a local load began to push.

use super::Row;
use super::case::{LIVER_LOAD_144, LIVER_LOAD_TRANSIENT, LIVER_VISIBLE_HUMAN, simulation};
use super::figure_6::view;
use super::liver;
use super::picture::{Picture, Scale};
use super::render::{Spot, render};
use rsph_core::mesh::TriangleMesh;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::{SymTensor, Vec3};
use std::path::Path;

/// Size of a panel.
const PANEL: [usize; 2] = [330, 250];
/// Peak pressure (Pa) and relaxation time (s) of the scenarios.
const PRESSURE: f64 = 270.0;
const RELAXATION: f64 = 0.2;

/// The surface of a moment.
struct State {
    /// Where its vertices are in the undeformed body.
    mesh: TriangleMesh,
    normal_strain: Vec<f64>,
    shear_strain: Vec<f64>,
    /// Component y of the force that the stress puts on the surface, Pa.
    traction: Vec<f64>,
    /// Component y of the force that the load puts there, Pa.
    applied: Vec<f64>,
    /// Area of a vertex.
    area: Vec<f64>,
    /// Distance to the centre of the load in its radii.
    distance: Vec<f64>,
    /// Largest displacement, m.
    largest: f64,
}

impl State {
    fn of(sim: &mut Simulation, centre: Vec3, radius: f64) -> Result<Self, String> {
        let snapshot = sim.snapshot();
        let surface = sim.surface(&snapshot);
        let values = |name: &str| {
            surface.field(name).map(|f| f.values.clone()).ok_or_else(|| format!("no {name} on the surface"))
        };
        let moved: Vec<Vec3> = values("displacement")?.chunks_exact(3).map(Vec3::from_column_slice).collect();
        let mut mesh = surface.mesh.clone();
        for (x, u) in mesh.vertices.iter_mut().zip(&moved) {
            *x -= u;
        }
        let mut area = vec![Vec3::zeros(); mesh.vertices.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for v in corners {
                area[*v as usize] += mesh.area_vector(t) / 3.0;
            }
        }
        let distance: Vec<f64> = mesh.vertices.iter().map(|x| (x - centre).norm() / radius).collect();
        let stress = values("stress")?;
        let normal = |v: usize| area[v].try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        let traction = |v: usize| SymTensor(std::array::from_fn(|i| stress[6 * v + i])).dot(&normal(v)).y;
        let applied =
            |v: usize| if normal(v).y > 0.0 { -PRESSURE * (-distance[v] * distance[v]).exp() } else { 0.0 };
        Ok(Self {
            normal_strain: values("normal_strain")?,
            shear_strain: values("shear_strain")?,
            traction: (0..area.len()).map(traction).collect(),
            applied: (0..area.len()).map(applied).collect(),
            largest: moved.iter().map(Vec3::norm).fold(0.0, f64::max),
            area: area.iter().map(Vec3::norm).collect(),
            distance,
            mesh,
        })
    }

    /// Mean over the surface, weighted by what the load puts there.
    fn under_load(&self, values: &[f64]) -> f64 {
        let weight = |v: usize| self.applied[v] * self.area[v];
        let all = (0..values.len()).map(weight).sum::<f64>();
        (0..values.len()).map(|v| weight(v) * values[v]).sum::<f64>() / all
    }

    /// Mean over the area at 2 to 3 radii from the load.
    fn around(&self, values: &[f64]) -> f64 {
        let ring = || (0..values.len()).filter(|&v| (2.0..3.0).contains(&self.distance[v]));
        ring().map(|v| values[v] * self.area[v]).sum::<f64>() / ring().map(|v| self.area[v]).sum::<f64>()
    }
}

/// A liver to look at.
struct Organ {
    what: &'static str,
    scenario: (&'static str, &'static str),
    edits: Vec<String>,
    /// Whether it has the smoothing that suits it best, not the paper's.
    accurate: bool,
}

pub(super) fn run(quick: bool, folder: &Path) -> Result<Vec<Row>, String> {
    let organ = |what, scenario, edits| Organ { what, scenario, edits, accurate: false };
    let mut organs = vec![organ("built-in liver", LIVER_LOAD_144, vec![])];
    if liver::is_there() {
        organs.push(organ("real liver", LIVER_VISIBLE_HUMAN, liver::edits(144)));
    }
    if !quick {
        organs.push(organ("built-in liver", LIVER_LOAD_TRANSIENT, vec![]));
        if liver::is_there() {
            let mut edits = liver::edits(1000);
            edits.push("solver.smoothing=0.8".into());
            organs.push(Organ { accurate: true, ..organ("real liver", LIVER_VISIBLE_HUMAN, edits) });
        }
    }
    let mut rows = Vec::new();
    let mut picture = Picture::new(4, PANEL, true);
    for organ in &organs {
        measure(organ, &mut rows, &mut picture)?;
    }
    picture.save(&folder.join("figure_7.svg"))?;
    Ok(rows)
}

fn measure(organ: &Organ, rows: &mut Vec<Row>, picture: &mut Picture) -> Result<(), String> {
    let (mut sim, until) = simulation(organ.scenario, &organ.edits)?;
    let original = sim.setup().shape.surface().clone();
    let (centre, radius) = if organ.scenario == LIVER_VISIBLE_HUMAN {
        (Vec3::from(liver::CENTRE), liver::RADIUS)
    } else {
        liver::upper_right(&original)
    };
    sim.advance_to(until, &mut |_| true).map_err(|e| e.to_string())?;
    let (readings, n) = (sim.readings(), sim.description().particles);
    let early = State::of(&mut sim, centre, radius)?;
    let (mut at_rest, _) = simulation(organ.scenario, &organ.edits)?;
    at_rest.solve_static(until, &mut |_, _| true).map_err(|e| e.to_string())?;
    let rest = State::of(&mut at_rest, centre, radius)?;

    let name = |of: &str| format!("figure_7: {}, {n} particles, {of}", organ.what);
    let strain = &early.normal_strain;
    // The clamp takes the moment of the load with far larger strains: what is farther from it than a radius.
    let lowest = early.mesh.vertices.iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
    let strongest = (0..strain.len())
        .filter(|v| early.mesh.vertices[*v].y > lowest + radius)
        .max_by(|a, b| strain[*a].abs().total_cmp(&strain[*b].abs()))
        .unwrap_or(0);
    let place = name("place of the largest normal strain away from the clamp");
    rows.push(Row::at_most(place, early.distance[strongest], 1.0, "radii from the load"));
    let largest = name("largest normal strain away from the clamp");
    rows.push(Row::at_most(largest, strain[strongest], 0.0, "1"));
    let under = early.under_load(strain);
    rows.push(Row::at_most(name("mean normal strain under the load"), under, 0.0, "1"));
    let fades = (early.around(strain) / under).abs();
    rows.push(Row::at_most(
        name("mean normal strain at 2 to 3 radii over that under the load"),
        fades,
        0.2,
        "1",
    ));
    let extent = original.bounds().map_or(1.0, |b| b.size().x);
    let seen = 100.0 * early.largest / extent;
    rows.push(
        Row::at_most(name("largest displacement"), seen, 1.0, "% of the extent").paper("not noticeable"),
    );
    // Without inertia a Kelvin-Voigt body under a constant load creeps as 1 - exp(-t / T), everywhere alike.
    let share = 1.0 - (-until / RELAXATION).exp();
    let crept = under / rest.under_load(&rest.normal_strain);
    rows.push(Row::within(name("normal strain under the load over that at rest"), crept, share, 15.0, "1"));
    // What the stress does to the surface must be what the load does there.
    if n > 500 {
        let (traction, applied) = (early.under_load(&early.traction), early.under_load(&early.applied));
        rows.push(Row::within(
            name("force of the stress on the loaded surface"),
            traction,
            applied,
            25.0,
            "Pa",
        ));
    }
    if organ.accurate {
        let u: Vec<f64> = readings.iter().map(|r| r.value).collect();
        let off = 100.0 * liver::off(&u, share);
        rows.push(Row::at_most(name("displacement off finite elements times 1 - exp(-t/T)"), off, 8.5, "%"));
    }
    panels(organ.what, n, until, &early, &original, picture)
}

/// Grey as in the paper, then colour: normal strain, shear strain.
fn panels(
    what: &str,
    n: usize,
    time: f64,
    state: &State,
    original: &TriangleMesh,
    picture: &mut Picture,
) -> Result<(), String> {
    let view = view(original, PANEL);
    let largest = |v: &[f64]| v.iter().map(|x| x.abs()).fold(f64::MIN_POSITIVE, f64::max);
    let (low, high) = state.normal_strain.iter().fold((0.0_f64, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
    let both = largest(&state.normal_strain);
    let most = largest(&state.shear_strain);
    let level = |share: f64| (255.0 * share.clamp(0.0, 1.0)) as u8;
    let grey_normal = |e: f64| [level((e - low) / (high - low)); 3];
    let grey_shear = |e: f64| [level(1.0 - e / most); 3];
    let blue_red = |e: f64| diverging(e / both);
    let heat = |e: f64| sequential(e / most);
    let kinds: [(&str, &[f64], f64, f64, Scale); 4] = [
        ("normal strain", &state.normal_strain, low, high, &grey_normal),
        ("shear strain", &state.shear_strain, 0.0, most, &grey_shear),
        ("normal strain", &state.normal_strain, -both, both, &blue_red),
        ("shear strain", &state.shear_strain, 0.0, most, &heat),
    ];
    for (i, (kind, values, low, high, scale)) in kinds.into_iter().enumerate() {
        let colour = |spot: &Spot| {
            let value: f64 = spot.corners.iter().zip(spot.weights).map(|(v, w)| w * values[*v]).sum();
            // Darker where the surface turns away, so that the shape is seen.
            let light = 0.7 + 0.3 * spot.facing;
            scale(value).map(|c| (f64::from(c) * light) as u8)
        };
        let title = if i == 0 { format!("{what}, {n}, {time} s: {kind}") } else { kind.to_owned() };
        picture.pixels(&title, &render(&state.mesh, &view, &colour))?;
        picture.scale(low, high, scale);
    }
    Ok(())
}

/// From blue (-1) over white (0) to red (1).
fn diverging(x: f64) -> [u8; 3] {
    let mix = |a: [f64; 3], share: f64| a.map(|c| (255.0 + (c - 255.0) * share) as u8);
    if x < 0.0 { mix([5.0, 48.0, 140.0], (-x).min(1.0)) } else { mix([160.0, 10.0, 30.0], x.min(1.0)) }
}

/// From white (0) over orange to dark red (1): darker is more.
fn sequential(x: f64) -> [u8; 3] {
    let stops = [[255.0, 250.0, 225.0], [245.0, 150.0, 50.0], [110.0, 0.0, 40.0]];
    let place = 2.0 * x.clamp(0.0, 1.0);
    let i = usize::from(place >= 1.0);
    let share = place - i as f64;
    std::array::from_fn(|c| (stops[i][c] + share * (stops[i + 1][c] - stops[i][c])) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_told_apart_in_grey() {
        let grey = |c: [u8; 3]| 0.3 * f64::from(c[0]) + 0.6 * f64::from(c[1]) + 0.1 * f64::from(c[2]);
        let shades: Vec<f64> = (0..=10).map(|i| grey(sequential(f64::from(i) / 10.0))).collect();
        assert!(shades.windows(2).all(|s| s[0] > s[1] + 5.0), "{shades:?}");
        assert_eq!(diverging(0.0), [255; 3]);
        assert!(grey(diverging(-1.0)) < 80.0 && grey(diverging(1.0)) < 80.0);
    }
}
