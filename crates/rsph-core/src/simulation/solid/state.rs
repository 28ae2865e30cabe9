//! What a checkpoint holds of a solid: how its particles were last remeshed. The rest follows from the particles
//! and the set-up.

use super::surface_reading::Settled;
use super::{LatticeParticles, Matter, Solid};
use crate::error::InvalidInput;
use crate::particles::{Field, Particles};
use crate::state::{State, damaged};
use crate::tensor::Vec3;

/// Puts it into `state`.
pub(super) fn save(solid: &Solid, state: &mut State) {
    if !solid.gradient_at_remesh.is_empty() {
        state.put_matrices("body/gradient_at_remesh", &solid.gradient_at_remesh);
    }
    if let Matter::Paper(paper) = &solid.matter {
        state.put_vectors("body/listed_at", paper.listed_at());
    }
    if let Some(reading) = solid.reading.as_ref().filter(|r| !r.settled.traction.is_empty()) {
        state.put("body/settled_time", [reading.settled.time]);
        state.put_vectors("body/settled_traction", &reading.settled.traction);
    }
    if let Some((time, u)) = &solid.last_remesh {
        state.put_whole("body/nodes", solid.lattice_particles.nodes().as_flattened());
        state.put("body/laid_time", [*time]);
        state.share("body/remesh_displacement", u.share());
    }
}

/// Takes it back, with `particles` of that state.
pub(super) fn restore(solid: &mut Solid, state: &State, particles: &Particles) -> Result<(), InvalidInput> {
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
        let cut = solid.undeformed.cut_at(places.iter());
        solid.lattice_particles = LatticeParticles::with_columns(nodes.as_chunks::<3>().0, particles, cut);
        let (setup, lattice_particles) = (&solid.setup, &solid.lattice_particles);
        let (mut elastic, quadrature) = solid
            .undeformed
            .deformed(setup, lattice_particles, &solid.held, time, &u, solid.boundary_surface())
            .map_err(|e| damaged("body/remesh_displacement", &format!("can not be remeshed: {e}")))?;
        let surface = (solid.boundary_surface(), &quadrature);
        elastic.loads = lattice_particles.loads(setup, &elastic, surface, &solid.held)?;
        solid.matter = Matter::new(setup, elastic);
        solid.last_remesh = Some((time, crate::particles::Column::from_vec(u, n)));
    } else if n != solid.lattice_particles.len() {
        return Err(damaged("body/nodes", "is missing"));
    } else {
        solid.lattice_particles.reference = reference.clone();
        // Weights found for the sampled particles stay good.
        solid.probed = reference.share();
        solid.fits.reference = reference.share();
    }
    if let Some(reading) = &mut solid.reading {
        reading.settled = Settled::default();
        if state.has("body/settled_traction") {
            let [time] = state.numbers("body/settled_time")?;
            let vertices = solid.zero_surface.vertices.len();
            reading.settled = Settled { time, traction: state.vectors("body/settled_traction", vertices)? };
        }
    }
    // Empty where remeshing does not go by the strain.
    if !solid.gradient_at_remesh.is_empty() {
        solid.gradient_at_remesh = state.matrices("body/gradient_at_remesh", n)?;
    }
    if let (Matter::Paper(paper), true) = (&mut solid.matter, state.has("body/listed_at")) {
        let count = state.real("body/listed_at")?.len() / 3;
        if count != 0 {
            let positions: Vec<Vec3> = state.vectors("body/listed_at", n)?;
            paper.list_at(positions);
        }
    }
    Ok(())
}
