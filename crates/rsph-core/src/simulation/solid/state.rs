//! What a checkpoint holds of a body: how its particles were last remeshed. The rest follows from the particles
//! and the set-up.

use super::surface_reading::Settled;
use super::{LatticeParticles, Matter, SolidBody};
use crate::error::InvalidInput;
use crate::particles::{Field, Particles};
use crate::state::{State, damaged};
use crate::tensor::Vec3;

/// Puts it into `state`.
pub(super) fn save(body: &SolidBody, state: &mut State) {
    if !body.gradient_at_remesh.is_empty() {
        state.put_matrices("body/gradient_at_remesh", &body.gradient_at_remesh);
    }
    if let Matter::Paper(paper) = &body.matter {
        state.put_vectors("body/listed_at", paper.listed_at());
    }
    if let Some(reading) = body.reading.as_ref().filter(|r| !r.settled.traction.is_empty()) {
        state.put("body/settled_time", [reading.settled.time]);
        state.put_vectors("body/settled_traction", &reading.settled.traction);
    }
    if let Some((time, u)) = &body.last_remesh {
        state.put_whole("body/nodes", body.lattice_particles.nodes().as_flattened());
        state.put("body/laid_time", [*time]);
        state.share("body/remesh_displacement", u.share());
    }
}

/// Takes it back, with `particles` of that state.
pub(super) fn restore(
    body: &mut SolidBody,
    state: &State,
    particles: &Particles,
) -> Result<(), InvalidInput> {
    let n = particles.len();
    let reference = particles.column(Field::Reference);
    if state.has("body/nodes") {
        let nodes = state.whole_of("body/nodes", 3 * n)?;
        if !nodes.iter().all(|i| i32::try_from(*i).is_ok()) {
            return Err(damaged("body/nodes", "names a node that no lattice has"));
        }
        let [time] = state.numbers("body/laid_time")?;
        let u = state.real_of("body/remesh_displacement", 3 * n)?.to_vec();
        let places: Vec<Vec3> = (0..n).map(|a| reference.vector(a)).collect();
        let cut = body.undeformed.cut_at(places.iter());
        body.lattice_particles = LatticeParticles::with_columns(nodes.as_chunks::<3>().0, particles, cut)
            .with_sight(body.undeformed.sight.as_ref());
        let (setup, lattice_particles) = (&body.setup, &body.lattice_particles);
        let (mut solid, quadrature) = body
            .undeformed
            .deformed(setup, lattice_particles, &body.held, time, &u, body.boundary_surface())
            .map_err(|e| damaged("body/remesh_displacement", &format!("can not be remeshed: {e}")))?;
        let surface = (body.boundary_surface(), &quadrature);
        solid.loads = lattice_particles.loads(setup, &solid, surface, &body.held)?;
        body.matter = Matter::new(setup, solid);
        body.last_remesh = Some((time, crate::particles::Column::from_vec(u, n)));
    } else if n != body.lattice_particles.len() {
        return Err(damaged("body/nodes", "is missing"));
    } else {
        body.lattice_particles.reference = reference.clone();
        // Weights found for the sampled particles stay good.
        body.probed = reference.share();
        body.fits.reference = reference.share();
    }
    if let Some(reading) = &mut body.reading {
        reading.settled = Settled::default();
        if state.has("body/settled_traction") {
            let [time] = state.numbers("body/settled_time")?;
            let vertices = body.zero_surface.vertices.len();
            reading.settled = Settled { time, traction: state.vectors("body/settled_traction", vertices)? };
        }
    }
    // Empty where remeshing does not go by the strain.
    if !body.gradient_at_remesh.is_empty() {
        body.gradient_at_remesh = state.matrices("body/gradient_at_remesh", n)?;
    }
    if let (Matter::Paper(paper), true) = (&mut body.matter, state.has("body/listed_at")) {
        let count = state.real("body/listed_at")?.len() / 3;
        if count != 0 {
            let positions: Vec<Vec3> = state.vectors("body/listed_at", n)?;
            paper.list_at(positions);
        }
    }
    Ok(())
}
