//! Pieces of a shape that hang together by nothing: which of them are simulated, and notes on the others.

use super::assemble::TOLERANCE;
use crate::boundary::constraints::Constraints;
use crate::boundary::surface_load::quadrature;
use crate::error::InvalidInput;
use crate::neighbors::CellList;
use crate::region::Region;
use crate::sample::{Body, LeftOut, WhyLeftOut};
use crate::setup::{Formulation, Foundation, Pieces, Probe, RemeshTrigger, Setup, SolidSetup};
use crate::tensor::Vec3;

/// Distance between the places of a surface that are looked at for a hold, in spacings.
const LOOKOUT: f64 = 0.5;

/// Width of a gap, in spacings, below which a note names it: cells beside it are filled as if there were none.
const NARROW: f64 = 0.25;

/// Leaves out of `body` the pieces that are not simulated.
///
/// # Errors
/// A boundary that holds nothing of any piece.
pub(super) fn choose(setup: &Setup<SolidSetup>, body: &mut Body) -> Result<(), InvalidInput> {
    if body.pieces() < 2 {
        return Ok(());
    }
    if setup.solver.formulation == Formulation::Paper {
        let mut sizes = vec![0; body.pieces()];
        body.piece.iter().for_each(|piece| sizes[*piece as usize] += 1);
        let largest = (0..sizes.len()).rev().max_by_key(|piece| sizes[*piece]);
        let keep: Vec<bool> = (0..sizes.len()).map(|piece| Some(piece) == largest).collect();
        body.leave_out(&*setup.shape, &keep, WhyLeftOut::Smaller);
    } else if setup.pieces == Pieces::Held {
        let held = held(setup, body)?;
        if held.contains(&true) {
            body.leave_out(&*setup.shape, &held, WhyLeftOut::Unheld);
        }
    }
    Ok(())
}

/// Whether boundaries or foundations hold anything of each piece.
fn held(setup: &Setup<SolidSetup>, body: &Body) -> Result<Vec<bool>, InvalidInput> {
    let (surface, dx) = (body.boundary_surface(&*setup.shape), body.grid.spacing);
    let positions: Vec<Vec3> = body.cells.iter().map(|c| body.grid.centre(*c)).collect();
    let constraints = Constraints::new(&setup.mechanics.boundaries, surface, &positions, dx)?;
    let mut held = vec![false; body.pieces()];
    for particle in constraints.fixed(&positions)?.particles {
        held[body.piece[particle.particle] as usize] = true;
    }
    let piece_of = body.bounded_pieces(surface);
    for (piece, held) in held.iter_mut().enumerate().filter(|(_, held)| !**held) {
        let of = surface.retain(|t| piece_of[t] == Some(piece as u32));
        let places = quadrature(&of, LOOKOUT * dx);
        let tolerance = TOLERANCE * dx;
        *held = places.iter().any(|p| {
            let rests = |f: &Foundation| f.region.contains_on_surface(&p.x, &p.normal, tolerance);
            constraints.held_at(&p.x, &p.normal).is_some() || setup.mechanics.foundations.iter().any(rests)
        });
    }
    Ok(held)
}

/// What the user should know about pieces that are left out, and about gaps that the lattice does not resolve.
pub(super) fn notes(setup: &Setup<SolidSetup>, body: &Body) -> Vec<String> {
    let whole = setup.shape.volume();
    let share = |volume: f64| format!("{:.2} %", 100.0 * volume / whole);
    let place = |x: &Vec3| format!("({:.4}, {:.4}, {:.4})", x.x, x.y, x.z);
    let mut notes = Vec::new();
    let crumbs: Vec<&LeftOut> = body.left_out.iter().filter(|p| p.why == WhyLeftOut::Crumb).collect();
    if let Some(largest) = crumbs.iter().max_by_key(|p| p.cells.len()) {
        let volume = crumbs.iter().map(|p| p.volume).sum();
        notes.push(format!(
            "{} of the body's volume is left out, {} too small for particles to deform (the largest has {} and lies around {}): a smaller \
             spacing may join it to the body or resolve it",
            share(volume),
            if crumbs.len() == 1 { "a piece".to_owned() } else { format!("{} pieces", crumbs.len()) },
            largest.cells.len(),
            place(&largest.centre()),
        ));
    }
    for piece in body.left_out.iter().filter(|p| p.why != WhyLeftOut::Crumb) {
        let (why, remedy) = match piece.why {
            WhyLeftOut::Smaller => {
                ("the scheme of the paper has one piece, the largest", "take formulation = \"adjoint\"")
            }
            _ => (
                "nothing holds it, so that it has no equilibrium",
                "hold it by a boundary, or let it move: mode = \"dynamic\"",
            ),
        };
        notes.push(format!(
            "{} of the body's volume is left out, the piece of {} particles around {}: {why}; {remedy}",
            share(piece.volume),
            piece.cells.len(),
            place(&piece.centre()),
        ));
    }
    notes.extend(about_gaps(setup, body));
    notes
}

