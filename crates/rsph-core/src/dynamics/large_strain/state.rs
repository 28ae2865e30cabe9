//! What a checkpoint holds of a body at large strain: the configuration of the last remesh, from which
//! neighbours and their weights are found again.

use super::LargeStrain;
use super::body::{HOURGLASS, LargeBody, LastRemesh, ghosts};
use super::configuration::Configuration;
use crate::error::InvalidInput;
use crate::state::State;
use crate::tensor::Vec3;
use std::sync::Arc;

impl<const D: usize> LargeBody<D> {
    /// Puts what the set-up does not say into `state`.
    pub(crate) fn save(&self, state: &mut State) {
        let Some(laid) = &self.laid else { return };
        let c = &self.dynamics.configuration;
        state.put("body/laid_time", [laid.time]);
        state.put_vectors("body/laid_nodes", &laid.nodes);
        state.put_vectors("body/lattice", &[self.lattice.origin, self.lattice.spacing]);
        state.put_vectors("body/nodes", &c.nodes);
        state.put_vectors("body/reference", &c.reference);
        state.put("body/volume", c.volume.as_slice());
        state.put("body/reference_volume", c.reference_volume.as_slice());
        state.put_matrices("body/correction", &c.correction);
        state.put_matrices("body/first_gradient", &c.first_gradient);
    }

    /// Takes back a state of `n` particles.
    ///
    /// # Errors
    /// What is missing or has another length; boundaries and loads that act on nothing.
    pub(crate) fn restore(&mut self, state: &State, n: usize) -> Result<(), InvalidInput> {
        if !state.has("body/laid_time") && n == self.dynamics.len() {
            return Ok(());
        }
        let [time] = state.numbers("body/laid_time")?;
        let laid = LastRemesh { time, nodes: state.vectors("body/laid_nodes", n)? };
        let smoothing_length = self.dynamics.configuration.smoothing_length;
        let images = ghosts::<D>(&self.planes, time, &laid.nodes, smoothing_length);
        let points = n + images.list.len();
        let reference: Vec<Vec3> = state.vectors("body/reference", points)?;
        let volume = state.real_of("body/volume", points)?.to_vec();
        let mut c = Configuration::<D>::new(
            laid.nodes.clone(),
            reference[..n].to_vec(),
            volume[..n].to_vec(),
            images,
            smoothing_length,
        );
        c.nodes = state.vectors("body/nodes", points)?;
        c.reference = reference;
        c.volume = volume;
        c.reference_volume = state.real_of("body/reference_volume", n)?.to_vec();
        c.correction = state.matrices("body/correction", n)?;
        c.first_gradient = state.matrices("body/first_gradient", n)?;
        let held = self.held_among(&c.reference[..n])?;
        self.dynamics = LargeStrain::new(c, Arc::clone(&self.material), HOURGLASS * self.solver.hourglass)?;
        self.dynamics.fixed = held;
        self.tag_loads()?;
        let lattice = state.vectors("body/lattice", 2)?;
        (self.lattice.origin, self.lattice.spacing) = (lattice[0], lattice[1]);
        self.laid = Some(laid);
        Ok(())
    }
}
