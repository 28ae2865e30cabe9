//! What may be changed about a simulation as it runs: forces from outside and probes.

use super::Simulation;
use crate::boundary::nodal_load::NodalLoad;
use crate::boundary::surface_quadrature::SurfaceQuadrature;
use crate::error::InvalidInput;
use crate::setup::{Probe, Ramp};

impl Simulation {
    /// Puts a force (N) on every particle, component by component (3 n values), beside the loads, in the
    /// place of the forces that were put there before. They stay as they are until they are replaced, by
    /// none if `force` is empty, and until the particles are remeshed.
    ///
    /// # Errors
    /// `force` when there are not three finite values for each particle, or the body takes no forces.
    pub fn set_forces(&mut self, force: &[f64]) -> Result<(), InvalidInput> {
        let wanted = 3 * self.particles.len();
        if !force.is_empty() && (force.len() != wanted || force.iter().any(|f| !f.is_finite())) {
            return Err(InvalidInput::new(
                "force",
                format!("{} values", force.len()),
                format!("needs {wanted} finite values: three for each particle"),
                "give the force on every particle, zero where there is none",
            ));
        }
        let Some(loads) = self.model.dynamics_mut().loads_mut() else {
            return Err(InvalidInput::new(
                "force",
                "",
                "this kind of body takes no forces from outside",
                "take a solid",
            ));
        };
        // The loads of the set-up come first.
        loads.truncate(self.setup.solid().map_or(0, |solid| solid.loads.len()));
        if !force.is_empty() {
            loads.push(NodalLoad::new(force.to_vec(), Ramp::default()));
        }
        Ok(())
    }

    /// Points of the undeformed surface, with the weights by which forces there go to the present particles
    /// and their values come here; `None` for a body that takes no forces.
    pub fn surface_quadrature(&self) -> Option<SurfaceQuadrature> {
        self.model.surface_quadrature()
    }

    /// Adds a probe; its readings follow those of the others.
    ///
    /// # Errors
    /// A name that is there already, a probe that reads nothing, or a body that takes no more probes.
    pub fn add_probe(&mut self, probe: Probe) -> Result<(), InvalidInput> {
        if self.setup.probes.iter().any(|p| p.name == probe.name) {
            return Err(InvalidInput::new(
                "probe.name",
                &probe.name,
                "there is a probe of that name",
                "give every probe a name of its own",
            ));
        }
        self.model.add_probe(&probe)?;
        self.setup.probes.push(probe);
        Ok(())
    }
}