/// What the user should know about gaps that the lattice does not resolve.
fn about_gaps(setup: &Setup<SolidSetup>, body: &Body) -> Vec<String> {
    let Some(sight) = &body.sight else { return Vec::new() };
    let place = |x: &Vec3| format!("({:.4}, {:.4}, {:.4})", x.x, x.y, x.z);
    let narrowest = sight.narrowest();
    let (width, at) = (narrowest.width, place(&narrowest.place));
    let mut notes = Vec::new();
    if let Some(cell) = body.parted_cells.first() {
        notes.push(format!(
            "parts of the surface face each other across less than a spacing, {width:.2e} at {at}: nothing acts across the gap, but {} cells, \
             the first around {}, hold tissue of both sides, where the smaller share moves with the particles beside it, and what bends there may be \
             off by some per cent; a spacing of {width:.2e} keeps both sides apart",
            body.parted_cells.len(),
            place(cell),
        ));
    } else if width < NARROW * body.grid.spacing {
        notes.push(format!(
            "parts of the surface face each other across less than a quarter of a spacing, {width:.2e} at {at}: nothing acts across the gap, \
             but what bends beside it may be off by some per cent; a spacing of {:.2e} resolves it",
            width / NARROW,
        ));
    }
    if setup.remesh.trigger != RemeshTrigger::Never {
        notes.push(format!(
            "parts of the surface face each other across a gap of {width:.2e} at {at}: a remesh carries displacements across gaps of less than \
             four spacings, so that they drift together; a spacing below {:.2e} resolves this one, and without remeshing nothing acts across it",
            width / 4.0,
        ));
    }
    notes
}

/// Where the pieces were that are left out.
#[derive(Clone, Debug)]
pub(super) struct LeftOutPlaces {
    cells: Vec<Vec3>,
    list: CellList,
    spacing: f64,
}

impl LeftOutPlaces {
    /// Of those pieces, of cells that large.
    pub fn new(pieces: Vec<LeftOut>, spacing: f64) -> Self {
        let cells: Vec<Vec3> = pieces.into_iter().flat_map(|piece| piece.cells).collect();
        Self { list: CellList::new(&cells, spacing), cells, spacing }
    }

    /// Refuses a probe at a point that lies in what is left out of a body with particles at `positions`.
    ///
    /// # Errors
    /// `probe[i].region`.
    pub fn check_probe(&self, index: usize, probe: &Probe, positions: &[Vec3]) -> Result<(), InvalidInput> {
        let Region::Point(x) = &probe.region else { return Ok(()) };
        // A point beside the body belongs to the nearest cell.
        let reach = 2.0 * self.spacing;
        let Some((_, distance)) = self.list.nearest(&self.cells, x, reach) else { return Ok(()) };
        if positions.iter().any(|p| (p - x).norm() <= distance) {
            return Ok(());
        }
        Err(InvalidInput::new(
            format!("probe[{index}].region"),
            format!("({}, {}, {})", x.x, x.y, x.z),
            "lies in a piece of the body that is left out",
            "the notes say which pieces are left out and why; hold the piece by a boundary, or move the probe",
        ))
    }
}
