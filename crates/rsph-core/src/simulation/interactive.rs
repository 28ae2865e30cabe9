//! What may be changed about a simulation as it runs: forces from outside and probes.

use super::Simulation;
use crate::boundary::nodal_load::NodalLoad;
use crate::boundary::surface_quadrature::SurfaceQuadrature;
use crate::dynamics::Imposed;
use crate::error::InvalidInput;
use crate::material::Material;
use crate::setup::{Curve, Probe};
use crate::tensor::Vec3;
use std::sync::Arc;

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
            loads.push(NodalLoad::new(force.to_vec(), Curve::default()));
        }
        Ok(())
    }

    /// Goes on with another material in the place of number `k` of [`SolidSetup::materials`], of the same density, under a linear law as before or under any other as before: for moduli that
    /// are tried out as a body moves. What its energy changes by counts as work.
    ///
    /// # Errors
    /// `material` when it is of another density or kind, or the body keeps its own; `time.dt` when a given step is too long for it.
    /// Nothing has changed then.
    pub fn set_material(&mut self, k: usize, material: &Arc<dyn Material>) -> Result<(), InvalidInput> {
        let before = self.setup.solid().and_then(|solid| solid.materials().nth(k).cloned());
        if let Some(before) = &before {
            let is_linear = |m: &dyn Material| m.law().finite_strain().is_none();
            if before.density().to_bits() != material.density().to_bits() {
                return Err(InvalidInput::new(
                    "material.density",
                    material.density(),
                    format!("must stay what it is, {}", before.density()),
                    "start a new simulation for another density",
                ));
            }
            let has_field = self.setup.solid().is_some_and(|solid| {
                solid.fibres.is_some() || solid.parts.iter().any(|part| part.fibres.is_some())
            });
            if has_field && before.fibre() != material.fibre() {
                return Err(InvalidInput::new(
                    "material.fibre",
                    "",
                    "must stay what it is where a field turns the fibres",
                    "give the material the same `fibre`, or start a new simulation",
                ));
            }
            if before.prony().len() != material.prony().len() {
                return Err(InvalidInput::new(
                    "material.prony",
                    format!("{} terms", material.prony().len()),
                    format!("must have as many terms as before, {}", before.prony().len()),
                    "start a new simulation for another series",
                ));
            }
            let several = self.setup.solid().is_some_and(|solid| !solid.parts.is_empty());
            let [was, is] = [before, material].map(|m| m.relaxation_time());
            if several && is_linear(&**material) && was.to_bits() != is.to_bits() {
                return Err(InvalidInput::new(
                    "material.relaxation_time",
                    is,
                    format!("must stay what it is, {was}, beside other materials"),
                    "start a new simulation for another relaxation time",
                ));
            }
            if is_linear(&**before) != is_linear(&**material) {
                return Err(InvalidInput::new(
                    "material.model",
                    material.name(),
                    format!(
                        "can not take the place of \"{}\": one of them is for small strain only",
                        before.name()
                    ),
                    "start with a law for any strain, such as \"neo-hookean\"",
                ));
            }
        }
        let energy = self.energy();
        self.model.set_material(k, material)?;
        if let Some(solid) = self.setup.solid_mut() {
            solid.set_material(k, material);
        }
        if let Err(error) = self.set_integration(self.setup.integration, self.setup.time_step) {
            if let (Some(solid), Some(before)) = (self.setup.solid_mut(), before) {
                self.model.set_material(k, &before)?;
                solid.set_material(k, &before);
            }
            return Err(error);
        }
        let now = self.energy();
        let change = now.kinetic + now.elastic - energy.kinetic - energy.elastic;
        self.balance.impose(&Imposed { momentum: Vec3::zeros(), energy: change });
        self.watch.restart(self.model.dynamics(), &self.particles, self.time, self.steps);
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
